"""The reduced model: the equivalent profile or the rough line, and its springs."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import NORMAL
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from reports.plots.figure import Axis, Band, Figure, Level, Series
from reports.plots.load_slider import SliderSteps, slider_steps
from reports.plots.style import CONTACT, DASHED, INK, MUTED, Look

MOST_LINE_POINTS = 1500
MOST_PROFILE_POINTS = 160
TITLE = "Reduced model"
LINE, TOUCHING = Look("line of the model", MUTED), Look("in contact", CONTACT)
PROFILE = Look("equivalent profile g(x)", INK)


def reduced_picture(scene: SceneRecord) -> Figure | None:
    """Return the one-dimensional model: the profile or the rough line, and its springs."""
    levels = selection.resolutions(scene, MODEL)
    fields = scene.load_fields(MODEL, int(levels[-1])) if levels else {}
    if {"line_x", "line_height", "line_penetration"} <= fields.keys():
        return _line_figure(scene, fields)
    if {"profile_x", "profile_height", "penetration"} <= fields.keys():
        return _profile_figure(scene, fields)
    return None


def _earlier_depths(scene: SceneRecord, loads: SliderSteps) -> list[float]:
    """Return the penetration of realisation 0 at all loads but the last; NaN where it failed."""
    rows = selection.solved_rows(scene, MODEL)
    level = selection.column(rows, "resolution")
    rows = rows[level == np.nanmax(level)]
    rows = rows[[name != selection.MEAN for name in selection.texts(rows, "realisation")]]
    steps, depth = selection.column(rows, "step"), selection.column(rows, "penetration")
    # The first realisation stands first.
    first = [depth[steps == step][:1] for step in loads.steps[:-1]]
    return [float(depths[0]) if len(depths) else float("nan") for depths in first]


def _line_figure(scene: SceneRecord, fields: dict[str, np.ndarray]) -> Figure:
    x, height = _thinned(np.ravel(fields["line_x"]), np.ravel(fields["line_height"]))
    top = float(np.max(fields["line_height"]))
    last = top - float(fields["line_penetration"])

    def pressed_to(level: float) -> Figure:
        touching = np.where(height >= level, height, np.nan)
        return Figure(
            "reduced-line",
            TITLE,
            caption,
            Axis("along the line x", scale=fmt.prefix_for(x, "m")),
            Axis("height h", scale=fmt.prefix_for(height, "m")),
            (
                Series(LINE, x, height, marks=False, width=1.0, hover=LINE.label),
                Series(TOUCHING, x, touching, marks=False, width=3.0, hover=TOUCHING.label),
            ),
            levels=(Level(level, dash=DASHED),),
        )

    share = np.mean(np.ravel(fields["line_height"]) >= last)
    caption = (
        "The first rough line of the reduced model. Points above the dashed level compress springs "
        f"({fmt.relative(share)} of the line at the last load)."
    )
    depths = _earlier_depths(scene, slider_steps(scene))
    return replace(pressed_to(last), earlier=tuple(pressed_to(top - depth) for depth in depths))


def _profile_figure(scene: SceneRecord, fields: dict[str, np.ndarray]) -> Figure | None:
    x, height = np.ravel(fields["profile_x"]), np.ravel(fields["profile_height"])
    last = float(fields["penetration"])
    keep = np.isfinite(height) & (height <= 2 * last)
    if keep.sum() < 2:
        return None
    x, height = _both_sides(x[keep], height[keep])
    moves = scene.control in NORMAL and not scene.is_path
    depth = f"{fmt.with_unit(last, 'm')}{' at the last load' if moves else ''}"
    caption = (
        f"The equivalent one-dimensional profile, indented to the dashed level ({depth}). The "
        "shaded height is the compression of the springs."
    )

    def pressed_to(depth: float) -> Figure:
        inside = height <= depth
        level = np.full(int(inside.sum()), depth)
        return Figure(
            "reduced-profile",
            TITLE,
            caption,
            Axis("along the line x", scale=fmt.prefix_for(x, "m")),
            Axis("profile g", scale=fmt.prefix_for([last], "m")),
            (Series(PROFILE, x, height, marks=False, hover=PROFILE.label),),
            (Band(x[inside], height[inside], level, CONTACT, 0.35),),
            (Level(depth, dash=DASHED),),
            legend=False,
        )

    depths = _earlier_depths(scene, slider_steps(scene))
    return replace(pressed_to(last), earlier=tuple(pressed_to(depth) for depth in depths))


def _both_sides(x: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a thinned profile, mirrored if given on one side only."""
    stride = -(-len(x) // MOST_PROFILE_POINTS)
    x, height = x[::stride], height[::stride]
    if x.min() < 0:
        return x, height
    return np.concatenate([-x[::-1], x]), np.concatenate([height[::-1], height])


def _thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Keep the highest point of each bin, because the peaks make the contact."""
    if len(x) <= MOST_LINE_POINTS:
        return x, y
    edges = np.linspace(0, len(x), MOST_LINE_POINTS + 1).astype(int)
    keep = np.array([a + int(np.argmax(y[a:b])) for a, b in pairwise(edges)])
    return x[keep], y[keep]
