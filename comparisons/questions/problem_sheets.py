"""Problems for all methods: sheets, entries of strangers, and how these are judged.

A sheet is a scene, the quantities asked for, and what is known of them: the reference with the
half-width of its error, and what theorems enclose. Or it is sealed, and states only a hash of the
rounded reference: its recipe, the scene, gives the numbers again, and the hash shows that they are
those which were sealed. Entries are result files, read without running anything of theirs, and
judged by the references of their sheets.
"""

from __future__ import annotations

import hashlib
import json
import math
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, ValidationError, ValidationInfo, field_validator

from comparisons.errors import InputError
from comparisons.facts.quantities import CURVES
from comparisons.files import read_toml
from comparisons.judging.verdicts import Verdict, judged, severity
from comparisons.scene.fields import Positive, SceneTable, excerpt, fail
from comparisons.scene.problems import in_file
from comparisons.scene.scene import Scene, load_scene

FOLDER = Path(__file__).with_name("sheets")
Text = Annotated[str, Field(min_length=1, max_length=2000)]
Values = tuple[float, ...]
BAR_DIGITS = 2
ENTRIES = "entries"
# Digits of published references: beyond them nobody's solver is judged.
DIGITS = 10
# Rounding of a printed value, within which it may lie beyond a proved interval.
_ROUNDING = 1e-9


class Known(SceneTable):
    """What is known of a quantity at every load: the value, its bar, a proved interval."""

    values: Values
    bars: Values
    lower: Values = ()
    upper: Values = ()


class Seal(SceneTable):
    """The hash of the values of all quantities, rounded, and of their bars."""

    digits: Annotated[int, Field(ge=2, le=12)]
    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class Sheet(SceneTable):
    """A problem sheet."""

    id: Annotated[str, Field(pattern=r"^RL-\d{3}$")]
    version: Annotated[int, Field(ge=1)] = 1
    title: Text
    definition: Text
    source: Text
    licence: Text = "CC0-1.0"
    quantities: tuple[str, ...]
    tolerance: Positive = 0.01
    tables: dict[str, Any] = Field(alias="scene")
    reference: dict[str, Known] = Field(default_factory=dict)
    sealed: Seal | None = None

    @cached_property
    def scene(self) -> Scene:
        """The scene as roughline solves it."""
        compare = {"quantities": list(self.quantities), "tolerance": self.tolerance}
        tables = {**self.tables, "compare": {**self.tables.get("compare", {}), **compare}}
        return load_scene({"name": self.id.lower(), "title": self.title, **tables})


def builtin_sheets() -> dict[str, Sheet]:
    """Return the sheets by id, in the order of their numbers."""
    sheets = [read_sheet(path) for path in sorted(FOLDER.glob("*.toml"))]
    return {sheet.id: sheet for sheet in sheets}


def sheet_of(name: str) -> Sheet:
    """Return a sheet by its id, in capitals or not; InputError if there is none."""
    sheets = builtin_sheets()
    if name.upper() not in sheets:
        raise InputError(f"problem: expected one of {', '.join(sheets)}, got {name!r}")
    return sheets[name.upper()]


def read_sheet(path: Path) -> Sheet:
    """Read a sheet; InputError with all that is wrong with it."""
    try:
        sheet = Sheet.model_validate(read_toml(path))
    except ValidationError as error:
        problems = in_file(error, Sheet)
        raise InputError("\n".join([f"{path.name}:", *problems])) from error
    unknown = [name for name in sheet.quantities if name not in CURVES]
    if unknown:
        raise InputError(f"{path.name}: quantities: not a curve: {', '.join(unknown)}")
    return sheet


def seal(known: Mapping[str, Known], digits: int) -> Seal:
    """Return the seal of what is known of all quantities: values, and bars, which judge as well.

    >>> one, other = (Known(values=(value,), bars=(1e-3,)) for value in (1.00004, 1.00001))
    >>> seal({"force": one}, 4) == seal({"force": other}, 4)
    True
    """

    def written(values: Values, digits: int) -> str:
        return " ".join(f"{value:.{digits - 1}e}" for value in values)

    lines = [
        f"{name}: {written(part.values, digits)} bars {written(part.bars, BAR_DIGITS)}"
        for name, part in sorted(known.items())
    ]
    return Seal(digits=digits, sha256=hashlib.sha256("\n".join(lines).encode()).hexdigest())


LARGEST_FILE = 1_000_000
BLANK_SOLVER = "name and version"  # of an entry that is yet to be filled in
# Kinds of characters that nobody sees: control, format (zero width, direction), none, line ends.
_INVISIBLE = {"Cc", "Cf", "Cs", "Co", "Zl", "Zp"}
_BLANK = "\u2800\u115f\u1160\u3164\uffa0"  # letters and signs without ink
LEAST_SECONDS = 1e-9  # no clock tells less
Line = Annotated[str, Field(max_length=200)]
Value = Annotated[float, Field(strict=True)] | None


class Entry(SceneTable):
    """What an entry states."""

    # Of the sheet.
    problem: Annotated[str, Field(pattern=r"^RL-\d{3}$")]
    version: Annotated[int, Field(strict=True, ge=1)]
    solver: Annotated[str, Field(min_length=1, max_length=100)]
    author: Line = ""
    machine: Line = ""
    notes: Annotated[str, Field(max_length=1000)] = ""
    # Quantity -> value at every load of the sheet, in SI units; null where the solver failed.
    values: Annotated[
        dict[str, Annotated[tuple[Value, ...], Field(max_length=10_000)]], Field(max_length=50)
    ]
    # Everything that the solver does for all loads, on warm code, as its author states it.
    seconds: Annotated[float, Field(ge=LEAST_SECONDS, lt=1e9)] | None = None
    threads: Annotated[int, Field(strict=True, ge=1, le=1_000_000)] = 1
    unknowns: Annotated[int, Field(strict=True, ge=1, le=10**15)] | None = None

    @field_validator("solver", "author", "machine", "notes")
    @classmethod
    def _plain_text(cls, value: str, info: ValidationInfo) -> str:
        if any(unicodedata.category(character) in _INVISIBLE for character in value):
            raise fail("expected one line of text without invisible characters", value)
        if info.field_name == "solver" and not value.strip(f" {_BLANK}"):
            raise fail("expected the name of a solver, got nothing that can be seen", value)
        return value

    @field_validator("values")
    @classmethod
    def _finite(cls, value: dict[str, Any]) -> dict[str, Any]:
        for name, numbers in value.items():
            if not all(number is None or math.isfinite(number) for number in numbers):
                raise fail(f"{name}: expected finite numbers, or null where the solver failed")
        return value

    @property
    def text(self) -> str:
        """The entry in one form, whatever order and spaces its file had."""
        stated = self.model_dump(mode="json")
        return json.dumps(stated, sort_keys=True, ensure_ascii=False, indent=1) + "\n"

    @property
    def digest(self) -> str:
        """Hash of `text`."""
        return hashlib.sha256(self.text.encode()).hexdigest()


def read_entry(path: Path) -> Entry:
    """Read an entry and check it against its sheet; InputError with all that is wrong with it."""
    if not path.is_file():
        raise InputError(f"{path}: {'not a file' if path.exists() else 'no such file'}")
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(f"{path}: expected at most {LARGEST_FILE} bytes")
    try:
        text = path.read_bytes().decode("utf-8-sig")
        document = json.loads(text, parse_constant=_no_number, object_pairs_hook=_each_key_once)
        entry = Entry.model_validate(document)
    except OSError as error:
        raise InputError(f"{path}: not readable ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file in UTF-8") from error
    except ValidationError as error:
        raise InputError("\n  ".join([f"{path}:", *in_file(error, Entry)])) from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not valid JSON: {error}") from error
    from comparisons.geometry.prepare import prepare  # heavy: a list of problems needs none

    sheets = builtin_sheets()
    sheet = sheets.get(entry.problem)
    if sheet is None:
        expected = f"expected one of {', '.join(sheets)}, got {entry.problem!r}"
        raise InputError(f"{path}:\n  problem: {expected}")
    problems = []
    if entry.version != sheet.version:
        problems.append(f"version: expected {sheet.version}, got {entry.version}")
    if entry.solver == BLANK_SOLVER:
        problems.append(
            f"solver: expected the name of a solver, got {BLANK_SOLVER!r}: a blank entry"
        )
    if all(value is None for values in entry.values.values() for value in values):
        problems.append(
            "values: expected a number for at least one load, got none: a blank entry, or a solver "
            "that failed at every load, has nothing to be judged"
        )
    _, loads = prepare(sheet.scene)
    for name, values in entry.values.items():
        if name not in sheet.quantities:
            problems.append(
                f"values.{name}: expected one of {', '.join(sheet.quantities)}: the quantities of "
                f"{sheet.id}"
            )
        elif len(values) != len(loads.values):
            problems.append(
                f"values.{name}: expected {len(loads.values)} numbers, one for each load, got "
                f"{len(values)}"
            )
    if problems:
        raise InputError("\n  ".join([f"{path}:", *problems]))
    return entry


def _no_number(name: str) -> float:
    raise ValueError(f"{name} is no number of JSON; a value that is missing is null")


def _each_key_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object; of a key given twice nobody knows which value is meant."""
    table = dict(pairs)
    if len(table) < len(pairs):
        twice = next(key for number, (key, _) in enumerate(pairs) if key in dict(pairs[:number]))
        raise ValueError(f"the key {excerpt(twice)} is given more than once")
    return table


def reference_of(sheet: Sheet) -> dict[str, Known]:
    """Return what is known of every quantity; InputError if it is not the one that was sealed."""
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
    """Solve a sheet: truth, bars and what theorems enclose; InputError if one is missing."""
    # not to list the problems
    from comparisons.judging.truth import choose_truth
    from comparisons.methods.normal.proved import enclosures
    from comparisons.methods.solver import Refused
    from comparisons.questions.study import solved_in_memory
    from comparisons.solving.planning import plan_scene

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
    verdicts: dict[str, Verdict]
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
    """All entries of a problem, best first; the `front`, fastest first, has no better ones."""

    sheet: Sheet
    entries: tuple[Judged, ...]
    front: tuple[Judged, ...]


def board_of(sheet: Sheet, entries: Iterable[Entry]) -> Board:
    """Judge and rank the entries of a problem; InputError as of `reference_of`."""
    from comparisons.judging.metrics import front

    known = reference_of(sheet)
    ranked = sorted((judge_entry(entry, sheet, known) for entry in entries), key=_rank)
    placed = [judged for judged in ranked if judged.placed]
    times = np.array([judged.entry.seconds for judged in placed], dtype=float)
    best = front(times, np.array([judged.error for judged in placed]))
    return Board(sheet, tuple(ranked), tuple(placed[index] for index in best))


def boards_of(folder: Path) -> tuple[list[Board], list[str]]:
    """Return the boards of all problems with entries in a folder, and why files are not judged."""
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
