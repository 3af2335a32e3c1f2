"""One row per quantity, in one table; all other code reads its facts from here.

A new row, or file with `ROWS`, adds quantities: scenes can request them, and they are derived,
compared and reported. Quantities common to all scenes come first.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator

import numpy as np

from comparisons.discovery import files_of
from comparisons.facts.quantities.rows import Contact, Curves, Quantity

_rows = (row for file in files_of(sys.modules[__name__]) for row in getattr(file, "ROWS", ()))
QUANTITIES: dict[str, Quantity] = {
    row.name: row for row in sorted(_rows, key=lambda row: bool(row.physics))
}


def quantities_with(**facts: object) -> tuple[str, ...]:
    """Return the quantities whose rows match all of these facts.

    >>> quantities_with(load="normal")
    ('force', 'penetration', 'mean_gap')
    """
    return tuple(
        name
        for name, row in QUANTITIES.items()
        if all(getattr(row, key) == value for key, value in facts.items())
    )


# What a scene may ask for, what it gets where it asks for nothing, and what stands in columns.
COMPARABLE, DEFAULT = quantities_with(comparable=True), quantities_with(default=True)
CURVES, FIELDS = quantities_with(comparable=True, field=False), quantities_with(field=True)
DISTRIBUTIONS = tuple(name for name, row in QUANTITIES.items() if row.bins is not None)
NORMAL, TANGENTIAL = quantities_with(load="normal"), quantities_with(load="tangential")


def quantity(name: str) -> Quantity:
    """Return the row of a column; unknown columns keep their name.

    >>> quantity("force").unit
    'N'
    >>> quantity("local_stress_undefined_share").label
    'local stress undefined share'
    """
    return QUANTITIES.get(name, Quantity(name, name.replace("_", " "), comparable=False))


def in_order(names: Iterable[str]) -> list[str]:
    """Return names in the order of the rows, each once; unknown ones by name behind them.

    >>> in_order(["mine", "penetration", "force", "penetration"])
    ['force', 'penetration', 'mine']
    """
    given = set(names)
    known = [name for name in QUANTITIES if name in given]
    return known + sorted(given.difference(known))


def main_axis(axis: str, name: str) -> str:
    """Return the load at which a quantity is compared: the prescribed one, or for it the other.

    >>> main_axis("force", "contact_area"), main_axis("force", "force"), main_axis("time", "time")
    ('force', 'penetration', 'time')
    """
    return quantity(axis).counterpart or axis if name == axis else axis


def derived(
    computed: Curves, scene: Contact, *, is_round: bool
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the missing quantities that can be derived from computed curves, with their values."""
    curves = dict(computed)
    rules = {name: row.derived for name, row in QUANTITIES.items() if row.derived is not None}
    while True:
        due = [
            (name, rule)
            for name, rule in rules.items()
            if name not in curves
            and set(rule.of) <= set(curves)
            and (is_round or not rule.round_only)
        ]
        if not due:
            return
        for name, rule in due:
            # A copy: a step that fails is blanked in every curve by itself.
            curves[name] = np.array(rule.by(curves, scene), dtype=float)
            yield name, curves[name]
