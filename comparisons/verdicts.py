"""Verdicts: does an error hold a tolerance, given how well the truth is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

WITHIN, OUTSIDE, NOT_RESOLVED, NO_RESULT = "within", "outside", "not resolved", "no result"


def judge(error: ArrayLike, uncertainty: ArrayLike, tolerance: float) -> str:
    """Return the verdict on errors at one or several load steps.

    With e an error and u the 95 % half-width of its bar: "within" if |e| + u <= t at every step,
    "outside" if |e| - u > t at any, else "not resolved". An unknown bar resolves nothing, nor does
    a step without an error; if there are only such steps there is "no result".

    Examples
    --------
    >>> judge(0.004, 0.001, 0.01), judge(-0.02, 0.001, 0.01), judge(0.0095, 0.001, 0.01)
    ('within', 'outside', 'not resolved')
    >>> judge([0.001, 0.02], [0.0, 0.001], 0.01)
    'outside'
    >>> judge(float("nan"), 0.001, 0.01)
    'no result'
    """
    errors = np.abs(np.atleast_1d(np.asarray(error, dtype=float)))
    bars = np.broadcast_to(np.asarray(uncertainty, dtype=float), errors.shape)
    known = np.isfinite(errors)
    if not known.any():
        return NO_RESULT
    bars = np.where(np.isfinite(bars) & known, bars, np.inf)
    errors = np.where(known, errors, 0.0)
    if np.all(errors + bars <= tolerance):
        return WITHIN
    return OUTSIDE if np.any(errors - bars > tolerance) else NOT_RESOLVED
