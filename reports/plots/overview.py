"""All scenes in one plot: what every setting costs, and how far it is from its tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.judging.verdicts import NO_RESULT
from comparisons.results.advice import Advice, Setting
from comparisons.results.store import SceneRecord
from reports.plots.axes import log_axis, padded, time_axis
from reports.plots.figure import Figure, Level, Series
from reports.plots.speed import GUIDES
from reports.plots.style import drawing_order, look

LOW, HIGH = 1e-3, 1e3  # of error over tolerance: what lies beyond stands at the edge
CAPTION = (
    "Every setting of every scene: time against the largest |e| + u over load steps and the "
    "quantities that it gives, over the tolerance. Below the line: within. Points on an edge lie "
    "at or beyond it. Click one to open its scene."
)
Judged = Sequence[tuple[str, SceneRecord, Advice]]


def overview(scenes: Judged) -> Figure | None:
    """Return the plot of all settings of all scenes (anchor, record, advice), or None.

    The hover text of each point, and its place in the page's judgements, follow its order.
    """
    points: dict[str, list[tuple[SceneRecord, Setting]]] = {}
    for _, scene, advice in scenes:
        for setting in advice.settings:
            if np.isfinite(_ratio(scene, setting)) and setting.seconds > 0:
                points.setdefault(setting.method, []).append((scene, setting))
    if not points:
        return None
    times = np.array([item.seconds for items in points.values() for _, item in items])
    span = padded(times, 0.05, 0.2)
    series = [_series(method, points[method]) for method in drawing_order(points)]
    return Figure(
        "overview",
        "All scenes: time against error over tolerance",
        CAPTION,
        time_axis("time for the whole scene", span),
        log_axis("largest error / tolerance", (LOW, HIGH), lambda v: fmt.number(v, 1)),
        tuple(series),
        levels=(Level(1.0, "asked"),),
        guides=tuple(guide for guide in GUIDES if span[0] < guide.value < span[1]),
    )


def places(scenes: Judged) -> dict[str, list[tuple[int, int]]]:
    """Return for each method the places (scene, setting) of its points in the page's judgements."""
    found: dict[str, list[tuple[int, int]]] = {}
    for number, (_, scene, advice) in enumerate(scenes):
        for place, setting in enumerate(advice.settings):
            if np.isfinite(_ratio(scene, setting)) and setting.seconds > 0:
                found.setdefault(setting.method, []).append((number, place))
    return found


def _ratio(scene: SceneRecord, setting: Setting) -> float:
    """Return the largest |e| + u over the tolerance in the quantities that a setting gives."""
    known = [item.high for item in setting.counted if item.word != NO_RESULT]
    return float(np.max(known)) / scene.tolerance if known else float("nan")


def _series(method: str, items: list[tuple[SceneRecord, Setting]]) -> Series:
    style = look(method)
    return Series(
        replace(style, size=min(style.size, 8)),
        np.array([setting.seconds for _, setting in items]),
        np.array([np.clip(_ratio(scene, setting), LOW, HIGH) for scene, setting in items]),
        line=False,
        hover=tuple(
            "\n".join((scene.title or scene.name, setting.text, _judged(setting)))
            for scene, setting in items
        ),
        faint=0.75,
    )


def _judged(setting: Setting) -> str:
    return f"{setting.deciding.text}: {setting.verdict}"
