"""Verdicts on claims from the verdicts on their points (`comparisons.judging.verdicts`)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN

if TYPE_CHECKING:
    # Pages read verdicts, and would wait a second for the programs of all experiments.
    from comparisons.questions.experiments.experiment import Effort

HOLDS, FAILS, IN_A_RANGE = "holds", "fails", "holds in a range"
ONLY_AS_STATED = "holds only as stated"
VERDICTS = (HOLDS, FAILS, IN_A_RANGE, ONLY_AS_STATED, NOT_RESOLVED)


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


def verdict_over_all(
    stated: list[str], along: list[str], draws: list[str], effort: Effort = "full"
) -> str:
    """Return the verdict on a claim over all that its statement leaves open.

    It "holds only as stated" if it is within at its stated values, but under no draw over what the
    statement leaves open, or nowhere else at all. The few draws of quick effort do not tell.

    Parameters
    ----------
    stated, along, draws : list of str
        Verdicts on the points at the stated values; away from them along one parameter at a time;
        and drawn over all parameters.

    >>> verdict_over_all(["within"], ["within", "outside"], ["outside", "within"])
    'holds in a range'
    >>> verdict_over_all(["within"], ["within", "outside"], ["outside", "not resolved"])
    'holds only as stated'
    """
    verdict = verdict_of([*stated, *along, *draws], effort)
    elsewhere = draws or along
    if verdict == IN_A_RANGE and WITHIN in stated and effort == "full" and elsewhere:
        return verdict if WITHIN in elsewhere else ONLY_AS_STATED
    return verdict
