"""The shapes of pictures: rough surfaces, hills of pressure, bodies deformed and cut open.

They are arrays only; `reports.pictures.rendering` and `reports.pictures.turning` draw them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

# Corners of the faces of a brick and of a tetrahedron in VTK order, normals outwards.
_FACES = {
    8: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    4: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
}


def rough_surface(job: dict[str, np.ndarray], most: int) -> tuple[np.ndarray, ...]:
    """Return x, y, exaggerated z, heights and contacts, at most so many points per side.

    The longer side is 1.
    """
    heights, longest = job["heights"], job["size"].max()
    step = int(np.ceil(max(heights.shape) / most))
    sides = zip(heights.shape, job["size"] / longest, strict=True)
    x, y = np.meshgrid(*((np.arange(n) + 0.5) / n * side for n, side in sides), indexing="ij")
    z = (heights - heights.mean()) * float(job["exaggeration"]) / longest
    return tuple(values[::step, ::step] for values in (x, y, z, heights, job["touching"]))


def pressure_hill(job: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, y around the contact, some 1.3 times as wide as it, and p over the highest."""
    x, y, p = job["x"], job["y"], job["pressure"]
    inside = p > 0
    side = max(np.ptp(x[inside]), np.ptp(y[inside])) * 1.3 or 1.0
    x, y = (values - values[inside].mean() for values in (x, y))
    box = np.ix_(np.abs(x[:, 0]) <= side / 2, np.abs(y[0, :]) <= side / 2)
    return x[box] / side, y[box] / side, p[box] / float(job["highest"])


@dataclass(frozen=True)
class Piece:
    """Part of a mesh, with lengths in units of the reach and the body below z = 0."""

    points: np.ndarray
    cells: np.ndarray
    stress: np.ndarray
    pressure: np.ndarray


def deformed_piece(job: dict[str, np.ndarray], *, clipped: bool = False) -> Piece:
    """Return the body in a box of twice the reach around the contact, completed by symmetry.

    Cells that cross the box are kept whole; `clipped` moves their corners onto its walls and
    interpolates the fields there.
    """
    reach = float(job["reach"])
    points = job["mesh_points"] / reach
    shift = job["mesh_displacement"] / reach * float(job["exaggeration"])
    stress, cells = job["mesh_von_mises"], job["mesh_cells"]
    cells = cells[np.abs(points[cells]).min(axis=1).max(axis=1) <= (1.0 if clipped else 1.1)]
    if clipped:
        points, shift, stress = _clipped(points, shift, stress)
    # The contact pressure at mesh points of the surface, zero elsewhere.
    tree = cKDTree(np.column_stack([job["pressure_x"], job["pressure_y"]]) / reach)
    distance, nearest = tree.query(points[:, :2])
    on_top = (np.abs(points[:, 2]) <= 1e-9) & (distance < 1e-6)
    pressure = np.where(on_top, job["pressure"][nearest], 0.0)
    moved = points + shift
    if points[:, 2].mean() > 0:
        moved, cells = mirrored(moved, cells, 2)
    for side in (0, 1):
        if points[:, side].min() >= -1e-9:  # half of a symmetric body: complete it
            image, image_cells = mirrored(moved, cells, side)
            cells = np.vstack([cells, image_cells + len(moved)])
            moved = np.vstack([moved, image])
            stress, pressure = np.tile(stress, 2), np.tile(pressure, 2)
    return Piece(moved, cells, stress, pressure)


def _clipped(
    points: np.ndarray, shift: np.ndarray, stress: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Move points outside the box onto its walls; interpolate fields from four neighbours."""
    inside = np.clip(points, -1.0, 1.0)
    beyond = (inside != points).any(axis=1)
    if not beyond.any():
        return points, shift, stress
    distance, near = cKDTree(points).query(inside[beyond], k=4)
    weight = 1.0 / np.maximum(distance, 1e-12) ** 2
    weight /= weight.sum(axis=1, keepdims=True)
    shift, stress = shift.copy(), stress.copy()
    shift[beyond] = np.einsum("pk,pkc->pc", weight, shift[near])
    stress[beyond] = np.einsum("pk,pk->p", weight, stress[near])
    return inside, shift, stress


def mirrored(points: np.ndarray, cells: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the mirror image, with corners renumbered to keep volumes positive."""
    image = points.copy()
    image[:, side] *= -1
    order = [1, 0, 2, 3] if cells.shape[1] == 4 else [1, 0, 3, 2, 5, 4, 7, 6]
    return image, cells[:, order]


def opened_surface(piece: Piece) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return surface points, triangles and stress with the quarter x > 0, y < 0 cut out."""
    middle = piece.points[piece.cells].mean(axis=1)
    cells = piece.cells[~((middle[:, 0] > 0) & (middle[:, 1] < 0))]
    # Mirror images meet in points of their own: those at one place become one.
    _, first, number = np.unique(
        np.round(piece.points, 7), axis=0, return_index=True, return_inverse=True
    )
    cells = number.ravel()[cells]
    faces = cells[:, _FACES[piece.cells.shape[1]]].reshape(-1, len(_FACES[cells.shape[1]][0]))
    _, place, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = faces[place[count == 1]]
    halves = [[0, 1, 2]] if outer.shape[1] == 3 else [[0, 1, 2], [0, 2, 3]]
    triangles = np.vstack([outer[:, half] for half in halves])
    used, triangles = np.unique(triangles, return_inverse=True)
    chosen = first[used]
    return piece.points[chosen], triangles.reshape(-1, 3), piece.stress[chosen]
