"""Fit of the shares that bars are of the last change between grids, on the fitting halves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from comparisons.judging.uncertainty import SHARE_RULE, ShareRule
from comparisons.questions.calibration_cases import Case, summary

# Required coverage on the fitting half: of a rough quantity's 30 cases all but one; of single
# contacts on cells, of which there are more, more, and on elements, all. By how much factors are
# raised then, as so few cases say little about the last per cents.
LEAST_COVERAGE, LEAST_OF_SINGLE, MARGIN = 0.96, {"cells": 0.975, "elements": 1.0}, 1.1
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
    factors, single = dict(SHARE_RULE.factors), dict(SHARE_RULE.single)
    for quantity in factors:
        own = [case for case in three if (case.quantity, case.kind) == quantity]
        rules = {f: replace(SHARE_RULE, factors=((quantity, f),)) for f in FACTORS}
        factors[quantity] = _narrowest(own, rules, factors[quantity] / MARGIN)
    for kind in single:
        own = [case for case in three if case.kind == kind]
        if kind == "elements":  # few shapes: their grids' bar alone must cover the whole error
            own = [replace(case, bars_beside_grid=0 * case.errors) for case in own]
        rules = {f: replace(SHARE_RULE, single=((kind, f),)) for f in FINE_FACTORS}
        single[kind] = _narrowest(own, rules, single[kind] / MARGIN, LEAST_OF_SINGLE[kind])
    rule = replace(SHARE_RULE, factors=tuple(factors.items()), single=tuple(single.items()))
    two = [case for case in fitting if len(case.resolutions) == 2]
    rules = {f: replace(rule, two=f) for f in FACTORS}
    return replace(
        rule,
        factors=tuple((quantity, round(MARGIN * f, 2)) for quantity, f in factors.items()),
        single=tuple((kind, round(MARGIN * f, 2)) for kind, f in single.items()),
        two=_narrowest(two, rules, rule.two),
    )


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
