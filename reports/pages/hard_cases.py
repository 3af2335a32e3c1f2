"""The hard-cases page: the stability table, and time against error with failures."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.questions.hard_cases.case import HardCasesRecord, OutcomeRecord
from reports.pages.page import render, tally
from reports.plots.axes import FOOT_NOTE, error_axis, failed, parted, time_axis, with_foot
from reports.plots.figure import Figure, Level, Series
from reports.plots.style import DOTTED, MUTED, drawing_order, look

KINDS = ("accurate", "degraded", "refused", "not for", "left out", "lost")
SOLVED, FAILED = ("accurate", "degraded"), ("refused", "lost")  # not meant for a case: neither
# What is below 1 ppm is an arrow at the foot, so that round-off does not squeeze the others.
SMALLEST, LARGEST = 1e-6, 1e7
MARGIN = 1.5
CAPTION = (
    "One marker per case, at the error of the force (of the penetration if the force is "
    "prescribed), including the bar of the reference. Horizontal line: 1 %, above which an answer "
    "counts as degraded. Hollow crosses at the upper edge: refused or lost, with the reason on "
    f"hover; those without a time are at the right. {FOOT_NOTE}"
)


def hard_cases_page(record: HardCasesRecord) -> str:
    """Return the stability table and its plot as one HTML page."""
    figure = stability(record)
    return render(
        "hard_cases.html.j2",
        {figure.key: figure} if figure else {},
        record=record,
        figure=figure,
        tally=tally((outcome.kind for outcome in record.outcomes), KINDS),
    )


def stability(record: HardCasesRecord) -> Figure | None:
    """Return time against error of every method on every case, or None if nothing was solved."""
    solved = [outcome for outcome in record.outcomes if outcome.kind in SOLVED]
    times = np.array([outcome.seconds for outcome in solved if outcome.seconds], dtype=float)
    if not len(times):
        return None
    first, last = float(times.min()) / MARGIN, float(times.max()) * MARGIN
    errors = [_height(outcome) for outcome in solved]
    low, high = max(SMALLEST, min(errors) / MARGIN), min(LARGEST, max(*errors, 0.05) * MARGIN)
    series: list[Series] = []
    names = drawing_order(record.methods)
    for name in names:
        drawn = look(name, among=names)
        own = [outcome for outcome in solved if outcome.method == name]
        points = Series(
            drawn,
            np.array([outcome.seconds for outcome in own], dtype=float),
            np.array([_height(outcome) for outcome in own]),
            line=False,
            hover=tuple(f"{drawn.label}, {item.title}: {_ending(item)}" for item in own),
            size=max(drawn.size - 2, 6),
            faint=0.75,
        )
        series += parted(points, SMALLEST)
    unplaced = 0
    for name in names:
        places, reasons = [], []
        for item in record.outcomes:
            if item.method == name and item.kind in FAILED:
                # Without a time: at the right edge, side by side.
                places.append(item.seconds or last / (last / first) ** (0.008 * unplaced))
                reasons.append(f"{look(name).label}, {item.title}: {_ending(item)}")
                unplaced += item.seconds is None
        series.append(failed(look(name, among=names), places, high, reasons))
    return Figure(
        "stability",
        "Hard cases: time and error",
        CAPTION,
        time_axis("time", (first, last)),
        with_foot(error_axis(low, high, "largest error"), series),
        tuple(drawn for drawn in series if len(drawn.x)),
        levels=(Level(0.01, colour=MUTED, dash=DOTTED),),
    )


def _height(outcome: OutcomeRecord) -> float:
    return float(np.clip((outcome.error or 0.0) + (outcome.bar or 0.0), SMALLEST, LARGEST))


def _ending(outcome: OutcomeRecord) -> str:
    if outcome.kind not in SOLVED:
        return f"{outcome.kind}: {outcome.reason}"
    text = f"{outcome.kind}, {fmt.relative(outcome.error)} in {fmt.duration(outcome.seconds)}"
    return f"{text}; {outcome.deviation}" if outcome.deviation else text
