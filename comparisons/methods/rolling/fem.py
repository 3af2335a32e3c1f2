"""Rolling on finite elements in the stationary frame, through which the material flows."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.prepare import Geometry
from comparisons.methods.rolling.bem_fft import GridRolling
from comparisons.methods.solver import Refused
from comparisons.scene.scene import Scene
from reference.fem import Material
from reference.fem.grid_body import ShearBody


class FemRolling(GridRolling):
    """Columns of elements below a grid; stick and slip as on the half-space."""

    name = "fem"
    options_read = frozenset({"element", "inertia"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.options_read = frozenset({"element", "inertia"})
        self.fem = scene.methods.fem
        if scene.poisson_ratio < 0:
            raise Refused("rolling on finite elements: nu from 0")

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Elements per contact radius, one below each cell."""
        finest = int(np.clip(16 * np.sqrt(0.01 / self.scene.compare.tolerance), 12, 24))
        finest -= finest % 4
        return finest // 4, finest // 2, finest

    def model(self, geometry: Geometry) -> str:
        """Name the mesh, and what acts on what."""
        both = "normal and tangential forces coupled" if self.coupled else "uncoupled from pressure"
        flow = f", inertia rho V^2/G = {self.fem.inertia:g}" if self.fem.inertia else ""
        return (
            "a mesh of equal cells that stands still while the material flows through it "
            f"(arbitrary Lagrange-Euler){flow}; {both}"
        )

    def body(self, shape: tuple[int, int], spacing: tuple[float, float]) -> ShearBody:
        """Return the elements below the grid."""
        nu = self.scene.poisson_ratio
        material = Material(self.scene.effective_modulus * (1 - nu**2), nu)
        return ShearBody(
            shape, spacing, material, element=self.fem.element, inertia=self.fem.inertia
        )
