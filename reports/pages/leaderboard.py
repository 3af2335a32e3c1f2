"""The leaderboard page: entries of all problems, from nothing but the entries."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.judging.verdicts import OUTSIDE
from comparisons.questions.problem_sheets import Board, Judged
from reports.pages.page import render
from reports.plots.axes import error_axis, time_axis
from reports.plots.figure import Figure, Level, Series
from reports.plots.style import CONTACT, DOTTED, INK, LOOKS, MUTED, Look
from reports.tables import cells
from reports.tables.cells import Table, table

SMALLEST = 1e-12  # the bar of a closed form
MARGIN = 2.0
CAPTION = (
    "Each entry at the time that its author states and its largest error, the bar of the reference "
    "included. Orange, joined: the front, entries that none beats in both. Dotted, grey: the "
    "tolerance of the sheet; hollow: outside it. Entries without a time, or without all "
    "quantities, stand in the table only."
)
FRONT = Look("front", CONTACT, dash=DOTTED)


def leaderboard_page(boards: Sequence[Board], refused: Sequence[str]) -> str:
    """Return the whole page as text; the same entries give the same bytes."""
    plots = {board.sheet.id: front_plot(board) for board in boards}
    return render(
        "leaderboard.html.j2",
        {figure.key: figure for figure in plots.values() if figure is not None},
        boards=boards,
        refused=refused,
        plots=plots,
        tables={board.sheet.id: board_table(board) for board in boards},
    )


def board_table(board: Board) -> Table:
    """Return all entries of a problem, the best first."""
    quantities = board.sheet.quantities
    rows = []
    for judged in board.entries:
        entry = judged.entry
        seconds = cells.NOTHING if entry.seconds is None else cells.duration(entry.seconds)
        rows.append(
            (
                *(entry.solver, entry.author),
                cells.verdict(judged.verdicts[judged.worst].word),
                *map(cells.of_verdict, judged.verdicts.values()),
                ", ".join(quantity(name).label for name in judged.beyond),
                seconds,
                cells.count(entry.threads),
                "front" if judged in board.front else "",
                entry.digest[:16],
            )
        )
    heads = ("solver", "author", "verdict", *(quantity(name).label for name in quantities))
    return table(
        (*heads, "beyond what is proved", "time as stated", "threads", "front", "entry"), rows
    )


def front_plot(board: Board) -> Figure | None:
    """Return the plot of a problem, or None if no entry has both an error and a time."""
    placed = [judged for judged in board.entries if judged.placed]
    if not placed:
        return None
    times, errors = (np.array(v) for v in zip(*map(_place, placed), strict=True))
    tolerance = board.sheet.tolerance
    span = times.min() / MARGIN, times.max() * MARGIN
    edges = min(errors.min(), tolerance) / MARGIN, max(errors.max(), tolerance) * MARGIN
    series = []
    if board.front:
        x, y = (np.array(v) for v in zip(*map(_place, board.front), strict=True))
        series.append(Series(FRONT, x, y, marks=False))
    looks = list(LOOKS.values())
    for number, judged in enumerate(placed):
        entry, (x, y) = judged.entry, map(np.atleast_1d, _place(judged))
        colour = CONTACT if judged in board.front else INK
        own = Look(entry.solver, colour, looks[number % len(looks)].marker, size=10)
        wrong = judged.verdicts[judged.worst].word == OUTSIDE
        said = f"{entry.solver}: {fmt.relative(judged.error)} in {fmt.duration(entry.seconds)}"
        series.append(Series(own, x, y, line=False, hollow=wrong, hover=(said,)))
    return Figure(
        f"board-{board.sheet.id.lower()}",
        f"{board.sheet.id}: time and error",
        CAPTION,
        time_axis("time as stated", span),
        error_axis(*edges, "largest error"),
        tuple(series),
        levels=(Level(tolerance, colour=MUTED, dash=DOTTED),),
    )


def _place(judged: Judged) -> tuple[float, float]:
    return float(judged.entry.seconds or np.nan), max(judged.error, SMALLEST)
