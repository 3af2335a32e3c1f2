"""Verdicts: does an error hold a tolerance, given how well the truth is known.

The one criterion of roughline: the largest |e| + u over the load steps against the tolerance. Every
"within" and "outside" on a page, in a terminal, a table or an exit code comes from here. A claim is
measured at several points of a range: whether it "holds" or "fails" follows from the verdicts on
them (`comparisons.questions.claims.verdicts`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

WITHIN, OUTSIDE, NOT_RESOLVED, NO_RESULT = "within", "outside", "not resolved", "no result"
SAME = 1e-9  # relative differences between load steps that mean nothing
# Of several quantities the worst decides: one that is wrong, one that is missing, one unknown.
WORST_FIRST = (OUTSIDE, NO_RESULT, NOT_RESOLVED, WITHIN)


def severity(word: str, low: float, high: float, error: float = 0.0) -> tuple[int, float, float]:
    """Return what sorts verdicts, the worst first.

    Outside before no result before not resolved before within. Among equal words the one that is
    furthest out: by `low` (the largest |e| - u) where it is outside, else by `high` (the largest
    |e| + u), an unknown one being the largest; then the largest |e|.

    >>> sorted([("within", 0.1, 0.3), ("outside", 1.0, 9.0), ("outside", 2.0, 3.0)],
    ...        key=lambda verdict: severity(*verdict))
    [('outside', 2.0, 3.0), ('outside', 1.0, 9.0), ('within', 0.1, 0.3)]
    """
    size = low if word == OUTSIDE else high
    unknown = -np.inf if word == OUTSIDE else np.inf
    return (
        WORST_FIRST.index(word),
        -(size if np.isfinite(size) else unknown),
        -(abs(error) if np.isfinite(error) else 0.0),
    )


@dataclass(frozen=True)
class Judgement:
    """A verdict with the load step that decided it.

    Attributes
    ----------
    word : str
        "within", "outside", "not resolved" or "no result".
    step : int
        The load step that decided, counted from 0; -1 where there is no result.
    error, uncertainty : float
        e, with its sign, and u at that step; u is NaN where it is not known.
    low, high : float
        The largest |e| - u and |e| + u over the steps: a tolerance below `low` is missed, one
        from `high` on is held. `high` is NaN where a step has no error or no bar.
    """

    word: str
    step: int
    error: float
    uncertainty: float
    low: float
    high: float


def judged(error: ArrayLike, uncertainty: ArrayLike, tolerance: float) -> Judgement:
    """Judge errors at one or several load steps.

    With e an error and u the 95 % half-width of its bar: "within" if |e| + u <= t at every step,
    "outside" if |e| - u > t at any, else "not resolved". An unknown bar resolves nothing, nor does
    a step without an error; if there are only such steps there is "no result".

    The step that decides has the largest |e| - u if that is outside, else the largest |e| + u, an
    unknown bar being the widest.

    Examples
    --------
    >>> judged([0.004, 0.02], [0.001, 0.03], 0.01).step
    1
    >>> judged([0.05, 0.02], [0.001, 0.04], 0.01).step
    0
    """
    nan = float("nan")
    signed = np.atleast_1d(np.asarray(error, dtype=float))
    errors = np.abs(signed)
    bars = np.broadcast_to(np.asarray(uncertainty, dtype=float), errors.shape)
    finite = np.isfinite(errors)
    if not finite.any():
        return Judgement(NO_RESULT, -1, nan, nan, nan, nan)
    bars = np.where(np.isfinite(bars), bars, np.inf)
    least = np.where(finite, errors - bars, -np.inf)
    most = np.where(finite, errors + bars, -np.inf)
    low, high = float(np.max(least)), float(np.max(most)) if finite.all() else np.inf
    word = word_for(low, high, tolerance)
    step = _first_largest(least if word == OUTSIDE else most, np.where(finite, errors, 0.0))
    if not np.isfinite(high):
        high = nan
    bar = float(bars[step]) if np.isfinite(bars[step]) else nan
    return Judgement(word, step, float(signed[step]), bar, low if np.isfinite(low) else nan, high)


def _first_largest(values: np.ndarray, errors: np.ndarray) -> int:
    """Return the first step whose value is the largest, to round-off.

    Steps that are alike by similarity must not change places with the processor. Where bars are
    unknown, the larger error tells more.
    """
    largest = np.max(values)
    if np.isposinf(largest):
        return _first_largest(np.where(np.isposinf(values), errors, -1.0), errors)
    return int(np.argmax(values >= largest - SAME * abs(largest)))


def word_for(low: float, high: float, tolerance: float) -> str:
    """Return the word for an error that lies between `low` and `high` (unknown ends: NaN).

    >>> word_for(0.01, 0.03, 0.05), word_for(0.01, 0.03, 0.005), word_for(0.01, 0.03, 0.02)
    ('within', 'outside', 'not resolved')
    """
    if high <= tolerance:
        return WITHIN
    return OUTSIDE if low > tolerance else NOT_RESOLVED


def judge(error: ArrayLike, uncertainty: ArrayLike, tolerance: float) -> str:
    """Return the word of `judged`.

    Examples
    --------
    >>> judge(0.004, 0.001, 0.01), judge(-0.02, 0.001, 0.01), judge(0.0095, 0.001, 0.01)
    ('within', 'outside', 'not resolved')
    >>> judge([0.001, 0.02], [0.0, 0.001], 0.01)
    'outside'
    >>> judge(float("nan"), 0.001, 0.01)
    'no result'
    """
    return judged(error, uncertainty, tolerance).word
