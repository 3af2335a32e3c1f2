"""Shapes that are not round: the elliptic paraboloid, the pyramids of Vickers and Berkovich."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from comparisons.scene.fields import Length, Positive
from comparisons.scene.indenters.indenter import Indenter


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
