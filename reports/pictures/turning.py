"""Interactive views: the rendered pictures as plotly scenes, small enough to embed.

The page draws a view only on request. Until then, and in browsers without WebGL, it shows the
still picture.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from reports.pictures.rendering import Shape
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
# Of surfaces, and of bodies: shading would tell other stresses than the colour bar.
LIT = {"ambient": 0.75, "diffuse": 0.5, "specular": 0.0}
UNLIT = {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0}


def view(shape: Shape) -> dict[str, Any]:
    """Return data and layout of the interactive view of a shape."""
    shape = shape.thinned(MOST_POINTS)
    colours: dict[str, Any] = {"colorscale": "Viridis", "cmin": 0.0, "cmax": SHADES}
    shade = shape.shade
    if shape.palette == "cividis":
        # Contacts take the last colour of the scale, which no height reaches.
        shade = np.where(np.isnan(shade), 1.0, 0.98 * shade)
        places = np.linspace(0, 0.98, len(CIVIDIS)).tolist()
        scale = [[place, tone] for place, tone in zip(places, CIVIDIS, strict=True)]
        colours["colorscale"] = [*scale, [0.985, CONTACT], [1.0, CONTACT]]
    trace: dict[str, Any] = {"type": "mesh3d", "showscale": False, **colours}
    if shape.grid:
        # The page triangulates the grid: two triangles per cell, in the colour of its first corner,
        # so that the edges of contacts are sharp.
        shade = np.repeat(shade.reshape(shape.grid)[:-1, :-1].ravel(), 2)
        trace |= {"grid": list(shape.grid), "intensitymode": "cell", "lighting": LIT}
        trace["intensity"] = _shades(shade)
    elif shape.ball:
        marker = {"size": BALLS * shape.ball, "color": _shades(shade), **colours}
        marker |= {"opacity": 1.0, "line": {"width": 0}}
        trace = {"type": "scatter3d", "mode": "markers", "marker": marker}
    elif shape.triangles is not None:
        corners = zip("ijk", shape.triangles.T, strict=True)
        trace |= {name: _packed(corner, "u4") for name, corner in corners}
        trace |= {"intensity": _shades(shade), "lighting": UNLIT}
    # In steps of the largest extent, which are finer than a screen.
    extent = np.ptp(shape.points, axis=0)
    steps = np.round((shape.points - shape.points.min(axis=0)) * (STEPS / extent.max()))
    trace |= {name: _packed(steps[:, axis], "u2") for axis, name in enumerate("xyz")}
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


def _shades(values: np.ndarray) -> dict[str, Any]:
    """Return values from 0 to 1 as steps of a colour scale: as many as a screen shows."""
    return _packed(np.round(SHADES * np.clip(values, 0, 1)), "u1")


def _packed(values: np.ndarray, dtype: str) -> dict[str, Any]:
    """Return an array in plotly's packed encoding; indices of small meshes take two bytes."""
    if dtype == "u4" and values.max(initial=0) < 2**16:
        dtype = "u2"
    text = base64.b64encode(np.ascontiguousarray(values).astype(f"<{dtype}").tobytes()).decode()
    return {"dtype": dtype, "bdata": text}
