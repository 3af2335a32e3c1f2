"""The record of judged claims in claims.json: written atomically, validated when read."""

from __future__ import annotations

from pathlib import Path

from comparisons.files import write_text
from comparisons.judging.verdicts import NOT_RESOLVED
from comparisons.results.header import Form, Header, read_record

RECORD = "claims.json"


class PointRecord(Form):
    """A measurement; None for missing numbers."""

    parameter: float | None
    error: float | None
    uncertainty: float | None
    word: str
    details: dict[str, float | str | None]
    seconds: float


class RangeRecord(Form):
    """An interval in which the claim holds, see `comparisons.questions.claims.boundaries.Range`."""

    low: float
    high: float
    below: float | None
    above: float | None


class ClaimRecord(Form):
    """A claim with its verdict and the underlying measurements."""

    id: str
    text: str
    equation: str
    reading: str
    corrects: str | None
    what: str
    method: str
    quantity: list[str]
    measure: str
    parameter: str
    spacing: str
    tolerance: float
    tolerance_from: str = "ours"
    refuted_by: str
    theorem: str = ""
    expected: str | None
    verdict: str
    sentence: str
    points: list[PointRecord]
    ranges: list[RangeRecord]
    disagreements: list[str]
    command: str
    seconds: float
    effort: str

    @property
    def finding(self) -> str:
        """The verdict in one sentence, and what of the claim needs no measurement."""
        return f"{self.sentence} {self.theorem}".rstrip()

    @property
    def differs(self) -> bool:
        """Whether the verdict differs from the expected one.

        A quick run with wider bars may leave a claim unresolved, which is not a difference.
        """
        if self.expected is None or self.verdict == self.expected:
            return False
        return self.effort == "full" or self.verdict != NOT_RESOLVED


class ClaimsRecord(Header):
    """A complete run of claims."""

    claims: list[ClaimRecord]


def save_claims(directory: Path, record: ClaimsRecord) -> None:
    """Write claims.json, atomically."""
    write_text(directory / RECORD, record.model_dump_json(indent=1) + "\n")


def load_claims_record(path: Path) -> ClaimsRecord:
    """Read the claims of a results folder, or of a file written by `roughline claims --json`.

    Raises
    ------
    ResultsError
        If there are none, or the file is invalid.
    """
    file = path / RECORD if path.is_dir() else path
    return read_record(ClaimsRecord, file, f"{file}: no claims were judged here")
