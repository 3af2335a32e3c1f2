"""The claims that a run of `roughline claims` beside a study has judged, for the study's report."""

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
    """A claim, and the plot of its evidence where there is one."""

    record: ClaimRecord
    key: str
    figure: Figure | None


@dataclass(frozen=True)
class ClaimsBeside:
    """The claims of a run, and the page with all of its measurements, relative to the report."""

    record: ClaimsRecord
    page: str
    views: tuple[ClaimEvidence, ...]


def claims_beside(directory: Path) -> ClaimsBeside | None:
    """Return what the claims run beside a study's folder found, None where there is none.

    Damaged claims are no reason to lose a study's report: they are left out, too.
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
