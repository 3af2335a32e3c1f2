"""A round shape given by a table."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import model_validator

from comparisons.scene.fields import FiniteLength, fail
from comparisons.scene.indenters.indenter import Axisymmetric

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

# The exact transform of a table costs the square of its points.
MOST_TABLE_POINTS = 2000


class Profile(Axisymmetric):
    """An axisymmetric table f(r) from r = 0, f = 0; a sharp edge at the last r."""

    shape: Literal["profile"]
    r: tuple[FiniteLength, ...]
    f: tuple[FiniteLength, ...]
    interpolation: Literal["pchip", "linear"] = "pchip"

    @property
    def regular(self) -> bool:
        """No."""
        return False

    @model_validator(mode="after")
    def _a_monotone_table(self) -> Profile:
        r, f = np.array(self.r), np.array(self.f)
        if len(r) > MOST_TABLE_POINTS:
            raise fail(f"expected at most {MOST_TABLE_POINTS} points, got {len(r)}")
        if len(r) != len(f) or len(r) < 2:
            raise fail(f"expected r and f of the same length, at least 2, got {len(r)}, {len(f)}")
        if r[0] != 0 or f[0] != 0 or np.any(np.diff(r) <= 0):
            raise fail("expected r strictly increasing from 0, and f = 0 at r = 0")
        if np.any(np.diff(f) < 0):
            first = int(np.argmax(np.diff(f) < 0))
            raise fail(
                f"expected a non-decreasing f: hollow profiles have no reduced model "
                f"(f decreases after r = {r[first]:g} m)"
            )
        return self

    @property
    def face_area(self) -> float | None:
        """Area inside the sharp edge where the table is all zeros: a cylinder."""
        return float(np.pi * self.r[-1] ** 2) if max(self.f) == 0 else None

    @cached_property
    def _interpolant(self) -> PchipInterpolator:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.r, self.f)

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return the interpolated table, inf beyond its end."""
        inside = np.minimum(r, self.r[-1])
        if self.interpolation == "linear":
            height = np.interp(inside, self.r, self.f)
        else:
            height = np.maximum(self._interpolant(inside), 0.0)
        return np.where(np.asarray(r) <= self.r[-1], height, np.inf)

    def overlap_radius(self, penetration: float) -> float:
        """Return a radius at which the table lies above `penetration`, or the edge."""
        above = np.flatnonzero(np.array(self.f) > penetration)
        if not len(above):
            return self.r[-1]
        # Halving between two tabulated radii: a table of few points must not ask for a grid that
        # reaches to the next of them.
        low, high = self.r[above[0] - 1], self.r[above[0]]
        for _ in range(30):
            middle = 0.5 * (low + high)
            if float(self.radial_gap(np.array(middle))) > penetration:
                high = middle
            else:
                low = middle
        return high
