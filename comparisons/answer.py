"""The one-sentence answer of a scene: the cost of knowing it to the asked tolerance."""

from __future__ import annotations

import numpy as np
import pandas as pd

from comparisons.comparison import main_axis
from comparisons.formatting import duration, relative, tolerance
from comparisons.methods import METHODS
from comparisons.metrics import rms_and_maximum
from comparisons.reference import EXACT, Reference


def time_at_error(
    seconds: np.ndarray, errors: np.ndarray, wanted: float
) -> tuple[float, int | None]:
    """Return the least time at which a method's own time-error curve reaches an error.

    Points are joined in the order given (coarse to fine), straight in logarithms; nothing is
    extrapolated: a method that never reaches the error gives NaN.

    Returns
    -------
    (float, int or None)
        The time, and the index of the setting that reaches the error.

    Examples
    --------
    >>> t, e = np.array([1.0, 10.0]), np.array([0.1, 0.001])
    >>> seconds, index = time_at_error(t, e, 0.01)
    >>> round(seconds, 6), index
    (3.162278, 1)
    >>> time_at_error(t, e, 1e-4)
    (nan, None)
    """
    found = [(float(seconds[i]), i) for i in range(len(errors)) if errors[i] <= wanted]
    for i in range(len(errors) - 1):
        high, low = errors[i], errors[i + 1]
        if high > wanted > low > 0:
            share = np.log(high / wanted) / np.log(high / low)
            crossing = np.log(seconds[i]) + share * np.log(seconds[i + 1] / seconds[i])
            found.append((float(np.exp(crossing)), i + 1))
    return min(found, default=(float("nan"), None))


def answer(
    quantities: tuple[str, ...],
    control: str,
    wanted: float,
    measures: pd.DataFrame,
    reference: Reference | None,
) -> str:
    """Return the sentence for the first compared quantity that has an error.

    For example: "For 1 % in force: reduced model 0.7 ms (N = 10), FFT BEM 16 ms (N = 16); not
    reached by ...; truth: ..., known to 0.03 %." N is the resolution.
    """
    if reference is None:
        return "No 3-D method finished: there is no truth to compare with."
    for name in quantities:
        at = main_axis(control, name)
        if measures.empty:
            break
        table = measures[(measures["quantity"] == name) & (measures["at"] == at)]
        if table["rms"].notna().any():
            return _sentence(name, wanted, table, reference)
    return f"{reference.text} Nothing else was run, so there is nothing to compare."


def _sentence(name: str, wanted: float, table: pd.DataFrame, reference: Reference) -> str:
    reached, missed = [], []
    for method in [m for m in METHODS if m in set(table["method"])]:
        own = table[table["method"] == method].sort_values("resolution")
        own = own[own["rms"].notna()]
        if own.empty:
            continue
        errors = own["rms"].to_numpy()
        seconds, index = time_at_error(own["seconds"].to_numpy(), errors, wanted)
        if index is not None:
            level = int(own["resolution"].iloc[index])
            reached.append((seconds, f"{METHODS[method].title} {duration(seconds)} (N = {level})"))
        else:
            missed.append(f"{METHODS[method].title} (best {relative(float(errors.min()))})")
    words = name.replace("_", " ")
    text = f"For {tolerance(wanted)} in {words}: "
    text += ", ".join(each for _, each in sorted(reached)) or "no method got there"
    if missed:
        text += "; not reached by " + ", ".join(missed)
    truth = f"{METHODS[reference.method].title} (N = {reference.resolution})"
    bar = reference.uncertainty.get(name)
    if bar is None or not np.isfinite(bar).any():
        return text + f"; truth: {truth}, its error is not known."
    usual, _ = rms_and_maximum(bar)
    if usual <= EXACT:
        return text + "; truth: closed form."
    return text + f"; truth: {truth}, known to {relative(usual)}."
