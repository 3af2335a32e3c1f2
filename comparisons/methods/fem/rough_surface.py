"""The method `fem` on grids: elements below every cell, wave by wave.

It takes rough surfaces, and indenters on bodies that depend on depth. A rough patch is pressed on a
block of elements like any other mesh, if asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from comparisons.facts.methods import REPEATING_ELEMENTS
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry, elastic_body
from comparisons.methods import Refused, Row, Scene, Step, Task
from comparisons.methods.fem.indenter import (
    FAR,
    TRUNCATION_GRID,
    FemSolver,
    enforcement_of,
    options_problem,
)
from comparisons.methods.fem.step import (
    bytes_of_elimination,
    bytes_of_surface,
    contact_step,
    recovered,
)
from comparisons.methods.normal.grid import Grid, GridSolver, cells, rough_resolutions
from reference import fem
from reference.elasticity import Material
from reference.fem import grid_body
from reference.fem.grid_body import LONGEST, FreeBody, PeriodicBody
from reference.halfspace import Contact
from reference.halfspace.areas import corrected_area
from reference.layered import Stack
from reference.layered.layered_grid import Body
from reference.layered.stresses import inside
from reference.loads import Load, LoadPath

# Double arrays of one grid that a solve holds at once: those of `bem_fft`, and some kernels.
ARRAYS_PERIODIC, ARRAYS_FREE = 36, 62
# Matrices of the columns that are made at once, and compliances that are kept.
BYTES_OF_COLUMNS = 1.5e8
_IN_PLANE = {
    "linear": "bilinear in the plane, quadratic in depth",
    "splines": "quadratic splines in the plane, quadratic in depth",
    "quadratic": "27 nodes, pressures of a mixed method",
}

_IMPEDANCE = "the impedance of a half-space eight cells down (theory shared with bem_fft)"


class FemRepeating(GridSolver[FreeBody | PeriodicBody]):
    """A rough surface, or layers and grading, on elements that repeat from cell to cell."""

    name = "fem"
    title = REPEATING_ELEMENTS
    depths = True
    shared_cells = 25 * 256**2

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        unfit = options_problem(scene)
        if unfit:
            raise Refused(unfit)
        self.enforcement = enforcement_of(scene)
        self.element, self.bottom = scene.methods.fem.element, scene.methods.fem.bottom
        table = scene.half_space
        if self.bottom != "clamped" and (table.thickness is not None or table.grading is not None):
            raise Refused(
                "an impedance bottom is a half-space of one modulus, which does not lie below"
            )

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        if scene.rough:
            return scene.methods.fem.mesh == "repeating"
        return not scene.half_space.uniform

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Return the grids of the half-space solver; of an ensemble all but the finest.

        Two grids tell a mesh's error in a mean; the third would cost as much as the whole truth.
        """
        if isinstance(geometry, IndenterGeometry):
            return self.indenter_resolutions(geometry)
        planned = rough_resolutions(geometry)
        ensemble = self.scene.random and self.scene.realisations > 1
        return planned[:2] if ensemble else planned

    def refusal(self, task: Task) -> str:
        geometry = task.geometry
        if not isinstance(geometry, RoughGeometry):
            return super().refusal(task)
        sides = [side / n for side, n in zip(geometry.size, geometry.points, strict=True)]
        if geometry.periodic or max(sides) <= LONGEST * min(sides):
            return super().refusal(task)
        return f"a free patch of cells longer than {LONGEST} times their width"

    def memory(self, task: Task) -> float:
        """Bytes of the arrays and transforms of one grid, and of the columns."""
        arrays = ARRAYS_PERIODIC if task.geometry.periodic else ARRAYS_FREE
        stored = 4 * len(task.realisations)
        grid = 8.0 * (arrays + stored) * cells(task.geometry, task.resolution)
        return grid + BYTES_OF_COLUMNS

    def model(self, geometry: Geometry) -> str:
        mesh = f"hexahedra ({_IN_PLANE[self.element]}) below every cell"
        table = self.scene.half_space
        if table.thickness is not None:
            base = ", down to the rigid base"
        elif self.bottom == "impedance":
            base = f", down to {_IMPEDANCE}"
        else:
            base = ", down to a clamp two periods down"
        if geometry.periodic:
            return mesh + base
        far = "Boussinesq fields" if table.uniform else "the continuum of the same body"
        shared = base if self.bottom == "impedance" else ""
        return f"{mesh}{shared}, free of their surroundings; further away than some cells {far}"

    def operator(
        self, task: Task, shape: tuple[int, int], spacing: tuple[float, float]
    ) -> FreeBody | PeriodicBody:
        body: fem.Material | Body = fem.Material(*self.scene.elastic_constants)
        if not self.scene.half_space.uniform:
            body = elastic_body(self.scene)
        kind = PeriodicBody if task.geometry.periodic else FreeBody
        return kind(shape, spacing, body, self.element, bottom=self.bottom)

    def step(
        self, task: Task, operator: FreeBody | PeriodicBody, contact: Contact, grid: Grid
    ) -> Step:
        step = super().step(task, operator, contact, grid)
        return replace(step, body_fields=partial(below, self.scene, contact, grid))

    def pressed_on(self, operator: FreeBody | PeriodicBody) -> FreeBody | PeriodicBody:
        return grid_body.body_under(operator, self.enforcement)

    def sweep(
        self, task: Task, operator: FreeBody | PeriodicBody, gap: np.ndarray, loads: np.ndarray
    ) -> Iterator[Contact]:
        return grid_body.sweep(operator, gap, Load(task.loads.control, loads), self.enforcement)


# Surface points per side of a rough patch: 32 take 2 s, and the cost grows as the fourth power.
LARGEST_PATCH = 32


class FemPatch(FemSolver[RoughGeometry]):
    """A rough patch pressed node by node, free of its surroundings."""

    name = "fem"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.enforcement = enforcement_of(scene)

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Rough surfaces, where a mesh that need not repeat is asked for."""
        return scene.rough and scene.methods.fem.mesh == "block"

    def resolutions(self, geometry: RoughGeometry) -> tuple[int, ...]:
        """Return the points of the map, then more."""
        n, most = geometry.points[0], max(geometry.points)
        return tuple(f * n for f in (1, 2, 3) if f * most <= LARGEST_PATCH) or (n,)

    def refusal(self, task: Task[RoughGeometry]) -> str:
        points = max(task.geometry.points) * task.resolution // task.geometry.points[0]
        if points <= LARGEST_PATCH:
            return ""
        return f"{points} points per side, more than {LARGEST_PATCH}: the mesh would be too large"

    def memory(self, task: Task[RoughGeometry]) -> float:
        """Bytes of the elimination, and of the compliance between all points."""
        x, y = _map_lines(task)
        return bytes_of_elimination(fem.TensorMesh(x, y)) + bytes_of_surface(len(x) * len(y))

    def model(self, geometry: RoughGeometry) -> str:
        return f"a block below the patch, mesh nodes at the points of the map; {FAR}"

    def rows(self, task: Task[RoughGeometry]) -> Iterator[Row]:
        (x, y), (modulus, nu) = _map_lines(task), self.scene.elastic_constants
        body = fem.half_space_body(fem.TensorMesh(x, y), fem.Material(modulus, nu))

        def steps(realisation: int, loads: np.ndarray) -> Iterator[Step]:
            heights = task.geometry.heights(realisation, task.resolution)
            gap = np.ravel(max(task.geometry.top(realisation), heights.max()) - heights)
            load = LoadPath(task.loads.control, loads)
            for contact in fem.press(body, gap, load, self.enforcement):
                mean_gap = float(np.mean(gap + contact.displacement) - contact.penetration)
                # with the perimeter correction of grids: the nodes form one
                mask = contact.active.reshape(heights.shape)
                area = float(corrected_area(mask, task.geometry.spacing(mask)))
                mean_plane = contact.penetration - float(gap.mean())
                yield contact_step(
                    task,
                    body,
                    gap,
                    contact,
                    area,
                    quantities={"mean_gap": mean_gap, "penetration_mean_plane": mean_plane},
                    fields={
                        "heights": heights,
                        "size": np.array(task.geometry.size),
                        "contact": (contact.pressure > 0).reshape(heights.shape),
                    },
                    body_fields=partial(recovered, body, contact.reactions),
                )

        for realisation in task.realisations:
            sweep = partial(steps, realisation)
            yield Row(sweep, unknowns=body.unknowns, truncation=TRUNCATION_GRID)


def _map_lines(task: Task[RoughGeometry]) -> tuple[np.ndarray, np.ndarray]:
    """Return the mesh lines of a rough patch: through the points of the map."""
    geometry = task.geometry
    nx, ny = (n * task.resolution // geometry.points[0] for n in geometry.points)
    length, width = geometry.size
    return (np.arange(nx) + 0.5) * length / nx, (np.arange(ny) + 0.5) * width / ny


# Empty cells around a free patch, in its sides: images of it change the largest stress by 1 %.
_PADDED = 4
# Depths: the first in cells, each over the one above, and the last in the patch's shorter side.
_FIRST, _RATIO, _DEEPEST = 0.25, 1.25, 0.5
# How far below them a graded body has slices, over the last depth.
_BELOW = 8.0
# Nearly the surface, where the picture has it.
_SURFACE = 1e-6
# Points a side of what is shown, and cells a side of the transforms of a rough surface: those of a
# patch of 2048, free of its surroundings, would need 24 GB.
_SHOWN, _WIDEST = 64, 1024


def below(scene: Scene, contact: Contact, grid: Grid) -> dict[str, np.ndarray]:
    """Return a mesh of the part of the body where the stress of von Mises is highest.

    The fields are those of waves in the continuum under the pressure of the cells: of a large rough
    surface under those about the highest pressure alone (``stressed_cells``); of an indenter, which
    is smooth, under means over blocks of them, as many as are shown.
    """
    body: Body = elastic_body(scene)
    if scene.half_space.uniform:
        body = Stack([], [], Material(*scene.elastic_constants))
    pressure, spacing, origin = contact.pressure, grid.spacing, grid.origin
    periodic, part = contact.operator.periodic, dict[str, np.ndarray]()
    most = _WIDEST if periodic else _WIDEST // _PADDED
    if scene.rough and max(pressure.shape) > most:
        rows, columns = _about(pressure, most, repeated=periodic)
        nx, ny = pressure.shape
        pressure = pressure[np.ix_(rows % nx, columns % ny)]
        origin = origin[0] + rows[0] * spacing[0], origin[1] + columns[0] * spacing[1]
        part["stressed_cells"] = np.array(pressure.shape)
    if not scene.rough:
        step = -(-max(pressure.shape) // _SHOWN)
        pressure = np.pad(pressure, [(0, -n % step) for n in pressure.shape])
        rows, columns = (n // step for n in pressure.shape)
        pressure = pressure.reshape(rows, step, columns, step).mean(axis=(1, 3))
        spacing = step * spacing[0], step * spacing[1]
    shape = pressure.shape
    # depths in a geometric series
    side = min(spacing)
    last = _DEEPEST * min(n * step for n, step in zip(shape, spacing, strict=True))
    if isinstance(body, Stack) and body.base is None:
        last = min(last, body.total)
    count = max(2, int(np.ceil(np.log(last / (_FIRST * side)) / np.log(_RATIO))))
    depths = np.append(_SURFACE * min(side, last), last * _RATIO ** -np.arange(count, -1.0, -1.0))
    if isinstance(body, Stack):  # on either side of an interface, where stresses jump
        interfaces = np.cumsum(body.thicknesses)
        beside = np.concatenate([interfaces * (1 - _SURFACE), interfaces * (1 + _SURFACE)])
        depths = np.unique(np.append(depths, beside[beside < last]))
    else:
        # a graded body in slices between the depths that are shown, and some below
        deeper = np.arange(1.0, np.ceil(np.log(_BELOW) / np.log(_RATIO)) + 1)
        ends = np.concatenate([[0.0], depths[1:], depths[-1] * _RATIO**deeper])
        materials = body.slices(ends)
        body = Stack(np.diff(ends)[:-1].tolist(), materials[:-1], materials[-1])
    if not periodic:
        pressure = np.pad(pressure, [(0, (_PADDED - 1) * n) for n in shape])
    fields = list(inside(body, pressure, spacing, depths, kept=shape))
    stresses = [field.von_mises for field in fields]
    highest = max(stresses, key=np.max)
    kept = _about(highest, _SHOWN)
    # hexahedra between the centres of cells and the depths; z points into the body
    x, y = (
        start + (cells + 0.5) * step
        for start, cells, step in zip(origin, kept, spacing, strict=True)
    )
    z = np.array([field.depth for field in fields])
    z[0] = 0.0
    where = np.ix_(*kept)
    points = np.stack(np.meshgrid(z, x, y, indexing="ij"), axis=-1)[..., [1, 2, 0]]
    number = np.arange(z.size * x.size * y.size).reshape(z.size, x.size, y.size)
    corners = [
        number[k : z.size - 1 + k, i : x.size - 1 + i, j : y.size - 1 + j]
        for k in (0, 1)
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
    ]
    moved = [np.stack([part[where] for part in f.displacement], axis=-1) for f in fields]
    return part | {
        "mesh_points": points.reshape(-1, 3),
        "mesh_cells": np.stack([corner.ravel() for corner in corners], axis=-1),
        "mesh_displacement": np.array(moved).reshape(-1, 3),
        "mesh_von_mises": np.array([stress[where] for stress in stresses]).ravel(),
        "von_mises_depth": np.array([field.depth for field in fields]),
        "von_mises_highest": np.array([stress.max() for stress in stresses]),
    }


def _about(field: np.ndarray, side: int, *, repeated: bool = False) -> list[np.ndarray]:
    """Return the places along each axis of at most so many cells a side about the highest value.

    Of a repeated field they may lie beyond its ends.
    """
    places = []
    for n, at in zip(field.shape, np.unravel_index(field.argmax(), field.shape), strict=True):
        first = int(at) - side // 2
        if n <= side or not repeated:
            first = int(np.clip(first, 0, max(n - side, 0)))
        places.append(first + np.arange(min(side, n)))
    return places
