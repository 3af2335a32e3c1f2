"""The claims page: the verdicts, then the evidence for each claim."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from comparisons.files import write_text
from comparisons.questions.claims.record import ClaimRecord, ClaimsRecord, PointRecord
from comparisons.questions.claims.verdicts import VERDICTS
from comparisons.questions.claims.wording import error_text, limit_words
from reports.pages.page import render
from reports.plots.claim import along, evidence, validity_map
from reports.plots.figure import Figure
from reports.tables.claims import beyond, measurements
from reports.tables.table import Table

# Of more claims the page shows how many have which verdict; a click, a link or a search opens them.
MOST_UNFOLDED = 12


@dataclass(frozen=True)
class ClaimView:
    """The data that the template shows for one claim."""

    record: ClaimRecord
    anchor: str
    deciding: Deciding
    figures: tuple[Figure, ...]
    measurements: Table
    openness: Table | None


@dataclass(frozen=True)
class ClaimGroup:
    """The claims of one voice, folded together on a page of many."""

    title: str
    views: list[ClaimView]

    @property
    def tally(self) -> list[tuple[str, int]]:
        """How many claims have each verdict."""
        return _tally(view.record for view in self.views)


@dataclass(frozen=True)
class Deciding:
    """The deciding number of a claim: the largest error, with its bar."""

    text: str
    error: float
    uncertainty: float
    tolerance: float


def write_claims_report(record: ClaimsRecord, path: Path) -> None:
    """Write the verdicts and their evidence as one HTML file, atomically."""
    write_text(path, claims_page(record))


def claims_page(record: ClaimsRecord) -> str:
    """Return the whole page as text."""
    views = [_view(claim) for claim in record.claims]
    drawn = {f"{view.anchor}-{figure.key}": figure for view in views for figure in view.figures}
    return render(
        "claims.html.j2",
        drawn,
        record=record,
        limit_words=limit_words,
        views=views,
        groups=_groups(views) if len(views) > MOST_UNFOLDED else [],
        tally=_tally(record.claims),
    )


def _groups(views: list[ClaimView]) -> list[ClaimGroup]:
    voices = dict.fromkeys(view.record.voice for view in views)
    return [
        ClaimGroup(voice, [view for view in views if view.record.voice == voice])
        for voice in voices
    ]


def _tally(claims: Iterable[ClaimRecord]) -> list[tuple[str, int]]:
    counts = Counter(claim.verdict for claim in claims)
    return [(word, counts[word]) for word in VERDICTS if counts[word]]


def _view(claim: ClaimRecord) -> ClaimView:
    largest = max(claim.measured, key=_size)
    nan = float("nan")
    deciding = Deciding(
        text=error_text(largest, claim.factor),
        error=nan if largest.error is None else largest.error,
        uncertainty=nan if largest.uncertainty is None else largest.uncertainty,
        tolerance=claim.tolerance,
    )
    figures = [evidence(claim), validity_map(claim), *(along(claim, n) for n in claim.nuisances)]
    return ClaimView(
        claim,
        f"claim-{claim.id}",
        deciding,
        tuple(figure for figure in figures if figure is not None),
        measurements(claim),
        beyond(claim) if claim.nuisances else None,
    )


def _size(point: PointRecord) -> float:
    return -1.0 if point.error is None else abs(point.error)
