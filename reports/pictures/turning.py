"""Interactive views: the rendered pictures as plotly scenes, small enough to embed.

The page draws a view only on request. Until then, and in browsers without WebGL, it shows the
still picture.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from reports.pictures.rendering import deformed_piece, opened_surface, pressure_hill, rough_surface
from reports.plots.style import CONTACT

MOST_POINTS = 96  # per side of a surface
FILLING, FILLING_FLAT = 1.55, 2.0
SHADES, STEPS = 255, 65535  # of a colour, and of a place
BALLS = 200.0  # pixels of a ball as large as the half-width of what is shown
# The camera of the still pictures: from the front right, from above.
CAMERA = {"eye": {"x": 1.0, "y": -1.25, "z": 0.95}, "projection": {"type": "orthographic"}}
# Cividis in ten steps (Nunez, Anderton & Renslow, PLoS ONE 13 (2018) e0199239).
CIVIDIS = (
    "#00224e", "#123570", "#3b496c", "#575d6d", "#707173",
    "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838",
)  # fmt: skip
Job = dict[str, np.ndarray]
Drawn = tuple[dict[str, Any], np.ndarray]  # a trace without its places, and its points


def view(job: Job) -> dict[str, Any]:
    """Return data and layout of the interactive view of a rendering job."""
    trace, points = _VIEWS[str(job["kind"])](job)
    # In steps of the largest extent, which are finer than a screen.
    extent = np.ptp(points, axis=0)
    steps = np.round((points - points.min(axis=0)) * (STEPS / extent.max()))
    trace |= {name: _packed(steps[:, axis], "u2") for axis, name in enumerate("xyz")}
    if trace["type"] == "mesh3d":
        trace |= {"cmin": 0.0, "showscale": False}
    trace["hoverinfo"] = "skip"
    hidden = {"visible": False, "showspikes": False}
    scene: dict[str, Any] = {"xaxis": hidden, "yaxis": hidden, "zaxis": hidden}
    # To scale, and large enough to fill the frame.
    flat = extent[2] < 0.5 * extent.max()
    ratio = (FILLING_FLAT if flat else FILLING) * extent / extent.max()
    scene |= {"aspectmode": "manual", "aspectratio": dict(zip("xyz", ratio.tolist(), strict=True))}
    scene |= {"camera": CAMERA, "dragmode": "turntable", "bgcolor": "@paper"}
    layout = {"scene": scene, "margin": dict.fromkeys("lrtb", 0)}
    return {"data": [trace], "layout": layout}


def _rough(job: Job) -> Drawn:
    x, y, z, heights, touching = rough_surface(job, MOST_POINTS)
    low, high = float(job["heights"].min()), float(job["heights"].max())
    shade = 0.98 * (heights - low) / max(high - low, float(np.finfo(float).tiny))
    # Contacts take the last colour of the scale, which no height reaches.
    places = np.linspace(0, 1, len(CIVIDIS)).round(4).tolist()
    scale = [[0.98 * place, tone] for place, tone in zip(places, CIVIDIS, strict=True)]
    scale += [[0.985, CONTACT], [1.0, CONTACT]]
    return _surface(x, y, z, np.where(touching, 1.0, shade), scale)


def _hill(job: Job) -> Drawn:
    x, y, p = pressure_hill(job)
    step = int(np.ceil(max(p.shape) / MOST_POINTS))
    x, y, p = (values[::step, ::step] for values in (x, y, p))
    return _surface(x, y, 0.4 * p, p, "Viridis")


def _surface(x: np.ndarray, y: np.ndarray, z: np.ndarray, colour: np.ndarray, scale: Any) -> Drawn:
    """Return a triangulated surface with one colour per triangle, so that contact edges are sharp.

    The page triangulates the `grid`: two triangles per cell, in the colour of its first corner.
    """
    trace = {
        "type": "mesh3d",
        "grid": list(z.shape),
        "intensity": _packed(np.repeat(_shades(colour[:-1, :-1].ravel()), 2), "u1"),
        "intensitymode": "cell",
        "colorscale": scale,
        "cmax": SHADES,
        "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.0},
    }
    return trace, np.column_stack([x.ravel(), y.ravel(), z.ravel()])


def _body(job: Job) -> Drawn:
    points, triangles, stress = opened_surface(deformed_piece(job, clipped=True))
    trace = {
        "type": "mesh3d",
        **{name: _packed(triangles[:, axis], "u4") for axis, name in enumerate("ijk")},
        "intensity": _packed(_shades(stress / float(job["highest"])), "u1"),
        "colorscale": "Viridis",
        "cmax": SHADES,
        # Shading would tell other stresses than the colour bar.
        "lighting": {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0},
    }
    return trace, points


def _particles(job: Job) -> Drawn:
    marker = {
        "size": BALLS * float(job["spacing"]),
        "color": _packed(_shades(job["stress"] / float(job["highest"])), "u1"),
        "colorscale": "Viridis",
        "cmin": 0.0,
        "cmax": SHADES,
        "opacity": 1.0,
        "line": {"width": 0},
    }
    trace = {"type": "scatter3d", "mode": "markers", "marker": marker}
    return trace, job["places"] * np.array([1.0, 1.0, -1.0])


_VIEWS = {"rough": _rough, "hill": _hill, "body": _body, "particles": _particles}


def _shades(values: np.ndarray) -> np.ndarray:
    """Return values from 0 to 1 as steps of a colour scale: as many as a screen shows."""
    return np.round(SHADES * np.clip(values, 0, 1))


def _packed(values: np.ndarray, dtype: str) -> dict[str, Any]:
    """Return an array in plotly's packed encoding; indices of small meshes take two bytes."""
    if dtype == "u4" and values.max(initial=0) < 2**16:
        dtype = "u2"
    text = base64.b64encode(np.ascontiguousarray(values).astype(f"<{dtype}").tobytes()).decode()
    return {"dtype": dtype, "bdata": text}
