r"""Convex bodies of revolution, and parabolas that stay on one side of them.

A body outside this class (falling or hollow somewhere) is refused by having no class here.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Profile(ABC):
    """Gap f(r) before contact: f(0) = 0, rising and convex, with a third derivative of one sign.

    A value; its fields are positive and finite. All functions to a few units in the last place.
    """

    def __post_init__(self) -> None:
        refuse(positive_faults(**{f.name: getattr(self, f.name) for f in fields(self)}))

    @property
    def degree(self) -> float | None:
        """Exponent n where f(s r) = s^n f(r), else None: the body has a length."""
        return None

    @property
    def corners(self) -> tuple[float, ...]:
        """Radii at which a higher derivative jumps; f''' keeps its sign between them."""
        return ()

    @property
    def rising_curvature(self) -> bool:
        """Whether f''' >= 0 between the corners; else f''' <= 0."""
        return True

    @property
    def deepest(self) -> float:
        """Penetrations are below this, where the gap ends; infinite where it does not."""
        return math.inf

    @abstractmethod
    def gap(self, r: Array) -> Array:
        """f(r)."""

    @abstractmethod
    def slope(self, r: Array) -> Array:
        """f'(r)."""

    @abstractmethod
    def moment(self, r: Array) -> Array:
        """Integral of f(s) s ds from 0 to r."""

    @abstractmethod
    def reach(self, penetration: float) -> float:
        """Radius at which f is the penetration: contact stays inside of it."""


@dataclass(frozen=True)
class PowerLaw(Profile):
    """f(r) = c r^n with n >= 1: n = 1 is a cone of slope c, n = 2 a paraboloid of radius 1/(2c)."""

    exponent: float
    coefficient: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.exponent < 1:
            raise ValueError(
                f"the bounds hold for convex bodies, r^n with n >= 1, not n = {self.exponent!r}"
            )

    @property
    def degree(self) -> float | None:
        """Degree n."""
        return float(self.exponent)

    @property
    def rising_curvature(self) -> bool:
        """Sign of n (n-1) (n-2) c r^(n-3)."""
        return self.exponent >= 2 or self.exponent == 1

    def gap(self, r: Array) -> Array:
        """Return c r^n."""
        return self.coefficient * r**self.exponent

    def slope(self, r: Array) -> Array:
        """Return c n r^(n-1)."""
        return self.coefficient * self.exponent * r ** (self.exponent - 1)

    def moment(self, r: Array) -> Array:
        """Return c r^(n+2)/(n+2)."""
        return self.coefficient / (self.exponent + 2) * r ** (self.exponent + 2)

    def reach(self, penetration: float) -> float:
        """(d/c)^(1/n)."""
        return (penetration / self.coefficient) ** (1 / self.exponent)


def paraboloid(radius: float) -> PowerLaw:
    """Paraboloid r^2/(2R)."""
    refuse(positive_faults(radius=radius))
    return PowerLaw(2.0, 0.5 / radius)


def cone(slope: float) -> PowerLaw:
    """Cone s r."""
    return PowerLaw(1.0, slope)


@dataclass(frozen=True)
class Sphere(Profile):
    """f(r) = R - sqrt(R^2 - r^2) on r < R, within the linear theory of the half-space."""

    radius: float

    @property
    def deepest(self) -> float:
        """R, where the ball ends."""
        return self.radius

    def gap(self, r: Array) -> Array:
        """r^2/(R + sqrt(R^2 - r^2)), which does not cancel."""
        return r**2 / (self.radius + np.sqrt((self.radius - r) * (self.radius + r)))

    def slope(self, r: Array) -> Array:
        """r/sqrt(R^2 - r^2)."""
        return r / np.sqrt((self.radius - r) * (self.radius + r))

    def moment(self, r: Array) -> Array:
        """R f^2/2 - f^3/3, as r dr = (R - f) df."""
        f = self.gap(r)
        return f**2 * (self.radius / 2 - f / 3)

    def reach(self, penetration: float) -> float:
        """sqrt(d (2R - d)); a penetration of R or more, where the gap has no value, is refused."""
        if penetration >= self.radius:
            raise ValueError(
                f"a sphere of radius {self.radius!r} is bounded for penetrations below its "
                f"radius, not for {penetration!r}"
            )
        return math.sqrt(penetration * (2 * self.radius - penetration))


@dataclass(frozen=True)
class RoundedPunch(Profile):
    """f = 0 to r = b, then (r - b)^2/(2R)."""

    flat_radius: float
    edge_radius: float

    @property
    def corners(self) -> tuple[float, ...]:
        """b, where the curvature jumps."""
        return (self.flat_radius,)

    def gap(self, r: Array) -> Array:
        """(r - b)^2/(2R) beyond b."""
        return np.maximum(r - self.flat_radius, 0.0) ** 2 / (2 * self.edge_radius)

    def slope(self, r: Array) -> Array:
        """(r - b)/R beyond b."""
        return np.maximum(r - self.flat_radius, 0.0) / self.edge_radius

    def moment(self, r: Array) -> Array:
        """t^3 (t/4 + b/3)/(2R) with t = r - b."""
        t = np.maximum(r - self.flat_radius, 0.0)
        return t**3 * (t / 4 + self.flat_radius / 3) / (2 * self.edge_radius)

    def reach(self, penetration: float) -> float:
        """Return b + sqrt(2 R d)."""
        return self.flat_radius + math.sqrt(2 * self.edge_radius * penetration)


def minorant(profile: Profile, radii: Array) -> Array:
    """Bernstein coefficients (2 n + 1,) of a continuous, piecewise parabolic function below f.

    A bound needs the gap everywhere, not at nodes. Where the third derivative of f keeps its sign,
    the parabola through f(r1) and f(r2) that has the slope of f at one of the two ends stays on one
    side of f, as its error is

        f(r) - q(r) = f'''(s)/6 (r - r1) (r - r2)^2    with the slope at r2,
        f(r) - q(r) = f'''(s)/6 (r - r1)^2 (r - r2)    with the slope at r1

    for some s between r1 and r2 (Davis, Interpolation and Approximation, 1963, section 3.5). The
    coefficients of a piece are f(r1), b, f(r2) with b = f(r2) - f'(r2) h/2 or f(r1) + f'(r1) h/2.
    Radii (n + 1,) increase; the profile's corners are among them.

    Examples
    --------
    >>> import numpy as np
    >>> minorant(paraboloid(0.5), np.array([0.0, 1.0, 2.0])).tolist()
    [0.0, 0.0, 1.0, 2.0, 4.0]
    """
    gap, slope, half = profile.gap(radii), profile.slope(radii), 0.5 * np.diff(radii)
    coefficients = np.empty(2 * len(radii) - 1)
    coefficients[::2] = gap
    if profile.rising_curvature:
        coefficients[1::2] = gap[1:] - slope[1:] * half
    else:
        coefficients[1::2] = gap[:-1] + slope[:-1] * half
    return coefficients
