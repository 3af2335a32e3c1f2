"""Files of claims: what a family shares is written once. No solver is imported.

A file has a table ``[claims.ID]`` for each claim. Keys above them belong to all its claims, those
of ``[baselines.NAME]`` to the claims with ``like = NAME``; a claim's own tables (`parameters`,
`changes`, `vary`) add to theirs key by key. Nuisance parameters are tables of a claim, or names of
``[nuisances.NAME]`` in its file or, for all files, in nuisances.toml; ``{ like = NAME, ... }``
changes some keys. A list of tolerances makes a claim of each, on the same measurements: ID-5 and
ID-10 of 0.05 and 0.1, with a verdict each in `expected`. ``{tolerance}`` in a text is written out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from comparisons.files import read_toml
from comparisons.formatting import tolerance

# Positions of the chapter's sections and figures among its equations.
_PLACES = {
    "19.1.2": 1.5,
    "19.2 ": 8.5,
    "19.3, (5": 17.5,
    "beside 19.3": 17.6,
    "19.4, second": 19.4,
    "beside 19.4": 19.4,
    "Fig. 19.6": 19.5,
    "Fig. 19.8": 29.5,
    "19.5": 31.5,
    "19.7": 37.5,
    "19.8": 38.0,
    "Problem 1": 39.0,
}
HERE = Path(__file__).parent
SHARED = HERE / "nuisances.toml"

Keys = dict[str, Any]


def read_family(path: Path) -> dict[str, Keys]:
    """Return the keys of the claims of a file by id, with all that they share.

    ValueError if it is no TOML, or its tables do not go together.
    """
    shared = read_toml(path)
    parts = {name: shared.pop(name, {}) for name in ("claims", "baselines", "nuisances")}
    for name, table in parts.items():
        if not isinstance(table, dict) or not all(isinstance(t, dict) for t in table.values()):
            raise ValueError(f"{name}: expected tables [{name}.NAME]")
    if not parts["claims"] and not parts["nuisances"]:
        raise ValueError("expected a table [claims.ID] for each claim, its id in place of ID")
    known = {**read_toml(SHARED)["nuisances"], **parts["nuisances"]}
    claims: dict[str, Keys] = {}
    for name, table in parts["claims"].items():
        keys = _over(shared, _like(table, parts["baselines"], name))
        if isinstance(keys.get("nuisance"), list):
            keys["nuisance"] = [_like(n, known, f"{name}: nuisance") for n in keys["nuisance"]]
        limits, expected = keys.get("tolerance"), keys.get("expected")
        if not isinstance(limits, list):
            claims[name] = {"id": name, **keys}
            continue
        verdicts = expected if isinstance(expected, list) else [expected] * len(limits)
        if len(verdicts) != len(limits) or not all(isinstance(t, int | float) for t in limits):
            raise ValueError(f"{name}: expected numbers as tolerances, and a verdict for each")
        for limit, verdict in zip(limits, verdicts, strict=True):
            member = f"{name}-{100 * limit:g}"
            claims[member] = {**keys, "id": member, "tolerance": limit, "expected": verdict}
    for keys in claims.values():
        if isinstance(keys.get("tolerance"), int | float):
            limit = tolerance(keys["tolerance"]).replace("\u202f", " ")
            for key in ("text", "refuted_by"):
                if isinstance(keys.get(key), str):
                    keys[key] = keys[key].replace("{tolerance}", limit)
    return claims


def _like(entry: Any, known: Mapping[str, Keys], place: str) -> Any:
    """Return a table over the one that it is `like`; a text is the name of that one."""
    table = {"like": entry} if isinstance(entry, str) else entry
    if not isinstance(table, dict) or "like" not in table:
        return table
    name = table["like"]
    if not isinstance(name, str) or name not in known:
        raise ValueError(f"{place}: expected one of {', '.join(known) or 'none'}, got {name!r}")
    return _over(known[name], {key: value for key, value in table.items() if key != "like"})


def _over(lower: Keys, upper: Keys) -> Keys:
    """Return two tables as one; where both have a table, the upper one adds to it key by key."""
    merged = lower | upper
    for key in lower.keys() & upper.keys():
        if isinstance(lower[key], dict) and isinstance(upper[key], dict):
            merged[key] = lower[key] | upper[key]
    return merged


def builtin_claims() -> dict[str, Keys]:
    """Return the keys of the built-in claims by id, in the chapter's order."""
    families = (read_family(path) for path in sorted(HERE.glob("*.toml")))
    claims = {name: keys for family in families for name, keys in family.items()}
    order = sorted(claims, key=lambda name: chapter_order(claims[name]["equation"], name))
    return {name: claims[name] for name in order}


def chapter_order(equation: str, name: str) -> tuple[float, str]:
    """Return the sort key of claims in the chapter's order; claims from other sources come last.

    >>> equations = ["Fig. 19.6", "(19.10)", "19.3, (5.30)", "mine", "(19.9), (19.11)", "19.2 (a)"]
    >>> sorted(equations, key=lambda equation: chapter_order(equation, "a"))
    ['19.2 (a)', '(19.9), (19.11)', '(19.10)', '19.3, (5.30)', 'Fig. 19.6', 'mine']
    """
    number = re.search(r"\(19\.(\d+)", equation)
    if number:
        return float(number[1]), name
    places = (place for phrase, place in _PLACES.items() if phrase in equation)
    return next(places, math.inf), name
