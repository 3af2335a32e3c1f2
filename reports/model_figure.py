"""What the reduced model sees: the equivalent profile or the rough line, and its springs."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.loading import NORMAL
from comparisons.store import SceneRecord
from reports import selection
from reports.figure_style import CONTACT, INK, MUTED, Figure, axis, band, layout, numbers
from reports.figures import tolerance_line

MOST_LINE_POINTS = 1500


def reduced_picture(scene: SceneRecord) -> Figure | None:
    """Return the one-dimensional model itself: the profile or the rough line, and its springs."""
    levels = selection.resolutions(scene, "reduced")
    fields = scene.load_fields("reduced", int(levels[-1])) if levels else {}
    if {"line_x", "line_height", "line_penetration"} <= fields.keys():
        return _line_figure(fields)
    if {"profile_x", "profile_height", "penetration"} <= fields.keys():
        last = scene.control in NORMAL and not scene.is_path
        return _profile_figure(fields, " at the last load" if last else "")
    return None


def _line_figure(fields: dict[str, np.ndarray]) -> Figure | None:
    x, height = _thinned(np.ravel(fields["line_x"]), np.ravel(fields["line_height"]))
    level = float(np.max(fields["line_height"])) - float(fields["line_penetration"])
    across, up = fmt.prefix_for(x, "m"), fmt.prefix_for(height, "m")
    touching = np.where(height >= level, height, np.nan)
    scaled = numbers(x, across.factor)
    data = [
        _plain_trace("line of the model", scaled, numbers(height, up.factor), MUTED, 1.0),
        _plain_trace("in contact", scaled, numbers(touching, up.factor), CONTACT, 3.0),
    ]
    spec = {
        "data": data,
        "layout": layout(
            axis(f"along the line x / {across.unit}"),
            axis(f"height h / {up.unit}"),
            shapes=[_level(level * up.factor)],
        ),
    }
    share = np.mean(np.ravel(fields["line_height"]) >= level)
    caption = (
        "The first rough line of the reduced model at the last load. Each point above the "
        f"dashed level compresses a spring ({fmt.relative(share)} of the line)."
    )
    return Figure("reduced-line", "What the reduced model presses", caption, spec)


def _profile_figure(fields: dict[str, np.ndarray], when: str) -> Figure | None:
    x, height = np.ravel(fields["profile_x"]), np.ravel(fields["profile_height"])
    depth = float(fields["penetration"])
    keep = np.isfinite(height) & (height <= 2 * depth)
    if keep.sum() < 2:
        return None
    x, height = x[keep], height[keep]
    half = x.min() >= 0
    both = np.concatenate([-x[::-1], x]) if half else x
    mirrored = np.concatenate([height[::-1], height]) if half else height
    across, up = fmt.prefix_for(x, "m"), fmt.prefix_for([depth], "m")
    inside = mirrored <= depth
    scaled = numbers(both[inside], across.factor)
    bottom = numbers(mirrored[inside], up.factor)
    data = band(scaled, bottom, [depth * up.factor] * len(bottom), CONTACT, 0.35)
    data.append(
        _plain_trace(
            "equivalent profile g(x)",
            numbers(both, across.factor),
            numbers(mirrored, up.factor),
            INK,
            2.0,
        )
    )
    spec = {
        "data": data,
        "layout": layout(
            axis(f"along the line x / {across.unit}"),
            axis(f"profile g / {up.unit}"),
            shapes=[_level(depth * up.factor)],
            showlegend=False,
        ),
    }
    caption = (
        f"The equivalent one-dimensional profile, pressed to the dashed level{when} "
        f"({fmt.with_unit(depth, 'm')}). The shaded height is what each spring is compressed by."
    )
    return Figure("reduced-profile", "What the reduced model presses", caption, spec)


def _level(height: float) -> dict[str, Any]:
    shape = tolerance_line(height)
    return shape | {"line": shape["line"] | {"dash": "dash"}}


def _plain_trace(name: str, x: list, y: list, colour: str, width: float) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": x,
        "y": y,
        "line": {"color": colour, "width": width},
        "hovertemplate": "%{x:.3g}, %{y:.3g}<extra></extra>",
    }


def _thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Keep the highest point of each bin: peaks make the contact and must not be lost."""
    if len(x) <= MOST_LINE_POINTS:
        return x, y
    edges = np.linspace(0, len(x), MOST_LINE_POINTS + 1).astype(int)
    keep = np.array([a + int(np.argmax(y[a:b])) for a, b in pairwise(edges)])
    return x[keep], y[keep]
