"""Rendering of three-dimensional pictures in a separate process, which may crash safely.

Run as ``python -m reports.pictures.rendering IN.npz OUT.png [IN.npz OUT.png ...]``;
`reports.pictures.pictures` defines the contents of the input.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.pictures.shapes import deformed_piece, pressure_hill, rough_surface
from reports.plots.style import CONTACT

if TYPE_CHECKING:
    from pyvista import Plotter

WINDOW = (810, 540)
MOST_SURFACE_POINTS = 400
VIEW = np.array([1.0, -1.25, 0.95])  # the common camera: front right, from above
PLAIN: dict[str, Any] = {"show_scalar_bar": False, "specular": 0.0}
Job = dict[str, np.ndarray]
Frame = tuple[tuple[float, float, float], float]  # the centre of a picture, and half its height


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
    big = 1e3
    body = body.clip_box((-1.0, 1.0, -1.0, 1.0, -0.9, big), invert=False)
    opened = body.clip_box((0, big, -big, 0, -big, big), invert=True)
    plotter.add_mesh(
        opened,
        scalars="stress",
        cmap="viridis",
        clim=[0, float(job["highest"])],
        show_scalar_bar=False,
        lighting=False,  # shading would tell other stresses than the colour bar
    )
    edges = opened.extract_feature_edges(
        feature_angle=40, boundary_edges=False, non_manifold_edges=False, manifold_edges=False
    )
    plotter.add_mesh(edges, color="#808080", line_width=1.5)
    top = opened.extract_surface(algorithm="dataset_surface")
    highest = float(np.max(top["pressure"], initial=0.0))
    if highest > 0:
        rim = top.contour([0.02 * highest], scalars="pressure")
        if rim.n_points:
            plotter.add_mesh(rim, color=CONTACT, line_width=8, lighting=False)
    return (0.0, 0.0, -0.36), 1.32


def _particles(plotter: Plotter, job: Job) -> Frame:
    """Draw the particles as balls, a quarter of them taken away, with the surface up."""
    from pyvista import PolyData, Sphere

    cloud = PolyData(job["places"] * np.array([1.0, 1.0, -1.0]))
    cloud["stress"] = job["stress"]
    ball = Sphere(0.5 * float(job["spacing"]), theta_resolution=14, phi_resolution=10)
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
