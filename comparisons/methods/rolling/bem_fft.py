"""Rolling on the half-space below a grid, Cerruti's kernels between its cells."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import Geometry
from comparisons.methods.friction.path import normal_load
from comparisons.methods.normal.bem_fft import BemFft
from comparisons.methods.normal.grid import Grid, cells, make_grid
from comparisons.methods.rolling.creeps import PHYSICS, pairs, quantities, tables_of
from comparisons.scene.scene import Scene
from comparisons.tasks.steps import Row, Step
from comparisons.tasks.task import Task
from reference import loads as reference_loads
from reference.halfspace import areas
from reference.halfspace.cerruti import Compliance
from reference.halfspace.friction import FrictionalPress
from reference.halfspace.traction import NormalAndTangential
from reference.rolling.roll import Creep, RollingStep, roll

# Tighter ones are not asked of the tractions.
LEAST_TOLERANCE = 1e-8
# Where on a cell spin acts is a choice, and its error on three grids not monotone: a part of the
# bar, in cells on half the length of the contact. Measured: docs/rolling.md, other contacts.
SPIN_DOUBT = 0.5


class GridRolling(BemFft):
    """Stick and slip of a steady contact, by Newton's method on its unsymmetric equations."""

    physics = PHYSICS
    options_read = frozenset({"tolerance"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.rolling, friction = tables_of(scene)
        self.friction = friction.coefficient
        self.coupled = friction.coupling == "full" and scene.poisson_ratio < 0.5
        if self.options.tolerance <= LEAST_TOLERANCE:
            self.options_read -= {"tolerance"}

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Cells per contact radius: tractions are known to 1 % on 16, of first order."""
        finest = int(np.clip(24 * np.sqrt(0.01 / self.scene.compare.tolerance), 12, 28))
        finest -= finest % 4
        return finest // 4, finest // 2, finest

    def model(self, geometry: Geometry) -> str:
        """Name the domain, and what acts on what."""
        both = "normal and tangential tractions coupled"
        coupling = both if self.coupled else "pressure uncoupled from them"
        return f"{super().model(geometry)}; steady tractions with Cerruti's kernel; {coupling}"

    def memory(self, task: Task) -> float:
        """Bytes of one grid and of thirty pairs of directions and their images on it."""
        return 1500.0 * cells(task.geometry, task.resolution)

    @property
    def face(self) -> None:
        """None: nothing flat rolls."""

    def warm_up(self, task: Task) -> None:
        """Solve a small paraboloid."""
        x = np.arange(8.0) - 3.5
        body = self.body((8, 8), (1.0, 1.0))
        ball = FrictionalPress(body, (x[:, None] ** 2 + x**2) / 16, 0.5)
        list(roll(ball, reference_loads.Load("penetration", 0.5), [Creep(0.1)]))

    def body(self, shape: tuple[int, int], spacing: tuple[float, float]) -> NormalAndTangential:
        """Return the elastic body below the grid."""
        nu = self.scene.poisson_ratio
        compliance = Compliance.of(self.scene.shear_modulus, nu)
        return NormalAndTangential(shape, spacing, compliance)

    def rows(self, task: Task) -> Iterator[Row]:
        """Lay the grid."""
        grid = make_grid(task.geometry, task.resolution)
        body = self.body(grid.gap.shape, grid.spacing)
        along, across = task.geometry.reach
        cells_along = task.resolution * np.sqrt(along / across)
        doubt = float(SPIN_DOUBT / cells_along) if self.rolling.spin else 0.0
        yield Row(partial(self._rolled, task, body, grid), truncation=doubt)

    def _rolled(
        self,
        task: Task,
        body: NormalAndTangential,
        grid: Grid,
        values: np.ndarray,
    ) -> Iterator[Step]:
        """Yield the steps; each starts from the tractions of the one before."""
        press = FrictionalPress(body, grid.gap, self.friction, self.coupled)
        creeps = [Creep(*pair, self.rolling.spin) for pair in pairs(self.rolling, values)]
        tolerance = max(self.scene.methods.bem_fft.tolerance, LEAST_TOLERANCE)
        load = reference_loads.Load(*normal_load(task))
        for value, step in zip(
            values, roll(press, load, creeps, tolerance=tolerance), strict=False
        ):
            yield Step(
                self._quantities(step, grid, float(value)),
                iterations=step.rounds,
                violation=max(step.violation, step.error),
                unknowns=2 * int(np.count_nonzero(step.pressure)),
                pressure=partial(self._fields, grid, step),
                fields=partial(self._fields, grid, step) if task.wants_pressure else None,
            )

    def _fields(self, grid: Grid, step: RollingStep) -> dict[str, np.ndarray]:
        """Return pressure and tractions, and what part of the bound they use."""
        x, y = grid.centres
        bound, size = self.friction * step.pressure, np.hypot(*step.traction)
        return {
            "penetration": np.array(step.penetration),
            "pressure_x": x.ravel(),
            "pressure_y": y.ravel(),
            "pressure": step.pressure.ravel(),
            "pressure_weight": np.full(x.size, grid.spacing[0] * grid.spacing[1]),
            "pressure_shape": np.array(x.shape),
            "friction_used": np.divide(
                size, bound, out=np.full(size.shape, np.nan), where=bound > 0
            ).ravel(),
            "traction_x": step.traction[0].ravel(),
            "traction_y": step.traction[1].ravel(),
        }

    def _quantities(self, step: RollingStep, grid: Grid, value: float) -> dict[str, float]:
        mask = step.pressure > 0
        forces = step.tangential_force, step.lateral_force
        return quantities(self.rolling, value, forces, self.friction * step.force) | {
            "friction_coefficient": step.tangential_force / step.force,
            "stick_area": float(areas.corrected_area(step.sticking, grid.spacing)),
            "penetration": step.penetration,
            "force": step.force,
            "contact_area": float(areas.corrected_area(mask, grid.spacing)),
            "contact_area_raw": float(areas.raw_area(mask, grid.spacing)),
        }
