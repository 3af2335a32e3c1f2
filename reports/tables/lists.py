"""Lists of the built-in scenes, methods, claims and hard cases."""

from __future__ import annotations

from reports.tables.cells import Table, number, table


def scenes() -> Table:
    """Return the built-in scenes and their suites."""
    from comparisons.scene.scene import SUITES, builtin_names, load_scene

    rows = (
        (
            name,
            load_scene(name).heading,
            ", ".join(s for s, members in SUITES.items() if name in members),
        )
        for name in builtin_names()
    )
    return table(("name", "title", "suites"), rows, title="Built-in scenes")


def methods() -> Table:
    """Return all methods, and what they solve."""
    from comparisons.facts.methods import ELEMENTS, METHODS, REPEATING_ELEMENTS, THEORIES

    also = {ELEMENTS: f"; below rough surfaces {REPEATING_ELEMENTS}"}
    solves = {1: "a line", 3: "the 3-D contact"} | dict.fromkeys(THEORIES, "(a theory)")
    rows = (
        (name, method.title + also.get(name, ""), solves.get(name) or solves[method.dimension])
        for name, method in METHODS.items()
    )
    return table(("name", "title", "solves"), rows, title="Methods")


def claims() -> Table:
    """Return the built-in claims with their texts, in the chapter's order."""
    from comparisons.questions.claims.families import builtin_claims
    from comparisons.questions.claims.wording import limit_words

    rows = []
    for name, keys in builtin_claims().items():
        factor = keys.get("factor")
        limit = keys["tolerance"] if factor is None else factor - 1.0
        told = name, keys["equation"], keys.get("reading", "printed")
        rows.append((*told, number(limit_words(limit, factor), limit), keys["text"]))
    heads = ("id", "equation", "reading", "tolerance", "text")
    return table(heads, rows, title="Built-in claims")


def hard_cases() -> Table:
    """Return the hard cases with their difficulty."""
    from comparisons.questions.hard_cases.case import catalogue

    rows = ((case.id, case.title, case.hard) for case in catalogue().values())
    return table(("id", "title", "difficulty"), rows, title="Hard cases")


CATALOGUES = {"scenes": scenes, "methods": methods, "claims": claims, "hard-cases": hard_cases}
