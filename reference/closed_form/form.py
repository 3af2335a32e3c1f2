"""The common interface of all closed forms, and their common checks."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Curve = Callable[[ArrayLike], Any]


@dataclass(frozen=True)
class ClosedForm:
    """The exact solution of one contact with a half-space.

    All functions take a number or an array and return the same shape, in consistent units. They
    raise ValueError for a load that is negative, not finite or beyond the shape's validity.

    Attributes
    ----------
    name : str
        The shape, spelled as in a scene file.
    source : str
        The primary source, with its equation or chapter.
    force : callable
        Normal force of a penetration d.
    penetration : callable
        Penetration of a force: the inverse of ``force``, to rounding.
    contact_area, contact_radius, semi_axes : callable
        Functions of a penetration: area; radius (None if the contact is not a circle); half-lengths
        of the contact along x and y, as a pair.
    stiffness : callable
        dF/dd on the fixed contact set, 2 E* a for a circle. It equals the slope of ``force``.
    energy : callable
        Elastic energy, the integral of the force over the penetration.
    pressure : callable
        ``pressure(x, y, d)`` at points relative to the axis of the shape, broadcast against each
        other; zero outside the contact and +inf exactly on a singular edge or tip.
    singular_at : {"edge", "centre", None}
        Location of infinite pressure, if any. The force is always finite.
    singular_edge : tuple of float or None
        Semi-axes along x and y of the ellipse on which the pressure is infinite: comparisons of
        pressures omit points near it, see ``relative_radius``.
    """

    name: str
    source: str
    force: Curve
    penetration: Curve
    contact_area: Curve
    contact_radius: Curve | None
    semi_axes: Callable[[ArrayLike], tuple[Any, Any]]
    stiffness: Curve
    energy: Curve
    pressure: Callable[[ArrayLike, ArrayLike, ArrayLike], Any]
    singular_at: Literal["edge", "centre"] | None = None
    singular_edge: tuple[float, float] | None = None

    @property
    def pressure_is_singular(self) -> bool:
        """Whether the pressure is infinite anywhere."""
        return self.singular_at is not None

    def relative_radius(self, x: ArrayLike, y: ArrayLike, penetration: float) -> Array:
        """Return sqrt((x/a)^2 + (y/b)^2): 0 on the axis, 1 on the edge of the contact.

        To compare a singular pressure, keep for example the points where
        ``abs(form.relative_radius(x, y, d) - 1) > ring`` (edge) or ``> ring`` (centre).
        """
        half_x, half_y = self.semi_axes(penetration)
        return np.hypot(np.asarray(x) / half_x, np.asarray(y) / half_y)


def require_positive(shape: str, **parameters: float) -> None:
    """Raise one ValueError that lists every parameter that is not a finite positive number."""
    problems = []
    for name, value in parameters.items():
        try:
            good = math.isfinite(value) and value > 0 and not isinstance(value, bool)
        except TypeError:
            good = False
        if not good:
            problems.append(f"{name} must be a finite positive number, not {value!r}")
    if problems:
        raise ValueError(f"{shape}: " + "; ".join(problems))


def checked_load(name: str, value: ArrayLike, limit: float = math.inf, reason: str = "") -> Array:
    """Return a load as float64; raise ValueError unless it is finite, >= 0 and below a limit."""
    load = np.asarray(value)
    if load.dtype.kind not in "iuf":
        raise ValueError(f"{name} must be real numbers, not {value!r}")
    load = load.astype(np.float64)
    bad = ~(np.isfinite(load) & (load >= 0))
    if bad.any():
        raise ValueError(f"{name} must be finite and not negative, not {load[bad].flat[0]!r}")
    if (load > limit).any():
        raise ValueError(f"{name} {load.max():.6g} is above {limit:.6g}: {reason}")
    return load


@dataclass(frozen=True)
class Formulas:
    """Array formulas, and their conversion to a `ClosedForm` with checks of arguments.

    Parameters
    ----------
    name, source, singular_at, singular_edge
        As for `ClosedForm`.
    force, semi_axes, stiffness, energy : callable
        Functions of the penetration.
    penetration : callable
        Function of the force.
    pressure : callable
        Function of the relative radius rho in [0, 1] and the penetration, as flat arrays of points
        inside the contact only.
    axisymmetric : bool
    penetration_limit : float
        Largest penetration for which the formulas hold, for the reason `limit_reason`.
    """

    name: str
    source: str
    force: Callable[[Array], Array]
    penetration: Callable[[Array], Array]
    semi_axes: Callable[[Array], tuple[Array, Array]]
    stiffness: Callable[[Array], Array]
    energy: Callable[[Array], Array]
    pressure: Callable[[Array, Array], Array]
    axisymmetric: bool = True
    singular_at: Literal["edge", "centre"] | None = None
    singular_edge: tuple[float, float] | None = None
    penetration_limit: float = math.inf
    limit_reason: str = ""

    def closed_form(self) -> ClosedForm:
        """Return the formulas as functions of numbers and arrays that refuse invalid loads."""
        return ClosedForm(
            name=self.name,
            source=self.source,
            force=self._at(self.force),
            penetration=self._penetration,
            contact_area=self._at(lambda d: np.pi * np.prod(self.semi_axes(d), axis=0)),
            contact_radius=self._at(lambda d: self.semi_axes(d)[0]) if self.axisymmetric else None,
            semi_axes=self._at(self.semi_axes),
            stiffness=self._at(self.stiffness),
            energy=self._at(self.energy),
            pressure=self._pressure,
            singular_at=self.singular_at,
            singular_edge=self.singular_edge,
        )

    def _depth(self, d: ArrayLike) -> Array:
        return checked_load("penetration", d, self.penetration_limit, self.limit_reason)

    def _at(self, formula: Callable[[Array], Any]) -> Curve:
        return lambda d: formula(self._depth(d))

    @cached_property
    def _force_limit(self) -> float:
        limit = np.asarray(self.penetration_limit)
        return float(self.force(limit)) if self.limit_reason else math.inf

    def _penetration(self, F: ArrayLike) -> Any:
        return self.penetration(checked_load("force", F, self._force_limit, self.limit_reason))

    def _pressure(self, x: ArrayLike, y: ArrayLike, d: ArrayLike) -> Any:
        x, y, d = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float), self._depth(d))
        half_x, half_y = self.semi_axes(d)
        loaded = d > 0
        rho = np.full(d.shape, np.inf)
        scaled_x = np.divide(x, half_x, out=rho.copy(), where=loaded)
        scaled_y = np.divide(y, half_y, out=rho.copy(), where=loaded)
        np.hypot(scaled_x, scaled_y, out=rho, where=loaded)
        inside = rho <= 1
        result = np.zeros(d.shape)
        with np.errstate(divide="ignore"):  # infinite on a singular edge or tip, as documented
            result[inside] = self.pressure(rho[inside], d[inside])
        return result[()]
