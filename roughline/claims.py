"""Tests of claims about the reduced model: statement, tolerance, verdict and evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from comparisons.errors import InputError
from comparisons.files import plain
from comparisons.questions.claims import claim as files
from comparisons.questions.claims.record import ClaimRecord
from comparisons.questions.claims.runner import judge_claim
from reports.plots.claims import evidence
from reports.tables import lists
from reports.tables.validation import measurements
from reports.tables.written import frame
from roughline import notebook

if TYPE_CHECKING:
    from reports.paper.figures import PaperFigure

MOST_ROWS = 12


@dataclass(frozen=True, repr=False)
class ClaimVerdict:
    """The verdict on one claim, with its evidence.

    Attributes
    ----------
    record : comparisons.questions.claims.record.ClaimRecord
    """

    record: ClaimRecord

    @property
    def verdict(self) -> str:
        """One of `comparisons.questions.claims.record.VERDICTS`."""
        return self.record.verdict

    @property
    def sentence(self) -> str:
        """The verdict in one sentence with its numbers."""
        return self.record.sentence

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """Intervals of the parameter in which the claim holds; of a quick run, what it measured."""
        return [(interval.low, interval.high) for interval in self.record.ranges]

    @property
    def as_expected(self) -> bool:
        """Whether the verdict agrees with the one expected in the claim file, if any."""
        return not self.record.differs

    def table(self) -> pd.DataFrame:
        """Return one row per measurement: parameter, relative error, bar and verdict."""
        names = ["parameter", "error", "uncertainty", "word", "seconds"]
        rows = [point.model_dump(include=set(names)) for point in self.record.points]
        return pd.DataFrame(rows, columns=names)

    def plot(self) -> PaperFigure:
        """Return the error along the claim's parameter, with bars (extra `paper`).

        InputError if the claim has no parameter, or matplotlib is missing.
        """
        from reports.paper.figures import single

        figure = evidence(self.record, fewest=1)
        if figure is None:
            raise InputError(f"plot: {self.record.id} has no parameter to draw an error along")
        return single(figure)

    def __repr__(self) -> str:
        return f"{self.record.id}: {self.verdict}. {self.record.finding}"

    def _repr_html_(self) -> str:
        points = self.record.points
        measured = measurements(self.record).without("time", "details").first(MOST_ROWS)
        return notebook.block(
            f"{self.record.id}, {self.record.equation}",
            self.record.text,
            notebook.badge(self.verdict) + f" {self.record.finding}",
            *self.record.disagreements,
            notebook.table(measured),
            notebook.more(len(points) - MOST_ROWS, "measurements"),
        )


def check_claim(
    claim: str | Path | Mapping[str, Any], *, method: str | None = None, full: bool = True
) -> ClaimVerdict:
    """Test a claim: measure along its parameter until the boundaries of its range are known.

    InputError lists all errors in the claim.

    Parameters
    ----------
    claim : str, Path or mapping
        The id of a built-in claim (`list_claims`), a claim file, or its tables as a dict.
    method : str, optional
        Test this method instead of the reduced model, on a claim that is based on a scene.
    full : bool
        Refine the reference until its bar is a fifth of the tolerance, and narrow each boundary;
        else wider bars, and no more points than the verdict needs. Up to an hour on rough surfaces;
        the claim's range is part of the answer, so that this is the default.

    Examples
    --------
    >>> check_claim("friction-law-force").verdict
    'holds'
    """
    if isinstance(claim, Mapping):
        chosen = [files.make_claim(plain(dict(claim)), "claim", Path.cwd())]
    else:
        chosen = files.load_claims((str(claim),))
    if len(chosen) > 1:
        raise InputError(f"{claim}: expected one claim, got {', '.join(c.id for c in chosen)}")
    if method is not None:
        chosen = files.about_method(chosen, method)
    return ClaimVerdict(judge_claim(chosen[0], "full" if full else "quick"))


def list_claims() -> pd.DataFrame:
    """Return the built-in claims in the chapter's order.

    Examples
    --------
    >>> list_claims().loc["transform-cone", "reading"]
    'corrected'
    """
    return frame(lists.claims()).set_index("id")
