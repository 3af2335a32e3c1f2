"""The claims page: the verdicts, then the evidence for each claim."""

from __future__ import annotations

import math
from types import SimpleNamespace

from comparisons.questions.claims.record import VERDICTS, ClaimsRecord
from comparisons.questions.claims.wording import error_text, limit_words
from reports.pages.page import render, tally
from reports.plots.claims import boundary_map, evidence
from reports.tables.validation import beyond, measurements

# Of more claims the page shows how many have which verdict; a click, a link or a search opens them.
MOST_UNFOLDED = 12


def claims_page(record: ClaimsRecord) -> str:
    """Return the verdicts and their evidence as one HTML page; the largest error decides."""
    views = []
    for claim in record.claims:
        largest = max(claim.measured, key=lambda p: -1.0 if p.error is None else abs(p.error))
        along_others = (evidence(claim, nuisance) for nuisance in claim.nuisances)
        figures = [evidence(claim), boundary_map(claim), *along_others]
        views.append(
            SimpleNamespace(
                record=claim,
                anchor=f"claim-{claim.id}",
                text=error_text(largest, claim.factor),
                error=math.nan if largest.error is None else largest.error,
                uncertainty=math.nan if largest.uncertainty is None else largest.uncertainty,
                figures=[figure for figure in figures if figure is not None],
                measurements=measurements(claim),
                openness=beyond(claim) if claim.nuisances else None,
            )
        )

    def verdicts(views: list[SimpleNamespace]) -> list[tuple[str, int]]:
        return tally((view.record.verdict for view in views), VERDICTS)

    by_voice: dict[str, list[SimpleNamespace]] = {}
    for view in views:
        by_voice.setdefault(view.record.voice, []).append(view)
    drawn = {f"{view.anchor}-{figure.key}": figure for view in views for figure in view.figures}
    return render(
        "claims.html.j2",
        drawn,
        record=record,
        limit_words=limit_words,
        views=views,
        groups=[(voice, own, verdicts(own)) for voice, own in by_voice.items()]
        if len(views) > MOST_UNFOLDED
        else [],
        tally=verdicts(views),
    )
