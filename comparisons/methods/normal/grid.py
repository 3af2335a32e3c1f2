"""Methods on grids of cells: the grid of a scene, the quantities of a contact, flat punches."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import cache, partial
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from comparisons.facts.quantities.rows import HALF_AXES
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods import Row, Solver, Step, Task
from comparisons.scene.indenters.not_round import Ellipsoid
from comparisons.scene.polygons import area_fractions, offset_outline, signed_area
from comparisons.tasks.distributions import Stretches, of_values, wanted
from comparisons.tasks.shown_loads import MOST_POINTS, grid_pressure
from comparisons.tasks.solution import Solution, Stopwatch
from reference.contact.body import ElasticBody
from reference.contact.press import SHORTEST_COARSENED, sweep
from reference.errors import ConvergenceError
from reference.halfspace import Contact, FreeOperator
from reference.halfspace import areas as area_measures
from reference.halfspace.areas import located_area, on_whole_patch, reaches_rim
from reference.halfspace.punches import (
    EDGE_OFFSET,
    EDGE_SCATTER,
    SMOOTH_SCATTER,
    FaceResponse,
    respond,
)
from reference.loads import Load

# Blocks a side of a stored field; fields of up to MOST_POINTS cells are stored as they are.
SIDE = 512

Blocks = tuple[np.ndarray, np.ndarray]


def blocks_of(shape: tuple[int, ...]) -> Blocks | None:
    """Return the first rows and columns of the blocks of a field; None if it is small enough.

    The last blocks may be smaller than the others.

    >>> blocks_of((4, 4)) is None
    True
    >>> [len(starts) for starts in blocks_of((4096, 1100))]
    [512, 138]
    """
    if shape[0] * shape[1] <= MOST_POINTS:
        return None
    step = -(-max(shape) // SIDE)
    return np.arange(0, shape[0], step), np.arange(0, shape[1], step)


def block_means(field: np.ndarray, blocks: Blocks | None) -> np.ndarray:
    """Return the means over the blocks, or the field itself; forces are kept."""
    if blocks is None:
        return field
    rows, columns = blocks
    sums = np.add.reduceat(np.add.reduceat(field, columns, axis=1, dtype=float), rows, axis=0)
    sides = [np.diff([*starts, n]) for starts, n in zip(blocks, field.shape, strict=True)]
    return np.asarray(sums / np.outer(*sides))


AnyOperator = TypeVar("AnyOperator", bound=ElasticBody)
# Cells of the finest grid planned after refining by a factor: a 512 x 512 map is refined once
# (by FFT BEM of a single surface further: `bem.FURTHER`).
MOST_INDENTER_CELLS = 3_000_000
LARGEST_REFINED = {1: 2**24, 2: 1400**2, 4: 512**2}


def ball(side: int) -> np.ndarray:
    """Return the gap of a ball on cells of size 1, a side of which is its radius: to compile on."""
    return np.asarray(((np.indices((side, side)) - (side - 1) / 2) ** 2).sum(axis=0) / (2 * side))


SMALL_BALL = ball(8)

# Largest error of the unit displacement from which a stiffness is taken; it errs by the square of
# that. The looser one is as far as single precision comes in one go.
_STIFFNESS, _RANDOM_STIFFNESS = 1e-6, 1e-4


@dataclass(frozen=True)
class Grid:
    """Cells of a half-space problem: the initial gap at their centres."""

    gap: np.ndarray
    spacing: tuple[float, float]
    origin: tuple[float, float]

    @property
    def centres(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates of the cell centres, each of shape (nx, ny)."""
        axes = [
            start + (np.arange(n) + 0.5) * step
            for n, step, start in zip(self.gap.shape, self.spacing, self.origin, strict=True)
        ]
        x, y = np.meshgrid(*axes, indexing="ij")
        return x, y


def indenter_shape(geometry: IndenterGeometry, resolution: int) -> tuple[int, int]:
    """Return the number of cells in x and y that cover the geometric overlap."""
    cell = geometry.contact_radius / resolution
    half_x, half_y = (max(1, int(np.ceil(half / cell - 1e-9))) for half in geometry.reach)
    return 2 * half_x, 2 * half_y


def make_grid(geometry: Geometry, resolution: int, realisation: int = 0) -> Grid:
    """Return the grid of a scene: cells where contact is possible, and none beyond.

    The surface never rises above its undeformed level, so contact stays inside the region where
    the shape overlaps the half-space.
    """
    if isinstance(geometry, RoughGeometry):
        heights = geometry.heights(realisation, resolution)
        top = max(geometry.top(realisation), float(heights.max()))
        return Grid(top - heights, geometry.spacing(heights), (0.0, 0.0))
    shape = indenter_shape(geometry, resolution)
    cell = geometry.contact_radius / resolution
    origin = (-shape[0] * cell / 2, -shape[1] * cell / 2)
    empty = Grid(np.zeros(shape), (cell, cell), origin)
    return Grid(geometry.indenter.gap(*empty.centres), empty.spacing, origin)


def grid_shape(geometry: Geometry, resolution: int) -> tuple[int, int]:
    """Return the number of grid cells in x and y."""
    if isinstance(geometry, RoughGeometry):
        return resolution, round(resolution * geometry.points[1] / geometry.points[0])
    return indenter_shape(geometry, resolution)


def cells(geometry: Geometry, resolution: int) -> int:
    """Return the number of grid cells of a resolution."""
    nx, ny = grid_shape(geometry, resolution)
    return nx * ny


def contact_cells(task: Task) -> float:
    """Estimate the number of cells in contact at the largest load."""
    geometry, load = task.geometry, float(task.loads.values[-1])
    total = cells(geometry, task.resolution)
    if isinstance(geometry, IndenterGeometry):
        if geometry.indenter.face_area is not None:
            half_x, half_y = geometry.reach
            return total * geometry.indenter.face_area / (4 * half_x * half_y)
        return float(np.pi * task.resolution**2)
    if task.loads.control == "force":
        # A/A0 is about 2 F / (E* A0 h') at small loads, and never above it; the iteration starts
        # from the geometric overlap, which is about twice as large.
        nominal = task.scene.effective_modulus * geometry.area * geometry.rms_slope
        return total * min(1.0, 4 * load / nominal)
    heights = geometry.heights(0, geometry.points[0])
    level = heights.max() - load if task.loads.control == "penetration" else heights.mean() - load
    return float(total * np.mean(heights > level))


def rough_resolutions(geometry: RoughGeometry) -> tuple[int, ...]:
    """Return the surface's own points and finer grids of the same surface, as far as affordable."""
    n = geometry.points[0]
    finer = [f * n for f in (1, 2, 4) if cells(geometry, f * n) <= LARGEST_REFINED[f]]
    return tuple(finer or [n])


@cache
def _coarsen_once() -> None:
    """Press a grid that begins on coarser ones, by code that small grids do not run.

    It is the same for every elastic body: once in a process serves all.
    """
    gap = ball(2 * SHORTEST_COARSENED)
    forces = Load("force", 0.01 * gap.size * np.array([1.0, 1.1]))
    list(sweep(FreeOperator(gap.shape, (1.0, 1.0), 1.0), gap, forces))


class GridSolver(Solver[Geometry], Generic[AnyOperator]):
    """A solver of an elastic body below a grid of rectangular cells."""

    # Solver of the linear problem of a flat face; None: faces are like other shapes.
    face: Respond | None = None
    # Whether contact is found by descent, which begins large grids on coarser ones.
    descends: ClassVar[bool] = True

    def operator(
        self, task: Task, shape: tuple[int, int], spacing: tuple[float, float]
    ) -> AnyOperator:
        """Return the operator from pressure to displacement."""
        raise NotImplementedError

    def sweep(
        self, task: Task, operator: AnyOperator, gap: np.ndarray, loads: np.ndarray
    ) -> Iterator[Contact]:
        """Yield the contacts at the loads still to do."""
        raise NotImplementedError

    def indenter_resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Return cells per contact radius.

        Measured on Hertz: the force errs by about 1 % at 8 cells per radius, and falls with the
        square of the cell; area and sharp edges converge only linearly. Of a flat face one solve
        serves all loads, and a fine grid is what knows corners to 0.05 %.
        """
        return self.series(64, 128 if geometry.indenter.flat else 32, 256)

    def pressed_on(self, operator: AnyOperator) -> AnyOperator:
        """Return the body that a shape is pressed on: with springs of a penalty it is softer."""
        return operator

    def warm_up(self, task: Task) -> None:
        """Solve a paraboloid on a handful of the scene's cells, on its kind of half-space.

        Layers that are thin against other cells would be none.
        """
        if self.descends:
            _coarsen_once()
        rough = isinstance(task.geometry, RoughGeometry)
        side = task.geometry.size[0] if rough else task.geometry.contact_radius
        cell = float(side / task.resolution)
        gap = cell * SMALL_BALL
        operator = self.operator(task, gap.shape, (cell, cell))
        # Half the mean gap is open on a periodic half-space, and a contact on a free one, whose
        # width is nearly half of the grid's, or more; the force is about that of it.
        load = 0.5 * float(gap.mean())
        if task.loads.control == "force":
            load = 0.01 * operator.effective_modulus * cell**2 * gap.size
        for contact in self.sweep(task, operator, gap, np.array([load, 1.1 * load])):
            if rough:
                located_area(contact, patch=True)

    def refusal(self, task: Task) -> str:
        """Refuse grids that only a very elongated indenter asks for."""
        number = cells(task.geometry, task.resolution)
        # A round contact needs some 10 N^2 cells.
        round_one = isinstance(task.geometry, RoughGeometry) or number <= 100 * task.resolution**2
        if round_one or number <= MOST_INDENTER_CELLS:
            return ""
        return f"{number} cells to cover an elongated contact, more than {MOST_INDENTER_CELLS}"

    def solve(self, task: Task) -> Solution:
        """Solve every realisation on the same operator; a flat punch with its edge cells."""
        geometry, face = task.geometry, self.face
        area = geometry.indenter.face_area if isinstance(geometry, IndenterGeometry) else None
        if isinstance(geometry, IndenterGeometry) and face is not None and area is not None:
            return solve_punch(task, geometry, area, face)
        return super().solve(task)

    def rows(self, task: Task) -> Iterator[Row]:
        operator = None
        for realisation in task.realisations:
            grid = make_grid(task.geometry, task.resolution, realisation)
            if operator is None:
                operator = self.operator(task, grid.gap.shape, grid.spacing)
                # kernels are made when first asked for: they are set-up
                operator.convolution(np.float64)
            sweep = partial(self._steps, task, operator, grid)
            yield Row(sweep, unknowns=int(np.isfinite(grid.gap).sum()))

    def _steps(
        self, task: Task, operator: AnyOperator, grid: Grid, loads: np.ndarray
    ) -> Iterator[Step]:
        """Yield the steps of the loads that a surface admits; then the next one's fault is raised.

        A load beyond what this surface admits is a lost step, not a wrong argument, because another
        realisation may admit it.
        """
        # the load below which the surface has an answer, and why not above
        limit, reason, control = np.inf, "", task.loads.control
        if isinstance(task.geometry, RoughGeometry):
            mean, periodic = float(grid.gap.mean()), operator.periodic
            if control == "mean_gap":
                limit, reason = mean, f"no contact: at first touch the mean gap is {mean:.3g} m"
            elif control == "penetration" and periodic and not self.pressed_on(operator).sinks:
                limit, reason = mean, f"no gap is left, the surfaces are closed at {mean:.3g} m"
        within = loads[loads < limit]
        if len(within):
            for contact in self.sweep(task, operator, grid.gap, within):
                yield self.step(task, operator, contact, grid)
        if len(within) < len(loads):
            called = control.replace("_", " ")
            raise ConvergenceError(f"{called} {loads[len(within)]:.3g} m: {reason}")

    def step(self, task: Task, operator: AnyOperator, contact: Contact, grid: Grid) -> Step:
        """Return the step of a solved contact."""
        return contact_step(task, operator, contact, grid)


def contact_step(task: Task, operator: ElasticBody, contact: Contact, grid: Grid) -> Step:
    """Return the step of a solved contact on a grid."""
    return Step(
        contact_quantities(task, operator, contact, grid),
        iterations=contact.iterations,
        violation=contact.violation,
        distributions=partial(contact_distributions, task, contact, grid),
        pressure=pressure_of(task, contact, grid),
        fields=partial(contact_fields, task, contact, grid),
    )


def counted_quantities(
    state: Any, spacing: tuple[float, float], *, periodic: bool = False
) -> dict[str, float]:
    """Return depth, force and the counted areas of a contact's `pressure` on cells."""
    mask = state.pressure > 0
    return {
        "penetration": state.penetration,
        "force": state.force,
        "contact_area": float(area_measures.corrected_area(mask, spacing, periodic)),
        "contact_area_raw": float(area_measures.raw_area(mask, spacing)),
    }


def contact_quantities(
    task: Task, operator: ElasticBody, contact: Contact, grid: Grid
) -> dict[str, float]:
    """Return the quantities of one load step; the costly ones only if asked for.

    Of an elastic contact on a free patch they are those of the whole patch (`on_whole_patch`).
    """
    mask = contact.pressure > 0
    quantities = set(task.quantities)
    periodic = operator.periodic
    rough = isinstance(task.geometry, RoughGeometry)
    values = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area_raw": float(area_measures.raw_area(mask, grid.spacing)),
        "contact_area": located_area(contact, patch=rough),
        **half_axes(task, *grid.centres, contact.pressure),
    }
    if rough:
        values["mean_gap"] = contact.mean_gap
        # of all cells: fields of large maps are means over blocks
        values["pressure_peak"] = float(contact.pressure.max())
        if quantities & {"contact_count", "contact_length"}:
            patches = area_measures.patches(mask, grid.spacing, periodic=periodic)
            length = float(np.sqrt(4 * patches.areas / np.pi).sum())
            counted = {"contact_count": float(patches.count), "contact_length": length}
            values |= {name: value for name, value in counted.items() if name in quantities}
    stiff = bool(quantities & {"stiffness", "contact_length_stiffness"})
    cut = rough and not periodic and not task.scene.physics and reaches_rim(mask)
    if stiff or cut:
        accuracy = _STIFFNESS if stiff and not task.geometry.random else _RANDOM_STIFFNESS
        contact.forget_displacement()  # the stiffness is a solve of its own, in as much memory
        # of what was pressed: with a penalty its springs give way, too
        response = area_measures.contact_response(contact.operator, mask, accuracy)
        if stiff:
            values["stiffness"] = response.stiffness
        if cut:
            area = values["contact_area"]
            values |= asdict(on_whole_patch(contact, response, task.loads.control, area))
    if rough:
        values["penetration_mean_plane"] = values["penetration"] - float(grid.gap.mean())
    if "energy" in quantities:
        values["energy"] = float(area_measures.elastic_energy(operator, contact.pressure))
    return values


def half_axes(task: Task, x: np.ndarray, y: np.ndarray, pressed: np.ndarray) -> dict[str, float]:
    """Return the half-axes of an ellipsoid's contact from forces at points; of others nothing.

    Their second moments are those of Hertz's pressure, <x^2> = a^2/5: of second order in the cells
    across, while the outermost cell is known to a cell.
    """
    scene = task.scene
    hertz = scene.half_space.uniform and {*scene.physics} <= {"rolling", "friction"}
    if not (isinstance(scene.indenter, Ellipsoid) and hertz and scene.body is None):
        return {}
    share = pressed / max(float(pressed.sum()), np.finfo(float).tiny)
    axes = (float(np.sqrt(5 * (share * place**2).sum())) for place in (x, y))
    return dict(zip(HALF_AXES, axes, strict=True))


def contact_distributions(task: Task, contact: Contact, grid: Grid) -> dict[str, np.ndarray]:
    """Return the distributions of one load step that are asked for."""
    names = wanted(task)
    if not names:
        return {}
    mask, share = contact.mask, 1.0 / contact.pressure.size
    values: dict[str, Callable[[], Stretches]] = {
        "pressure_distribution": lambda: Stretches.points(contact.pressure[mask], share),
        # round-off may close an open cell a little more than entirely: it is the narrowest gap
        "gap_distribution": lambda: Stretches.points(
            np.maximum(contact.gap[~mask], np.finfo(float).tiny), share
        ),
        "contact_sizes": lambda: Stretches.points(
            area_measures.patches(mask, grid.spacing, periodic=contact.operator.periodic).areas
        ),
    }
    return of_values(task, {name: values[name]() for name in names})


def pressure_of(
    task: Task, contact: Contact, grid: Grid
) -> Callable[[], dict[str, np.ndarray]] | None:
    """Return what makes the pressure that the report shows, kept in single precision."""
    if not task.wants_pressure or contact.pressure.size > MOST_POINTS:
        return None
    pressure = contact.pressure.astype(np.float32)
    return lambda: grid_pressure(*grid.centres, pressure)


def contact_fields(task: Task, contact: Contact, grid: Grid) -> dict[str, np.ndarray]:
    """Return the arrays that plots and pictures use."""
    fields: dict[str, np.ndarray] = {"penetration": np.array(contact.penetration)}
    rough = isinstance(task.geometry, RoughGeometry)
    blocks = blocks_of(grid.gap.shape) if rough else None
    coarse = partial(block_means, blocks=blocks)
    if task.wants_pressure:
        x, y = (coarse(axis) for axis in grid.centres)
        cell = grid.spacing[0] * grid.spacing[1]
        if blocks is None:
            area = np.full(grid.gap.shape, cell)
        else:
            sides = [np.diff([*b, n]) for b, n in zip(blocks, grid.gap.shape, strict=True)]
            area = cell * np.outer(*sides)
        fields |= grid_pressure(x, y, coarse(contact.pressure)) | {
            "pressure_weight": area.ravel(),
            "displacement": coarse(contact.displacement).ravel(),
            # Infinite where the shape has no material.
            "gap": (coarse(grid.gap) - contact.penetration + coarse(contact.displacement)).ravel(),
        }
    if isinstance(task.geometry, RoughGeometry):
        heights = task.geometry.heights(task.realisations[0], task.resolution)
        fields["heights"] = coarse(heights)
        fields["size"] = np.array(task.geometry.size)
        fields["contact"] = coarse(contact.pressure > 0)  # of a block the share in contact
    return fields


Respond = Callable[[FreeOperator, np.ndarray], FaceResponse]
# Corners of the polygon that stands for an ellipse: its outline errs by 1e-6 of the radius.
_CORNERS = 4096
# For readers of its pressure.
RIM = "a cell on the rim carries the force on its part of the face, its middle may lie beyond"


def punch_grid(geometry: IndenterGeometry, area: float, cells: int) -> tuple[Grid, np.ndarray]:
    """Return square cells, so many per contact radius, and their shares below a face of an area.

    The outline, of an ellipse a fine polygon of the same area, is moved outwards by what the cells
    put the edge too far in.
    """
    side, corners = geometry.contact_radius / cells, geometry.indenter.outline
    if corners is None:
        angle = 2 * np.pi * np.arange(_CORNERS) / _CORNERS
        ellipse = np.stack([np.cos(angle), np.sin(angle)], axis=1) * geometry.indenter.reach(0.0)
        corners = np.asarray(ellipse * np.sqrt(area / signed_area(ellipse)))
    corners = offset_outline(corners, EDGE_OFFSET * side)
    reach = np.abs(corners).max(axis=0)
    shape = (2 * int(np.ceil(reach[0] / side - 1e-9)), 2 * int(np.ceil(reach[1] / side - 1e-9)))
    origin = (-shape[0] * side / 2, -shape[1] * side / 2)
    fractions = area_fractions(corners, shape, (side, side), origin)
    return Grid(np.where(fractions > 0, 0.0, np.inf), (side, side), origin), fractions


def solve_punch(
    task: Task, geometry: IndenterGeometry, area: float, solver: Respond = respond
) -> Solution:
    """Solve a flat face of this area once, and scale the answer to every load: F = k d."""
    with Stopwatch() as setup:
        grid, fractions = punch_grid(geometry, area, task.resolution)
        operator = FreeOperator(fractions.shape, grid.spacing, task.scene.effective_modulus)
    cells = int(np.count_nonzero(fractions))
    answer = solver(operator, fractions)
    loads, stiffness = task.loads.values, answer.stiffness
    depths = loads if task.loads.control == "penetration" else loads / stiffness
    curves = {
        "penetration": depths,
        "force": stiffness * depths,
        "contact_area_raw": float(cells * operator.cell_area),
        "contact_area": area,
        "stiffness": stiffness,
        "energy": stiffness * depths * (depths / 2),
    }
    solution = Solution.of(
        task,
        curves,
        unknowns=cells,
        iterations=answer.iterations,
        violation=answer.residual,
        setup_seconds=setup.seconds,
    )
    solution.exact = ("contact_area", "contact_radius", "equivalent_radius")
    # The stiffness goes with the radius: both err by the same share.
    scatter = SMOOTH_SCATTER if geometry.indenter.outline is None else EDGE_SCATTER
    solution.truncation = scatter / task.resolution
    last = float(depths[-1])
    solution.fields = {"penetration": np.array(last)}
    if task.wants_pressure:  # the arrays that plots use, as for every half-space solution

        def pressure(depth: float) -> dict[str, np.ndarray]:
            return grid_pressure(*grid.centres, depth * answer.pressure)

        for step, depth in enumerate(depths):
            solution.keep(task, (0, step), partial(pressure, float(depth)))
        displacement = last * operator.apply(answer.pressure)
        solution.fields |= pressure(last) | {
            "pressure_weight": np.full(displacement.size, operator.cell_area),
            "displacement": displacement.ravel(),
            "gap": (grid.gap + displacement - last).ravel(),
        }
    return solution
