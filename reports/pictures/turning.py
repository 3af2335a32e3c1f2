"""Interactive views: the rendered pictures as plotly scenes, small enough to embed.

The page draws a view only on request. Until then, and in browsers without WebGL, it shows the
still picture.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from reports.pictures.body_piece import deformed_piece, opened_surface
from reports.plots.style import CONTACT

MOST_POINTS = 96  # per side of a surface
FILLING, FILLING_FLAT = 1.55, 2.0
_SHADES = 255
# Pixels of a ball as large as the half-width of what is shown.
BALLS = 200.0
# The camera of the still pictures: from the front right, from above.
CAMERA = {
    "eye": {"x": 1.0, "y": -1.25, "z": 0.95},
    "projection": {"type": "orthographic"},
}


def view(job: dict[str, np.ndarray]) -> dict[str, Any]:
    """Return data and layout of the interactive view of a rendering job."""
    trace, extent = _VIEWS[str(job["kind"])](job)
    hidden = {"visible": False, "showspikes": False}
    scene: dict[str, Any] = {"xaxis": hidden, "yaxis": hidden, "zaxis": hidden}
    # To scale, and large enough to fill the frame.
    flat = extent[2] < 0.5 * extent.max()
    ratio = (FILLING_FLAT if flat else FILLING) * extent / extent.max()
    scene |= {"aspectmode": "manual", "aspectratio": dict(zip("xyz", ratio.tolist(), strict=True))}
    scene |= {"camera": CAMERA, "dragmode": "turntable", "bgcolor": "@paper"}
    layout = {"scene": scene, "margin": dict.fromkeys("lrtb", 0)}
    return {"data": [trace], "layout": layout}


def _rough(job: dict[str, np.ndarray]) -> tuple[dict[str, Any], np.ndarray]:
    heights, touching = job["heights"], job["touching"]
    step = int(np.ceil(max(heights.shape) / MOST_POINTS))
    side = job["size"] / job["size"].max()
    z = (heights - heights.mean()) * float(job["exaggeration"]) / job["size"].max()
    low, high = float(heights.min()), float(heights.max())
    shade = 0.98 * (heights - low) / max(high - low, float(np.finfo(float).tiny))
    # Contacts take the last colour of the scale, which no height reaches.
    colour = np.where(touching, 1.0, shade)
    scale = [[0.98 * place, tone] for place, tone in _CIVIDIS]
    scale += [[0.985, CONTACT], [1.0, CONTACT]]
    axes = [(np.arange(n) + 0.5) / n * s for n, s in zip(heights.shape, side, strict=True)]
    return _surface(
        [axis[::step] for axis in axes], z[::step, ::step], colour[::step, ::step], scale
    )


def _hill(job: dict[str, np.ndarray]) -> tuple[dict[str, Any], np.ndarray]:
    x, y, p = job["x"], job["y"], job["pressure"]
    inside = p > 0
    side = max(np.ptp(x[inside]), np.ptp(y[inside])) * 1.3 or 1.0
    axes = [x[:, 0], y[0, :]]
    near = [
        np.abs(values - where[inside].mean()) <= side / 2
        for values, where in zip(axes, (x, y), strict=True)
    ]
    pressure = p[np.ix_(*near)] / float(job["highest"])
    step = int(np.ceil(max(pressure.shape) / MOST_POINTS))
    axes = [(values[keep] / side)[::step] for values, keep in zip(axes, near, strict=True)]
    pressure = pressure[::step, ::step]
    return _surface(axes, 0.4 * pressure, pressure, "Viridis")


def _surface(
    axes: list[np.ndarray], z: np.ndarray, colour: np.ndarray, scale: object
) -> tuple[dict[str, Any], np.ndarray]:
    """Return a triangulated surface with one colour per triangle, so that contact edges are sharp.

    The page triangulates the `grid`: two triangles per cell, in the colour of its first corner.
    """
    x, y = np.meshgrid(*axes, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    shades = np.round(_SHADES * np.clip(colour[:-1, :-1].ravel(), 0, 1))
    trace = {
        "type": "mesh3d",
        "grid": list(z.shape),
        **_coordinates(points),
        "intensity": _packed(np.repeat(shades, 2), "u1"),
        "intensitymode": "cell",
        "colorscale": scale,
        "cmax": _SHADES,
        "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.0},
        **_PLAIN,
    }
    return trace, np.ptp(points, axis=0)


def _body(job: dict[str, np.ndarray]) -> tuple[dict[str, Any], np.ndarray]:
    points, triangles, stress = opened_surface(deformed_piece(job, clipped=True))
    trace = {
        "type": "mesh3d",
        **_coordinates(points),
        **{name: _packed(triangles[:, axis], "u4") for axis, name in enumerate("ijk")},
        "intensity": _packed(stress / float(job["highest"])),
        "colorscale": "Viridis",
        "cmax": 1.0,
        # Shading would tell other stresses than the colour bar.
        "lighting": {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0},
        **_PLAIN,
    }
    return trace, np.ptp(points, axis=0)


def _particles(job: dict[str, np.ndarray]) -> tuple[dict[str, Any], np.ndarray]:
    points = job["places"] * np.array([1.0, 1.0, -1.0])
    marker = {
        "size": BALLS * float(job["spacing"]),
        "color": _packed(job["stress"] / float(job["highest"])),
        "colorscale": "Viridis",
        "cmin": 0.0,
        "cmax": 1.0,
        "opacity": 1.0,
        "line": {"width": 0},
    }
    trace = {
        "type": "scatter3d",
        "mode": "markers",
        **_coordinates(points),
        "marker": marker,
        "hoverinfo": "skip",
    }
    return trace, np.ptp(points, axis=0)


def _coordinates(points: np.ndarray) -> dict[str, Any]:
    return {name: _packed(points[:, axis]) for axis, name in enumerate("xyz")}


def _packed(values: np.ndarray, dtype: str = "f4") -> dict[str, Any]:
    """Return an array in plotly's packed encoding; indices of small meshes take two bytes."""
    if dtype == "u4" and values.max(initial=0) < 2**16:
        dtype = "u2"
    text = base64.b64encode(np.ascontiguousarray(values).astype(f"<{dtype}").tobytes()).decode()
    return {"dtype": dtype, "bdata": text}


_PLAIN = {"cmin": 0.0, "showscale": False, "hoverinfo": "skip"}
_VIEWS = {"rough": _rough, "hill": _hill, "body": _body, "particles": _particles}
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
