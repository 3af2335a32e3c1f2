"""Comparison with stored curves: what moved, the model, a reference, shared code or the machine."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from comparisons.errors import InputError
from comparisons.facts.methods import MODEL as MODEL_NAME
from comparisons.facts.methods import title_of
from comparisons.formatting import number, relative
from comparisons.questions.campaign import Watch
from comparisons.questions.regression.snapshot import (
    CHECK_SCENES,
    Curves,
    SceneSnapshot,
    Snapshot,
    load_baseline,
    save_baseline,
    take_snapshot,
)

MODEL, REFERENCES, AGREEMENT, SPEED = "reduced model", "references", "agreement", "speed"
# The model does not iterate: processors and library versions change its last digits only.
MODEL_TOLERANCE = 1e-9
# References iterate to 1e-6 relative, within which the results of machines differ.
REFERENCE_TOLERANCE = 1e-5
# Loads are equal up to rounding in the division of a range.
ROUNDED = 1e-12
# Two curves changed equally if their factors agree to this fraction of the change.
ALIKE = 0.1
# Readings in turns scatter by about 20 %; a machine counts as slower from 25 % on.
SLOWER_MODEL, SLOWER_MACHINE = 2.0, 1.25


@dataclass(frozen=True)
class Finding:
    """A line of a check.

    Attributes
    ----------
    scene, subject : str
        Name of the scene, and one of the subjects above.
    text : str
        The finding in words.
    drifted : bool
        Whether the check fails.
    notable : bool
        Whether the finding is shown although the check does not fail.
    """

    scene: str
    subject: str
    text: str
    drifted: bool = False
    notable: bool = False


@dataclass(frozen=True)
class Move:
    """Change of a method's curves: factors new/old by quantity, and the largest change."""

    factors: dict[str, np.ndarray]
    lost: tuple[str, ...] = ()
    replanned: str = ""

    def largest(self) -> tuple[str, float]:
        """Return the quantity with the largest change, and its signed relative change."""
        changes = {
            name: float(values[np.argmax(np.abs(values - 1))] - 1)
            for name, values in self.factors.items()
            if len(values)
        }
        return max(changes.items(), key=lambda item: abs(item[1]), default=("", 0.0))

    def moved(self, tolerance: float) -> bool:
        """Return whether a curve changed beyond a tolerance, vanished, or has another plan."""
        return bool(self.lost or self.replanned) or abs(self.largest()[1]) > tolerance

    def text(self) -> str:
        """Return the largest change in words."""
        if self.replanned:
            return self.replanned
        if self.lost:
            return f"no answer any more for {', '.join(self.lost)}"
        name, change = self.largest()
        sign = "+" if change > 0 else "\N{MINUS SIGN}"
        return f"{name.replace('_', ' ')} by {sign}{relative(abs(change))}"


def compare_snapshots(
    stored: Snapshot, now: Snapshot, tolerance: float = MODEL_TOLERANCE
) -> list[Finding]:
    """Compare the current snapshot with the stored one, scene by scene.

    Parameters
    ----------
    stored, now : Snapshot
    tolerance : float
        Largest relative change of the model that counts as unchanged.

    Returns
    -------
    list of Finding
        For every scene: the model, the references, their agreement, the speed.
    """
    findings = []
    subject = "the reduced model" if now.method == "reduced" else title_of(now.method)
    for name, scene in now.scenes.items():
        before = stored.scenes.get(name)
        if before is None:
            findings.append(Finding(name, MODEL, "not in the baseline: --update adds it", True))
        elif before.scene and before.scene != scene.scene:
            text = "the scene itself is not the baseline's: --update takes the new one"
            findings.append(Finding(name, MODEL, text, True))
        elif len(before.loads) != len(scene.loads) or not np.allclose(
            before.loads, scene.loads, rtol=ROUNDED, atol=0
        ):
            findings.append(Finding(name, MODEL, "the scene's loads are not the baseline's", True))
        else:
            findings += _moves(name, subject, before, scene, tolerance)
            text, notable = " ".join(scene.disagreements), bool(scene.disagreements)
            if scene.alone:
                alone = _list([title_of(m) for m in scene.alone])
                text = f"{alone} stands alone against the others. {text}"
            new = notable and (not before.disagreements or scene.alone != before.alone)
            if not notable:
                text = "the references agree within their bars"
            elif not new:
                text = f"as in the baseline: {text}"
            findings.append(Finding(name, AGREEMENT, text, new, notable))
            if before.speed is None or scene.speed is None:
                continue
            model = scene.speed.ratio / before.speed.ratio
            machine = scene.speed.yardstick_seconds / before.speed.yardstick_seconds
            slower = model > SLOWER_MODEL
            text = f"{number(model, 2)} times the baseline's share of the yardstick"
            if slower:
                text = f"{subject} is slower: {number(model, 2)} times its share of the yardstick"
            elif machine > SLOWER_MACHINE:
                text = f"the machine is slower: {number(machine, 2)} times; "
                text += "the model keeps its share of it"
            notable = not slower and machine > SLOWER_MACHINE
            findings.append(Finding(name, SPEED, text, slower, notable))
    return findings


def _moves(
    name: str, subject: str, before: SceneSnapshot, now: SceneSnapshot, tolerance: float
) -> list[Finding]:
    model = _move(before.model, now.model)
    truths = {
        method: _move(curves, now.references.get(method))
        for method, curves in before.references.items()
    }
    moved = {m: move for m, move in truths.items() if move.moved(REFERENCE_TOLERANCE)}
    model_moved = model.moved(tolerance)
    shared = [m for m, move in moved.items() if model_moved and _alike(model, move)]
    if shared:
        quantity, change = model.largest()
        still = [title_of(m) for m, move in truths.items() if not move.moved(REFERENCE_TOLERANCE)]
        unmoved = f"; {_list(still)} did not move" if still else ""
        label = quantity.replace("_", " ")
        text = (
            f"{subject} and {_list([title_of(m) for m in shared])} moved by the same factor "
            f"{number(1 + change, 6)} ({label}): something they share has changed{unmoved}"
        )
        return [Finding(name, MODEL, text, True)]
    findings = [
        Finding(name, MODEL, f"{subject} moved: {model.text()}", True)
        if model_moved
        else Finding(name, MODEL, "unchanged")
    ]
    if moved:
        texts = [f"{title_of(m)}: {move.text()}" for m, move in moved.items()]
        still = [title_of(m) for m in truths if m not in moved]
        unmoved = f"; {_list(still)} did not" if still else ""
        text = f"the reference moved: {'; '.join(texts)}{unmoved}"
        findings.append(Finding(name, REFERENCES, text, True))
    else:
        findings.append(Finding(name, REFERENCES, "unchanged"))
    return findings


def _move(before: Curves | None, now: Curves | None) -> Move:
    if before is None:
        return Move({})
    if now is None:
        return Move({}, lost=("the whole scene",))
    if before.resolution != now.resolution:
        text = f"resolution {now.resolution} where the baseline has {before.resolution}"
        return Move({}, replanned=text)
    factors, lost = {}, []
    for name in before.quantities:
        if name not in now.quantities:
            lost.append(name)
            continue
        old, new = before.array(name), now.array(name)
        if np.isnan(new[np.isfinite(old)]).any():
            lost.append(name)
            continue
        finite = np.isfinite(old) & np.isfinite(new)
        same = old[finite] == new[finite]
        with np.errstate(divide="ignore", invalid="ignore"):
            factors[name] = np.where(same, 1.0, new[finite] / old[finite])
    return Move(factors, tuple(lost))


def _alike(model: Move, truth: Move) -> bool:
    """Return whether all common quantities changed by the same factor at every load."""
    common = [name for name in model.factors if name in truth.factors]
    if not common or model.lost or truth.lost or model.replanned or truth.replanned:
        return False
    size = max(float(np.abs(model.factors[name] - 1).max(initial=0.0)) for name in common)
    if size <= REFERENCE_TOLERANCE:
        return False
    apart = max(
        float(np.abs(model.factors[name] - truth.factors[name]).max(initial=0.0)) for name in common
    )
    return apart <= ALIKE * size


def _list(names: list[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def check_against(
    path: Path,
    method: str = MODEL_NAME,
    scenes: Iterable[str] = CHECK_SCENES,
    *,
    tolerance: float = MODEL_TOLERANCE,
    watch: Watch | None = None,
    update: bool = False,
) -> list[Finding]:
    """Solve scenes and compare them with a baseline file; `update` stores the current results.

    Other scenes of the baseline are kept then, and a missing one is created.

    Raises
    ------
    InputError
        If the baseline is missing, damaged or for another method, or a scene is invalid.
    """
    stored = load_baseline(path) if path.exists() or not update else None
    if stored is not None and stored.method != method:
        raise InputError(f"{path}: expected a baseline of {method}, got one of {stored.method}")
    now = take_snapshot(method, scenes, watch)
    findings = [] if stored is None else compare_snapshots(stored, now, tolerance)
    if update:
        kept = {} if stored is None else stored.scenes
        save_baseline(path, now.model_copy(update={"scenes": kept | now.scenes}))
    return findings
