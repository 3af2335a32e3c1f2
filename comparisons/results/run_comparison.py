"""Comparison of two runs, solve by solve: changes in value, error and time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
import pandas as pd

from comparisons.formatting import duration, finite, number, relative
from comparisons.results.record import SceneRecord, StudyRecord
from comparisons.results.rows import NO_ROWS

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
class Change:
    """The change of one solve (one method on one scene at one resolution)."""

    scene: str
    method: str
    resolution: int
    # Everything that is true of it: "moved", "lost", "slower" ...; ("same",) where nothing is.
    kinds: tuple[str, ...]
    # The largest relative change of each quantity, with sign.
    moves: dict[str, float] = field(default_factory=dict)
    # The largest error of the quantities compared with the truth, before and after (NaN where there
    # is none, as for the truth itself).
    errors: tuple[float, float] = (float("nan"), float("nan"))
    # Time before and after (NaN where not solved).
    seconds: tuple[float, float] = (float("nan"), float("nan"))
    text: str = ""  # the same in words

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
        moved = f"{self.quantity.replace('_', ' ')} by {_signed(self.change)}"
        return moved if CHANGED in self.kinds else self.text

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
    """Two runs side by side."""

    before: StudyRecord
    after: StudyRecord
    changes: tuple[Change, ...]  # one for every solve of both runs
    # What makes the runs differ as a whole: versions, machines, scenes, references.
    notes: tuple[str, ...]

    @property
    def failed(self) -> tuple[Change, ...]:
        """What moved, was lost, changed its verdict or became slower."""
        return tuple(change for change in self.changes if change.bad)


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
    machines are told, never judged.
    """
    old = {scene.name: scene for scene in before.scenes}
    new = {scene.name: scene for scene in after.scenes}
    notes = []
    for name in [*before.versions, *(n for n in after.versions if n not in before.versions)]:
        pair = [run.versions.get(name, "not installed") for run in (before, after)]
        if pair[0] != pair[1]:
            notes.append(f"{name}: {pair[0]} before, {pair[1]} after")
    if before.machine != after.machine:
        notes.append("the machines differ: times are shown but not judged")
    if before.effort != after.effort:
        notes.append(f"effort: {before.effort} before, {after.effort} after")
    for run, ordinal in ((before, "first"), (after, "second")):
        if run.interrupted:
            notes.append(f"the {ordinal} run was interrupted")
    for name, scene in old.items():
        scene_after = new.get(name)
        if scene_after is None:
            notes.append(f"{name}: in the first run only")
            continue
        if scene.tables != scene_after.tables:
            notes.append(f"{name}: the scene itself differs")
        truths = [
            f"{run.reference.method} {run.reference.resolution}" if run.reference.method else "none"
            for run in (scene, scene_after)
        ]
        if truths[0] != truths[1]:
            notes.append(f"{name}: the reference was {truths[0]}, now {truths[1]}")
        newly = [text for text in scene_after.disagreements if text not in scene.disagreements]
        notes += [f"{name}: {text}" for text in newly]
    notes += [f"{name}: in the second run only" for name in new if name not in old]
    slower = slower if before.machine == after.machine else float("inf")
    changes: list[Change] = []
    for name in [*old, *(name for name in new if name not in old)]:
        was, now = old.get(name), new.get(name)
        scenes = [scene for scene in (was, now) if scene is not None]
        solves = dict.fromkeys(
            (method, int(n))
            for scene in scenes
            for method in dict.fromkeys(scene.rows["method"])
            for n in scene.resolutions_run(method)
        )
        changes += [
            _change(name, method, n, was, now, tolerances.get(method, moved), slower)
            for method, n in solves
        ]
    return RunComparison(before, after, tuple(changes), tuple(notes))


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
        return Change(name, method, resolution, (ONE_SIDED,), text=text)
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
    quantity, change = max(moves.items(), key=lambda item: abs(item[1]), default=("", 0.0))
    if abs(change) > moved:
        kinds[CHANGED] = f"{quantity.replace('_', ' ')} moved by {_signed(change)}"

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
    sizes = [[abs(verdict.error) for verdict in side.values()] for side in sides]
    errors = tuple(max((e for e in side if finite(e)), default=float("nan")) for side in sizes)

    # times, which all rows of a solve share
    first, second = (float(rows["seconds"][0]) for rows in (old, new))
    times = f"{duration(first)} before, {duration(second)} after"
    if min(first, second) > 0 and max(first, second) >= SHORTEST:
        if second > slower * first:
            kinds[SLOW] = f"{number(second / first, 2)} times slower ({times})"
        elif first > slower * second:
            kinds[FAST] = f"{number(first / second, 2)} times faster ({times})"
    return Change(
        name,
        method,
        resolution,
        tuple(kinds) or (SAME,),
        moves,
        (errors[0], errors[1]),
        (first, second),
        "; ".join(kinds.values()) or "same",
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


def _signed(change: float) -> str:
    sign = "+" if change > 0 else "\N{MINUS SIGN}"
    return f"{sign}{relative(abs(change))}"
