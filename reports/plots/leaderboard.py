"""Entries of a problem: stated time against judged error, and the front that none beats."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.judging.verdicts import OUTSIDE
from comparisons.questions.problems.board import Board, Judged
from reports.plots.axes import log_axis
from reports.plots.figure import Figure, Level, Series
from reports.plots.style import CONTACT, DOTTED, INK, MUTED, Look

SMALLEST = 1e-12  # the bar of a closed form
MARGIN = 2.0
CAPTION = (
    "A marker per entry, at the time that its author states and its largest error, the bar of the "
    "reference included. Joined: entries that none beats in both. Dotted: the tolerance of the "
    "sheet; hollow: outside it. Entries without a time, or without all quantities, stand in the "
    "table only."
)
FRONT, OTHER = Look("front", CONTACT, dash=DOTTED), Look("other entries", INK)


def front_plot(board: Board) -> Figure | None:
    """Return the plot of a problem, or None if no entry has both an error and a time."""
    placed = [judged for judged in board.entries if judged.placed]
    if not placed:
        return None
    times, errors = (np.array(v) for v in zip(*map(_place, placed), strict=True))
    tolerance = board.sheet.tolerance
    span = times.min() / MARGIN, times.max() * MARGIN
    edges = min(errors.min(), tolerance) / MARGIN, max(errors.max(), tolerance) * MARGIN
    others = [judged for judged in placed if judged not in board.front]
    series = [_series(FRONT, board.front, line=True)]
    if others:
        series.append(_series(OTHER, others, line=False))
    return Figure(
        f"board-{board.sheet.id.lower()}",
        f"{board.sheet.id}: time and error",
        CAPTION,
        log_axis("time as stated", span, fmt.duration),
        log_axis("largest error", edges, lambda value: fmt.relative(value, 1)),
        tuple(series),
        levels=(Level(tolerance, colour=MUTED, dash=DOTTED),),
    )


def _place(judged: Judged) -> tuple[float, float]:
    return float(judged.entry.seconds or np.nan), max(judged.error, SMALLEST)


def _series(look: Look, entries: tuple[Judged, ...] | list[Judged], *, line: bool) -> Series:
    x, y = (np.array(v) for v in zip(*map(_place, entries), strict=True))
    wrong = [judged.verdicts[judged.worst].word == OUTSIDE for judged in entries]
    return Series(
        look,
        x,
        y,
        line=line,
        hollow=np.array(wrong),
        hover=tuple(
            f"{judged.entry.solver}: {fmt.relative(judged.error)} in "
            f"{fmt.duration(judged.entry.seconds)}"
            for judged in entries
        ),
    )
