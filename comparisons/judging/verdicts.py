"""Verdicts: does an error hold a tolerance, given how well the truth is known.

The one criterion of roughline: the largest |e| + u over the load steps against the tolerance. Every
"within" and "outside" on a page, in a terminal, a table or an exit code comes from here. A claim is
measured at several points of a range: whether it "holds" or "fails" follows from the verdicts on
them (`comparisons.questions.claims.record`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BeforeValidator

from comparisons import formatting as fmt
from comparisons.facts.quantities import QUANTITIES, quantity

WITHIN, OUTSIDE, NOT_RESOLVED, NO_RESULT = "within", "outside", "not resolved", "no result"
LAST_LOAD = "last load"
NAN = math.nan
# A number that JSON has as null where it is not known.
Number = Annotated[float, BeforeValidator(lambda value: NAN if value is None else value)]
SAME = 1e-9  # relative differences between load steps that mean nothing
# Of several quantities the worst decides: one that is wrong, one that is missing, one unknown.
WORST_FIRST = (OUTSIDE, NO_RESULT, NOT_RESOLVED, WITHIN)


def step_at(axis: str) -> str:
    """Return what one load is called; creeps, speeds, times and places along a path are steps."""
    return "load step" if quantity(axis).load else "step"


def of_steps(chosen: np.ndarray, axis: str) -> str:
    """Count load steps.

    >>> of_steps(np.array([True, False]), "force"), of_steps(np.array([True, False]), "time")
    ('1 of 2 load steps', '1 of 2 steps')
    """
    return f"{chosen.sum()} of {chosen.size} {step_at(axis)}s"


def severity(verdict: Verdict) -> tuple[int, float, float]:
    """Return what sorts verdicts, the worst first.

    Outside before no result before not resolved before within. Among equal words the one that is
    furthest out: by `low` (the largest |e| - u) where it is outside, else by `high` (the largest
    |e| + u), an unknown one being the largest; then the largest |e|.

    >>> several = [("within", 0.1, 0.3), ("outside", 1.0, 9.0), ("outside", 2.0, 3.0)]
    >>> verdicts = [Verdict(word=w, low=low, high=high, tolerance=1) for w, low, high in several]
    >>> [verdict.low for verdict in sorted(verdicts, key=severity)]
    [2.0, 1.0, 0.1]
    """
    size = verdict.low if verdict.word == OUTSIDE else verdict.high
    return (
        WORST_FIRST.index(verdict.word),
        -(size if np.isfinite(size) else np.inf),
        -(abs(verdict.error) if np.isfinite(verdict.error) else 0.0),
    )


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The verdict on one quantity of one setting, a method at a resolution; see `judged`."""

    word: str = NO_RESULT  # "within", "outside", "not resolved" or "no result"
    step: int = -1  # the load step that decided, counted from 0; -1 where there is no result
    # e, with its sign, and u at that step; u is NaN where it is not known.
    error: Number = NAN
    uncertainty: Number = NAN
    # The largest |e| - u and |e| + u over the steps: a tolerance below `low` is missed, one from
    # `high` on is held. `high` is NaN where a step has no error or no bar, `low` of what
    # is outside at any tolerance.
    low: Number = NAN
    high: Number = NAN
    # The resolution is 0 for a method that solved nothing; NaN where none is meant.
    method: str = ""
    resolution: Number = NAN
    # What was compared, and what was equal when it was ("penetration", "force", "last load").
    quantity: str = ""
    at: str = ""
    tolerance: float
    # Whether `error` has its sign, or is a size (norms); and whether it is a ratio minus 1 (along
    # paths errors are relative to the largest value).
    signed: bool = True
    ratio: bool = True
    # Along a path: the error over the value itself at the step where it is furthest outside, by its
    # |e| - u; NaN where it is nowhere.
    own_error: Number = NAN
    own_step: int = -1
    rms: Number = NAN  # root mean square of e over the load steps
    steps: int = 0  # how many load steps there are; of a single one none is named
    reason: str = ""  # why there is no result, or at how many load steps none
    # False for a quantity that the scene's solutions cannot answer for any method.
    counts: bool = True
    # False for a quantity that this method does not compute: a dash, no verdict on the method.
    offered: bool = True
    # Load steps, from 0, at which the one surface of a map is outside the band of single lines;
    # None where there is no such band. The error is that of the lines' mean.
    outside_band: tuple[int, ...] | None = None
    # 5 and 95 % quantiles of single realisations' errors, at the step where they reach furthest.
    single_low: Number = NAN
    single_high: Number = NAN
    single_step: int = -1

    @property
    def single(self) -> str:
        """The band of single realisations' errors: "−31 to +37 %"; "–" where there is none."""
        return fmt.between(self.single_low, self.single_high)

    @property
    def band(self) -> str:
        """Where the one surface of a map lies, among 90 % of single lines or beyond, and when."""
        if self.outside_band is None:
            return ""
        if not self.outside_band:
            return "within the scatter of single lines"
        steps = [step + 1 for step in self.outside_band]
        if self.steps == 1:
            return "beyond the scatter of single lines"
        if len(steps) == 1:
            return f"beyond the scatter of single lines at load step {steps[0]}"
        whole = steps[-1] - steps[0] + 1 == len(steps) > 2
        several = f"{steps[0]} to {steps[-1]}" if whole else ", ".join(map(str, steps))
        return f"beyond the scatter of single lines at load steps {several}"

    @property
    def number(self) -> str:
        """The error with its bar, as everything prints it."""
        return fmt.plus_minus(self.error, self.uncertainty, signed=self.signed, ratio=self.ratio)

    @property
    def lacking(self) -> str:
        """What follows the error where some load steps have none; "" where all have one."""
        return f", {self.reason}" if self.reason and self.word != NO_RESULT else ""

    @property
    def has_step(self) -> bool:
        """Whether a load step decided; none does where only round-off is left."""
        return self.step >= 0 and self.number != "round-off"

    @property
    def when(self) -> str:
        """The step that decided: "load step 4", "last load"; "" for round-off."""
        if self.steps == 1 or self.word == NO_RESULT:
            return ""
        if self.at == LAST_LOAD:
            return LAST_LOAD
        if not self.has_step:
            return ""
        step = f"{step_at(self.at)} {self.step + 1}"
        if self.ratio:
            return step
        when = f"{step}, over the largest value of the path"
        if self.word == WITHIN and self.own_step >= 0:
            own = f"{fmt.signed_error(self.own_error)} at {step_at(self.at)} {self.own_step + 1}"
            # with its tolerance: on pages, where another one is chosen, the text stays true
            when += f" (outside {fmt.tolerance(self.tolerance)} over its own: {own})"
        return when

    @property
    def where(self) -> str:
        """That step and what was equal there: "load step 4, equal force"; on maps the band."""
        if self.word == NO_RESULT:
            return ""
        compared = self.ratio and self.at in QUANTITIES  # along a path each step with itself
        equal = f"equal {quantity(self.at).label}" if compared else ""
        place = f"the lines' mean, the surface {self.band}" if self.band else ""
        return "; ".join(filter(None, [", ".join(filter(None, [self.when, equal])), place]))

    @property
    def because(self) -> str:
        """The comparison that decided: "|e| + u = 0.99 % ≤ t = 1 %", or why there is none."""
        if self.word == NO_RESULT:
            return self.reason
        limit = f"t = {fmt.tolerance(self.tolerance)}"
        if self.high < fmt.ROUND_OFF:
            return f"round-off ≤ {limit}"
        least, most = (fmt.relative(max(end, 0.0)) for end in (self.low, self.high))
        if self.word == WITHIN:
            return f"|e| + u = {most} ≤ {limit}"
        if self.word == OUTSIDE:
            if not fmt.finite(self.low):
                return self.reason
            return f"|e| − u = {least} > {limit}"
        unknown = self.reason or "u is not known"
        if fmt.finite(self.high):
            unknown = f"{limit} < |e| + u = {most}"
        return f"|e| − u = {least} ≤ {limit}, but {unknown}" if fmt.finite(self.low) else unknown

    @property
    def text(self) -> str:
        """Quantity, number and step, or why there is none: "force 2.3 ± 0.1 % at load step 4"."""
        label = quantity(self.quantity).label
        if self.word == NO_RESULT:
            return f"{label}: {self.reason}"
        when = f" at {self.when}" if self.when else ""
        return f"{label} {self.number}{when}{self.lacking}"


def worst(items: Iterable[Verdict], *, asked: bool = False) -> Verdict:
    """Return the verdict that decides over several quantities, by `severity`.

    Quantities that nothing answers, or that the method does not compute, decide only where all are
    such; with `asked` the method has to compute all that some method answers.
    """
    several = list(items)
    counted = [verdict for verdict in several if verdict.counts]
    offered = [] if asked else [verdict for verdict in counted if verdict.offered]
    return min(offered or counted or several, key=severity)


def judged(error: ArrayLike, uncertainty: ArrayLike, tolerance: float, **of: Any) -> Verdict:
    """Judge errors at one or several load steps; `of` says what they are errors of (`Verdict`).

    With e an error and u the 95 % half-width of its bar: "within" if |e| + u <= t at every step,
    "outside" if |e| - u > t at any, else "not resolved". An unknown bar resolves nothing, nor does
    a step without an error; if there are only such steps there is "no result".

    The step that decides has the largest |e| - u if that is outside, else the largest |e| + u, an
    unknown bar being the widest.

    >>> [judged(e, 0.001, 0.01).word for e in (0.004, -0.02, 0.0095, float("nan"))]
    ['within', 'outside', 'not resolved', 'no result']
    >>> judged([0.004, 0.02], [0.001, 0.03], 0.01).step
    1
    >>> judged([0.05, 0.02], [0.001, 0.04], 0.01).step
    0
    """
    signed = np.atleast_1d(np.asarray(error, dtype=float))
    finite = np.isfinite(signed)
    errors = np.where(finite, np.abs(signed), 0.0)
    bars = np.broadcast_to(np.asarray(uncertainty, dtype=float), errors.shape)
    if not finite.any():
        return Verdict(tolerance=tolerance, **of)
    bars = np.where(np.isfinite(bars), bars, np.inf)
    least = np.where(finite, errors - bars, -np.inf)
    most = np.where(finite, errors + bars, -np.inf)
    low, high = float(np.max(least)), float(np.max(most)) if finite.all() else np.inf
    word = word_for(low, high, tolerance)
    # the first step whose value is the largest to round-off; of unknown bars the error
    sizes = least if word == OUTSIDE else most
    if np.isposinf(sizes).any():
        sizes = np.where(np.isposinf(sizes), errors, -1.0)
    largest = np.max(sizes)
    step = int(np.argmax(sizes >= largest - SAME * abs(largest)))
    numbers = {"error": signed[step], "uncertainty": bars[step], "low": low, "high": high}
    known: dict[str, Any] = {
        name: float(n) if np.isfinite(n) else NAN for name, n in numbers.items()
    }
    return Verdict(word=word, step=step, tolerance=tolerance, **known, **of)


def word_for(low: float, high: float, tolerance: float) -> str:
    """Return the word for an error that lies between `low` and `high` (unknown ends: NaN).

    >>> word_for(0.01, 0.03, 0.05), word_for(0.01, 0.03, 0.005), word_for(0.01, 0.03, 0.02)
    ('within', 'outside', 'not resolved')
    """
    if high <= tolerance:
        return WITHIN
    return OUTSIDE if low > tolerance else NOT_RESOLVED
