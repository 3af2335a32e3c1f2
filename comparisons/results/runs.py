"""Comparison of two runs, solve by solve: changes in value, error and time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from comparisons.formatting import duration, number, relative
from comparisons.results.store import SceneRecord, StudyRecord

# The same solve on another machine ends within the tolerance of its iterations (1e-6).
MOVED = 1e-5
# Two readings of one solve scatter by some 20 %, and more on a busy machine.
SLOWER = 1.5
# Shorter solves are timed no better than the machine's interruptions.
SHORTEST = 0.02

SAME, CHANGED, LOST, RECOVERED, ONE_SIDED, VERDICT, SLOW, FAST = (
    "same",
    "moved",
    "lost",
    "found again",
    "in one run only",
    "verdict changed",
    "slower",
    "faster",
)
# What a comparison fails on; the rest is told. A time alone is no worse answer.
BAD = (CHANGED, LOST, VERDICT)
TIMED = (SLOW, FAST)


@dataclass(frozen=True)
class _Counts:
    """What counts: a relative change of a quantity, and a ratio of times."""

    moved: float
    slower: float


@dataclass(frozen=True)
class Change:
    """The change of one solve (one method on one scene at one resolution).

    Attributes
    ----------
    scene, method : str
    resolution : int
    kinds : tuple of str
        Everything that is true of it: "moved", "lost", "slower" ...; ("same",) where nothing is.
    quantity : str
        The quantity that changed most.
    change : float
        Its largest relative change, with sign; 0 where nothing was compared.
    errors : tuple of float
        The largest error of the quantities compared with the truth, before and after (NaN where
        there is none, as for the truth itself).
    seconds : tuple of float
        Time before and after (NaN where not solved).
    text : str
        The same in words.
    """

    scene: str
    method: str
    resolution: int
    kinds: tuple[str, ...]
    quantity: str = ""
    change: float = 0.0
    errors: tuple[float, float] = (float("nan"), float("nan"))
    seconds: tuple[float, float] = (float("nan"), float("nan"))
    text: str = ""

    @property
    def bad(self) -> bool:
        """Whether it makes a comparison fail."""
        return any(kind in BAD for kind in self.kinds)

    @property
    def only_timed(self) -> bool:
        """Whether nothing but the time has changed."""
        return all(kind in TIMED for kind in self.kinds)

    @property
    def ratio(self) -> float:
        """Time after over time before."""
        before, after = self.seconds
        return after / before if before > 0 else float("nan")


@dataclass(frozen=True)
class RunComparison:
    """Two runs side by side.

    Attributes
    ----------
    before, after : StudyRecord
    changes : tuple of Change
        One for every solve of both runs.
    notes : tuple of str
        What makes the runs differ as a whole: versions, machines, scenes, references.
    """

    before: StudyRecord
    after: StudyRecord
    changes: tuple[Change, ...]
    notes: tuple[str, ...]

    @property
    def failed(self) -> tuple[Change, ...]:
        """What moved, was lost, changed its verdict or became slower."""
        return tuple(change for change in self.changes if change.bad)


def compare_runs(
    before: StudyRecord, after: StudyRecord, moved: float = MOVED, slower: float = SLOWER
) -> RunComparison:
    """Compare two results folders.

    Parameters
    ----------
    before, after : StudyRecord
    moved : float
        Relative change of a quantity (on a path, relative to its largest value) that counts.
    slower : float
        Ratio of times that counts; times of different machines are told, never judged.

    Returns
    -------
    RunComparison
    """
    old = {scene.name: scene for scene in before.scenes}
    new = {scene.name: scene for scene in after.scenes}
    notes = list(_notes(before, after, old, new))
    counts = _Counts(moved, slower if before.machine == after.machine else float("inf"))
    changes: list[Change] = []
    for name in [*old, *(name for name in new if name not in old)]:
        was, now = old.get(name), new.get(name)
        keys = {key: None for scene in (was, now) if scene is not None for key in _solves(scene)}
        changes += [_change(name, key, was, now, counts) for key in keys]
    return RunComparison(before, after, tuple(changes), tuple(notes))


def _notes(
    before: StudyRecord,
    after: StudyRecord,
    old: dict[str, SceneRecord],
    new: dict[str, SceneRecord],
) -> Iterator[str]:
    names = [*before.versions, *(n for n in after.versions if n not in before.versions)]
    for name in names:
        pair = [run.versions.get(name, "not installed") for run in (before, after)]
        if pair[0] != pair[1]:
            yield f"{name}: {pair[0]} before, {pair[1]} after"
    if before.machine != after.machine:
        yield "the machines differ: times are shown but not judged"
    if before.effort != after.effort:
        yield f"effort: {before.effort} before, {after.effort} after"
    for run, ordinal in ((before, "first"), (after, "second")):
        if run.interrupted:
            yield f"the {ordinal} run was interrupted"
    for name, scene in old.items():
        scene_after = new.get(name)
        if scene_after is None:
            yield f"{name}: in the first run only"
            continue
        if scene.tables != scene_after.tables:
            yield f"{name}: the scene itself differs"
        yield from _truth_notes(name, scene, scene_after)
    yield from (f"{name}: in the second run only" for name in new if name not in old)


def _truth_notes(name: str, was: SceneRecord, now: SceneRecord) -> Iterator[str]:
    truths = [
        f"{scene.reference['method']} {scene.reference['resolution']}"
        if scene.reference
        else "none"
        for scene in (was, now)
    ]
    if truths[0] != truths[1]:
        yield f"{name}: the reference was {truths[0]}, now {truths[1]}"
    for text in now.disagreements:
        if text not in was.disagreements:
            yield f"{name}: {text}"


def _solves(scene: SceneRecord) -> list[tuple[str, int]]:
    """Return what was solved; refusals have no resolution."""
    rows = scene.rows
    if not len(rows):
        return []
    solved = rows[rows["resolution"].notna()]
    pairs = solved[["method", "resolution"]].drop_duplicates()
    return [(str(m), int(n)) for m, n in pairs.itertuples(index=False)]


def _rows(scene: SceneRecord | None, method: str, resolution: int) -> pd.DataFrame:
    if scene is None or not len(scene.rows):
        return pd.DataFrame()
    rows = scene.rows
    return rows[(rows["method"] == method) & (rows["resolution"] == resolution)]


def _change(
    name: str,
    solved: tuple[str, int],
    was: SceneRecord | None,
    now: SceneRecord | None,
    counts: _Counts,
) -> Change:
    """Return what became of one solve: a method at a resolution."""
    method, resolution = solved
    old, new = _rows(was, method, resolution), _rows(now, method, resolution)
    if was is None or now is None or not len(old) or not len(new):
        ordinal = "first" if len(old) else "second"
        text = f"in the {ordinal} run only"
        return Change(name, method, resolution, (ONE_SIDED,), text=text)
    both = old.merge(new, on=["realisation", "step"], suffixes=("", "_after"))
    lost = int((_true(both["converged"]) & ~_true(both["converged_after"])).sum())
    lost += max(len(old) - len(both), 0)
    recovered = int((~_true(both["converged"]) & _true(both["converged_after"])).sum())
    both = both[_true(both["converged"]) & _true(both["converged_after"])]
    quantity, change = _largest(both, now)
    verdicts = _verdicts(was, now, method, resolution)
    seconds = _seconds(old), _seconds(new)
    kinds: dict[str, str] = {}
    if lost:
        kinds[LOST] = f"{lost} of {len(old)} answers lost: {_reason(new)}"
    if recovered:
        kinds[RECOVERED] = f"{recovered} lost answers recovered"
    if abs(change) > counts.moved:
        sign = "+" if change > 0 else "\N{MINUS SIGN}"
        kinds[CHANGED] = f"{quantity.replace('_', ' ')} moved by {sign}{relative(abs(change))}"
    if verdicts:
        kinds[VERDICT] = "; ".join(verdicts)
    kinds |= _time_words(seconds, counts.slower)
    errors = _error(was, method, resolution), _error(now, method, resolution)
    text = "; ".join(kinds.values()) or "same"
    all_kinds = tuple(kinds) or (SAME,)
    return Change(name, method, resolution, all_kinds, quantity, change, errors, seconds, text)


def _true(column: pd.Series[Any]) -> pd.Series[bool]:
    return column.astype(str) == "True"


def _seconds(rows: pd.DataFrame) -> float:
    """Return the time of one solve: its rows share it."""
    values = pd.to_numeric(rows["seconds"], errors="coerce").to_numpy(dtype=float)
    return float(values[0]) if len(values) and np.isfinite(values[0]) else float("nan")


def _time_words(seconds: tuple[float, float], slower: float) -> dict[str, str]:
    before, after = seconds
    if not (before > 0 and after > 0) or max(seconds) < SHORTEST:
        return {}
    times = f"{duration(before)} before, {duration(after)} after"
    if after > slower * before:
        return {SLOW: f"{number(after / before, 2)} times slower ({times})"}
    if before > slower * after:
        return {FAST: f"{number(before / after, 2)} times faster ({times})"}
    return {}


def _largest(both: pd.DataFrame, scene: SceneRecord) -> tuple[str, float]:
    """Return the quantity that changed most and its change, relative to its size."""
    worst = ("", 0.0)
    for name in scene.quantities:
        if name not in both or f"{name}_after" not in both:
            continue
        old = pd.to_numeric(both[name], errors="coerce").to_numpy(dtype=float)
        new = pd.to_numeric(both[f"{name}_after"], errors="coerce").to_numpy(dtype=float)
        differing = np.isfinite(old) & np.isfinite(new) & (old != new)
        if not differing.any():
            continue
        size = np.abs(old[differing])
        if scene.is_path:
            size = np.full_like(size, np.nanmax(np.abs(old)))
        with np.errstate(divide="ignore"):
            changes = (new[differing] - old[differing]) / size
        most = float(changes[np.argmax(np.abs(changes))])
        if abs(most) > abs(worst[1]):
            worst = name, most
    return worst


def _measures(scene: SceneRecord, method: str, resolution: int) -> pd.DataFrame:
    table = scene.measures
    if not len(table) or "method" not in table:
        return pd.DataFrame()
    return table[(table["method"] == method) & (table["resolution"] == resolution)]


def _error(scene: SceneRecord, method: str, resolution: int) -> float:
    measures = _measures(scene, method, resolution)
    if not len(measures):
        return float("nan")
    values = pd.to_numeric(measures["maximum"], errors="coerce").abs().to_numpy(dtype=float)
    return float(np.nanmax(values)) if np.isfinite(values).any() else float("nan")


def _verdicts(was: SceneRecord, now: SceneRecord, method: str, resolution: int) -> list[str]:
    """Return the verdicts that changed, in words."""
    sides = [_measures(scene, method, resolution) for scene in (was, now)]
    if not all(len(side) for side in sides):
        return []

    old, new = (
        {(str(row.quantity), str(row.at)): str(row.verdict) for row in side.itertuples()}
        for side in sides
    )
    return [
        f"{name[0].replace('_', ' ')} at equal {name[1].replace('_', ' ')} was {verdict}, "
        f"is {new[name]}"
        for name, verdict in old.items()
        if name in new and new[name] != verdict
    ]


def _reason(rows: pd.DataFrame) -> str:
    reasons = [str(reason) for reason in rows["reason"].dropna() if str(reason)]
    return reasons[0] if reasons else "no reason given"
