"""Checks of arguments, shared by the package: every check lists what is wrong, in words."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np


def positive_faults(**values: object) -> list[str]:
    """Name the values that are not finite, positive numbers.

    Examples
    --------
    >>> positive_faults(radius=2.0, spacing=-1.0)
    ['spacing must be finite and positive, got -1.0']
    """
    return [
        f"{name} must be finite and positive, got {value!r}"
        for name, value in values.items()
        if not (_is_number(value) and np.isfinite(value) and value > 0)
    ]


def count_faults(least: int = 1, **values: object) -> list[str]:
    """Name the values that are not whole numbers of at least `least`.

    Examples
    --------
    >>> count_faults(springs=float("nan"), threads=2)
    ['springs must be an integer >= 1, got nan']
    """
    return [
        f"{name} must be an integer >= {least}, got {value!r}"
        for name, value in values.items()
        if not (_is_number(value) and np.isfinite(value) and value == int(value) >= least)
    ]


def choice_faults(name: str, value: object, known: Collection[str]) -> list[str]:
    """Say so if a value is none of the known ones.

    Examples
    --------
    >>> choice_faults("edges", "cell", ("sub_cell", "nodal"))
    ["edges must be one of 'sub_cell', 'nodal', got 'cell'"]
    """
    names = ", ".join(map(repr, known))
    return [] if value in known else [f"{name} must be one of {names}, got {value!r}"]


def refuse(wrong: list[str]) -> None:
    """Raise one ValueError for everything wrong, if anything is."""
    if wrong:
        raise ValueError("; ".join(wrong))


def _is_number(value: object) -> bool:
    return np.ndim(value) == 0 and np.asarray(value).dtype.kind in "iuf"
