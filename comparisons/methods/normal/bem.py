"""The methods `bem_fft` and `bem_dense`: the half-space on a grid.

By FFT and projected conjugate gradients, or by the dense matrix of the chapter, (19.2)-(19.8).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry, elastic_body
from comparisons.methods import Refused, Scene, Task
from comparisons.methods.normal.grid import (
    RIM,
    GridSolver,
    cells,
    contact_cells,
    make_grid,
    punch_grid,
    rough_resolutions,
)
from comparisons.scene.options import FftOptions
from reference.contact.body import ElasticBody
from reference.contact.pivot import CELL_LIMIT
from reference.contact.press import Contact, started_from, sweep
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.halfspace.punches import respond, respond_dense
from reference.layered import LayeredFree, LayeredPeriodic
from reference.loads import Load

# Bytes per cell that a solve holds at most, the gap and the answer included: 61 and 89, measured
# (`roughline bench bem`; the free half-space pads each direction to twice its cells).
BYTES_PERIODIC = 64
BYTES_FREE = 128
# More, on a period, where a load before is there to extrapolate from, and while the stiffness of a
# contact is solved for beside it: 65 and 73 in all, measured. A free half-space has room for both.
EXTRAPOLATED, STIFFNESS = 8, 20
# Where single precision stalls the fallback in double holds 38 and 51 more (2048 points a side).
_DOUBLE_PERIODIC, _DOUBLE_FREE = 42, 56
# Beside the solve: the heights of every surface of a block.
_HEIGHTS = 8

# Factors by which the points of a single surface are refined further, and up to how many cells: the
# third grid of 512 x 512 points takes half a minute (640 x 480, a usual size of maps, have one,
# too), more of small ones a tenth of a second a load. Where not even twice the points are in reach
# every second or third one is a coarser grid: without a second grid there is no bar.
FURTHER = ((2, 2560 * 1920), (4, 2560 * 1920), (8, 256**2), (16, 256**2))
COARSER = (2, 3)


class HalfSpaceGrid(GridSolver[ElasticBody]):
    """Free (zero-padded) or periodic half-space, whatever happens on it: what all physics share."""

    depths = True
    # What the physics adds to the model, in words.
    beside = ""
    # 25 grids of 64 x 64, 8 of 128 x 128, 2 of 256 x 256: of fine ones few are needed, and beside
    # one of them the set-up is nothing.
    shared_cells = 2 * 256**2

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Cells per contact radius from the tolerance; on rough scenes three grids.

        More of a small map or a single small surface: its few spots are known no better by their
        number.
        """
        if isinstance(geometry, RoughGeometry):
            planned = rough_resolutions(geometry)
            if self.scene.random and self.scene.realisations > 1:
                return planned
            own = geometry.points[0]
            further = ((factor * own, most) for factor, most in FURTHER)
            finer = [n for n, most in further if n > planned[-1] and cells(geometry, n) <= most]
            if planned == (own,) and not finer:
                steps = [k for k in COARSER if not any(n % k for n in geometry.points)]
                return (*(own // k for k in steps[:1]), own)
            return (*planned, *finer)
        return self.indenter_resolutions(geometry)

    def memory(self, task: Task) -> float:
        """Bytes of the arrays and transforms of one grid."""
        solve = BYTES_FREE
        if task.geometry.periodic:
            solve = BYTES_PERIODIC + (EXTRAPOLATED if len(task.loads.values) > 1 else 0)
            if {"stiffness", "contact_length_stiffness"} & set(task.quantities):
                solve += STIFFNESS
        heights = _HEIGHTS * len(task.realisations)
        heights = heights if isinstance(task.geometry, RoughGeometry) else 0
        return float(solve + heights) * cells(task.geometry, task.resolution)

    def most_memory(self, task: Task) -> float:
        """Bytes where single precision stalls, and double takes its place."""
        more = _DOUBLE_PERIODIC if task.geometry.periodic else _DOUBLE_FREE
        return self.memory(task) + float(more) * cells(task.geometry, task.resolution)

    def model(self, geometry: Geometry) -> str:
        text = (
            "the surface of the half-space where the shape can touch (its geometric overlap), on "
            "square cells, with the free-space kernel by zero-padding"
        )
        if isinstance(geometry, RoughGeometry):
            kind = "one period" if geometry.periodic else "the patch, free of its surroundings,"
            text = f"{kind} of the surface on its grid; the elastic body enters through its kernel"
        return f"{text}; {self.beside}" if self.beside else text


class BemFft(HalfSpaceGrid):
    """Free (zero-padded) or periodic half-space, layered or not; every scene."""

    name = "bem_fft"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        options = scene.methods.bem_fft
        # The edge cells of a flat face are known on a half-space: one linear problem.
        self.face = respond if scene.half_space.uniform else None
        if self.face and scene.indenter is not None and scene.indenter.flat:
            self.beside = RIM
        if scene.surface is not None and scene.surface.periodic:
            self.kernel = options.kernel
        # Of the warm-up alone, where a face is known: the option is not read then.
        self.tolerance: float = FftOptions.model_fields["tolerance"].default
        if self.face is None or scene.indenter is None or not scene.indenter.flat:
            self.tolerance = options.tolerance

    def operator(
        self, task: Task, shape: tuple[int, int], spacing: tuple[float, float]
    ) -> ElasticBody:
        modulus, periodic = task.scene.effective_modulus, task.geometry.periodic
        if not task.scene.half_space.uniform:
            body = elastic_body(task.scene)
            if periodic:
                return LayeredPeriodic(shape, spacing, body, kernel=self.kernel)
            return LayeredFree(shape, spacing, body)
        if periodic:
            return PeriodicOperator(shape, spacing, modulus, kernel=self.kernel)
        return FreeOperator(shape, spacing, modulus)

    def sweep(
        self, task: Task, operator: ElasticBody, gap: np.ndarray, loads: np.ndarray
    ) -> Iterator[Contact]:
        load = Load(task.loads.control, loads)
        return sweep(operator, gap, load, tolerance=self.tolerance)


# Later loads start from the contact of the last one: of the cells that overlap beside the contact,
# this power of one less the ratio of both overlaps (measured on a paraboloid).
_LATER = 3.7
# Of the fields and transforms on the grid.
_BYTES_OF_CELL = 250.0
# Of the matrix of a flat face: a number, and whether it is finite.
_BYTES_OF_ENTRY = 9.0


class BemDense(GridSolver[FreeOperator]):
    """Exact to round-off on its grid, with work that grows as the cube of the contact cells."""

    name = "bem_dense"
    descends = False

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if scene.surface is not None and scene.surface.periodic:
            raise Refused("the kernel (19.3) is for a free half-space")
        if scene.loading.control == "mean_gap":
            raise Refused("no mean-gap control: use bem_fft or fem, or prescribe the force")
        self.face = respond_dense
        self.most_cells = scene.methods.bem_dense.max_cells

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Up to some 1000 contact cells: beyond it the FFT gives the same answer sooner."""
        if isinstance(geometry, RoughGeometry):
            return rough_resolutions(geometry)
        return (5, 10, 20)

    def refusal(self, task: Task) -> str:
        elongated = super().refusal(task)
        if elongated:
            return elongated
        number, limit = contact_cells(task), self.most_cells
        if number <= limit:
            return ""
        return f"about {number:.0f} contact cells, more than {limit}: use bem_fft"

    def memory(self, task: Task) -> float:
        """Bytes of the factor of the contact cells, the largest of all loads, and of the grid."""
        geometry = task.geometry
        if isinstance(geometry, IndenterGeometry) and geometry.indenter.face_area is not None:
            _, fractions = punch_grid(geometry, geometry.indenter.face_area, task.resolution)
            entries = np.count_nonzero(fractions) ** 2
            return float(_BYTES_OF_ENTRY * entries + _BYTES_OF_CELL * fractions.size)
        rough = isinstance(geometry, RoughGeometry)
        grid = make_grid(geometry, geometry.points[0] if rough else task.resolution)
        total = cells(geometry, task.resolution)
        # cells that overlap at each load, from which the iteration starts: at least one
        gap, reached = grid.gap, list(task.loads.values)
        if task.loads.control == "force":
            operator = self.operator(task, gap.shape, grid.spacing)
            lowest = gap[np.isfinite(gap)].min()
            reached = [lowest + started_from(operator, gap - lowest, float(f)) for f in reached]
        overlapping = np.maximum(np.searchsorted(np.sort(gap, axis=None), reached), 1)
        overlap = overlapping * total / gap.size
        # of a rough surface they are counted twice, with what overlaps beside them
        share = min(1.0, contact_cells(task) / (2 if rough else 1) / overlap[-1])
        last = np.append(0.0, overlap[:-1]) / overlap
        factor = np.minimum(overlap * (share + (1 - share) * (1 - last) ** _LATER), CELL_LIMIT)
        return float(8.0 * factor.max() ** 2 + _BYTES_OF_CELL * total)

    def model(self, geometry: Geometry) -> str:
        if isinstance(geometry, IndenterGeometry) and geometry.indenter.flat:
            return f"only the cells of the face enter the matrix; {RIM}"
        return (
            "only the contact cells enter the matrix; the contact set is found by removing cells "
            "in tension and adding overlapping cells"
        )

    def operator(
        self, task: Task, shape: tuple[int, int], spacing: tuple[float, float]
    ) -> FreeOperator:
        return FreeOperator(shape, spacing, task.scene.effective_modulus)

    def sweep(
        self, task: Task, operator: FreeOperator, gap: np.ndarray, loads: np.ndarray
    ) -> Iterator[Contact]:
        return sweep(operator, gap, Load(task.loads.control, loads), by="pivot")
