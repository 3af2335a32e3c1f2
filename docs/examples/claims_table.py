"""Write the verdicts on the claims into README.md and docs/claims.md, from stored full runs.

The record of the runs is docs/claims.json. A run of all claims, or of those that are new or
changed, is put into it, and the tables between the markers of both pages are written anew::

    roughline claims --full --json run.json
    python docs/examples/claims_table.py run.json
"""

# %%
import re
import sys
from collections import Counter
from pathlib import Path

from comparisons.files import write_text
from comparisons.formatting import duration, plus_minus, tolerance
from comparisons.machine import machine_text
from comparisons.questions.claims.claim import VERDICTS, load_claims
from comparisons.questions.claims.record import ClaimRecord, ClaimsRecord, load_claims_record

DOCS = Path(__file__).resolve().parents[1]
STORED = DOCS / "claims.json"
PAGES = (DOCS.parent / "README.md", DOCS / "claims.md")
BLOCK = re.compile(r"(<!-- claims (short|long) -->\n).*?(<!-- end of claims -->)", re.DOTALL)
# What the README tells of: one claim, printed or corrected, for each statement of the chapter.
TOLD = (
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

    Date, machine and duration are those of the (last) run that judged most of them. The details
    of single measurements are left out: `roughline claims` finds them again.
    """
    known = [claim.id for claim in load_claims()]
    found = {claim.id: claim for record in records for claim in record.claims}
    kept = [_bare(found[name]) for name in known if name in found]
    main = max(reversed(records), key=lambda record: len(record.claims))
    return main.model_copy(update={"claims": kept})


def _bare(claim: ClaimRecord) -> ClaimRecord:
    points = [point.model_copy(update={"details": {}}) for point in claim.points]
    return claim.model_copy(update={"points": points})


# %%
def largest(claim: ClaimRecord) -> str:
    """Return the largest error found, with its bar."""
    known = [point for point in claim.points if point.error is not None]
    if not known:
        return "–"
    point = max(known, key=lambda each: abs(each.error))
    return plus_minus(point.error, point.uncertainty)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ").strip()


def short_row(claim: ClaimRecord) -> str:
    """Return what the README says of a claim."""
    text = claim.text + (" *(as corrected)*" if claim.reading == "corrected" else "")
    cells = (claim.equation, text, f"**{claim.verdict}**", claim.sentence)
    return "| " + " | ".join(map(_cell, cells)) + " |"


def long_row(claim: ClaimRecord) -> str:
    """Return what docs/claims.md says of a claim: its text, its verdict, the decisive numbers."""
    cells = (
        *(claim.id, claim.equation, claim.reading, claim.text),
        f"{tolerance(claim.tolerance)}{' (chapter)' if claim.tolerance_from == 'chapter' else ''}",
        *(f"**{claim.verdict}**", largest(claim), claim.sentence),
    )
    return "| " + " | ".join(map(_cell, cells)) + " |"


HEADS = {
    "short": ("equation", "the chapter says", "verdict", "found"),
    "long": (
        *("claim", "equation", "reading", "text", "tolerance", "verdict", "largest error"),
        "what was found",
    ),
}


# %%
def rendered(record: ClaimsRecord, kind: str) -> str:
    """Return one table, with a line that says when and on what it was made.

    The short one has the claims that are `TOLD`, in that order; the long one has all.
    """
    row = short_row if kind == "short" else long_row
    by_id = {claim.id: claim for claim in record.claims}
    shown = [by_id[name] for name in TOLD] if kind == "short" else record.claims
    lines = ["| " + " | ".join(HEADS[kind]) + " |", "|" + "---|" * len(HEADS[kind])]
    lines += [row(claim) for claim in shown]
    made = f"`{record.command}`, {record.created[:10]}, {duration(record.seconds)}"
    lines += ["", f"{tally(record)} (Most of them by {made}, {machine_text(record.machine)}.)"]
    return "\n".join(lines) + "\n"


def tally(record: ClaimsRecord) -> str:
    """Return how many claims, as printed and as corrected, got which verdict."""
    told = []
    for reading in ("printed", "corrected"):
        claims = [claim for claim in record.claims if claim.reading == reading]
        words = Counter(claim.verdict for claim in claims)
        counts = ", ".join(
            f"{words[word]} {word.replace('holds', 'hold').replace('fails', 'fail')}"
            for word in VERDICTS
            if words[word]
        )
        told.append(f"{len(claims)} claims as {reading}: {counts}")
    return "; ".join(told) + "."


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
