"""Comparison of current results with a baseline file, and update of the baseline."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from comparisons.errors import InputError
from comparisons.facts.methods import MODEL
from comparisons.questions.campaign import Watch
from comparisons.questions.regression.findings import MODEL_TOLERANCE, Finding, compare_snapshots
from comparisons.questions.regression.measure import CHECK_SCENES, take_snapshot
from comparisons.questions.regression.snapshot import Snapshot, load_baseline, save_baseline


def check_against(
    path: Path,
    method: str = MODEL,
    scenes: Iterable[str] = CHECK_SCENES,
    *,
    tolerance: float = MODEL_TOLERANCE,
    watch: Watch | None = None,
) -> list[Finding]:
    """Solve scenes and compare them with a baseline file.

    Raises
    ------
    InputError
        If the baseline is missing, damaged or for another method, or a scene is invalid.
    """
    stored = _stored(path, method)
    return compare_snapshots(stored, take_snapshot(method, scenes, watch), tolerance)


def update_baseline(
    path: Path,
    method: str = MODEL,
    scenes: Iterable[str] = CHECK_SCENES,
    *,
    tolerance: float = MODEL_TOLERANCE,
    watch: Watch | None = None,
) -> list[Finding]:
    """Solve scenes, compare them with any existing baseline, and store the current results.

    Other scenes of the baseline are kept unchanged.

    Raises
    ------
    InputError
        As in `check_against`, except that a missing baseline is created.
    """
    stored = _stored(path, method) if path.exists() else None
    now = take_snapshot(method, scenes, watch)
    if stored is None:
        save_baseline(path, now)
        return []
    findings = compare_snapshots(stored, now, tolerance)
    save_baseline(path, now.model_copy(update={"scenes": stored.scenes | now.scenes}))
    return findings


def _stored(path: Path, method: str) -> Snapshot:
    stored = load_baseline(path)
    if stored.method != method:
        raise InputError(f"{path}: expected a baseline of {method}, got one of {stored.method}")
    return stored
