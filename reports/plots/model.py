"""What the reduced model sees: the equivalent profile or the rough line, and its springs."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from comparisons.scene.loading import NORMAL
from reports.pages import load_frames
from reports.pages.load_frames import Loads
from reports.plots.curves import tolerance_line
from reports.plots.style import CONTACT, INK, MUTED, Figure, axis, band, layout, numbers

MOST_LINE_POINTS = 1500
MOST_PROFILE_POINTS = 160


def reduced_picture(scene: SceneRecord) -> Figure | None:
    """Return the one-dimensional model itself: the profile or the rough line, and its springs."""
    levels = selection.resolutions(scene, "reduced")
    fields = scene.load_fields("reduced", int(levels[-1])) if levels else {}
    if {"line_x", "line_height", "line_penetration"} <= fields.keys():
        return _line_figure(scene, fields)
    if {"profile_x", "profile_height", "penetration"} <= fields.keys():
        last = scene.control in NORMAL and not scene.is_path
        return _profile_figure(scene, fields, " at the last load" if last else "")
    return None


def _depths(scene: SceneRecord, loads: Loads) -> list[float]:
    """Return the penetration of realisation 0 at each load of the slider, NaN where lost."""
    rows = selection.solved_rows(scene, "reduced")
    level = selection.column(rows, "resolution")
    rows = rows[level == np.nanmax(level)]
    rows = rows[[name != selection.MEAN for name in selection.words(rows, "realisation")]]
    steps, depth = selection.column(rows, "step"), selection.column(rows, "penetration")
    # The first realisation stands first.
    found = [depth[steps == step][:1] for step in loads.steps]
    return [float(each[0]) if len(each) else float("nan") for each in found]


def _line_figure(scene: SceneRecord, fields: dict[str, np.ndarray]) -> Figure | None:
    x, height = _thinned(np.ravel(fields["line_x"]), np.ravel(fields["line_height"]))
    top = float(np.max(fields["line_height"]))
    level = top - float(fields["line_penetration"])
    across, up = fmt.prefix_for(x, "m"), fmt.prefix_for(height, "m")
    scaled = numbers(x, across.factor)
    data = [
        _plain_trace("line of the model", scaled, numbers(height, up.factor), MUTED, 1.0),
        _plain_trace("in contact", scaled, [], CONTACT, 3.0) | _touching(height, level, up.factor),
    ]
    loads = load_frames.loads_of(scene)
    levels = [top - depth for depth in _depths(scene, loads)[:-1]]
    frames = [
        {
            "data": [{}, _touching(height, each, up.factor)],
            "layout": {"shapes": [_level(each * up.factor)] if np.isfinite(each) else []},
        }
        for each in [*levels, level]
    ]
    spec = {
        "data": data,
        "layout": layout(
            axis(f"along the line x / {across.unit}"),
            axis(f"height h / {up.unit}"),
            shapes=[_level(level * up.factor)],
        ),
    }
    spec = load_frames.with_frames(spec, frames) if loads.steps else spec
    share = np.mean(np.ravel(fields["line_height"]) >= level)
    caption = (
        "The first rough line of the reduced model at the last load. Each point above the "
        f"dashed level compresses a spring ({fmt.relative(share)} of the line)."
    )
    return Figure("reduced-line", "What the reduced model presses", caption, spec)


def _touching(height: np.ndarray, level: float, factor: float) -> dict[str, Any]:
    return {"y": numbers(np.where(height >= level, height, np.nan), factor)}


def _profile_figure(scene: SceneRecord, fields: dict[str, np.ndarray], when: str) -> Figure | None:
    x, height = np.ravel(fields["profile_x"]), np.ravel(fields["profile_height"])
    depth = float(fields["penetration"])
    keep = np.isfinite(height) & (height <= 2 * depth)
    if keep.sum() < 2:
        return None
    x, height = x[keep], height[keep]
    stride = -(-len(x) // MOST_PROFILE_POINTS)
    x, height = x[::stride], height[::stride]
    half = x.min() >= 0
    both = np.concatenate([-x[::-1], x]) if half else x
    mirrored = np.concatenate([height[::-1], height]) if half else height
    across, up = fmt.prefix_for(x, "m"), fmt.prefix_for([depth], "m")
    data = _pressed(both, mirrored, depth, across.factor, up.factor)
    loads = load_frames.loads_of(scene)
    frames = [
        {
            "data": [*_pressed(both, mirrored, each, across.factor, up.factor), {}],
            "layout": {"shapes": [_level(each * up.factor)] if np.isfinite(each) else []},
        }
        for each in [*_depths(scene, loads)[:-1], depth]
    ]
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
    spec = load_frames.with_frames(spec, frames) if loads.steps else spec
    caption = (
        f"The equivalent one-dimensional profile, pressed to the dashed level{when} "
        f"({fmt.with_unit(depth, 'm')}). The shaded height is what each spring is compressed by."
    )
    return Figure("reduced-profile", "What the reduced model presses", caption, spec)


def _pressed(
    x: np.ndarray, height: np.ndarray, depth: float, across: float, up: float
) -> list[dict[str, Any]]:
    """Return the band between the profile and the level to which it is pressed: one trace."""
    inside = height <= depth
    bottom = numbers(height[inside], up)
    found = band(numbers(x[inside], across), bottom, [depth * up] * len(bottom), CONTACT, 0.35)
    return found or [{"x": [], "y": []}]


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
