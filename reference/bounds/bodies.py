"""Convex bodies that are no bodies of revolution: the gap on one part of a symmetric whole."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from reference.bounds.ellipses import elliptic_stiffness
from reference.bounds.interval import EPSILON
from reference.bounds.outlines import Outline, circle, dihedral
from reference.closed_form.elliptic import ellipsoid

Array = NDArray[np.float64]


# Exponent of the spacing of rays towards a pyramid's edge, along which the contact is drawn out.
_POINTED = 2.0


class Body(Protocol):
    """A gap of some degree n, g(s x) = s^n g(x), that is quadratic on the part that is computed.

    Attributes
    ----------
    degree : int
        1 or 2.
    """

    @property
    def degree(self) -> int:
        """Exponent of the gap."""
        ...

    def __hash__(self) -> int:
        """Bodies are values."""
        ...

    def gap(self, x: Array, y: Array) -> Array:
        """Return g on the part of the plane that the outline spans."""
        ...

    def punch(self, cells: int) -> Outline:
        """Return a first outline: the ellipse that carries most, at a penetration of 1."""
        ...

    def punch_force(self) -> float:
        """Lower bound of the force at a penetration of 1 for E* = 1, in closed form."""
        ...


@dataclass(frozen=True)
class Paraboloid:
    """g = x^2/(2 R_x) + y^2/(2 R_y).

    The best ellipse is the contact area itself: Barber's bound is exact but for rounding.
    """

    radius_x: float
    radius_y: float

    def __post_init__(self) -> None:
        if not all(r > 0 and math.isfinite(r) for r in (self.radius_x, self.radius_y)):
            raise ValueError(
                "radii must be positive and finite, got "
                f"radius_x = {self.radius_x!r}, radius_y = {self.radius_y!r}"
            )

    @property
    def degree(self) -> int:
        """Degree 2."""
        return 2

    def gap(self, x: Array, y: Array) -> Array:
        """Return the gap."""
        return 0.5 * (x**2 / self.radius_x + y**2 / self.radius_y)

    def _semi_axes(self) -> tuple[float, float]:
        """Semi-axes of the contact at a penetration of 1, a guess that no bound hangs on."""
        x, y = ellipsoid(self.radius_x, self.radius_y, 1.0).semi_axes(1.0)
        return float(x), float(y)

    def punch(self, cells: int) -> Outline:
        """Return the quarter of the contact ellipse."""
        return circle(cells, dihedral(2), 0.5 * np.pi).stretched(*self._semi_axes())

    def punch_force(self) -> float:
        """Return k (1 - a^2/(6 R_x) - b^2/(6 R_y))."""
        a, b = self._semi_axes()
        mean = a * a / (6 * self.radius_x) + b * b / (6 * self.radius_y)
        return elliptic_stiffness(a, b).lower * (1 - mean) * (1 - 32 * EPSILON)


@dataclass(frozen=True)
class Pyramid:
    """Regular pyramid, g = s max(x . n_i) over the normals n_i of its faces' base lines.

    Four faces make Vickers's indenter, three Berkovich's.

    Raises
    ------
    ValueError
        For fewer than three faces, part of one, or a slope that is not positive.
    """

    faces: int
    slope: float

    def __post_init__(self) -> None:
        whole = self.faces >= 3 and float(self.faces).is_integer()
        if not (whole and self.slope > 0 and math.isfinite(self.slope)):
            raise ValueError(
                "a pyramid has at least three faces of a positive slope, got "
                f"faces = {self.faces!r}, slope = {self.slope!r}"
            )

    @property
    def degree(self) -> int:
        """Degree 1."""
        return 1

    def gap(self, x: Array, y: Array) -> Array:
        """Return s x: the part lies between the middle of a face and its edge."""
        return self.slope * x + 0 * y

    def gap_anywhere(self, x: Array, y: Array) -> Array:
        """Return the height of the highest of the planes of all faces."""
        turns = 2 * np.pi * np.arange(self.faces) / self.faces
        return self.slope * np.max([np.cos(t) * x + np.sin(t) * y for t in turns], axis=0)

    def _radius(self) -> float:
        """Radius of the best circle: k (1 - <g>) is largest where <g> = 1/2."""
        return 0.5 / self._mean_gap()

    def _mean_gap(self) -> float:
        """Mean of the gap under a circular punch of radius 1.

        <r> = pi/4 under the shadow of a sphere, times the mean of cos over half a face's angle.
        """
        half = np.pi / self.faces
        return self.slope * 0.25 * np.pi * math.sin(half) / half

    def punch(self, cells: int) -> Outline:
        """Return half a face's part of the best circle."""
        full_circle = circle(cells, dihedral(self.faces), np.pi / self.faces, _POINTED)
        return full_circle.scaled(self._radius())

    def punch_force(self) -> float:
        """Return 2 a (1 - <g>)."""
        a = self._radius()
        return 2 * a * (1 - a * self._mean_gap()) * (1 - 32 * EPSILON)
