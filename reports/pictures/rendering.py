"""The shapes of pictures as arrays, and their rendering in a process of its own, which may crash.

Run as ``python -m reports.pictures.rendering IN.npz OUT.png [IN.npz OUT.png ...]``;
`reports.pictures.pictures` makes the shapes, and `reports.pictures.turning` turns the same ones:
rough surfaces, hills of pressure, bodies deformed and cut open, particles.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from reports.plots.style import CONTACT

if TYPE_CHECKING:
    from pyvista import Plotter

WINDOW = (810, 540)
MOST_SURFACE_POINTS = 400
VIEW = np.array([1.0, -1.25, 0.95])  # the common camera: front right, from above
# Corners of the faces of a brick and of a tetrahedron in VTK order, normals outwards.
_FACES = {
    8: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    4: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
}


@dataclass(frozen=True)
class Shape:
    """What a picture shows, the surface up: a grid of points, triangles between them, or balls."""

    points: np.ndarray
    shade: np.ndarray  # of each point, its place on the palette; NaN: in contact
    palette: str
    middle: float  # height of what the camera looks at
    half: float  # height of a picture, halved
    grid: Sequence[int] = ()
    triangles: np.ndarray | None = None
    pressure: np.ndarray | None = None  # at the points of a body; NaN inside
    ball: float = 0.0  # diameter

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """The shape as a file holds it."""
        known = {name: value for name, value in vars(self).items() if value is not None}
        return {name: np.asarray(value) for name, value in known.items()}

    def thinned(self, most: int) -> Shape:
        """Return a surface with at most so many points per side; other shapes as they are."""
        if not len(self.grid):
            return self
        step = int(np.ceil(max(self.grid) / most))
        places = np.arange(len(self.points)).reshape(self.grid)[::step, ::step]
        kept = self.points[places.ravel()], self.shade[places.ravel()]
        return replace(self, points=kept[0], shade=kept[1], grid=places.shape)


def surface(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, shade: np.ndarray, palette: str, middle: float
) -> Shape:
    """Return a surface from 2-D arrays."""
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    return Shape(points, shade.ravel(), palette, middle, 0.53, z.shape)


@dataclass(frozen=True)
class Piece:
    """Part of a mesh, with lengths in units of the reach and the body below z = 0."""

    points: np.ndarray
    cells: np.ndarray
    stress: np.ndarray
    pressure: np.ndarray


def deformed_piece(body: Piece, shift: np.ndarray) -> Piece:
    """Return a body that is shifted, in the box [-1, 1]^3 alone, completed by symmetry.

    Corners of cells that cross the box move onto its walls, with the fields of four neighbours.
    """
    points, cells, stress, pressure = body.points, body.cells, body.stress, body.pressure
    cells = cells[np.abs(points[cells]).min(axis=1).max(axis=1) <= 1.0]
    inside = np.clip(points, -1.0, 1.0)
    beyond = (inside != points).any(axis=1)
    if beyond.any():
        distance, near = cKDTree(points).query(inside[beyond], k=4)
        weight = 1.0 / np.maximum(distance, 1e-12) ** 2
        weight /= weight.sum(axis=1, keepdims=True)
        shift, stress = shift.copy(), stress.copy()
        shift[beyond] = np.einsum("pk,pkc->pc", weight, shift[near])
        stress[beyond] = np.einsum("pk,pk->p", weight, stress[near])
        points = inside
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


def mirrored(points: np.ndarray, cells: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the mirror image, with corners renumbered to keep volumes positive."""
    image = points.copy()
    image[:, side] *= -1
    order = [1, 0, 2, 3] if cells.shape[1] == 4 else [1, 0, 3, 2, 5, 4, 7, 6]
    return image, cells[:, order]


def opened_surface(piece: Piece) -> Piece:
    """Return the surface as triangles, with the quarter x > 0, y < 0 cut out."""
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
    fields = piece.stress[chosen], piece.pressure[chosen]
    return Piece(piece.points[chosen], triangles.reshape(-1, 3), *fields)


def draw(plotter: Plotter, shape: Shape) -> None:
    """Draw a shape; of a body its edges, and the rim of the contact, too."""
    from pyvista import PolyData, Sphere, StructuredGrid

    scale: dict[str, Any] = {"cmap": shape.palette, "clim": [0, 1], "show_scalar_bar": False}
    scale |= {"scalars": "shade", "specular": 0.0}
    if len(shape.grid):
        grid = StructuredGrid(*shape.points.T.reshape(3, *shape.grid))
        grid["shade"] = shape.shade.reshape(shape.grid).ravel(order="F")
        scale |= {"nan_color": CONTACT, "interpolate_before_map": False}
        plotter.add_mesh(grid, smooth_shading=True, **scale)
    elif shape.ball:
        cloud = PolyData(shape.points)
        cloud["shade"] = shape.shade
        ball = Sphere(radius=0.5 * shape.ball, theta_resolution=14, phi_resolution=10)
        balls = cloud.glyph(geom=ball, scale=False, orient=False)
        plotter.add_mesh(balls, smooth_shading=True, ambient=0.5, **scale)
    elif shape.triangles is not None and shape.pressure is not None:
        cells, pressure = shape.triangles, shape.pressure
        body = PolyData.from_regular_faces(shape.points, cells)
        body["shade"] = shape.shade
        plotter.add_mesh(body, lighting=False, **scale)  # shading would tell other stresses
        sides = {"boundary_edges": False, "non_manifold_edges": False, "manifold_edges": False}
        edges = body.extract_feature_edges(feature_angle=40, **sides)
        plotter.add_mesh(edges, color="#808080", line_width=1.5)
        on_top = cells[np.isfinite(pressure[cells]).all(axis=1)]
        top = PolyData.from_regular_faces(shape.points, on_top)
        top["pressure"] = np.nan_to_num(pressure)
        rim = top.contour([0.02 * top["pressure"].max()], scalars="pressure")
        if rim.n_points:
            plotter.add_mesh(rim, color=CONTACT, line_width=8, lighting=False)


def main(arguments: Sequence[str]) -> None:
    """Render every IN.npz to its OUT.png, written atomically."""
    from pyvista import Plotter

    for source, target in zip(arguments[::2], arguments[1::2], strict=True):
        with np.load(source, allow_pickle=False) as archive:
            known = {name: archive[name] for name in archive.files}
        plotter = Plotter(off_screen=True, window_size=list(WINDOW), lighting="light kit")
        plotter.enable_anti_aliasing("ssaa")
        shape = Shape(**{name: v if v.ndim else v.item() for name, v in known.items()})
        draw(plotter, shape.thinned(MOST_SURFACE_POINTS))
        camera = plotter.camera
        camera.enable_parallel_projection()
        camera.focal_point = 0.0, 0.0, shape.middle
        camera.position = tuple(camera.focal_point + 5 * shape.half * VIEW)
        camera.up = (0.0, 0.0, 1.0)
        camera.parallel_scale = shape.half
        plotter.reset_camera_clipping_range()
        unfinished = Path(target).with_suffix(".part.png")
        plotter.screenshot(unfinished, transparent_background=True)
        unfinished.replace(target)


if __name__ == "__main__":
    main(sys.argv[1:])
    gc.freeze()  # the process ends: its objects are not looked through for garbage before
