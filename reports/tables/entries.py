"""Tables of the entries to problems."""

from __future__ import annotations

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.questions.problems.board import Board, Judged
from comparisons.questions.problems.sheet import Sheet
from reports.tables import cells
from reports.tables.table import Cell, Table, table


def judged_table(judged: Judged, sheet: Sheet) -> Table:
    """Return the verdict on every quantity of an entry."""
    rows = []
    for name, verdict in judged.verdicts.items():
        solved = verdict.step >= 0
        error = cells.error(verdict.error, verdict.uncertainty) if solved else cells.NOTHING
        proved = "beyond what is proved" if name in judged.beyond else ""
        at = f"load {verdict.step + 1}" if solved else ""
        lost = judged.lost(name)
        if lost:
            at = f"{at}; no value at load {', '.join(map(str, lost))}".removeprefix("; ")
        word = cells.verdict(verdict.word, text=f"{verdict.word} {fmt.tolerance(sheet.tolerance)}")
        rows.append((quantity(name).label, error, at, word, proved))
    return table(("quantity", "largest error", "at", "verdict", "theorem"), rows)


def judged_text(judged: Judged, sheet: Sheet) -> str:
    """Return the verdict on an entry in one sentence."""
    entry, verdict = judged.entry, judged.verdicts[judged.worst]
    cost = f"{fmt.duration(entry.seconds)} as stated" if entry.seconds else "no time stated"
    return (
        f"{entry.solver} on {sheet.id}: {verdict.word} {fmt.tolerance(sheet.tolerance)} "
        f"({quantity(judged.worst).label} decides), {cost}, {fmt.count(entry.threads)} "
        f"thread{'s' if entry.threads > 1 else ''}; SHA-256 {entry.digest}"
    )


def board_table(board: Board) -> Table:
    """Return all entries of a problem, the best first."""
    quantities = board.sheet.quantities
    rows = []
    for judged in board.entries:
        entry = judged.entry
        errors = []
        for verdict in judged.verdicts.values():
            solved = verdict.step >= 0
            errors.append(
                cells.error(verdict.error, verdict.uncertainty) if solved else cells.NOTHING
            )
        seconds = cells.NOTHING if entry.seconds is None else cells.duration(entry.seconds)
        rows.append(
            (
                Cell(entry.solver, entry.solver, "text"),
                Cell(entry.author, entry.author, "text"),
                cells.verdict(judged.verdicts[judged.worst].word),
                *errors,
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
