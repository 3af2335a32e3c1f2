"""The leaderboard page: entries of all problems, from nothing but the entries."""

from __future__ import annotations

from pathlib import Path

from comparisons.files import write_text
from comparisons.questions.problems.board import Leaderboard
from reports.pages.page import render
from reports.plots.leaderboard import front_plot
from reports.tables.entries import board_table


def write_leaderboard(leaderboard: Leaderboard, path: Path) -> None:
    """Write the page, atomically; the same entries give the same bytes."""
    write_text(path, leaderboard_page(leaderboard))


def leaderboard_page(leaderboard: Leaderboard) -> str:
    """Return the whole page as text."""
    boards = leaderboard.boards
    plots = {board.sheet.id: front_plot(board) for board in boards}
    return render(
        "leaderboard.html.j2",
        {figure.key: figure for figure in plots.values() if figure is not None},
        boards=boards,
        refused=leaderboard.refused,
        plots=plots,
        tables={board.sheet.id: board_table(board) for board in boards},
    )
