"""Views that turn: the pictures of `reports.pictures` as plotly scenes, light enough to embed.

The page draws one only when its reader asks for it; until then the picture stands in its place,
and where a browser has no WebGL it stays.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from reports.body_piece import deformed_piece, opened_surface
from reports.figure_style import CONTACT

MOST_POINTS = 96  # per side of a surface
# The camera of the still pictures: from the front right, from above.
CAMERA = {
    "eye": {"x": 1.0, "y": -1.25, "z": 0.95},
    "projection": {"type": "orthographic"},
}


def view(job: dict[str, np.ndarray]) -> dict[str, Any]:
    """Return data and layout of the view of a picture's job."""
    trace = _VIEWS[str(job["kind"])](job)
    hidden = {"visible": False, "showspikes": False}
    scene = {"xaxis": hidden, "yaxis": hidden, "zaxis": hidden, "aspectmode": "data"}
    scene |= {"camera": CAMERA, "dragmode": "turntable", "bgcolor": "@paper"}
    layout = {"scene": scene, "margin": dict.fromkeys("lrtb", 0)}
    return {"data": [trace], "layout": layout}


def _rough(job: dict[str, np.ndarray]) -> dict[str, Any]:
    heights, touching = job["heights"], job["touching"]
    step = int(np.ceil(max(heights.shape) / MOST_POINTS))
    side = job["size"] / job["size"].max()
    z = (heights - heights.mean()) * float(job["exaggeration"]) / job["size"].max()
    low, high = float(heights.min()), float(heights.max())
    # Contacts take the last colour of the scale, which no height reaches.
    colour = np.where(touching, 1.0, 0.98 * (heights - low) / max(high - low, np.finfo(float).tiny))
    scale = [[0.98 * place, shade] for place, shade in _CIVIDIS]
    scale += [[0.985, CONTACT], [1.0, CONTACT]]
    return _surface(
        [(np.arange(n) + 0.5) / n * s for n, s in zip(heights.shape, side, strict=True)],
        z,
        step,
        surfacecolor=_packed(colour[::step, ::step].T),
        colorscale=scale,
        cmax=1.0,
    )


def _hill(job: dict[str, np.ndarray]) -> dict[str, Any]:
    x, y, p = job["x"], job["y"], job["pressure"]
    inside = p > 0
    side = max(np.ptp(x[inside]), np.ptp(y[inside])) * 1.3 or 1.0
    axes = [x[:, 0], y[0, :]]
    near = [
        np.abs(values - where[inside].mean()) <= side / 2
        for values, where in zip(axes, (x, y), strict=True)
    ]
    shown = p[np.ix_(*near)]
    step = int(np.ceil(max(shown.shape) / MOST_POINTS))
    axes = [values[keep] / side for values, keep in zip(axes, near, strict=True)]
    scaled = shown / float(job["highest"])
    return _surface(
        axes,
        0.4 * scaled,
        step,
        surfacecolor=_packed(scaled[::step, ::step].T),
        colorscale="Viridis",
        cmax=1.0,
    )


def _surface(axes: list[np.ndarray], z: np.ndarray, step: int, **colours: Any) -> dict[str, Any]:
    x, y = (values[::step] for values in axes)
    return {
        "type": "surface",
        "x": _packed(x),
        "y": _packed(y),
        "z": _packed(z[::step, ::step].T),  # plotly's rows run along y
        "showscale": False,
        "hoverinfo": "skip",
        "cmin": 0.0,
        "contours": {axis: {"highlight": False} for axis in "xyz"},
        "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.0},
        **colours,
    }


def _body(job: dict[str, np.ndarray]) -> dict[str, Any]:
    points, triangles, stress = opened_surface(deformed_piece(job))
    return {
        "type": "mesh3d",
        **{name: _packed(points[:, axis]) for axis, name in enumerate("xyz")},
        **{name: _packed(triangles[:, axis], "u4") for axis, name in enumerate("ijk")},
        "intensity": _packed(stress / float(job["highest"])),
        "colorscale": "Viridis",
        "cmin": 0.0,
        "cmax": 1.0,
        "showscale": False,
        "hoverinfo": "skip",
        # Shading would tell other stresses than the colour bar.
        "lighting": {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0},
    }


def _packed(values: np.ndarray, dtype: str = "f4") -> dict[str, Any]:
    """Return an array as plotly reads it packed; corners of small meshes in two bytes."""
    if dtype == "u4" and values.max(initial=0) < 2**16:
        dtype = "u2"
    text = base64.b64encode(np.ascontiguousarray(values).astype(f"<{dtype}").tobytes()).decode()
    packed: dict[str, Any] = {"dtype": dtype, "bdata": text}
    if values.ndim == 2:
        packed["shape"] = f"{values.shape[0]}, {values.shape[1]}"
    return packed


_VIEWS = {"rough": _rough, "hill": _hill, "body": _body}
# Cividis in ten steps (Nunez, Anderton & Renslow, PLoS ONE 13 (2018) e0199239).
_CIVIDIS = tuple(
    zip(
        np.linspace(0, 1, 10).round(4).tolist(),
        (
            "#00224e", "#123570", "#3b496c", "#575d6d", "#707173",
            "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838",
        ),
        strict=True,
    )
)  # fmt: skip
