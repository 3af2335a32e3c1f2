"""Claims tested next to a study by `roughline claims`, for inclusion in its report."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from comparisons.errors import ResultsError
from comparisons.questions.claims.record import (
    RECORD,
    ClaimRecord,
    ClaimsRecord,
    load_claims_record,
)
from reports.plots.claim import evidence
from reports.plots.figure import Figure

FOLDER = "claims"  # where `roughline claims` writes, beside the folders of studies


@dataclass(frozen=True)
class ClaimEvidence:
    """A claim and, where available, the plot of its evidence."""

    record: ClaimRecord
    key: str
    figure: Figure | None


@dataclass(frozen=True)
class ClaimsBeside:
    """The claims of a run, and the path of its page relative to the report."""

    record: ClaimsRecord
    page: str
    views: tuple[ClaimEvidence, ...]


def claims_beside(directory: Path) -> ClaimsBeside | None:
    """Return the claims tested next to a study's folder, or None.

    Damaged claims are also left out, so that they cannot prevent the report of the study.
    """
    folder = directory.resolve().parent / FOLDER
    if folder == directory.resolve() or not (folder / RECORD).exists():
        return None
    try:
        record = load_claims_record(folder)
    except ResultsError:
        return None
    page = folder / "report.html"
    link = os.path.relpath(page, directory.resolve()) if page.exists() else ""
    views = tuple(
        ClaimEvidence(claim, f"claim-{number}-evidence", evidence(claim))
        for number, claim in enumerate(record.claims, start=1)
    )
    return ClaimsBeside(record, Path(link).as_posix() if link else "", views)
