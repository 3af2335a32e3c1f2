"""The claims page: the verdicts, then the evidence for each claim."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from comparisons.files import write_text
from comparisons.questions.claims.record import ClaimRecord, ClaimsRecord, PointRecord
from comparisons.questions.claims.verdicts import VERDICTS
from reports.pages.page import render
from reports.plots.claim import evidence
from reports.plots.figure import Figure
from reports.tables.claims import measurements
from reports.tables.table import Table


@dataclass(frozen=True)
class ClaimView:
    """The data that the template shows for one claim."""

    record: ClaimRecord
    anchor: str
    deciding: Deciding
    figure: Figure | None
    measurements: Table


@dataclass(frozen=True)
class Deciding:
    """The deciding number of a claim: the largest error, with its bar."""

    error: float
    uncertainty: float
    tolerance: float


def write_claims_report(record: ClaimsRecord, path: Path) -> None:
    """Write the verdicts and their evidence as one HTML file, atomically."""
    write_text(path, claims_page(record))


def claims_page(record: ClaimsRecord) -> str:
    """Return the whole page as text."""
    views = [_view(claim) for claim in record.claims]
    drawn = {f"{v.anchor}-{v.figure.key}": v.figure for v in views if v.figure}
    counts = Counter(claim.verdict for claim in record.claims)
    return render(
        "claims.html.j2",
        drawn,
        record=record,
        views=views,
        tally=[(word, counts[word]) for word in VERDICTS if counts[word]],
    )


def _view(claim: ClaimRecord) -> ClaimView:
    largest = max(claim.points, key=_size)
    nan = float("nan")
    deciding = Deciding(
        error=nan if largest.error is None else largest.error,
        uncertainty=nan if largest.uncertainty is None else largest.uncertainty,
        tolerance=claim.tolerance,
    )
    return ClaimView(claim, f"claim-{claim.id}", deciding, evidence(claim), measurements(claim))


def _size(point: PointRecord) -> float:
    return -1.0 if point.error is None else abs(point.error)
