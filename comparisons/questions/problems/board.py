"""Entries judged by the sheet's reference, and the front of those that none beats."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from comparisons.errors import InputError
from comparisons.files import write_text
from comparisons.judging.metrics import front
from comparisons.judging.verdicts import Judgement, judged, severity
from comparisons.questions.problems.entry import Entry, read_entry
from comparisons.questions.problems.reference import reference_of
from comparisons.questions.problems.sheet import Known, Sheet, builtin_sheets

ENTRIES = "entries"
# Rounding of a printed value, within which it may lie beyond a proved interval.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Judged:
    """An entry with a verdict on every quantity of its sheet.

    Attributes
    ----------
    beyond : tuple of str
        Quantities with a value outside the interval that a theorem gives: certainly wrong.
    """

    entry: Entry
    verdicts: dict[str, Judgement]
    beyond: tuple[str, ...]

    @property
    def worst(self) -> str:
        """The quantity that decides."""
        return min(
            self.verdicts,
            key=lambda name: severity(
                self.verdicts[name].word,
                self.verdicts[name].low,
                self.verdicts[name].high,
                self.verdicts[name].error,
            ),
        )

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


@dataclass(frozen=True)
class Board:
    """All entries of a problem, the best first; `front` are those that no other one beats."""

    sheet: Sheet
    entries: tuple[Judged, ...]
    front: tuple[Judged, ...]


def judge_entry(entry: Entry, sheet: Sheet) -> Judged:
    """Judge an entry at the loads of its sheet: largest |e| + u against the tolerance.

    Raises
    ------
    InputError
        If the sealed reference does not come out here.
    """
    known = reference_of(sheet)
    verdicts, beyond = {}, []
    for name in sheet.quantities:
        reference = known[name]
        values = np.array(entry.values.get(name, [None] * len(reference.values)), dtype=float)
        with np.errstate(over="ignore"):  # a value that is beyond all bounds errs infinitely
            errors = values / np.array(reference.values) - 1
        verdicts[name] = judged(errors, np.array(reference.bars), sheet.tolerance)
        if _is_beyond(values, reference):
            beyond.append(name)
    return Judged(entry, verdicts, tuple(beyond))


def _is_beyond(values: np.ndarray, known: Known) -> bool:
    if not known.lower:
        return False
    low, high = np.array(known.lower), np.array(known.upper)
    return bool(np.any((values < low * (1 - _ROUNDING)) | (values > high * (1 + _ROUNDING))))


def add_entry(folder: Path, entry: Entry) -> Path:
    """Store an entry under the hash of what it states; the same one again changes nothing."""
    path = folder / ENTRIES / f"{entry.problem.lower()}-{entry.digest[:16]}.json"
    write_text(path, entry.text)
    return path


@dataclass(frozen=True)
class Leaderboard:
    """The boards of all problems with entries, and why files are not judged."""

    boards: tuple[Board, ...]
    refused: tuple[str, ...] = ()


def leaderboard_of(folder: Path) -> Leaderboard:
    """Judge all entries of a folder, problem by problem.

    Raises
    ------
    InputError
        If there are none.
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
    boards = (_board(sheet, entries.values()) for sheet in builtin_sheets().values())
    return Leaderboard(tuple(board for board in boards if board.entries), tuple(refused))


def _board(sheet: Sheet, entries: Iterable[Entry]) -> Board:
    judged_entries = [judge_entry(entry, sheet) for entry in entries if entry.problem == sheet.id]
    ranked = sorted(judged_entries, key=_rank)
    return Board(sheet, tuple(ranked), tuple(undominated(ranked)))


def _rank(judged_entry: Judged) -> tuple[object, ...]:
    verdict, entry = judged_entry.verdicts[judged_entry.worst], judged_entry.entry
    order, *_ = severity(verdict.word, verdict.low, verdict.high, verdict.error)
    error = judged_entry.error if np.isfinite(judged_entry.error) else np.inf
    seconds = np.inf if entry.seconds is None else entry.seconds
    return -order, error, seconds, entry.solver, entry.digest


def undominated(entries: Sequence[Judged]) -> list[Judged]:
    """Return the entries that no other one beats in both error and time, the fastest first."""
    placed = [judged for judged in entries if judged.placed]
    times = np.array([judged.entry.seconds for judged in placed], dtype=float)
    errors = np.array([judged.error for judged in placed])
    return [placed[index] for index in front(times, errors)]
