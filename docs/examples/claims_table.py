"""Write what the claims found into the pages, from stored full runs.

The record of the runs comes with the package (`STORED`; `roughline claims --stored` writes its
page). A run of all claims, or of those that are new or changed, is put into it, and what stands
between the markers is made anew, sentences of claims_pages.toml with the numbers of the claims::

    roughline claims --full --json run.json
    python docs/examples/claims_table.py run.json
"""

# %%
import math
import re
import sys
import tomllib
from collections import Counter
from pathlib import Path

from comparisons.files import write_text
from comparisons.questions.claims.claim import Claim, load_claims
from comparisons.questions.claims.record import (
    STORED,
    VERDICTS,
    ClaimRecord,
    ClaimsRecord,
    PointRecord,
    load_claims_record,
    not_run,
)
from comparisons.questions.claims.wording import error_text, finding, limit_words, value

DOCS = Path(__file__).resolve().parents[1]
TEXTS = tomllib.loads((DOCS / "examples" / "claims_pages.toml").read_text(encoding="utf-8"))
BLOCK = re.compile(r"(<!-- claims (\w+) -->\n).*?(<!-- end of claims -->)", re.DOTALL)
PAGES = [
    page
    for page in (DOCS.parent / "README.md", *sorted(DOCS.glob("*.md")))
    if BLOCK.search(page.read_text(encoding="utf-8"))
]


# %%
def put_together(records: list[ClaimsRecord]) -> ClaimsRecord:
    """Return one record of the claims there are, each from the last run that judged it.

    Date and machine are those of the (last) run that judged most of them, the seconds those of all
    solves. The details of single measurements are left out: `roughline claims` finds them again.
    """
    files = {claim.id: claim for claim in load_claims()}
    judged = {
        claim.id: claim
        for record in records
        for claim in record.claims
        if not not_run(claim.points)
    }
    judged_claims = [_bare(judged[name], files[name]) for name in files if name in judged]
    main = max(reversed(records), key=lambda record: len(record.claims))
    seconds = sum(claim.seconds for claim in judged_claims)
    return main.model_copy(update={"claims": judged_claims, "seconds": seconds})


def _bare(claim: ClaimRecord, file: Claim) -> ClaimRecord:
    """Leave out details of points; the claim is in the words of its file, the finding in ours."""
    changed = {
        "text": file.text,
        "what": file.what,
        "refuted_by": file.refuted_by,
        "author": file.author,
        "confirmed_by": file.confirmed_by,
        "expected": file.expected,
        "points": _without_details(claim.points),
        "draws": _without_details(claim.draws),
        "nuisances": [
            nuisance.model_copy(update={"points": _without_details(nuisance.points)})
            for nuisance in claim.nuisances
        ],
    }
    if claim.map is not None:
        rows = [
            row.model_copy(update={"points": _without_details(row.points)})
            for row in claim.map.rows
        ]
        changed["map"] = claim.map.model_copy(update={"rows": rows})
    bare = claim.model_copy(update=changed)
    words = finding(file, bare.model_copy(update={"effort": "full"}))
    return bare.model_copy(update={"sentence": words})


def _without_details(points: list[PointRecord]) -> list[PointRecord]:
    """Keep only the details that words need."""
    kept = ("quantity", "no result")
    return [
        point.model_copy(
            update={"details": {k: point.details[k] for k in kept if k in point.details}}
        )
        for point in points
    ]


# %%
def rendered(record: ClaimsRecord, kind: str) -> str:
    """Return the sentences of a block; every number is a claim's. `known` has the tally, too."""
    by_id = {claim.id: claim for claim in record.claims}
    lines = []
    for text in TEXTS[kind]["sentences"]:
        sentence, ids = _with_numbers(text, by_id)
        of: dict[str, list[str]] = {}
        for name in ids:
            of.setdefault(by_id[name].verdict, []).append(f"`{name}`")
        verdicts = "; ".join(f"{', '.join(names)}: {verdict}" for verdict, names in of.items())
        lines.append(f"- {sentence} ({verdicts})")
    if kind == "known":
        lines += ["", tally(record)]
    return "\n".join(lines) + "\n"


def _with_numbers(text: str, by_id: dict[str, ClaimRecord]) -> tuple[str, list[str]]:
    """Return a sentence with the numbers of its claims in place of {claim.number}; the claims.

    An error at one value is {claim.error@value}. A range is of a tolerance, which the sentence
    names; what may be zero is no smallest error.
    """
    place = re.compile(r"\{([a-z0-9-]+)\.(\w+)(?:@([^}]+))?\}")
    numbers = {m[1]: Numbers(by_id[m[1]]) for m in place.finditer(text)}

    def number(m: re.Match[str]) -> str:
        if m[2] == "error":
            return numbers[m[1]].error(float(m[3]))
        return str(getattr(numbers[m[1]], m[2]))

    sentence = place.sub(number, text)
    for m in place.finditer(text):
        tolerance = numbers[m[1]].tolerance
        if m[2] in ("low", "high") and tolerance not in sentence.replace(" %", "\u202f%"):
            raise ValueError(f"{m[0]} is a range at {tolerance}, which is not said: {text}")
    return sentence, list(numbers)


class Numbers:
    """The numbers of a claim, as its sentence in docs/claims.md names them."""

    def __init__(self, claim: ClaimRecord) -> None:
        stated = [point for point in claim.points if point.error is not None]
        ordered = sorted(stated, key=lambda point: abs(point.error))
        self.claim, self._smallest = claim, ordered[0]
        self.most = self._text(ordered[-1])
        self.tolerance = limit_words(claim.tolerance, claim.factor)
        self.verdict = claim.verdict
        self.first, self.last = (
            value(stated[place].parameter) if stated[place].parameter is not None else ""
            for place in (0, -1)
        )
        self.low, self.high = (
            (value(claim.ranges[0].low), value(claim.ranges[-1].high)) if claim.ranges else ("", "")
        )
        beside = [point for n in claim.nuisances for point in n.points] + claim.draws
        sized = [point for point in beside if point.error is not None]
        self.beyond = ""
        if sized:
            worst = max(sized, key=lambda point: abs(point.error))
            self.beyond = self._text(worst)

    def _text(self, point: PointRecord) -> str:
        return error_text(point, self.claim.factor)

    @property
    def least(self) -> str:
        """The smallest error."""
        if not abs(self._smallest.error) > self._smallest.uncertainty:
            raise ValueError(f"{self.claim.id}: the smallest error may be zero")
        return self._text(self._smallest)

    def error(self, parameter: float) -> str:
        """Return the error at a value of the claim's parameter."""
        (point,) = [p for p in self.claim.points if math.isclose(p.parameter, parameter)]
        return self._text(point)


def tally(record: ClaimsRecord) -> str:
    """Return how many claims of whom got which verdict, and how many verdicts confirm them."""
    groups: dict[str, list[ClaimRecord]] = {}
    for claim in record.claims:
        groups.setdefault(claim.voice, []).append(claim)
    sentences = []
    for who, claims in groups.items():
        number = Counter(claim.verdict for claim in claims)
        counts = ", ".join(
            f"{number[verdict]} {verdict.replace('holds', 'hold').replace('fails', 'fail')}"
            for verdict in VERDICTS
            if number[verdict]
        )
        sentences.append(f"{len(claims)} claims of {who}: {counts}")
    denied = [claim for claim in record.claims if claim.confirmed_by != "holds"]
    confirming = sum(claim.verdict == claim.confirmed_by for claim in denied)
    return (
        ". ".join(sentences) + f". The chapter denies {len(denied)} of them, {confirming} rightly."
    )


def written(page: str, record: ClaimsRecord) -> str:
    """Return a page with the tables between its markers made anew."""
    return BLOCK.sub(lambda match: match[1] + rendered(record, match[2]) + match[3], page)


# %%
if __name__ == "__main__":
    runs = [load_claims_record(Path(name)) for name in sys.argv[1:]]
    if not all(claim.effort == "full" for run in runs for claim in run.claims):
        sys.exit("a quick run decides less: claims --full")
    stored = put_together(([load_claims_record(STORED)] if STORED.exists() else []) + runs)
    write_text(STORED, stored.model_dump_json() + "\n")
    for path in PAGES:
        path.write_text(written(path.read_text(encoding="utf-8"), stored), encoding="utf-8")
