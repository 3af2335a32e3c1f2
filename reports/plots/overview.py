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
from reports.plots.gutter import parted, with_foot
from reports.plots.speed import GUIDES
from reports.plots.style import drawing_order, look

LOW, HIGH = 1e-3, 1e3  # of error over tolerance: what lies beyond stands at the edge
CAPTION = (
    "Every setting of every scene: time against the largest |e| + u over load steps and the "
    "quantities that it gives, over the tolerance. Below the line: within. Arrows at the foot: "
    "at or below it. Click one to open its scene."
)
Judged = Sequence[tuple[str, SceneRecord, Advice]]


def overview(scenes: Judged) -> Figure | None:
    """Return the plot of all settings of all scenes (anchor, record, advice), or None.

    Each method has two series, of points and of arrows at the foot, in the order of `places`.
    """
    by_method = _points(scenes)
    if not by_method:
        return None
    times = np.array([item.seconds for items in by_method.values() for *_, item in items])
    span = padded(times, 0.05, 0.2)
    series = [
        part
        for method, items in by_method.items()
        for part in parted(_series(method, items), LOW, always=True)
    ]
    axis = log_axis("largest error / tolerance", (LOW, HIGH), lambda v: fmt.number(v, 1))
    return Figure(
        "overview",
        "All scenes: time against error over tolerance",
        CAPTION,
        time_axis("time for the whole scene", span),
        with_foot(axis, series),
        tuple(series),
        levels=(Level(1.0, "asked"),),
        guides=tuple(guide for guide in GUIDES if span[0] < guide.value < span[1]),
    )


def places(scenes: Judged) -> list[list[tuple[int, int]]]:
    """Return the places (scene, setting) of the points of each method in the page's judgements."""
    return [[(number, place) for number, place, *_ in items] for items in _points(scenes).values()]


Point = tuple[int, int, SceneRecord, Setting]


def _points(scenes: Judged) -> dict[str, list[Point]]:
    """Return the settings of each method that can be drawn, in drawing order."""
    points: dict[str, list[Point]] = {}
    for number, (_, scene, advice) in enumerate(scenes):
        for place, setting in enumerate(advice.settings):
            if np.isfinite(_ratio(scene, setting)) and setting.seconds > 0:
                points.setdefault(setting.method, []).append((number, place, scene, setting))
    return {method: points[method] for method in drawing_order(points)}


def _ratio(scene: SceneRecord, setting: Setting) -> float:
    """Return the largest |e| + u over the tolerance in the quantities that a setting gives."""
    known = [item.high for item in setting.counted if item.word != NO_RESULT]
    return float(np.max(known)) / scene.tolerance if known else float("nan")


def _series(method: str, items: list[Point]) -> Series:
    called = dict.fromkeys(setting.title for *_, setting in items)
    style = look(method).labelled(", ".join(called))
    return Series(
        replace(style, size=min(style.size, 8)),
        np.array([setting.seconds for *_, setting in items]),
        np.array([np.clip(_ratio(scene, setting), LOW, HIGH) for *_, scene, setting in items]),
        line=False,
        hover=tuple(
            "\n".join((scene.title or scene.name, setting.text, _judged(setting)))
            for *_, scene, setting in items
        ),
        faint=0.75,
    )


def _judged(setting: Setting) -> str:
    return f"{setting.deciding.text}: {setting.verdict}"
