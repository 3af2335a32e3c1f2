"""Verdicts on claims from the verdicts on their points (`comparisons.judging.verdicts`)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN

if TYPE_CHECKING:
    # Pages read verdicts, and would wait a second for the programs of all experiments.
    from comparisons.questions.experiments.base import Effort

HOLDS, FAILS, IN_A_RANGE = "holds", "fails", "holds in a range"
VERDICTS = (HOLDS, FAILS, IN_A_RANGE, NOT_RESOLVED)


def verdict_of(points: Iterable[str], effort: Effort = "full") -> str:
    """Return the verdict on a claim from the verdicts on all measured points.

    One point outside refutes a claim about the whole range: it "holds in a range" if another point
    is within, else it "fails". Without points outside it "holds" if all points are within, else it
    is "not resolved". The wide bars of quick effort may hide a range, so a claim that is outside at
    all resolved points then "fails" only if every point is resolved.

    >>> verdict_of(["within", "within"]), verdict_of(["within", "outside"])
    ('holds', 'holds in a range')
    >>> verdict_of(["outside", "not resolved"]), verdict_of(["outside", "not resolved"], "quick")
    ('fails', 'not resolved')
    """
    verdicts = set(points)
    if verdicts == {WITHIN}:
        return HOLDS
    if OUTSIDE not in verdicts:
        return NOT_RESOLVED
    if WITHIN in verdicts:
        return IN_A_RANGE
    return FAILS if effort == "full" or verdicts == {OUTSIDE} else NOT_RESOLVED
