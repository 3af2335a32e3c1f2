"""The shapes of pictures as arrays, and their rendering in a process of its own, which may crash.

Run as ``python -m reports.pictures.rendering IN.npz OUT.png [IN.npz OUT.png ...]``;
`reports.pictures.pictures` defines the contents of the input, and `reports.pictures.turning` draws
the same shapes: rough surfaces, hills of pressure, bodies deformed and cut open.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.plots.style import CONTACT

if TYPE_CHECKING:
    from pyvista import Plotter

WINDOW = (810, 540)
MOST_SURFACE_POINTS = 400
VIEW = np.array([1.0, -1.25, 0.95])  # the common camera: front right, from above
PLAIN: dict[str, Any] = {"show_scalar_bar": False, "specular": 0.0}
Job = dict[str, np.ndarray]
Frame = tuple[tuple[float, float, float], float]  # the centre of a picture, and half its height
# Corners of the faces of a brick and of a tetrahedron in VTK order, normals outwards.
_FACES = {
    8: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    4: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
}


def rough_surface(job: Job, most: int) -> tuple[np.ndarray, ...]:
    """Return x, y, exaggerated z, heights and contacts, at most so many points per side.

    The longer side is 1.
    """
    heights, longest = job["heights"], job["size"].max()
    step = int(np.ceil(max(heights.shape) / most))
    sides = zip(heights.shape, job["size"] / longest, strict=True)
    x, y = np.meshgrid(*((np.arange(n) + 0.5) / n * side for n, side in sides), indexing="ij")
    z = (heights - heights.mean()) * float(job["exaggeration"]) / longest
    return tuple(values[::step, ::step] for values in (x, y, z, heights, job["touching"]))


def pressure_hill(job: Job) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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


def deformed_piece(job: Job, *, clipped: bool = False) -> Piece:
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
        # Points outside of the box go onto its walls, with the fields of four neighbours.
        inside = np.clip(points, -1.0, 1.0)
        beyond = (inside != points).any(axis=1)
        if beyond.any():
            from scipy.spatial import cKDTree  # half as long to import as PyVista, which needs none

            distance, near = cKDTree(points).query(inside[beyond], k=4)
            weight = 1.0 / np.maximum(distance, 1e-12) ** 2
            weight /= weight.sum(axis=1, keepdims=True)
            shift, stress = shift.copy(), stress.copy()
            shift[beyond] = np.einsum("pk,pkc->pc", weight, shift[near])
            stress[beyond] = np.einsum("pk,pk->p", weight, stress[near])
            points = inside
    pressure = job["pressure"]
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


def _rough(plotter: Plotter, job: Job) -> Frame:
    from pyvista import StructuredGrid

    x, y, z, heights, touching = rough_surface(job, MOST_SURFACE_POINTS)
    plotter.add_mesh(
        StructuredGrid(x, y, z),
        scalars=np.where(touching, np.nan, heights).ravel(order="F"),
        cmap="cividis",
        clim=[job["heights"].min(), job["heights"].max()],
        nan_color=CONTACT,
        smooth_shading=True,
        interpolate_before_map=False,
        **PLAIN,
    )
    width, depth = job["size"] / job["size"].max()
    return (width / 2, depth / 2, 0.0), 0.53


def _hill(plotter: Plotter, job: Job) -> Frame:
    from pyvista import StructuredGrid

    x, y, p = pressure_hill(job)
    plotter.add_mesh(
        StructuredGrid(x, y, 0.4 * p),
        scalars=p.ravel(order="F"),
        cmap="viridis",
        clim=[0, 1],
        **PLAIN,
    )
    return (0.0, 0.0, 0.12), 0.53


def _body(plotter: Plotter, job: Job) -> Frame:
    """Draw the body near the contact, cut open, with the rim of the contact."""
    from pyvista import CellType, UnstructuredGrid

    piece = deformed_piece(job)
    corners = piece.cells.shape[1]
    table = np.hstack([np.full((len(piece.cells), 1), corners), piece.cells]).ravel()
    kind = CellType.TETRA if corners == 4 else CellType.HEXAHEDRON
    body = UnstructuredGrid(table, np.full(len(piece.cells), kind), piece.points)
    body["pressure"], body["stress"] = piece.pressure, piece.stress
    body = body.clean(tolerance=1e-9)  # sews the mirror images together: no seam in the picture
    # Whole cells go: of a body made of mirror images none crosses a plane of symmetry.
    x, y, _ = body.cell_centers().points.T
    opened = body.extract_cells((x < 0) | (y > 0)).clip_box((-1, 1, -1, 1, -0.9, 1e3), invert=False)
    plotter.add_mesh(
        opened,
        scalars="stress",
        cmap="viridis",
        clim=[0, float(job["highest"])],
        show_scalar_bar=False,
        lighting=False,  # shading would tell other stresses than the colour bar
    )
    edges = opened.extract_surface(algorithm="geometry").extract_feature_edges(
        feature_angle=40, boundary_edges=False, non_manifold_edges=False, manifold_edges=False
    )
    plotter.add_mesh(edges, color="#808080", line_width=1.5)
    closed = body.extract_surface(algorithm="geometry")
    highest = float(np.max(closed["pressure"], initial=0.0))
    if highest > 0:
        rim = closed.contour([0.02 * highest], scalars="pressure")
        rim = rim.clip_box((0, 1e3, -1e3, 0, -1e3, 1e3))
        if rim.n_points:
            plotter.add_mesh(rim, color=CONTACT, line_width=8, lighting=False)
    return (0.0, 0.0, -0.36), 1.32


def _particles(plotter: Plotter, job: Job) -> Frame:
    """Draw the particles as balls, a quarter of them taken away, with the surface up."""
    from pyvista import PolyData, Sphere

    cloud = PolyData(job["places"] * np.array([1.0, 1.0, -1.0]))
    cloud["stress"] = job["stress"]
    ball = Sphere(radius=0.5 * float(job["spacing"]), theta_resolution=14, phi_resolution=10)
    plotter.add_mesh(
        cloud.glyph(geom=ball, scale=False, orient=False),
        scalars="stress",
        cmap="viridis",
        clim=[0, float(job["highest"])],
        smooth_shading=True,
        ambient=0.5,
        **PLAIN,
    )
    return (0.0, 0.0, -0.36), 1.32


DRAWERS = {"rough": _rough, "body": _body, "particles": _particles, "hill": _hill}


def main(arguments: Sequence[str]) -> None:
    """Render every IN.npz to its OUT.png, written atomically."""
    from pyvista import Plotter

    for source, target in zip(arguments[::2], arguments[1::2], strict=True):
        with np.load(source, allow_pickle=False) as archive:
            job = {name: archive[name] for name in archive.files}
        plotter = Plotter(off_screen=True, window_size=list(WINDOW), lighting="light kit")
        plotter.enable_anti_aliasing("ssaa")
        camera = plotter.camera
        camera.enable_parallel_projection()
        centre, extent = DRAWERS[str(job["kind"])](plotter, job)
        camera.focal_point = centre
        camera.position = tuple(np.array(centre) + 5 * extent * VIEW)
        camera.up = (0.0, 0.0, 1.0)
        camera.parallel_scale = extent
        plotter.reset_camera_clipping_range()
        unfinished = Path(target).with_suffix(".part.png")
        plotter.screenshot(unfinished, transparent_background=True)
        unfinished.replace(target)


if __name__ == "__main__":
    main(sys.argv[1:])
    gc.freeze()  # the process ends: its objects are not looked through for garbage before
