"""Fit of the shares that bars are of the last change between grids, on the fitting halves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from comparisons.judging.uncertainty import SHARE_RULE, ShareRule
from comparisons.questions.calibration_cases import Case, summary

# Required coverage on the fitting half: of a rough quantity's 30 cases all but one, of a single
# contact, of which there are more, more. By how much factors are raised then, as so few cases say
# little about the last per cents; by more on cells, where a theorem may refute a bar.
LEAST_COVERAGE, LEAST_ON_CELLS, MARGIN, MARGIN_ON_CELLS = 0.96, 0.99, 1.1, 1.4
# The factors that are tried; in finer steps for single contacts, of which there are more cases.
FACTORS, FINE_FACTORS = tuple(k / 10 for k in range(1, 51)), tuple(k / 100 for k in range(1, 501))


def with_rule(case: Case, rule: ShareRule) -> Case:
    """Return a case with the bar of another rule."""
    return replace(case, rule=rule)


def fitted_rule(cases: Iterable[Case]) -> ShareRule:
    """Return the narrowest rule that covers enough of the fitting half.

    Every factor covers LEAST_COVERAGE of its cases with three grids, then `two` as much of all
    cases with two; the factors are then raised by MARGIN. What nothing covers keeps its value.
    """
    fitting = [case for case in cases if case.half == "fitting"]
    three = [case for case in fitting if len(case.resolutions) > 2]
    factors = dict(SHARE_RULE.factors)
    for quantity in factors:
        own = [case for case in three if (case.quantity, case.kind) == quantity]
        on_cells = quantity[1] == "cells"
        tried = FINE_FACTORS if on_cells else FACTORS
        rules = {f: replace(SHARE_RULE, factors=((quantity, f),)) for f in tried}
        least = LEAST_ON_CELLS if on_cells else LEAST_COVERAGE
        margin = MARGIN_ON_CELLS if on_cells else MARGIN
        factors[quantity] = _narrowest(own, rules, factors[quantity] / margin, least)
    rule = replace(SHARE_RULE, factors=tuple(factors.items()))
    two = [case for case in fitting if len(case.resolutions) == 2]
    rules = {f: replace(rule, two=f) for f in FACTORS}
    raised = tuple(
        (quantity, round((MARGIN_ON_CELLS if quantity[1] == "cells" else MARGIN) * f, 2))
        for quantity, f in factors.items()
    )
    return replace(rule, factors=raised, two=_narrowest(two, rules, rule.two))


def _narrowest(
    cases: list[Case],
    rules: dict[float, ShareRule],
    other: float,
    least: float = LEAST_COVERAGE,
) -> float:
    """Return the first of some numbers whose rule covers enough of the cases; else another one."""
    for number, rule in rules.items() if cases else ():
        if summary(with_rule(case, rule) for case in cases).coverage >= least:
            return number
    return other
