"""The record of judged claims in claims.json: written atomically, validated when read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

from pydantic import Field

from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN
from comparisons.results.folder import Form, Header, read_record

HOLDS, FAILS, IN_A_RANGE = "holds", "fails", "holds in a range"
ONLY_AS_STATED = "holds only as stated"
VERDICTS = (HOLDS, FAILS, IN_A_RANGE, ONLY_AS_STATED, NOT_RESOLVED)
RECORD = "claims.json"
# The last full run of every claim, which comes with the package (docs/examples/claims_table.py).
STORED = Path(__file__).with_name(RECORD)
# The detail of a point that was not measured for want of an optional part: what is missing.
NOT_RUN = "not run"


class PointRecord(Form):
    """A measurement; None for missing numbers."""

    parameter: float | None
    error: float | None
    uncertainty: float | None
    word: str
    details: dict[str, float | str | None]
    seconds: float
    noun: str = "error"  # what the error is called, as of `Measurement`
    # Of a draw over the nuisance parameters, their values by name.
    setting: dict[str, str] = Field(default_factory=dict)


class RangeRecord(Form):
    """An interval of the parameter with all measured points within the tolerance."""

    # The outermost points within, and the next measured points, which are not (None at the end of
    # the tested range). The boundary lies between them, and their distance is its resolution.
    low: float
    high: float
    below: float | None
    above: float | None


class NuisanceRecord(Form):
    """A claim along a parameter that its statement leaves open, the others as stated."""

    name: str
    reason: str
    stated: float  # the value along the claim's own parameter; of choices its place
    spacing: str
    choices: list[str]  # labels of the values that are not numbers; points then count them from 0
    at: float | None  # the value of the claim's own parameter
    points: list[PointRecord]
    ranges: list[RangeRecord]


class RowRecord(Form):
    """A row of a validity map: the claim along its own parameter, at one value of another."""

    number: float
    points: list[PointRecord]
    ranges: list[RangeRecord]


class MapRecord(Form):
    """A validity map: the claim's own parameter horizontally, the nuisance `up` vertically."""

    up: str
    spacing: str
    choices: list[str]  # as of the nuisance
    rows: list[RowRecord]


class ClaimRecord(Form):
    """A claim with its verdict and the underlying measurements."""

    id: str
    text: str
    equation: str
    reading: str
    corrects: str | None
    author: str = ""
    confirmed_by: str = HOLDS
    what: str
    method: str
    quantity: list[str]
    measure: str
    parameter: str
    spacing: str
    tolerance: float
    factor: float | None = None
    tolerance_from: str = "ours"
    refuted_by: str
    theorem: str = ""
    expected: str | None
    verdict: str
    sentence: str
    points: list[PointRecord]
    ranges: list[RangeRecord]
    nuisances: list[NuisanceRecord] = Field(default_factory=list)
    draws: list[PointRecord] = Field(default_factory=list)
    map: MapRecord | None = None
    disagreements: list[str]
    command: str
    seconds: float
    effort: str
    digest: str = ""  # of the code of a full run, as of `comparisons.questions.claims.runner`

    @property
    def voice(self) -> str:
        """Whose statement it is, as a heading names it; all of the literature is one voice."""
        if self.author in ("", f"chapter, {self.reading}"):
            return f"the chapter as {self.reading}"
        return "our own" if self.author == "ours" else "the literature"

    @property
    def finding(self) -> str:
        """The verdict in one sentence, and the part of the claim that holds by theorem."""
        return f"{self.sentence} {self.theorem}".rstrip()

    @property
    def measured(self) -> list[PointRecord]:
        """All points: as stated, along each nuisance parameter, and drawn over all of them."""
        beside = [point for nuisance in self.nuisances for point in nuisance.points]
        return [*self.points, *beside, *self.draws]

    @property
    def differs(self) -> bool:
        """Whether the verdict differs from the expected one.

        A quick run may leave a claim unresolved, and tells no "holds as stated only": neither
        differs.
        """
        if self.expected is None or self.verdict == self.expected or not_run(self.points):
            return False
        open_if_quick = {NOT_RESOLVED} | (
            {IN_A_RANGE} if self.expected == ONLY_AS_STATED else set()
        )
        return self.effort == "full" or self.verdict not in open_if_quick


def not_run(points: Sequence[PointRecord]) -> str:
    """Return what is missing where nothing was measured for want of an optional part, else ""."""
    missing = [str(point.details.get(NOT_RUN, "")) for point in points]
    return missing[0] if all(missing) else ""


class ClaimsRecord(Header):
    """A complete run of claims."""

    claims: list[ClaimRecord]


def load_claims_record(path: Path) -> ClaimsRecord:
    """Read the claims of a folder, or of a file; ResultsError if there are none, or damaged."""
    file = path / RECORD if path.is_dir() else path
    return read_record(ClaimsRecord, file, f"{file}: no claims were judged here")


@cache
def stored() -> Mapping[str, ClaimRecord]:
    """Return the claims that come with the package, by their names."""
    return {claim.id: claim for claim in load_claims_record(STORED).claims}


def verdict_of(points: Iterable[str], effort: str = "full") -> str:
    """Return the verdict on a claim from the verdicts on all measured points.

    One point outside refutes a claim about the whole range: it "holds in a range" if another point
    is within, else it "fails". Without points outside it "holds" if all points are within, else it
    is "not resolved". The wide bars of quick effort may hide a range, so a claim that is outside at
    all resolved points then "fails" only if every point is resolved.

    >>> verdict_of(["within", "within"]), verdict_of(["within", "outside"])
    ('holds', 'holds in a range')
    >>> verdict_of(["outside", "not resolved"]), verdict_of(["outside", "not resolved"], "quick")
    ('fails', 'not resolved')
    """
    verdicts = set(points)
    if verdicts == {WITHIN}:
        return HOLDS
    if OUTSIDE not in verdicts:
        return NOT_RESOLVED
    if WITHIN in verdicts:
        return IN_A_RANGE
    return FAILS if effort == "full" or verdicts == {OUTSIDE} else NOT_RESOLVED


def verdict_over_all(
    stated: list[str], along: list[str], draws: list[str], effort: str = "full"
) -> str:
    """Return the verdict on a claim over all that its statement leaves open.

    It "holds only as stated" if it is within at its stated values, but under no draw over what the
    statement leaves open, or nowhere else at all. The few draws of quick effort do not tell. The
    verdicts are those on the points at the stated values; away from them `along` one parameter at a
    time; and drawn over all parameters.

    >>> verdict_over_all(["within"], ["within", "outside"], ["outside", "within"])
    'holds in a range'
    >>> verdict_over_all(["within"], ["within", "outside"], ["outside", "not resolved"])
    'holds only as stated'
    """
    verdict = verdict_of([*stated, *along, *draws], effort)
    elsewhere = draws or along
    if verdict == IN_A_RANGE and WITHIN in stated and effort == "full" and elsewhere:
        return verdict if WITHIN in elsewhere else ONLY_AS_STATED
    return verdict
