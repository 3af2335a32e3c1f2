"""The elliptic paraboloid."""

from __future__ import annotations

from typing import Literal

import numpy as np

from comparisons.scene.fields import Length
from comparisons.scene.indenters.indenter import Indenter


class Ellipsoid(Indenter):
    """x^2 / (2 Rx) + y^2 / (2 Ry), with radii of curvature Rx and Ry."""

    shape: Literal["ellipsoid"]
    radius_x: Length
    radius_y: Length

    @property
    def axisymmetric(self) -> bool:
        """Only when both radii are equal."""
        return self.radius_x == self.radius_y

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the elliptic paraboloid."""
        return x**2 / (2 * self.radius_x) + y**2 / (2 * self.radius_y)

    def reach(self, penetration: float) -> tuple[float, float]:
        """Return sqrt(2 Rx d) and sqrt(2 Ry d)."""
        return (
            float(np.sqrt(2 * self.radius_x * penetration)),
            float(np.sqrt(2 * self.radius_y * penetration)),
        )
