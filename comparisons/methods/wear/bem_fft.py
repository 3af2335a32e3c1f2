"""Worn shapes on the half-space below a grid."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.friction.path import normal_load
from comparisons.methods.normal.bem_fft import BemFft
from comparisons.methods.normal.grid import Grid, contact_quantities
from comparisons.methods.wear.motion import FRETTING, SLIDING, Motion, worn_picture
from comparisons.scene.scene import Scene
from comparisons.tasks.steps import Step
from comparisons.tasks.task import Task
from reference.contact.body import ElasticBody
from reference.halfspace import areas
from reference.halfspace.wear import Oscillation, WornContact, wear
from reference.loads import Load


class GridWear(BemFft):
    """The half-space on a grid, on which every cell of the shape wears by its own pressure."""

    physics = SLIDING
    options_read = frozenset({"tolerance", "kernel"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.options_read |= {"tolerance"}
        self.motion = Motion.of(scene)

    @property
    def face(self) -> None:
        """None: a flat face wears, and has no edge cells then."""

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Return fewer cells than without wear: steps grow in number with them."""
        if isinstance(geometry, RoughGeometry):
            return super().resolutions(geometry)[:2]
        finest = int(np.clip(24 * np.sqrt(0.01 / self.scene.compare.tolerance), 16, 32))
        return finest // 4, finest // 2, finest

    def model(self, geometry: Geometry) -> str:
        """Name the domain, and what wears."""
        return f"{super().model(geometry)}; each cell wears by its own pressure and slip"

    def warm_up(self, task: Task) -> None:
        """Wear a paraboloid on a handful of cells, on the scene's kind of half-space."""
        x = np.arange(8.0) - 3.5
        gap = (x[:, None] ** 2 + x**2) / 16
        operator = self.operator(task, gap.shape, (1.0, 1.0))
        force = Load("force", 0.1 * operator.effective_modulus)
        for _ in wear(operator, gap, force, 0.1 / operator.effective_modulus, np.ones(1)):
            pass

    def _steps(
        self, task: Task, operator: ElasticBody, grid: Grid, distances: np.ndarray
    ) -> Iterator[Step]:
        control, load = normal_load(task)
        swing = self.motion.oscillation
        oscillation = None if swing is None else Oscillation(*swing)
        depths: list[np.ndarray] = []
        states = wear(
            operator,
            grid.gap,
            Load(control, load),
            self.motion.coefficient,
            distances,
            oscillation,
            tolerance=self.options.tolerance,
        )
        for state in states:
            middle = grid.gap.shape[1] // 2
            depths.append(state.depth[:, middle])
            yield Step(
                self._quantities(task, operator, state, grid),
                iterations=state.iterations,
                violation=state.contact.violation,
                fields=partial(_picture, grid, depths),
            )

    def _quantities(
        self, task: Task, operator: ElasticBody, state: WornContact, grid: Grid
    ) -> dict[str, float]:
        values = contact_quantities(task, operator, state.contact, grid)
        values |= {"worn_volume": state.volume, "wear_depth": float(state.depth.max())}
        mask, periodic = state.contact.mask, operator.periodic
        # the edge of a worn contact is no smooth one, in which a contact could be located
        area = areas.corrected_area(mask, grid.spacing, periodic=periodic)
        values["contact_area"] = float(area)
        if self.motion.oscillation is not None:
            sticking = areas.corrected_area(state.sticking, grid.spacing, periodic=periodic)
            values["stick_area"] = float(sticking)
        return values


class GridFretting(GridWear):
    """A shape that wears where it slips: in proportion to the gap that its stick circle leaves."""

    physics = FRETTING


def _picture(grid: Grid, depths: list[np.ndarray]) -> dict[str, np.ndarray]:
    """Return the worn section through the middle, or along a row of a rough surface."""
    x, _ = grid.centres
    middle = grid.gap.shape[1] // 2
    shape = grid.gap[:, middle]
    inside = np.isfinite(shape)
    place = x[inside, middle]
    shapes = [shape[inside], *(shape[inside] + lost[inside] for lost in depths)]
    return worn_picture(place, shapes)
