"""Names say what they hold: a solution, a load step, a claim; never just that it was found."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("reduced", "reference", "comparisons", "reports", "roughline", "docs")
FILLERS = {
    *("found", "each", "words", "one", "what", "why", "outside", "usual", "crew", "house", "spans"),
    *("wirings", "forms", "thing", "things", "stuff", "told", "said", "asked"),
}
# A filler before what may follow a name that is given; most files need not be parsed.
LOOKS_GIVEN = re.compile(
    rf"\b_*(?:{'|'.join(FILLERS)})_*(?:\s*[:=,)]|\s+in\b)"
    rf"|\b(?:as|def|class)\s+_*(?:{'|'.join(FILLERS)})_*\b",
    re.IGNORECASE,
)
# Keys of files, which keep their names: ``what`` of claims.json, ``why`` of a hard case.
KEYS = {
    "comparisons/questions/claims/record.py: what",
    "comparisons/questions/hard_cases/case.py: why",
}


def fillers(source: str) -> set[str]:
    """Return the fillers among the names that a source gives to variables and definitions.

    Upper case is free: OUTSIDE is a verdict.
    """
    names: set[str] = set()
    if not LOOKS_GIVEN.search(source):
        return names
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.arg):
            names.add(node.arg)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            names.add(node.name)
        elif isinstance(node, ast.ClassDef):
            names.add(node.name.lower())
        elif isinstance(node, ast.ExceptHandler | ast.MatchAs | ast.alias):
            names.add(getattr(node, "asname", node.name) or "")
    return {name for name in names if name.strip("_") in FILLERS}


@pytest.mark.parametrize("room", ROOMS)
def test_names_say_what_they_hold(room):
    files = {file: file.relative_to(ROOT).as_posix() for file in (ROOT / room).rglob("*.py")}
    wrong = {
        f"{name}: {filler}"
        for file, name in files.items()
        for filler in fillers(file.read_text(encoding="utf-8")) | ({file.stem} & FILLERS)
    }
    assert sorted(wrong - KEYS) == []


def test_every_way_to_give_a_name_is_seen():
    source = (
        "import numpy as what\n"
        "def each(found, *, words): usual = [one for one in found if (said := one)]\n"
        "class Crew: told: str\n"
        "OUTSIDE, solution = 'outside', lambda why: why\n"
    )
    seen = {"what", "each", "found", "words", "usual", "one", "said", "crew", "told", "why"}
    assert fillers(source) == seen
