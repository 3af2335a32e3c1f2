"""The one-sentence answer of a scene: the cost of knowing it to the asked tolerance."""

from __future__ import annotations

import numpy as np
import pandas as pd

from comparisons.formatting import duration, relative, tolerance
from comparisons.methods import METHODS
from comparisons.reference import Reference, known_to, main_axis
from comparisons.verdicts import NOT_RESOLVED, WITHIN


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
    reached by ...; truth: ..., known to 0.03 %." N is the resolution. A setting reaches the
    tolerance only where its verdict is "within": with the bar.
    """
    if reference is None:
        return "No 3-D method finished: there is no truth to compare with."
    for name in quantities:
        at = main_axis(control, name)
        if measures.empty:
            break
        table = measures[(measures["quantity"] == name) & (measures["at"] == at)]
        if table["rms"].notna().any():
            return _sentence(control, name, wanted, table, reference)
    return f"{reference.text} Nothing else was run, so there is nothing to compare."


def _sentence(
    control: str, name: str, wanted: float, table: pd.DataFrame, reference: Reference
) -> str:
    reached, unresolved, missed = [], [], []
    for method in [m for m in METHODS if m in set(table["method"])]:
        own = table[table["method"] == method].sort_values("resolution")
        own = own[own["rms"].notna()]
        if own.empty:
            continue
        title, errors = METHODS[method].title, own["rms"].to_numpy()
        # A setting counts only where its bar is narrow enough to say so.
        sure = np.where(own["verdict"] == WITHIN, errors, np.maximum(errors, 1.01 * wanted))
        seconds, index = time_at_error(own["seconds"].to_numpy(), sure, wanted)
        if index is not None:
            level = int(own["resolution"].iloc[index])
            reached.append((seconds, f"{title} {duration(seconds)} (N = {level})"))
        elif errors.min() <= wanted or NOT_RESOLVED in set(own["verdict"]):
            unresolved.append(f"{title} ({relative(float(errors.min()))})")
        else:
            missed.append(f"{title} (best {relative(float(errors.min()))})")
    text = f"For {tolerance(wanted)} in {name.replace('_', ' ')}: "
    text += ", ".join(each for _, each in sorted(reached)) or "no method is sure to get there"
    if unresolved:
        text += "; not resolved: " + ", ".join(unresolved)
    if missed:
        text += "; not reached by " + ", ".join(missed)
    return text + f"; truth: {_truth(control, name, reference)}."


def _truth(control: str, name: str, reference: Reference) -> str:
    if reference.method == "closed_form":
        return "closed form"
    title = f"{METHODS[reference.method].title} (N = {reference.resolution})"
    bar = known_to(control, reference, name)
    known = f"known to {relative(bar)}" if np.isfinite(bar) else "its error is not known"
    return f"{title}, {known}"
