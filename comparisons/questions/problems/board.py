"""Entries judged by the references of their sheets, and the front of those that none beats."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from comparisons.errors import InputError
from comparisons.judging.metrics import front
from comparisons.judging.truth import choose_truth
from comparisons.judging.verdicts import Judgement, judged, severity
from comparisons.methods.normal.proved import enclosures
from comparisons.methods.solver import Refused
from comparisons.questions.problems.sheet import (
    BAR_DIGITS,
    Entry,
    Known,
    Sheet,
    builtin_sheets,
    read_entry,
    seal,
)
from comparisons.questions.study import solved_in_memory
from comparisons.solving.planning import plan_scene

ENTRIES = "entries"
# Digits of published references: beyond them nobody's solver is judged.
DIGITS = 10
# Rounding of a printed value, within which it may lie beyond a proved interval.
_ROUNDING = 1e-9


def reference_of(sheet: Sheet) -> dict[str, Known]:
    """Return what is known of every quantity: as published, or computed and held against its seal.

    InputError if the reference that is computed here is not the one that was sealed.
    """
    if sheet.sealed is None:
        return sheet.reference
    known = computed(sheet)
    if seal(known, sheet.sealed.digits) != sheet.sealed:
        raise InputError(
            f"{sheet.id}: the reference of this roughline is not the sealed one (version "
            f"{sheet.version}): nothing is judged by it"
        )
    return known


def computed(sheet: Sheet) -> dict[str, Known]:
    """Solve the scene of a sheet and return the truth, its bars and what theorems enclose.

    InputError if no method gives all quantities.
    """
    plan = plan_scene(sheet.scene)[0]
    plan, solved = solved_in_memory(plan, "quick")
    truth = choose_truth(solved, plan.loads.axis, sheet.quantities)
    missing = [name for name in sheet.quantities if truth is None or not truth.knows(name)]
    if truth is None or missing:
        raise InputError(f"{sheet.id}: no reference for {', '.join(missing)}")
    try:
        sides = enclosures(plan.scene, plan.geometry, plan.loads)
    except Refused:
        sides = {}

    def rounded(values: np.ndarray | None, digits: int) -> tuple[float, ...]:
        return () if values is None else tuple(float(f"{value:.{digits - 1}e}") for value in values)

    return {
        name: Known(
            values=rounded(truth.curves[name], DIGITS),
            bars=rounded(truth.bar(name), BAR_DIGITS),
            lower=rounded(sides.get(f"{name}_lower"), DIGITS),
            upper=rounded(sides.get(f"{name}_upper"), DIGITS),
        )
        for name in sheet.quantities
    }


@dataclass(frozen=True)
class Judged:
    """An entry with a verdict on every quantity of its sheet."""

    entry: Entry
    verdicts: dict[str, Judgement]
    # Quantities with a value outside the interval that a theorem gives: certainly wrong.
    beyond: tuple[str, ...]

    @property
    def worst(self) -> str:
        """The quantity that decides."""
        return min(self.verdicts, key=lambda name: severity(self.verdicts[name]))

    def lost(self, name: str) -> list[int]:
        """Return the loads, counted from one, at which an entry gives no value of a quantity."""
        values = self.entry.values.get(name, ())
        return [step for step, value in enumerate(values, start=1) if value is None]

    @property
    def error(self) -> float:
        """The largest |e| + u of all quantities; NaN where one is missing."""
        return float(np.max([verdict.high for verdict in self.verdicts.values()]))

    @property
    def placed(self) -> bool:
        """Whether it has a place in a plot of error against time."""
        return bool(np.isfinite(self.error)) and self.entry.seconds is not None


def judge_entry(entry: Entry, sheet: Sheet, known: dict[str, Known]) -> Judged:
    """Judge an entry by the reference of its sheet: largest |e| + u against the tolerance."""
    verdicts, beyond = {}, []
    for name in sheet.quantities:
        part = known[name]
        values = np.array(entry.values.get(name, [None] * len(part.values)), dtype=float)
        with np.errstate(over="ignore"):  # a value that is beyond all bounds errs infinitely
            errors = values / np.array(part.values) - 1
        verdicts[name] = judged(errors, np.array(part.bars), sheet.tolerance)
        below = part.lower and values < np.array(part.lower) * (1 - _ROUNDING)
        above = part.upper and values > np.array(part.upper) * (1 + _ROUNDING)
        if np.any(below) or np.any(above):
            beyond.append(name)
    return Judged(entry, verdicts, tuple(beyond))


@dataclass(frozen=True)
class Board:
    """All entries of a problem, the best first; `front` are those that no other one beats.

    None beats in both error and time; the fastest of the front is its first.
    """

    sheet: Sheet
    entries: tuple[Judged, ...]
    front: tuple[Judged, ...]


def board_of(sheet: Sheet, entries: Iterable[Entry]) -> Board:
    """Judge and rank the entries of a problem.

    InputError if the sealed reference does not come out here.
    """
    known = reference_of(sheet)
    ranked = sorted((judge_entry(entry, sheet, known) for entry in entries), key=_rank)
    placed = [judged for judged in ranked if judged.placed]
    times = np.array([judged.entry.seconds for judged in placed], dtype=float)
    best = front(times, np.array([judged.error for judged in placed]))
    return Board(sheet, tuple(ranked), tuple(placed[index] for index in best))


def boards_of(folder: Path) -> tuple[list[Board], list[str]]:
    """Return the boards of all problems with entries in a folder, and why files are not judged.

    InputError if there are no entries, or a sealed reference does not come out here.
    """
    paths = sorted((folder / ENTRIES).glob("*.json"))
    if not paths:
        raise InputError(
            f"{folder}: no entries; `roughline submit FILE --leaderboard DIR` adds one"
        )
    entries: dict[str, Entry] = {}
    refused = []
    for path in paths:
        try:
            entry = read_entry(path)
            entries[entry.digest] = entry
        except InputError as error:
            refused.append(str(error).replace(str(path), path.name))
    boards = []
    for sheet in builtin_sheets().values():
        ours = [entry for entry in entries.values() if entry.problem == sheet.id]
        if ours:
            boards.append(board_of(sheet, ours))
    return boards, refused


def _rank(entry: Judged) -> tuple[object, ...]:
    error = entry.error if np.isfinite(entry.error) else np.inf
    seconds = np.inf if entry.entry.seconds is None else entry.entry.seconds
    order = -severity(entry.verdicts[entry.worst])[0]
    return order, error, seconds, entry.entry.solver, entry.entry.digest
