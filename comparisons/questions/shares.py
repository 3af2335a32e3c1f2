"""Fit of the shares that bars are of the changes between grids, on the fitting halves."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from comparisons.judging.uncertainty import SHARE_RULE, Calibrated, ShareRule
from comparisons.questions.calibration_cases import Case, at_loads

# Coverage that is required at every load on the fitting half, and by how much factors are raised
# then. Theorems enclose force, penetration and stiffness of single contacts, whose bars are to be
# too narrow rarely; the area they do not, and 95 % it is. Raised until no bar of the quick suite
# misses what is proved (stiffness on cells), and references that agree there do not seem to differ
# (elements, of which there are some fourteen cases). Of rough surfaces, of which there are some
# thirty cases of small ones, 95 %, raised by a tenth.
ROUGH = 0.95, 1.1
SINGLE: dict[Calibrated, tuple[float, float]] = {
    ("force", "cells"): (0.99, 1.0),
    ("penetration", "cells"): (0.99, 1.0),
    ("contact_area", "cells"): (0.95, 1.0),
    ("stiffness", "cells"): (0.99, 1.3),
    ("force", "elements"): (0.99, 1.25),
    ("contact_area", "elements"): (0.99, 2.0),
    ("stiffness", "elements"): (0.99, 1.15),
}
# The factors that are tried.
FACTORS = tuple(map(float, np.geomspace(0.01, 100, 2000)))


def with_rule(case: Case, rule: ShareRule) -> Case:
    """Return a case with the bar of another rule."""
    return replace(case, rule=rule)


def fitted_rule(cases: Iterable[Case]) -> ShareRule:
    """Return the narrowest rule that covers enough of the fitting half.

    Every factor covers the required share of the bars at every load of its cases with three grids,
    then `two` as much of all rough cases with two; the factors are then raised. What nothing covers
    keeps its value. Areas that are counted, too, have a rule of their own: here they stand for
    those of other methods.
    """
    fitting = [replace(case, counted=None) for case in cases if case.half == "fitting"]
    three = [case for case in fitting if len(case.resolutions) > 2]
    factors = dict(SHARE_RULE.factors)
    for quantity in factors:
        own = [case for case in three if (case.quantity, case.kind) == quantity]
        least, margin = SINGLE.get(quantity, ROUGH)
        rules = {f: replace(SHARE_RULE, factors=((quantity, f),)) for f in FACTORS}
        factors[quantity] = _narrowest(own, rules, factors[quantity] / margin, least)
    rule = replace(SHARE_RULE, factors=tuple(factors.items()))
    two = [case for case in fitting if len(case.resolutions) == 2]
    rules = {f: replace(rule, two=f) for f in FACTORS}
    raised = tuple(
        (quantity, round(SINGLE.get(quantity, ROUGH)[1] * f, 2)) for quantity, f in factors.items()
    )
    return replace(rule, factors=raised, two=_narrowest(two, rules, rule.two, ROUGH[0]))


def scaled(cases: Iterable[Case], by: float) -> list[Case]:
    """Return the cases with the grid's part of their bars so much wider."""
    return [replace(case, widened=by) for case in cases]


def _narrowest(
    cases: list[Case], rules: dict[float, ShareRule], other: float, least: float
) -> float:
    """Return the first of some numbers whose rule covers enough of the cases; else another one."""
    numbers = list(rules)

    def covers(number: float) -> bool:
        made = [with_rule(case, rules[number]) for case in cases]
        return at_loads(made).coverage >= least

    # the larger the number, the wider all bars
    first = bisect_left(numbers, True, key=covers) if cases else len(numbers)
    return numbers[first] if first < len(numbers) else other
