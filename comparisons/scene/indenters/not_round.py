"""Shapes that are not round: the elliptic paraboloid, the pyramids of Vickers and Berkovich."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from comparisons.scene.fields import FiniteLength, Length, Positive, fail
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.polygons import crosses_itself, sides, signed_area


class Ellipsoid(Indenter):
    """x^2 / (2 Rx) + y^2 / (2 Ry), with radii of curvature Rx and Ry."""

    shape: Literal["ellipsoid"]
    radius_x: Length
    radius_y: Length

    @property
    def axisymmetric(self) -> bool:
        return self.radius_x == self.radius_y

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return x**2 / (2 * self.radius_x) + y**2 / (2 * self.radius_y)

    def reach(self, penetration: float) -> tuple[float, float]:
        return (
            float(np.sqrt(2 * self.radius_x * penetration)),
            float(np.sqrt(2 * self.radius_y * penetration)),
        )


class Pyramid(Indenter):
    """slope max(x . n_i) over the normals n_i of the base's sides, the first of them along x.

    The slope is the tangent of the angle between a face and the surface: 0.404 for Vickers.
    """

    shape: Literal["pyramid"]
    slope: Positive
    sides: Annotated[int, Field(ge=3, le=64)] = 4
    sharp_tip: ClassVar[bool] = True
    axisymmetric: ClassVar[bool] = False
    regular: ClassVar[bool] = False

    @property
    def quarter_symmetric(self) -> bool:
        """Whether an opposite side belongs to the first."""
        return self.sides % 2 == 0

    @property
    def even(self) -> tuple[bool, bool]:
        """Always in y; in x with an even number of sides."""
        return self.quarter_symmetric, True

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        angle = 2 * np.pi * np.arange(self.sides) / self.sides
        planes = [np.cos(t) * x + np.sin(t) * y for t in angle]
        return self.slope * np.max(planes, axis=0)

    def reach(self, penetration: float) -> tuple[float, float]:
        """Return the half-widths of the section there, between its corners."""
        corner = penetration / self.slope / np.cos(np.pi / self.sides)
        angle = 2 * np.pi * (np.arange(self.sides) + 0.5) / self.sides
        return corner * float(np.abs(np.cos(angle)).max()), corner * float(np.sin(angle).max())


class EllipticPunch(Indenter):
    """Flat face with semi-axes a (along x) and b (along y)."""

    shape: Literal["elliptic_punch"]
    semi_axes: tuple[Length, Length]

    @property
    def parameters(self) -> dict[str, Any]:
        """The semi-axes by a name each."""
        return {"semi_axis_x": self.semi_axes[0], "semi_axis_y": self.semi_axes[1]}

    @property
    def axisymmetric(self) -> bool:
        return self.semi_axes[0] == self.semi_axes[1]

    @property
    def face_area(self) -> float:
        return float(np.pi * self.semi_axes[0] * self.semi_axes[1])

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        a, b = self.semi_axes
        return np.where((x / a) ** 2 + (y / b) ** 2 <= 1, 0.0, np.inf)

    def reach(self, penetration: float) -> tuple[float, float]:
        return self.semi_axes


class RightAngledPunch(Indenter):
    """Flat rectangular face, sides along x and y."""

    axisymmetric: ClassVar[bool] = False
    regular: ClassVar[bool] = False

    @property
    def lengths(self) -> tuple[float, float]:
        """Sides along x and y."""
        raise NotImplementedError

    @property
    def face_area(self) -> float:
        return self.lengths[0] * self.lengths[1]

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        half_x, half_y = self.reach(0.0)
        inside = (np.abs(x) <= half_x) & (np.abs(y) <= half_y)
        return np.where(inside, 0.0, np.inf)

    @property
    def outline(self) -> np.ndarray:
        corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
        return corners * self.lengths

    def reach(self, penetration: float) -> tuple[float, float]:
        return self.lengths[0] / 2, self.lengths[1] / 2


class SquarePunch(RightAngledPunch):
    """Flat square face, sides along x and y."""

    shape: Literal["square_punch"]
    side: Length

    @property
    def lengths(self) -> tuple[float, float]:
        return self.side, self.side


class RectanglePunch(RightAngledPunch):
    """Flat rectangular face, sides along x and y."""

    shape: Literal["rectangle_punch"]
    sides: tuple[Length, Length]

    @property
    def lengths(self) -> tuple[float, float]:
        return self.sides


class PolygonPunch(Indenter):
    """Flat face with the outline of a simple polygon; its centroid is moved to the origin."""

    shape: Literal["polygon_punch"]
    vertices: tuple[tuple[FiniteLength, FiniteLength], ...]
    axisymmetric: ClassVar[bool] = False
    regular: ClassVar[bool] = False
    # Not even a rectangle among the polygons is meshed as one: its lines are even.
    quarter_symmetric: ClassVar[bool] = False

    @model_validator(mode="after")
    def _a_simple_polygon(self) -> PolygonPunch:
        corners = np.array(self.vertices)
        if len(corners) < 3:
            raise fail(f"expected at least 3 vertices, got {len(corners)}")
        if len(corners) > 1000:
            raise fail(f"expected at most 1000 vertices, got {len(corners)}")
        span = np.ptp(corners, axis=0).max()
        if not span or abs(signed_area(corners)) < 1e-12 * span**2:
            raise fail("expected a polygon with non-zero area")
        if crosses_itself(corners):
            raise fail("expected a simple polygon, got one whose sides touch or cross")
        return self

    @cached_property
    def corners(self) -> np.ndarray:
        """Vertices relative to the centroid, shape (n, 2), counter-clockwise."""
        corners = np.array(self.vertices)
        if signed_area(corners) < 0:
            corners = corners[::-1]
        corners = corners - corners.mean(axis=0)
        following = np.roll(corners, -1, axis=0)
        cross = corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]
        centroid = ((corners + following) * cross[:, None]).sum(axis=0) / (3 * cross.sum())
        return corners - centroid

    @property
    def outline(self) -> np.ndarray:
        return self.corners

    @cached_property
    def even(self) -> tuple[bool, bool]:
        """Whether the outline is its own mirror image; to rounding, corner by corner."""
        noise = 1e-9 * float(np.ptp(self.corners, axis=0).max())

        def mirrored(signs: tuple[int, int]) -> bool:
            image = self.corners * signs
            return all(np.abs(self.corners - corner).max(axis=1).min() < noise for corner in image)

        return mirrored((-1, 1)), mirrored((1, -1))

    @property
    def face_area(self) -> float:
        return abs(signed_area(np.array(self.vertices)))

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return 0 inside (even-odd rule) and inf outside."""
        x, y = np.broadcast_arrays(x, y)
        inside = np.zeros(x.shape, dtype=bool)
        for (x0, y0), (x1, y1) in sides(self.corners):
            straddles = (y0 > y) != (y1 > y)
            if y0 != y1:
                inside ^= straddles & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        return np.where(inside, 0.0, np.inf)

    def reach(self, penetration: float) -> tuple[float, float]:
        half = np.abs(self.corners).max(axis=0)
        return float(half[0]), float(half[1])
