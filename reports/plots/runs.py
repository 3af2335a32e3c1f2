"""Figures for the comparison of two runs: errors and times before and after."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from comparisons import formatting as fmt
from comparisons.results.runs import BAD, Change, RunComparison
from reports.plots.axes import log_axis
from reports.plots.figure import Figure, Series
from reports.plots.style import DOTTED, MUTED, Look, drawing_order, look

MARGIN = 1.6
# Errors below are round-off, and a plot of their ratios would show noise.
SMALLEST = 1e-12
DIAGONAL = Look("unchanged", MUTED, dash=DOTTED)

Pair = tuple[float, float]


@dataclass(frozen=True)
class _Compared:
    """A quantity drawn before and after: name, pair of numbers, and format."""

    key: str
    word: str
    caption: str
    pair: Callable[[Change], Pair]
    label: Callable[[object], str]


def _errors(change: Change) -> Pair:
    before, after = change.errors
    return max(before, SMALLEST), max(after, SMALLEST)


ERRORS = _Compared(
    "errors",
    "error",
    "One marker per solve: its largest error before and after, each relative to the reference of "
    "its run. Above the line the error has grown. Hollow markers: highlighted in the table.",
    _errors,
    lambda value: fmt.relative(value, 1),
)
TIMES = _Compared(
    "times",
    "time",
    "One marker per solve: its time before and after. Above the line it is slower; times scatter "
    "by some 20 %. Hollow markers: highlighted in the table.",
    lambda change: change.seconds,
    fmt.duration,
)


def comparison_figures(record: RunComparison) -> list[Figure]:
    """Return the plots, without empty ones."""
    return [figure for measure in (ERRORS, TIMES) if (figure := _figure(record, measure))]


def _figure(record: RunComparison, measure: _Compared) -> Figure | None:
    changes = [c for c in record.changes if all(np.isfinite(v) and v > 0 for v in measure.pair(c))]
    if not changes:
        return None
    values = np.array([measure.pair(change) for change in changes])
    span = float(values.min()) / MARGIN, float(values.max()) * MARGIN
    names = drawing_order({change.method for change in changes})
    line = Series(DIAGONAL, np.array(span), np.array(span), marks=False, legend=False, width=1)
    return Figure(
        measure.key,
        f"{measure.word.capitalize()} before and after",
        measure.caption,
        log_axis(f"{measure.word} before", span, measure.label),
        log_axis(f"{measure.word} after", span, measure.label),
        (line, *(series for name in names for series in _of(name, changes, measure))),
    )


def _of(method: str, changes: list[Change], measure: _Compared) -> list[Series]:
    """Return the changes of a method, those for the worse hollow and with a legend of their own."""
    own = [change for change in changes if change.method == method]
    worse = [change for change in own if any(kind in BAD for kind in change.kinds)]
    others = [change for change in own if change not in worse]
    return [
        _series(method, part, measure, hollow=part is worse) for part in (others, worse) if part
    ]


def _series(method: str, changes: list[Change], measure: _Compared, *, hollow: bool) -> Series:
    drawn, pairs = look(method), [measure.pair(change) for change in changes]
    before, after = np.array(pairs).T
    texts = (
        f"{drawn.label}, {c.scene}, N = {c.resolution}: "
        f"{measure.label(pair[0])} before, {measure.label(pair[1])} after; {c.text}"
        for c, pair in zip(changes, pairs, strict=True)
    )
    return Series(
        drawn.labelled(f"{drawn.label}, worse") if hollow else drawn,
        before,
        after,
        line=False,
        hollow=hollow,
        hover=tuple(texts),
        faint=0.8,
    )
