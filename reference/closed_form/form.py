"""The class of all exact contacts: laws of a shape, behind checks of the loads."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array
from reference.errors import positive_faults, refuse

Law = Callable[[Array], Array]


def require_positive(shape: str, **parameters: float) -> list[float]:
    """Return the parameters; one ValueError lists all that are no finite positive numbers."""
    refuse([f"{shape}: {fault}" for fault in positive_faults(**parameters)])
    return [float(value) for value in parameters.values()]


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


def keep_positive(shape: str, fields: dict[str, Any]) -> None:
    """Check the numbers among the fields of a frozen object, and keep them as floats."""
    numbers = {name: value for name, value in fields.items() if not isinstance(value, ClosedForm)}
    fields.update(zip(numbers, require_positive(shape, **numbers), strict=True))


@dataclass(frozen=True)
class ByRadius:
    """Laws of a round contact in its radius a, from which its adhesion follows."""

    source: str  # the adhesive solution
    # d0(a), F0(a) and d0'(a) without adhesion
    depth: Law
    load: Law
    rate: Law
    scale: Callable[[float], float]  # A radius to start searches from, as a function of w/E*
    # radii at which d0 begins to increase, and ends
    smallest: float = 0.0
    largest: float = math.inf
    refused: str = ""  # why adhesion cannot hold this shape, if so


@dataclass(frozen=True)
class ClosedForm:
    """The exact solution of one contact with a half-space.

    Its methods take a number or an array and return the same shape, in consistent units. They raise
    ValueError for a load that is negative, not finite or beyond the shape's validity.
    """

    name: str  # the shape, spelled as in a scene file
    source: str  # the primary source, with its equation or chapter
    effective_modulus: float  # E*
    # F, U and (of round contacts) a in the penetration d; the stiffness is then 2 E* a
    force_of: Law
    depth_of: Law  # d in the force
    energy_of: Law
    # p in the relative radius rho in [0, 1] and d, at points of the contact
    pressure_of: Callable[[Array, Array], Array]
    radius_of: Law | None = None
    # semi-axes along x and y and dF/dd in d, of contacts that are not round
    axes_of: Callable[[Array], tuple[Array, Array]] | None = None
    stiffness_of: Law | None = None
    by_radius: ByRadius | None = None
    # {"edge", "centre", None}: Location of infinite pressure, if any. The force is always finite.
    singular_at: Literal["edge", "centre"] | None = None
    # largest penetration for which the formulas hold, and why
    limit: float = math.inf
    limit_reason: str = ""

    def force(self, penetration: ArrayLike) -> Any:
        """Return the normal force of a penetration."""
        return self.force_of(self._depth(penetration))

    def penetration(self, force: ArrayLike) -> Any:
        """Penetration of a force: the inverse of `force`, to rounding."""
        limit = float(self.force_of(np.asarray(self.limit))) if self.limit_reason else math.inf
        return self.depth_of(checked_load("force", force, limit, self.limit_reason))

    def energy(self, penetration: ArrayLike) -> Any:
        """Elastic energy, the integral of the force over the penetration."""
        return self.energy_of(self._depth(penetration))

    def stiffness(self, penetration: ArrayLike) -> Any:
        """dF/dd on the fixed contact set, 2 E* a for a circle; the slope of `force`, too."""
        depth = self._depth(penetration)
        if self.stiffness_of is not None:
            return self.stiffness_of(depth)
        return 2 * self.effective_modulus * self.semi_axes(depth)[0]

    def semi_axes(self, penetration: ArrayLike) -> tuple[Any, Any]:
        """Half-lengths of the contact along x and y."""
        depth = self._depth(penetration)
        if self.radius_of is not None:
            return (self.radius_of(depth),) * 2
        assert self.axes_of is not None
        return self.axes_of(depth)

    def contact_area(self, penetration: ArrayLike) -> Any:
        """Area of the contact."""
        return np.pi * np.prod(self.semi_axes(penetration), axis=0)

    @property
    def contact_radius(self) -> Callable[[ArrayLike], Any] | None:
        """Radius of the contact as a function of the penetration; None if it is not a circle."""
        radius = self.radius_of
        return None if radius is None else lambda d: radius(self._depth(d))

    def pressure(self, x: ArrayLike, y: ArrayLike, penetration: ArrayLike) -> Any:
        """Pressure at points relative to the axis, broadcast against each other.

        Zero outside the contact and +inf exactly on a singular edge or tip.
        """
        x, y = np.asarray(x, float), np.asarray(y, float)
        x, y, d = np.broadcast_arrays(x, y, self._depth(penetration))
        half_x, half_y = self.semi_axes(d)
        loaded = d > 0
        rho = np.full(d.shape, np.inf)
        scaled_x = np.divide(x, half_x, out=rho.copy(), where=loaded)
        scaled_y = np.divide(y, half_y, out=rho.copy(), where=loaded)
        np.hypot(scaled_x, scaled_y, out=rho, where=loaded)
        inside = rho <= 1
        result = np.zeros(d.shape)
        with np.errstate(divide="ignore"):  # infinite on a singular edge or tip, as documented
            result[inside] = self.pressure_of(rho[inside], d[inside])
        return result[()]

    def relative_radius(self, x: ArrayLike, y: ArrayLike, penetration: float) -> Array:
        """Return sqrt((x/a)^2 + (y/b)^2): 0 on the axis, 1 on the edge of the contact.

        To compare a singular pressure, keep for example the points where
        ``abs(form.relative_radius(x, y, d) - 1) > ring`` (edge) or ``> ring`` (centre).
        """
        half_x, half_y = self.semi_axes(penetration)
        return np.hypot(np.asarray(x) / half_x, np.asarray(y) / half_y)

    def _depth(self, penetration: ArrayLike) -> Array:
        return checked_load("penetration", penetration, self.limit, self.limit_reason)
