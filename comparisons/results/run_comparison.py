"""Comparison of two runs, solve by solve: changes in value, error and time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd
from pydantic import BaseModel

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM
from comparisons.facts.quantities import quantity
from comparisons.results.record import SceneRecord, StudyRecord
from comparisons.results.rows import NO_ROWS, Rows
from comparisons.scene.fields import excerpt, unit_of

# The same solve on another machine ends within the tolerance of its iterations (1e-6).
MOVED = 1e-5
# Closer times are not told apart.
SLOWER = 1.5
# Shorter solves are timed no better than the machine's interruptions.
SHORTEST = 0.02

# A run keeps one time of a solve, no scatter: that it took longer is told, not that it is slower.
KINDS = LOST, CHANGED, VERDICT, SLOW, RECOVERED, FAST, ONE_SIDED, SAME = (
    *("lost", "moved", "verdict changed", "took longer", "found again"),
    *("took less time", "in one run only", "same"),
)
# What a comparison fails on; the rest is told. A time alone is no worse answer.
BAD = (CHANGED, LOST, VERDICT)
TIMED = (SLOW, FAST)


@dataclass(frozen=True)
class Change:
    """The change of one solve (one method on one scene at one resolution)."""

    scene: str
    method: str
    resolution: int
    # All that is true of it, in words: "moved", "lost", "took longer" ...; "same" where nothing is.
    kinds: dict[str, str]
    # The largest relative change of each quantity, with sign.
    moves: dict[str, float] = field(default_factory=dict)
    # The largest error of the quantities compared with the truth, before and after (NaN where there
    # is none, as for the truth itself).
    errors: tuple[float, float] = (float("nan"), float("nan"))
    errors_of: tuple[str, str] = ("", "")  # their quantities
    # Time before and after (NaN where not solved).
    seconds: tuple[float, float] = (float("nan"), float("nan"))

    @property
    def text(self) -> str:
        """All that is true of it, in words."""
        return "; ".join(self.kinds.values())

    @property
    def moved(self) -> str:
        """Each quantity that moved, by how much."""
        return self.kinds.get(CHANGED, "")

    @property
    def quantity(self) -> str:
        """The quantity that changed most."""
        return max(self.moves, key=lambda name: abs(self.moves[name]), default="")

    @property
    def change(self) -> float:
        """Its change; 0 where nothing was compared."""
        return self.moves.get(self.quantity, 0.0)

    @property
    def what(self) -> str:
        """What moved by how much, or else what happened."""
        moved = f"{self.quantity.replace('_', ' ')} by {fmt.signed_error(self.change)}"
        return moved if CHANGED in self.kinds else self.text

    @property
    def bad(self) -> bool:
        """Whether it makes a comparison fail."""
        return any(kind in BAD for kind in self.kinds)

    @property
    def only_timed(self) -> bool:
        """Whether nothing but the time has changed."""
        return all(kind in TIMED for kind in self.kinds)


@dataclass(frozen=True)
class RunComparison:
    """Two runs side by side."""

    before: StudyRecord
    after: StudyRecord
    changes: tuple[Change, ...]  # one for every solve of both runs
    # What makes the runs differ as a whole: versions, machines, scenes, references.
    notes: tuple[str, ...]

    @property
    def compared(self) -> tuple[Change, ...]:
        """What is in both runs."""
        return tuple(change for change in self.changes if ONE_SIDED not in change.kinds)

    @property
    def failed(self) -> tuple[Change, ...]:
        """What moved, was lost or changed its verdict."""
        return tuple(change for change in self.changes if change.bad)

    @property
    def alike(self) -> dict[str, str]:
        """What moved, by scene, where all solves moved alike: the input did, not a method."""
        moved: dict[str, list[str]] = {}
        for change in self.compared:
            only = {CHANGED, *TIMED}.issuperset(change.kinds)
            moved.setdefault(change.scene, []).append(change.moved if only else "")
        return {
            scene: f"{scene}: in all {len(own)} solves {own[0]}"
            for scene, own in moved.items()
            if own[0] and own.count(own[0]) == len(own) > 1
        }

    @property
    def sentence(self) -> str:
        """How many solves changed, in the words of terminal, page and notebook."""
        kinds = [c.kinds for c in self.compared]
        changed = sum(not {SAME, *TIMED}.issuperset(own) for own in kinds)
        alone = len(self.changes) - len(kinds)
        if not kinds:
            return "Nothing in both runs can be compared"
        return (
            f"{changed or 'None'} of {len(kinds)} solves in both runs changed an answer or a "
            "verdict" + (f"; {alone} more are in one run only" if alone else "")
        )


def compare_runs(
    before: StudyRecord,
    after: StudyRecord,
    moved: float = MOVED,
    slower: float = SLOWER,
    tolerances: Mapping[str, float] = MappingProxyType({}),
) -> RunComparison:
    """Compare two results folders.

    A relative change beyond `moved` counts (on a path, relative to the largest value; `tolerances`
    in its place, for single methods), and a ratio of times beyond `slower`; times of different
    machines are shown only. The only scenes of two runs are compared whatever their names.
    """
    old = {scene.name: scene for scene in before.scenes}
    new = {scene.name: scene for scene in after.scenes}
    notes = []
    if len(old) == len(new) == 1 and old.keys() != new.keys():
        (name,), (other,) = old, new
        notes.append(f"the scene is called {name} in the first run and {other} in the second")
        new = {name: new[other]}
    for name in [*before.versions, *(n for n in after.versions if n not in before.versions)]:
        pair = [run.versions.get(name, "not installed") for run in (before, after)]
        if pair[0] != pair[1]:
            notes.append(f"{name}: {pair[0]} before, {pair[1]} after")
    if before.machine != after.machine:
        notes.append("the machines differ: no solve is said to take longer or less time")
    if before.effort != after.effort:
        notes.append(f"effort: {before.effort} before, {after.effort} after")
    for run, ordinal in ((before, "first"), (after, "second")):
        if run.interrupted:
            notes.append(f"the {ordinal} run was interrupted")
    slower = slower if before.machine == after.machine else float("inf")
    changes: list[Change] = []
    for name in [*old, *(name for name in new if name not in old)]:
        was, now, least = old.get(name), new.get(name), 0.0
        if was is None or now is None:
            notes.append(f"{name}: in the {'second' if was is None else 'first'} run only")
        else:
            if differing := differences(was, now):
                told = "; ".join(differing)
                notes.append(f"{name}: the scene differs (plain numbers are SI): {told}")
            if problem_of(was) != problem_of(now):
                first, second, told = at_common_loads(was, now)
                notes += [f"{name}: {told}"] if told else []
                both = (was, now) if told and len(first.rows) else ()
                largest = [np.nanmax(np.abs(run.rows[run.control])) for run in both]
                if both and abs(largest[0] - largest[1]) > MOVED * max(largest):
                    least = min(was.tolerance, now.tolerance)  # the move that counts
                    told = f"moves on its grids count beyond {fmt.tolerance(least)}"
                    notes.append(f"{name}: N is of the largest load, which differs: {told}")
                was, now = first, second
            truths = [
                run.reference.method and f"{run.reference.method} {run.reference.resolution}"
                for run in (was, now)
            ]
            if truths[0] != truths[1]:
                told = ", now ".join(truth or "none" for truth in truths)
                notes.append(f"{name}: the reference was {told}")
            newly = [text for text in now.disagreements if text not in was.disagreements]
            notes += [f"{name}: {text}" for text in newly]
        solves = dict.fromkeys(
            (method, int(n))
            for scene in (was, now)
            if scene is not None
            for method in dict.fromkeys(scene.rows["method"])
            for n in scene.resolutions_run(method)
        )
        for method, n in solves:
            counts = tolerances.get(method, moved)
            counts = counts if method == CLOSED_FORM else max(counts, least)
            changes.append(_change(name, method, n, was, now, counts, slower))
    return RunComparison(before, after, tuple(changes), tuple(notes))


def problem_of(scene: SceneRecord) -> dict[str, object]:
    """Return the tables of a scene that say what is solved, whoever solves it."""
    apart = {"name", "title", "compare", "methods"}
    tables = {name: table for name, table in scene.tables.items() if name not in apart}
    if isinstance(surface := tables.get("surface"), dict):  # a check takes a few surfaces
        tables["surface"] = {k: v for k, v in surface.items() if k != "realisations"}
    return tables


def differences(was: SceneRecord, now: SceneRecord) -> list[str]:
    """Return the keys of a scene, but its name, that differ between two runs, with both values."""
    sides = [
        pd.json_normalize(scene.tables).to_dict("records")[0]
        | {"compare.tolerance": scene.tolerance}  # also where it is the default
        for scene in (was, now)
    ]
    told = []
    for key in dict.fromkeys([*sides[0], *sides[1]]):
        if key == "name" or sides[0].get(key) == sides[1].get(key):
            continue
        table, unit = now.scene, ""
        for name in key.split("."):
            known = type(table).model_fields if isinstance(table, BaseModel) else {}
            unit = unit_of(known[name]) if name in known else ""
            table = getattr(table, name, None)
        texts = (_in_words(key, side.get(key), unit) for side in sides)
        told.append(f"{key.removesuffix('.values')}: {' → '.join(texts)}")
    return told


def _in_words(key: str, value: Any, unit: str = "") -> str:
    """Return what a scene says under a key, with its unit, a long list by its ends."""
    if key == "compare.tolerance":
        return fmt.tolerance(value)
    values = value if isinstance(value, list) else [value]
    if not values or not all(type(item) in (int, float) for item in values):
        return "not given" if value is None else excerpt(value)
    table, _, name = key.removesuffix(".values").partition(".")
    unit = quantity(name).unit if table == "loading" else unit
    scale = fmt.prefix_for(values, unit) if unit.isalpha() else fmt.Scale(1.0, unit)
    texts = [fmt.without_padding(fmt.number(item * scale.factor, 12)) for item in values]
    text = ", ".join(texts) if len(texts) <= 4 else f"{len(texts)} from {texts[0]} to {texts[-1]}"
    return f"{text}{fmt.THIN}{scale.unit}" if scale.unit else text


def at_common_loads(was: SceneRecord, now: SceneRecord) -> tuple[SceneRecord, SceneRecord, str]:
    """Return two records at the loads that both have, with the steps of the first; and a note.

    Paths are followed until they part. Verdicts and times are left out unless all loads are common.
    """
    names = list(dict.fromkeys((was.along, was.control))) if was.along == "time" else [was.control]
    first, second = (
        scene.rows.frame().reindex(columns=["step", *names]).groupby("step")[names].median()
        for scene in (was, now)
    )
    x, y = first.to_numpy(dtype=float), second.to_numpy(dtype=float)
    if (was.control, was.along) != (now.control, now.along):
        x, y = x[:0], y[:0]
    if was.is_path:
        places = np.arange(min(len(x), len(y)))
        near = np.cumprod(np.isclose(x[places], y[places], MOVED, 0).all(axis=1)) > 0
    else:  # loads increase
        places = np.searchsorted(y[:, 0], x[:, 0] - MOVED * np.abs(x[:, 0]))
        near = places < len(y)
        near[near] = np.isclose(x[near], y[places[near]], MOVED, 0)[:, 0]
    steps = dict(zip(second.index[places[near]], first.index[: len(near)][near], strict=True))
    whole = len(steps) == len(first) == len(second)
    sides = []
    for scene, own in ((was, {step: step for step in steps.values()}), (now, steps)):
        table = scene.rows.where(np.isin(scene.rows["step"], list(own))).frame()
        table["step"] = table["step"].map(own)
        if not whole:
            table["seconds"] = np.nan
        verdicts = scene.verdicts if whole else ()
        sides.append(replace(scene, rows=Rows.of(table), verdicts=verdicts))
    if loads := first.loc[list(steps.values()), was.control].tolist():
        common = _in_words(f"loading.{was.control}", loads)
        words = "step" if len(loads) == 1 else "steps"
        told = f"compared at {common} alone, the only {words} in both; verdicts and times, which "
        told += "cover all steps, are left out"
    else:
        told = "no load is common to both runs, so that nothing is compared"
    return sides[0], sides[1], "" if whole else told


def _change(
    name: str,
    method: str,
    resolution: int,
    was: SceneRecord | None,
    now: SceneRecord | None,
    moved: float,
    slower: float,
) -> Change:
    """Return what became of one solve: a method at a resolution."""
    setting = method, resolution
    old, new = (NO_ROWS if scene is None else scene.setting_rows(*setting) for scene in (was, now))
    if was is None or now is None or not len(old) or not len(new):
        text = f"in the {'first' if len(old) else 'second'} run only"
        return Change(name, method, resolution, {ONE_SIDED: text})
    kinds: dict[str, str] = {}

    # answers, and how far they moved
    key = ["realisation", "step"]
    both = old.frame().merge(new.frame(), on=key, suffixes=("", "_after"))
    solved, again = both["converged"], both["converged_after"]
    # On a grid that is no longer the finest, fewer of the solved surfaces have rows: none is lost.
    fewer = new["surfaces"][0] < old["surfaces"][0] or set(old["step"]) - set(new["step"])
    missing = max(len(old) - len(both), 0) if fewer else 0
    lost = int((solved & ~again).sum()) + missing
    if lost:
        reasons = [reason for reason in new["reason"] if reason]
        why = reasons[0] if reasons else "no reason given"
        kinds[LOST] = f"{lost} of {len(old)} answers lost: {why}"
    if recovered := int((~solved & again).sum()):
        kinds[RECOVERED] = f"{recovered} lost answers recovered"
    answered = both[solved & again]
    known = [name for name in now.quantities if name in old and name in new]
    gone = [q for q in known if (answered[q].notna() & answered[f"{q}_after"].isna()).any()]
    if gone:
        named = ", ".join(name.replace("_", " ") for name in gone)
        kinds[LOST] = "; ".join(filter(None, [kinds.get(LOST), f"no value of {named} any more"]))
    moves = _moves(answered, known, is_path=now.is_path)
    told = [
        f"{name.replace('_', ' ')} by {fmt.signed_error(change)}"
        for name, change in moves.items()
        if abs(change) > moved
    ]
    if told:
        kinds[CHANGED] = ", ".join(told).replace(" by ", " moved by ", 1)

    # verdicts, and the largest error of the solve
    sides = [
        {(v.quantity, v.at): v for v in scene.verdicts if (v.method, v.resolution) == setting}
        for scene in (was, now)
    ]
    told = [
        f"{which[0].replace('_', ' ')} at equal {which[1].replace('_', ' ')} was "
        f"{verdict.word}, is {sides[1][which].word}"
        for which, verdict in sides[0].items()
        if which in sides[1] and sides[1][which].word != verdict.word
    ]
    if told:
        kinds[VERDICT] = "; ".join(told)
    known_errors = (
        [(abs(v.error), v.quantity) for v in side.values() if fmt.finite(v.error)] for side in sides
    )
    (error, of), (error_after, of_after) = (
        max(side, default=(float("nan"), "")) for side in known_errors
    )

    # times, which all rows of a solve share
    first, second = (float(rows["seconds"][0]) for rows in (old, new))
    if min(first, second) >= SHORTEST and max(first, second) > slower * min(first, second):
        kind = SLOW if second > first else FAST
        kinds[kind] = f"{kind}: {fmt.duration(first)} before, {fmt.duration(second)} after"
    return Change(
        name,
        method,
        resolution,
        kinds or {SAME: SAME},
        moves,
        (error, error_after),
        (of, of_after),
        (first, second),
    )


def _moves(both: pd.DataFrame, quantities: list[str], *, is_path: bool) -> dict[str, float]:
    """Return the largest change of each quantity that has one, relative to its size."""
    moves = {}
    for name in quantities:
        old, new = (both[column].to_numpy() for column in (name, f"{name}_after"))
        differing = np.isfinite(old) & np.isfinite(new) & (old != new)
        if not differing.any():
            continue
        size = np.abs(old[differing])
        if is_path:
            size = np.full_like(size, np.nanmax(np.abs(old)))
        with np.errstate(divide="ignore"):
            changes = (new[differing] - old[differing]) / size
        moves[name] = float(changes[np.argmax(np.abs(changes))])
    return moves
