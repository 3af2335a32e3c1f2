"""Write the verdicts on the claims into their pages, from stored full runs.

Eight stand in README.md, one for each statement of the chapter in docs/findings.md, all in
docs/claims.md. The record of the runs comes with the package (`STORED`). A run of all claims, or of
those that are new or changed, is put into it, and the tables between the markers are written anew::

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
from comparisons.formatting import duration, greek
from comparisons.machine import machine_text
from comparisons.questions.claims.claim import Claim, load_claims
from comparisons.questions.claims.record import (
    STORED,
    ClaimRecord,
    ClaimsRecord,
    PointRecord,
    load_claims_record,
)
from comparisons.questions.claims.verdicts import VERDICTS
from comparisons.questions.claims.wording import error_text, limit_words, value
from reports.tables.documents import markdown

DOCS = Path(__file__).resolve().parents[1]
PAGES = (
    DOCS.parent / "README.md",
    *(DOCS / name for name in ("findings.md", "claims.md", "what-we-now-know.md")),
)
TEXTS = tomllib.loads((DOCS / "examples" / "claims_pages.toml").read_text(encoding="utf-8"))
BLOCK = re.compile(
    r"(<!-- claims (eight|short|long|choices|known) -->\n).*?(<!-- end of claims -->)", re.DOTALL
)
# The README's eight, in words that need no chapter beside them; the verdict is on the claim itself.
EIGHT = {
    "half-radius-cone": "Any body of revolution may be replaced by a one-dimensional cross-section "
    "with half its radius of curvature: a cone, force within 1 %.",
    "transform-cone": "The cross-section that the integral transform of Popov & Heß (2015) gives, "
    "in place of the chapter's, is exact: a cone, within 0.01 %.",
    "punch-triangle": "A flat punch has the stiffness of a round one of equal area, with an error "
    "of less than 3 %: a triangular punch.",
    "partial-slip-rigid": "Springs that stick until their friction is used up give how far a "
    "tangential force moves a ball: within 1 % for every Poisson's ratio.",
    "adhesion-ball-force": "Springs that hold up to a given stretch give the adhesion of a ball "
    "(Johnson, Kendall & Roberts): depth, area and pull-off force within 0.1 %.",
    "rough-penetration": "Under the same force a rough line on springs is pressed in as deep as "
    "the rough surface: within 10 %.",
    "rough-area-printed": "The line has the real contact area of the rough surface, with the "
    "numbers of the chapter's figure: within 10 %.",
    "rubber-paraboloid": "Springs that relax give the friction of a ball that slides over rubber: "
    "within 10 % at any speed.",
}
# What docs/findings.md tells of: one claim, printed or corrected, for each statement.
SHORT = (
    *("exact-paraboloid", "half-radius-cone", "transform-cone", "ellipsoid-force"),
    *("punch-square", "punch-triangle", "quasi-static-energy", "size-unimportant-plane"),
    *("line-height-printed", "line-peak-radius", "rough-area-printed", "rough-area"),
    *("rough-area-reading-part", "rough-penetration", "rough-stiffness", "rough-mean-gap"),
    *("stress-local-field", "first-yield-criterion"),
    *("tangential-stiffness", "tangential-stiffness-square", "partial-slip-rigid"),
    *("viscoelastic-unloading", "viscoelastic-again", "rubber-paraboloid", "rubber-printed-start"),
    *("adhesion-sphere", "adhesion-elliptic-punch", "adhesion-range", "impact-ball-springs"),
)


# %%
def put_together(records: list[ClaimsRecord]) -> ClaimsRecord:
    """Return one record of the claims there are, each from the last run that judged it.

    Date and machine are those of the (last) run that judged most of them, the seconds those of all
    solves. The details of single measurements are left out: `roughline claims` finds them again.
    """
    files = {claim.id: claim for claim in load_claims()}
    judged = {claim.id: claim for record in records for claim in record.claims}
    judged_claims = [_bare(judged[name], files[name]) for name in files if name in judged]
    main = max(reversed(records), key=lambda record: len(record.claims))
    seconds = sum(claim.seconds for claim in judged_claims)
    return main.model_copy(update={"claims": judged_claims, "seconds": seconds})


def _bare(claim: ClaimRecord, file: Claim) -> ClaimRecord:
    """Leave out details of points; the words of the claim are as the file has them."""
    changed = {
        "text": file.text,
        "refuted_by": file.refuted_by,
        "author": file.author,
        "confirmed_by": file.confirmed_by,
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
    return claim.model_copy(update=changed)


def _without_details(points: list[PointRecord]) -> list[PointRecord]:
    return [point.model_copy(update={"details": {}}) for point in points]


# %%
def largest(claim: ClaimRecord) -> str:
    """Return the largest error, with its bar."""
    measured = [point for point in claim.measured if point.error is not None]
    if not measured:
        return "–"
    point = max(measured, key=lambda point: abs(point.error))
    return error_text(point, claim.factor)


def _cells(texts: tuple[str, ...]) -> list[str]:
    return [greek(text).replace("|", "\\|").replace("\n", " ").strip() for text in texts]


def readme_row(claim: ClaimRecord) -> tuple[str, ...]:
    """Return what the README says of a claim, and the command that measures it."""
    command = f"`roughline claims {claim.id} --full`"
    return (EIGHT[claim.id], f"**{claim.verdict}**", claim.sentence, command)


def short_row(claim: ClaimRecord) -> tuple[str, ...]:
    """Return what docs/findings.md says of a claim."""
    text = claim.text + (" *(as corrected)*" if claim.reading == "corrected" else "")
    return (claim.equation, text, f"**{claim.verdict}**", claim.finding, f"`{claim.id}`")


def long_row(claim: ClaimRecord) -> tuple[str, ...]:
    """Return what docs/claims.md says of a claim: its text, its verdict, the decisive numbers."""
    return (
        *(claim.id, claim.equation, claim.author, claim.text),
        limit_words(claim.tolerance, claim.factor)
        + (" (chapter)" if claim.tolerance_from == "chapter" else ""),
        *(f"**{claim.verdict}**", largest(claim), claim.finding),
    )


HEADS = {
    "eight": ("the statement", "verdict", "measured", "by"),
    "short": ("equation", "the chapter says", "verdict", "measured", "claim"),
    "long": (
        *("claim", "equation", "who says it", "text", "tolerance", "verdict", "largest error"),
        "measured",
    ),
}
ROWS = {"eight": readme_row, "short": short_row, "long": long_row}


# %%
def rendered(record: ClaimsRecord, kind: str) -> str:
    """Return one block of a page.

    The README has the `EIGHT`, docs/findings.md the claims of `SHORT`, docs/claims.md has all, each
    with a line that says at what cost and on what it was made; two blocks have texts of their own.
    """
    by_id = {claim.id: claim for claim in record.claims}
    if kind == "choices":
        return choices(by_id)
    if kind == "known":
        return known(by_id)
    ids = {"eight": EIGHT, "short": SHORT, "long": by_id}[kind]
    table = markdown([HEADS[kind], *(_cells(ROWS[kind](by_id[name])) for name in ids)])
    cost, machine = duration(record.seconds), machine_text(record.machine)
    origin = f"(From stored full runs, {cost} of solves in all, {machine}.)"
    return f"{table}\n\n{tally(record)} {origin}\n"


def choices(by_id: dict[str, ClaimRecord]) -> str:
    """Return the verdicts that hung on a choice: what they were, what they are, why."""
    rows = [("claim", "was", "is", "why")]
    for row in TEXTS["choice"]:
        claim = by_id[row["claim"]]
        within = sum(point.word == "within" for point in claim.measured)
        verdict = f"**{claim.verdict}**, {largest(claim)} at the worst; {within} of "
        verdict += f"{len(claim.measured)} points within"
        rows.append((f"`{claim.id}`", row["was"], verdict, row["why"]))
    return markdown([rows[0], *(_cells(row) for row in rows[1:])]) + "\n"


def known(by_id: dict[str, ClaimRecord]) -> str:
    """Return the sentences of docs/what-we-now-know.md; every number is a claim's."""
    lines = []
    for text in TEXTS["known"]["sentences"]:
        sentence, ids = _with_numbers(text, by_id)
        verdicts = ", ".join(f"`{name}`: {by_id[name].verdict}" for name in ids)
        lines.append(f"- {sentence} ({verdicts})")
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
    """The numbers of a claim, as its sentence in docs/what-we-now-know.md names them."""

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
    confirming = sum(claim.confirms for claim in denied)
    return (
        "; ".join(sentences)
        + f". {len(denied)} of them state what the chapter denies; {confirming} of these verdicts "
        "confirm it."
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
