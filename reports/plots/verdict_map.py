"""All verdicts in one plot: error over tolerance of every quantity, a row for each scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import in_order, quantity
from comparisons.judging.verdicts import NO_RESULT, Verdict
from comparisons.results.decisions import judged_methods, verdicts
from comparisons.results.store import SceneRecord
from reports.plots.axes import log_axis
from reports.plots.figure import Axis, Figure, Guide, Series
from reports.plots.style import CROSS, INK, Look, Marker, look

LOW, HIGH = 1e-3, 1e3  # of error over tolerance: what lies beyond is an arrow at the edge
CAPTION = (
    "Largest |e| over all load steps at equal prescribed load, with its bar u, over the tolerance "
    "that was asked for; a marker for each quantity, hollow where the model is too low. Left of "
    "the dotted line with the whole bar: within. Arrows: beyond the axis. Crosses: no result."
)
MARKERS = (
    *(Marker("circle", "o"), Marker("square", "s"), Marker("triangle-up", "^")),
    *(Marker("diamond", "D"), Marker("triangle-down", "v"), Marker("pentagon", "p")),
    *(Marker("star", "*"), Marker("hexagon", "h"), Marker("cross", "P")),
)
UNDER, OVER = Marker("arrow-left", 4), Marker("arrow-right", 5)
SPREAD = 0.7  # of a row, over which its markers stand


def verdict_map(scenes: Sequence[SceneRecord]) -> Figure | None:
    """Return error over tolerance of the leading method of each scene, or None without scenes."""
    rows = [verdicts(scene, judged_methods(scene)[0]) for scene in scenes]
    names = in_order({item.quantity for row in rows for item in row})
    if not names:
        return None
    ink = look(judged_methods(scenes[0])[0]).colour
    series: list[Series] = []
    for number, name in enumerate(names):
        style = Look(quantity(name).label, ink, MARKERS[number % len(MARKERS)], size=9)
        items = [
            (height + SPREAD * ((place + 0.5) / len(row) - 0.5), item)
            for height, row in enumerate(rows)
            for place, item in enumerate(row)
            if item.quantity == name
        ]
        series += _quantity_series(style, items)
    ticks = tuple((float(number), scene.name) for number, scene in enumerate(scenes))
    return Figure(
        "verdicts",
        "Error over tolerance of all scenes",
        CAPTION,
        log_axis("(|e| ± u) / tolerance", (LOW, HIGH), lambda v: fmt.number(v, 1), most=9),
        Axis("", limits=(len(rows) - 0.5, -0.5), ticks=ticks),
        tuple(series),
        guides=(Guide(1.0, colour=INK),),
    )


def _quantity_series(style: Look, items: list[tuple[float, Verdict]]) -> list[Series]:
    """Return markers, bars, arrows at both edges, and crosses of one quantity."""
    known = [(height, item) for height, item in items if item.word != NO_RESULT]
    heights = np.array([height for height, _ in known])
    sizes = np.array([abs(item.error) / item.tolerance for _, item in known])
    bars = np.nan_to_num([item.uncertainty / item.tolerance for _, item in known])
    low = np.array([item.error < 0 for _, item in known], dtype=bool)
    hover = tuple(f"{item.text}\n{item.because}: {item.word}" for _, item in known)
    inside = np.where((sizes > LOW) & (sizes < HIGH), sizes, np.nan)
    # The bars are one line with gaps.
    ends = np.clip([np.maximum(sizes - bars, 0.0), sizes + bars, sizes], LOW, HIGH)
    ends[2] = np.nan
    nameless = replace(style, label="")
    series = [
        Series(style, inside, heights, line=False, hollow=low, hover=hover),
        Series(nameless, ends.T.ravel(), np.repeat(heights, 3), marks=False, width=1.2),
    ]
    for marker, edge, beyond in ((UNDER, LOW, sizes <= LOW), (OVER, HIGH, sizes >= HIGH)):
        arrows = np.where(beyond, edge, np.nan)
        series.append(Series(replace(nameless, marker=marker), arrows, heights, line=False))
    lost = np.array([height for height, item in items if item.word == NO_RESULT])
    crossed = replace(style, label=f"{style.label}: no result" if len(lost) else "", marker=CROSS)
    return [*series, Series(crossed, np.full(len(lost), 0.8 * HIGH), lost, line=False)]
