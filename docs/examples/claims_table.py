"""Write the table of verdicts into README.md and docs/claims.md, from a stored run.

The run is docs/claims.json, made by::

    roughline claims --full --json docs/claims.json

Then, from the repository's root::

    python docs/examples/claims_table.py

The tables between the markers of both pages are written anew.
"""

# %%
import re
from pathlib import Path

from comparisons.claims.record import ClaimRecord, ClaimsRecord, load_claims_record
from comparisons.formatting import duration, plus_minus, tolerance
from comparisons.machine import machine_text

DOCS = Path(__file__).resolve().parents[1]
STORED = DOCS / "claims.json"
PAGES = (DOCS.parent / "README.md", DOCS / "claims.md")
BLOCK = re.compile(r"(<!-- claims (short|long) -->\n).*?(<!-- end of claims -->)", re.DOTALL)


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
    cells = (claim.id, claim.equation, f"**{claim.verdict}**", claim.sentence)
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
    "short": ("claim", "equation", "verdict", "what was found"),
    "long": (
        *("claim", "equation", "reading", "text", "tolerance", "verdict", "largest error"),
        "what was found",
    ),
}


# %%
def rendered(record: ClaimsRecord, kind: str) -> str:
    """Return one table, with a line that says when and on what it was made.

    The short one has the claims as printed, the long one also those that correct them.
    """
    row = short_row if kind == "short" else long_row
    heads = HEADS[kind]
    shown = [c for c in record.claims if kind == "long" or c.reading == "printed"]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    lines += [row(claim) for claim in shown]
    lines += ["", f"(`{record.command}`, {record.created[:10]}, {duration(record.seconds)},"]
    lines[-1] += f" {machine_text(record.machine)})"
    return "\n".join(lines) + "\n"


def written(page: str, record: ClaimsRecord) -> str:
    """Return a page with the tables between its markers made anew."""
    return BLOCK.sub(lambda match: match[1] + rendered(record, match[2]) + match[3], page)


# %%
if __name__ == "__main__":
    stored = load_claims_record(STORED)
    for path in PAGES:
        path.write_text(written(path.read_text(encoding="utf-8"), stored), encoding="utf-8")
