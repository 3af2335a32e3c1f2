"""Round shapes: a formula f(r), or a table of it."""

from __future__ import annotations

import sys
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from pydantic import field_validator, model_validator

from comparisons.scene.fields import NUMBER, Dimension, FiniteLength, Length, Positive, fail, to_si
from comparisons.scene.indenters.indenter import Axisymmetric

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator


class Paraboloid(Axisymmetric):
    """f = r^2 / (2 R)."""

    shape: Literal["paraboloid"]
    radius: Length

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        return r**2 / (2 * self.radius)

    def overlap_radius(self, penetration: float) -> float:
        return float(np.sqrt(2 * self.radius * penetration))


class Sphere(Axisymmetric):
    """f = R - sqrt(R^2 - r^2), up to the equator."""

    shape: Literal["sphere"]
    radius: Length

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return the sphere's gap, in the form that keeps its digits near the apex."""
        ratio = np.asarray(r) / self.radius
        with np.errstate(invalid="ignore"):
            height = self.radius * ratio**2 / (1 + np.sqrt(1 - ratio**2))
        return np.where(ratio <= 1, height, np.inf)

    def overlap_radius(self, penetration: float) -> float:
        depth = min(penetration, self.radius)
        return float(np.sqrt(depth * (2 * self.radius - depth)))


class Cone(Axisymmetric):
    """f = slope * r; the slope is the tangent of the angle between flank and surface."""

    shape: Literal["cone"]
    slope: Positive
    sharp_tip: ClassVar[bool] = True

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        return self.slope * r

    def overlap_radius(self, penetration: float) -> float:
        return penetration / self.slope


class PowerLaw(Axisymmetric):
    """f = coefficient * r^exponent; the coefficient has the unit m^(1 - exponent)."""

    shape: Literal["power_law"]
    exponent: Positive
    coefficient: float

    @field_validator("exponent")
    @classmethod
    def _monotone_slope(cls, value: float) -> float:
        if not 0.1 <= value <= 100:
            raise fail("expected an exponent from 0.1 to 100", value)
        return value

    @model_validator(mode="before")
    @classmethod
    def _coefficient_with_unit(cls, data: Any) -> Any:
        """Convert the coefficient here, because its unit depends on the exponent."""
        if not isinstance(data, dict) or not isinstance(data.get("coefficient"), str):
            return data
        try:
            exponent = to_si(data.get("exponent"), NUMBER)
            if not exponent.is_integer():
                return data
            dimension = Dimension(length=1 - int(exponent))
            return data | {"coefficient": to_si(data["coefficient"], dimension)}
        except ValueError:
            return data

    @field_validator("coefficient", mode="before")
    @classmethod
    def _positive_coefficient(cls, value: Any) -> float:
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not number or not sys.float_info.min <= value < sys.float_info.max:
            raise fail(
                "expected a positive number in m^(1 - exponent), or a text with that unit"
                ' (for an integer exponent) such as "1e6 m^-2" for exponent 3',
                value,
            )
        return float(value)

    @property
    def sharp_tip(self) -> bool:
        """A cone's for exponent 1, a cusp's below."""
        return self.exponent <= 1

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return coefficient * r^exponent; inf, which never touches, where it overflows."""
        with np.errstate(over="ignore"):
            return self.coefficient * np.asarray(r) ** self.exponent

    def overlap_radius(self, penetration: float) -> float:
        return float((penetration / self.coefficient) ** (1 / self.exponent))


class Cylinder(Axisymmetric):
    """A flat circular punch."""

    shape: Literal["cylinder"]
    radius: Length

    @property
    def face_area(self) -> float:
        return float(np.pi * self.radius**2)

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        return np.where(np.asarray(r) <= self.radius, 0.0, np.inf)

    def overlap_radius(self, penetration: float) -> float:
        return self.radius


class RoundedPunch(Axisymmetric):
    """Flat to r = b, then (r - b)^2 / (2 R)."""

    shape: Literal["rounded_punch"]
    flat_radius: Length
    edge_radius: Length

    @property
    def flat_within(self) -> float:
        return self.flat_radius

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        return np.maximum(np.asarray(r) - self.flat_radius, 0) ** 2 / (2 * self.edge_radius)

    def overlap_radius(self, penetration: float) -> float:
        return float(self.flat_radius + np.sqrt(2 * self.edge_radius * penetration))


# The exact transform of a table costs the square of its points.
MOST_TABLE_POINTS = 2000


class Profile(Axisymmetric):
    """An axisymmetric table f(r) from r = 0, f = 0; a sharp edge at the last r."""

    shape: Literal["profile"]
    r: tuple[FiniteLength, ...]
    f: tuple[FiniteLength, ...]
    interpolation: Literal["pchip", "linear"] = "pchip"
    regular: ClassVar[bool] = False

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
