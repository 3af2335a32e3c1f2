"""Regression of the reduced model: comparison with stored curves of model and references."""

from __future__ import annotations

from comparisons.questions.regression.findings import Finding, compare_snapshots
from comparisons.questions.regression.measure import CHECK_SCENES, take_snapshot
from comparisons.questions.regression.snapshot import (
    PACKAGED,
    Snapshot,
    load_baseline,
    save_baseline,
)

__all__ = [
    "CHECK_SCENES",
    "PACKAGED",
    "Finding",
    "Snapshot",
    "compare_snapshots",
    "load_baseline",
    "save_baseline",
    "take_snapshot",
]
