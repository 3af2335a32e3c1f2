"""The claims page: the verdicts, then the evidence for each claim."""

from __future__ import annotations

import math
from dataclasses import dataclass

from comparisons.questions.claims.record import VERDICTS, ClaimRecord, ClaimsRecord
from comparisons.questions.claims.wording import error_text, limit_words
from reports.pages.page import render, tally
from reports.plots.claims import boundary_map, evidence
from reports.plots.figure import Figure
from reports.tables.validation import beyond, measurements

# Of more claims the page shows how many have which verdict; a click, a link or a search opens them.
MOST_UNFOLDED = 12


@dataclass(frozen=True)
class ClaimView:
    """What the page shows of a claim: its record, and the error that decides."""

    record: ClaimRecord
    text: str
    error: float
    uncertainty: float
    figures: list[Figure]

    @property
    def anchor(self) -> str:
        """Where the claim stands on the page."""
        return f"claim-{self.record.id}"


def claims_page(record: ClaimsRecord) -> str:
    """Return the verdicts and their evidence as one HTML page; the largest error decides."""
    views = []
    for claim in record.claims:
        largest = max(claim.measured, key=lambda p: -1.0 if p.error is None else abs(p.error))
        error, bar = (math.nan if v is None else v for v in (largest.error, largest.uncertainty))
        along_others = (evidence(claim, nuisance) for nuisance in claim.nuisances)
        figures = filter(None, [evidence(claim), boundary_map(claim), *along_others])
        text = error_text(largest, claim.factor)
        views.append(ClaimView(claim, text, error, bar, [*figures]))

    def verdicts(views: list[ClaimView]) -> list[tuple[str, int]]:
        return tally((view.record.verdict for view in views), VERDICTS)

    by_voice: dict[str, list[ClaimView]] = {}
    for view in views:
        by_voice.setdefault(view.record.voice, []).append(view)
    drawn = {f"{view.anchor}-{figure.key}": figure for view in views for figure in view.figures}
    return render(
        "claims.html.j2",
        drawn,
        record=record,
        limit_words=limit_words,
        measurements=measurements,
        beyond=beyond,
        views=views,
        groups=[(voice, own, verdicts(own)) for voice, own in by_voice.items()]
        if len(views) > MOST_UNFOLDED
        else [],
        tally=verdicts(views),
    )
