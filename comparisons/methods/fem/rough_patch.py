"""The method `fem` on rough patches, if asked for: a block of elements like any other mesh."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import RoughGeometry
from comparisons.methods.fem.indenter import FAR, TRUNCATION_GRID, FemMesh
from comparisons.methods.fem.step import (
    bytes_of_elimination,
    bytes_of_surface,
    contact_step,
    recovered,
)
from comparisons.scene.scene import Scene
from comparisons.tasks.steps import Row, Step
from comparisons.tasks.task import Task
from reference import fem
from reference.halfspace.areas import corrected_area

# Surface points per side of a rough patch: 32 take 2 s, and the cost grows as the fourth power.
LARGEST_PATCH = 32


class FemPatch(FemMesh[RoughGeometry]):
    """A rough patch pressed node by node, free of its surroundings."""

    name = "fem"

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Rough surfaces, where a mesh that need not repeat is asked for."""
        return scene.rough and scene.methods.fem.mesh == "block"

    def resolutions(self, geometry: RoughGeometry) -> tuple[int, ...]:
        """Return the points of the map, then more."""
        n, most = geometry.points[0], max(geometry.points)
        return tuple(f * n for f in (1, 2, 3) if f * most <= LARGEST_PATCH) or (n,)

    def refusal(self, task: Task[RoughGeometry]) -> str:
        """Refuse patches whose elimination would take minutes."""
        points = max(task.geometry.points) * task.resolution // task.geometry.points[0]
        if points <= LARGEST_PATCH:
            return ""
        return f"{points} points per side, more than {LARGEST_PATCH}: the mesh would be too large"

    def memory(self, task: Task[RoughGeometry]) -> float:
        """Bytes of the elimination, and of the compliance between all points."""
        x, y = _map_lines(task)
        return bytes_of_elimination(fem.TensorMesh(x, y)) + bytes_of_surface(len(x) * len(y))

    def model(self, geometry: RoughGeometry) -> str:
        """Name the mesh."""
        return f"a block below the patch, mesh nodes at the points of the map; {FAR}"

    def rows(self, task: Task[RoughGeometry]) -> Iterator[Row]:
        """Build and condense the body once for all realisations."""
        (x, y), (modulus, nu) = _map_lines(task), self.scene.elastic_constants
        body = fem.half_space_body(fem.TensorMesh(x, y), fem.Material(modulus, nu))
        for realisation in task.realisations:
            sweep = partial(self._steps, task, body, realisation)
            yield Row(sweep, unknowns=body.unknowns, truncation=TRUNCATION_GRID)

    def _steps(
        self,
        task: Task[RoughGeometry],
        body: fem.CondensedBody,
        realisation: int,
        loads: np.ndarray,
    ) -> Iterator[Step]:
        heights = task.geometry.heights(realisation, task.resolution)
        gap = np.ravel(max(task.geometry.top(realisation), heights.max()) - heights)
        for contact in self.press(task, body, gap, loads):
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


def _map_lines(task: Task[RoughGeometry]) -> tuple[np.ndarray, np.ndarray]:
    """Return the mesh lines of a rough patch: through the points of the map."""
    geometry = task.geometry
    nx, ny = (n * task.resolution // geometry.points[0] for n in geometry.points)
    length, width = geometry.size
    return (np.arange(nx) + 0.5) * length / nx, (np.arange(ny) + 0.5) * width / ny
