"""Flat punches on the half-space grid, edge cells by area fractions.

The contact is the whole face at any load, so that everything is linear: one solve serves all
loads.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.scene.polygons import area_fractions, offset_outline, signed_area
from comparisons.tasks.shown_loads import grid_pressure
from comparisons.tasks.solution import Solution, Stopwatch
from comparisons.tasks.task import Task
from reference.halfspace import FreeOperator
from reference.halfspace.punches import (
    EDGE_OFFSET,
    EDGE_SCATTER,
    SMOOTH_SCATTER,
    FaceResponse,
    respond,
)

Respond = Callable[[FreeOperator, np.ndarray], FaceResponse]
# Corners of the polygon that stands for an ellipse: its outline errs by 1e-6 of the radius.
_CORNERS = 4096
# For readers of its pressure.
RIM = "a cell on the rim carries the force on its part of the face, its middle may lie beyond"


def face_outline(geometry: IndenterGeometry, area: float) -> np.ndarray:
    """Return the corners of the face; an ellipse as a fine polygon of the same area."""
    corners = geometry.indenter.outline
    if corners is not None:
        return corners
    angle = 2 * np.pi * np.arange(_CORNERS) / _CORNERS
    ellipse = np.stack([np.cos(angle), np.sin(angle)], axis=1) * geometry.indenter.reach(0.0)
    return np.asarray(ellipse * np.sqrt(area / signed_area(ellipse)))


def punch_grid(
    geometry: IndenterGeometry, area: float, cells: int, modulus: float
) -> tuple[FreeOperator, np.ndarray, tuple[float, float]]:
    """Return operator, area fractions and origin of square cells, so many per contact radius.

    The outline is moved outwards by what the cells put the edge too far in.
    """
    side = geometry.contact_radius / cells
    corners = offset_outline(face_outline(geometry, area), EDGE_OFFSET * side)
    reach = np.abs(corners).max(axis=0)
    shape = (2 * int(np.ceil(reach[0] / side - 1e-9)), 2 * int(np.ceil(reach[1] / side - 1e-9)))
    origin = (-shape[0] * side / 2, -shape[1] * side / 2)
    fractions = area_fractions(corners, shape, (side, side), origin)
    return FreeOperator(shape, (side, side), modulus), fractions, origin


def solve_punch(
    task: Task, geometry: IndenterGeometry, area: float, solver: Respond = respond
) -> Solution:
    """Solve a flat face of this area once, and scale the answer to every load: F = k d."""
    with Stopwatch() as setup:
        grid = punch_grid(geometry, area, task.resolution, task.scene.effective_modulus)
    operator, fractions, _ = grid
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
    if task.wants_pressure:
        for step, depth in enumerate(depths):
            solution.keep(task, (0, step), partial(_pressure, grid, answer, float(depth)))
    last = float(depths[-1])
    solution.fields = {"penetration": np.array(last)}
    if task.wants_pressure:  # the arrays that plots use, as for every half-space solution
        displacement = last * operator.apply(answer.pressure)
        solution.fields |= _pressure(grid, answer, last) | {
            "pressure_weight": np.full(displacement.size, operator.cell_area),
            "displacement": displacement.ravel(),
            "gap": np.where(fractions > 0, displacement - last, np.inf).ravel(),
        }
    return solution


def _pressure(
    grid: tuple[FreeOperator, np.ndarray, tuple[float, float]], answer: FaceResponse, depth: float
) -> dict[str, np.ndarray]:
    operator, _, origin = grid
    axes = [
        start + (np.arange(n) + 0.5) * step
        for start, n, step in zip(origin, operator.shape, operator.spacing, strict=True)
    ]
    x, y = np.meshgrid(*axes, indexing="ij")
    return grid_pressure(x, y, depth * answer.pressure)
