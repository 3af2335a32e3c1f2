"""Fit of the shares that bars are of the changes between grids, on the fitting halves."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from comparisons.judging.uncertainty import SHARES, Calibrated, Share, Shares
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


def with_shares(case: Case, shares: Shares) -> Case:
    """Return a case with the bar of other shares."""
    return replace(case, shares=shares)


def fitted_shares(cases: Iterable[Case]) -> Shares:
    """Return the narrowest shares that cover enough of the fitting half.

    Every factor covers the required share of the bars at every load of its cases with three grids,
    `two` times as much that of the cases with two; the factors are then raised. What nothing covers
    keeps its value. Areas that are counted, too, have a rule of their own: here they stand for
    those of other methods.
    """
    fitting = [replace(case, counted=None) for case in cases if case.half == "fitting"]
    fitted: dict[Calibrated, Share] = {}
    for known, used in SHARES.items():
        own = [case for case in fitting if (case.quantity, case.kind) == known]
        three = [case for case in own if len(case.resolutions) > 2]
        two = [case for case in own if len(case.resolutions) == 2]
        least, raised = SINGLE.get(known, ROUGH)
        tried = {f: {known: used._replace(factor=f)} for f in FACTORS}
        factor = _narrowest(three, tried, used.factor / raised, least)
        tried = {f: {known: Share(used.order, factor, f)} for f in FACTORS}
        wider = _narrowest(two, tried, used.two, least)
        fitted[known] = Share(used.order, round(raised * factor, 2), wider)
    return fitted


def scaled(cases: Iterable[Case], by: float) -> list[Case]:
    """Return the cases with the grid's part of their bars so much wider."""
    return [replace(case, widened=by) for case in cases]


def _narrowest(
    cases: list[Case], tried: Mapping[float, Shares], other: float, least: float
) -> float:
    """Return the first of some numbers whose shares cover enough of the cases; else another one."""
    numbers = list(tried)

    def covers(number: float) -> bool:
        made = [with_shares(case, tried[number]) for case in cases]
        return at_loads(made).coverage >= least

    # the larger the number, the wider all bars
    first = bisect_left(numbers, True, key=covers) if cases else len(numbers)
    return numbers[first] if first < len(numbers) else other
