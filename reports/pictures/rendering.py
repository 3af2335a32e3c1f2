"""Rendering of three-dimensional pictures in a separate process, which may crash safely.

Run as ``python -m reports.pictures.rendering IN.npz OUT.png [IN.npz OUT.png ...]``;
`reports.pictures.pictures` defines the contents of the input.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from reports.pictures.body_piece import deformed_piece
from reports.plots.style import CONTACT

if TYPE_CHECKING:
    from pyvista import Plotter, PolyData, UnstructuredGrid

WINDOW = (810, 540)
MOST_SURFACE_POINTS = 400


def _plotter() -> Plotter:
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=list(WINDOW), lighting="light kit")
    plotter.enable_anti_aliasing("ssaa")
    plotter.camera.enable_parallel_projection()
    return plotter


def _look(plotter: Plotter, centre: tuple[float, float, float], extent: float) -> None:
    """Set the common camera position: front right, from above."""
    direction = np.array([1.0, -1.25, 0.95])
    plotter.camera.focal_point = centre
    plotter.camera.position = tuple(np.array(centre) + 5 * extent * direction)
    plotter.camera.up = (0.0, 0.0, 1.0)
    plotter.camera.parallel_scale = extent
    plotter.reset_camera_clipping_range()


def _draw_rough(job: dict[str, np.ndarray], output: Path) -> None:
    import pyvista

    heights, touching = job["heights"], job["touching"]
    step = int(np.ceil(max(heights.shape) / MOST_SURFACE_POINTS))
    size = job["size"] / job["size"].max()
    axes = [(np.arange(n) + 0.5) / n * side for n, side in zip(heights.shape, size, strict=True)]
    x, y = np.meshgrid(axes[0][::step], axes[1][::step], indexing="ij")
    h, contact = heights[::step, ::step], touching[::step, ::step]
    z = (h - h.mean()) * float(job["exaggeration"]) / job["size"].max()
    surface = pyvista.StructuredGrid(x, y, z)
    free = np.where(contact, np.nan, h)
    plotter = _plotter()
    plotter.add_mesh(
        surface,
        scalars=free.ravel(order="F"),
        cmap="cividis",
        clim=[heights.min(), heights.max()],
        nan_color=CONTACT,
        show_scalar_bar=False,
        smooth_shading=True,
        interpolate_before_map=False,
        specular=0.0,
    )
    _look(plotter, (size[0] / 2, size[1] / 2, 0.0), 0.53)
    plotter.screenshot(output, transparent_background=True)


def _draw_hill(job: dict[str, np.ndarray], output: Path) -> None:
    import pyvista

    x, y, p = job["x"], job["y"], job["pressure"]
    inside = p > 0
    side = max(np.ptp(x[inside]), np.ptp(y[inside])) * 1.3 or 1.0
    centre = (x[inside].mean(), y[inside].mean())
    rows = np.abs(x[:, 0] - centre[0]) <= side / 2
    columns = np.abs(y[0, :] - centre[1]) <= side / 2
    box = np.ix_(rows, columns)
    height = 0.4 * p[box] / float(job["highest"])
    hill = pyvista.StructuredGrid((x[box] - centre[0]) / side, (y[box] - centre[1]) / side, height)
    plotter = _plotter()
    plotter.add_mesh(
        hill,
        scalars=p[box].ravel(order="F"),
        cmap="viridis",
        clim=[0, float(job["highest"])],
        show_scalar_bar=False,
        specular=0.0,
    )
    _look(plotter, (0.0, 0.0, 0.12), 0.53)
    plotter.screenshot(output, transparent_background=True)


def _draw_body(job: dict[str, np.ndarray], output: Path) -> None:
    body = _deformed_body(job)
    reach, big = 1.0, 1e3
    body = body.clip_box((-reach, reach, -reach, reach, -0.9 * reach, big), invert=False)
    opened = body.clip_box((0, big, -big, 0, -big, big), invert=True)
    plotter = _plotter()
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
    rim = _contact_rim(opened)
    if rim is not None:
        plotter.add_mesh(rim, color=CONTACT, line_width=8, lighting=False)
    _look(plotter, (0.0, 0.0, -0.36), 1.32)
    plotter.screenshot(output, transparent_background=True)


def _draw_particles(job: dict[str, np.ndarray], output: Path) -> None:
    """Draw the particles as balls, a quarter of them taken away, with the surface up."""
    import pyvista

    cloud = pyvista.PolyData(job["places"] * np.array([1.0, 1.0, -1.0]))
    cloud["stress"] = job["stress"]
    ball = pyvista.Sphere(0.5 * float(job["spacing"]), theta_resolution=14, phi_resolution=10)
    plotter = _plotter()
    plotter.add_mesh(
        cloud.glyph(geom=ball, scale=False, orient=False),
        scalars="stress",
        cmap="viridis",
        clim=[0, float(job["highest"])],
        show_scalar_bar=False,
        smooth_shading=True,
        ambient=0.5,
        specular=0.0,
    )
    _look(plotter, (0.0, 0.0, -0.36), 1.32)
    plotter.screenshot(output, transparent_background=True)


def _deformed_body(job: dict[str, np.ndarray]) -> UnstructuredGrid:
    """Return the whole body near the contact as a pyvista grid."""
    import pyvista

    piece = deformed_piece(job)
    corners = piece.cells.shape[1]
    table = np.hstack([np.full((len(piece.cells), 1), corners), piece.cells]).ravel()
    kind = pyvista.CellType.TETRA if corners == 4 else pyvista.CellType.HEXAHEDRON
    grid = pyvista.UnstructuredGrid(table, np.full(len(piece.cells), kind), piece.points)
    grid["pressure"], grid["stress"] = piece.pressure, piece.stress
    return grid.clean(tolerance=1e-9)  # sews the mirror images together: no seam in the picture


def _contact_rim(opened: UnstructuredGrid) -> PolyData | None:
    top = opened.extract_surface(algorithm="dataset_surface")
    highest = float(np.max(top["pressure"], initial=0.0))
    if highest <= 0:
        return None
    rim = top.contour([0.02 * highest], scalars="pressure")
    return rim if rim.n_points else None


DRAWERS = {
    "rough": _draw_rough,
    "body": _draw_body,
    "particles": _draw_particles,
    "hill": _draw_hill,
}


def main(arguments: Sequence[str]) -> None:
    """Render every IN.npz to its OUT.png, written atomically."""
    for source, target in zip(arguments[::2], arguments[1::2], strict=True):
        with np.load(source, allow_pickle=False) as archive:
            job = {name: archive[name] for name in archive.files}
        unfinished = Path(target).with_suffix(".part.png")
        DRAWERS[str(job["kind"])](job, unfinished)
        unfinished.replace(target)


if __name__ == "__main__":
    main(sys.argv[1:])
