"""The reference of a problem sheet: as published, or computed anew and held against its seal."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from comparisons.errors import InputError
from comparisons.judging.truth import choose_truth
from comparisons.methods.normal.proved import enclosures
from comparisons.methods.solver import Refused
from comparisons.questions.problems.sheet import BAR_DIGITS, Known, Sheet, seal, sheet_of
from comparisons.questions.study import solved_in_memory
from comparisons.solving.planning import plan_scene

# Digits of published references: beyond them nobody's solver is judged.
DIGITS = 10


def reference_of(sheet: Sheet) -> dict[str, Known]:
    """Return what is known of every quantity of a sheet.

    Raises
    ------
    InputError
        If the reference that is computed here is not the one that was sealed.
    """
    return sheet.reference if sheet.sealed is None else dict(_unsealed(sheet.id))


@lru_cache(maxsize=64)
def _unsealed(name: str) -> tuple[tuple[str, Known], ...]:
    sheet = sheet_of(name)
    known = computed(sheet)
    assert sheet.sealed is not None
    if seal(known, sheet.sealed.digits) != sheet.sealed:
        raise InputError(
            f"{sheet.id}: the reference of this roughline is not the sealed one (version "
            f"{sheet.version}): nothing is judged by it"
        )
    return tuple(known.items())


def computed(sheet: Sheet) -> dict[str, Known]:
    """Solve the scene of a sheet and return the truth, its bars and what theorems enclose.

    Raises
    ------
    InputError
        If no method gives all quantities.
    """
    plan = plan_scene(sheet.scene)[0]
    plan, solved = solved_in_memory(plan, "quick")
    truth = choose_truth(solved, plan.loads.axis, sheet.quantities)
    missing = [name for name in sheet.quantities if truth is None or not truth.knows(name)]
    if truth is None or missing:
        raise InputError(f"{sheet.id}: no reference for {', '.join(missing)}")
    try:
        sides = enclosures(plan.scene, plan.geometry, plan.loads)
    except Refused:
        sides = {}
    return {
        name: Known(
            values=_rounded(truth.curves[name], DIGITS),
            bars=_rounded(truth.bar(name), BAR_DIGITS),
            lower=_rounded(sides[f"{name}_lower"], DIGITS) if f"{name}_lower" in sides else (),
            upper=_rounded(sides[f"{name}_upper"], DIGITS) if f"{name}_upper" in sides else (),
        )
        for name in sheet.quantities
    }


def _rounded(values: np.ndarray, digits: int) -> tuple[float, ...]:
    return tuple(float(f"{value:.{digits - 1}e}") for value in values)
