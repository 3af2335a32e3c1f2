"""Time against error of every method on every hard case, with failures at the upper edge."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.questions.hard_cases.record import HardCasesRecord, OutcomeRecord
from reports.plots.axes import error_axis, log_axis
from reports.plots.figure import Figure, Level, Series
from reports.plots.marks import FOOT_NOTE, failed, parted, with_foot
from reports.plots.style import DOTTED, MUTED, drawing_order, look

# What is below 1 ppm is an arrow at the foot, so that round-off does not squeeze the others.
SMALLEST, LARGEST = 1e-6, 1e7
MARGIN = 1.5
SOLVED = ("accurate", "degraded")
CAPTION = (
    "One marker per case, at the error of the force (of the penetration if the force is "
    "prescribed), including the bar of the reference. Horizontal line: 1 %, above which an answer "
    "counts as degraded. Hollow crosses at the upper edge: refused or lost, with the reason on "
    f"hover; those without a time are at the right. {FOOT_NOTE}"
)


def stability(record: HardCasesRecord) -> Figure | None:
    """Return the plot, or None if nothing was solved."""
    solved = [outcome for outcome in record.outcomes if outcome.kind in SOLVED]
    times = np.array([outcome.seconds for outcome in solved if outcome.seconds], dtype=float)
    if not len(times):
        return None
    span = float(times.min()) / MARGIN, float(times.max()) * MARGIN
    total = [_height(outcome) for outcome in solved]
    edges = max(SMALLEST, min(total) / MARGIN), min(LARGEST, max(*total, 0.05) * MARGIN)
    names = drawing_order(record.methods)
    series = [
        part
        for name in names
        for part in parted(_series(name, [o for o in solved if o.method == name]), SMALLEST)
    ]
    series += _failures(record, names, span, edges[1])
    return Figure(
        "stability",
        "Hard cases: time and error",
        CAPTION,
        log_axis("time", span, fmt.duration),
        with_foot(error_axis(*edges, "largest error"), series),
        tuple(drawn for drawn in series if len(drawn.x)),
        levels=(Level(0.01, colour=MUTED, dash=DOTTED),),
    )


def _height(outcome: OutcomeRecord) -> float:
    error = (outcome.error or 0.0) + (outcome.bar or 0.0)
    return float(np.clip(error, SMALLEST, LARGEST))


def _series(method: str, outcomes: list[OutcomeRecord]) -> Series:
    drawn = look(method)
    return Series(
        drawn,
        np.array([outcome.seconds for outcome in outcomes], dtype=float),
        np.array([_height(outcome) for outcome in outcomes]),
        line=False,
        hover=tuple(f"{drawn.label}, {outcome.title}: {_ending(outcome)}" for outcome in outcomes),
        size=max(drawn.size - 2, 6),
        faint=0.75,
    )


def _ending(outcome: OutcomeRecord) -> str:
    if outcome.kind not in SOLVED:
        return f"{outcome.kind}: {outcome.reason}"
    text = f"{outcome.kind}, {fmt.relative(outcome.error)} in {fmt.duration(outcome.seconds)}"
    return f"{text}; {outcome.deviation}" if outcome.deviation else text


def _failures(
    record: HardCasesRecord, names: list[str], span: tuple[float, float], high: float
) -> list[Series]:
    """Return crosses for failures; a method not meant for a case has not failed."""
    unplaced, series = 0, []
    for name in names:
        failures = [
            e for e in record.outcomes if e.method == name and e.kind in ("refused", "lost")
        ]
        x = []
        for failure in failures:
            # Without a time: at the right edge, side by side.
            x.append(failure.seconds or span[1] / (span[1] / span[0]) ** (0.008 * unplaced))
            unplaced += failure.seconds is None
        reasons = [
            f"{look(name).label}, {failure.title}: {_ending(failure)}" for failure in failures
        ]
        series.append(failed(look(name), x, high, reasons))
    return series
