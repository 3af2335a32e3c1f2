"""Which method? The cheapest setting that meets a tolerance, bar included, and what others cost."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from comparisons.formatting import ROUND_OFF, duration, relative, tolerance
from comparisons.methods import METHODS
from comparisons.plain import plain
from comparisons.reference import main_axis
from comparisons.store import SceneRecord
from comparisons.verdicts import NO_RESULT, NOT_RESOLVED, OUTSIDE, WITHIN, judge

# The worst verdict over several quantities is the one that counts.
_WORST_FIRST = (NO_RESULT, OUTSIDE, NOT_RESOLVED, WITHIN)
_REACHED, _UNRESOLVED, _MISSED, _INCOMPLETE = _HEADINGS = (
    *("reached:", "not resolved:", "not reached by", "without all of these:"),
)


@dataclass(frozen=True)
class Setting:
    """One method at one resolution, and what was measured of it.

    Attributes
    ----------
    method, resolution : str, int
    seconds : float
    errors : dict
        Quantity -> rms relative error over the load steps; NaN where the method has none. Of the
        truth itself: its bar.
    verdict : str
        Over all quantities, each with its bar: "within", "outside", "not resolved" or
        "no result".
    certain : float
        The largest error over quantities and load steps with its bar: what is sure to be met.
    is_truth : bool
        Whether this is the solution that the others were compared with.
    """

    method: str
    resolution: int
    seconds: float
    errors: dict[str, float]
    verdict: str
    certain: float = float("nan")
    is_truth: bool = False

    @property
    def worst(self) -> float:
        """The largest error over the quantities; NaN if one is missing."""
        return float(np.max(list(self.errors.values()))) if self.errors else float("nan")

    @property
    def title(self) -> str:
        """The method's title, or the name of one that is not known here."""
        return METHODS[self.method].title if self.method in METHODS else self.method


@dataclass(frozen=True)
class Advice:
    """What a scene's measured results say about the choice of a method.

    Attributes
    ----------
    quantities : tuple of str
        What has to be within the tolerance.
    tolerance : float
    settings : tuple of Setting
        Everything that was measured, fastest first.
    sentence : str
        The advice in one sentence.
    """

    quantities: tuple[str, ...]
    tolerance: float
    settings: tuple[Setting, ...]
    sentence: str

    @property
    def cheapest(self) -> Setting | None:
        """The fastest setting that is sure to meet the tolerance; closed forms need no choice."""
        good = (each for each in self.settings if each.verdict == WITHIN)
        return next((each for each in good if each.method != "closed_form"), None)

    def times_to(self, wanted: float) -> dict[str, float]:
        """Return how long each method takes to be sure of an error, NaN where it never is.

        On each method's own time-error curve, as `time_at_error` reads it; the truth counts with
        its own bar. Methods of which nothing is known are left out.
        """
        found = {}
        for method in dict.fromkeys(each.method for each in self.settings):
            own = [each for each in self.settings if each.method == method]
            seconds, _ = _time_to(own, wanted, self.tolerance)
            truth = next((each for each in own if each.is_truth), None)
            if np.isnan(seconds) and truth is not None and truth.worst <= wanted:
                seconds = truth.seconds
            if np.isfinite(seconds) or any(np.isfinite(each.worst) for each in own):
                found[method] = seconds
        return found

    def document(self, scene: str) -> dict[str, Any]:
        """Return the advice as plain data for JSON; what is not known is None."""
        return plain(
            {
                "scene": scene,
                "tolerance": self.tolerance,
                "quantities": list(self.quantities),
                "sentence": self.sentence,
                "cheapest": None if self.cheapest is None else asdict(self.cheapest),
                "settings": [asdict(each) for each in self.settings],
            }
        )


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


def advise(record: SceneRecord) -> Advice:
    """Say which method to use for the compared quantities of a scene at its tolerance.

    Every quantity is taken at its main load (force at equal penetration, and so on). A setting
    meets the tolerance t only where |e| + u <= t at every load step, with u the bar. The truth
    itself is a setting too: it meets what its own bar is within.
    """
    quantities = tuple(q for q in record.quantities if q != "pressure")
    if not record.reference:
        text = "No 3-D method finished: there is no truth to compare with."
        return Advice(quantities, record.tolerance, (), text)
    known = tuple(q for q in quantities if _measured(record, q) or _bar(record, q) is not None)
    found = sorted(_settings(record, known), key=lambda each: each.seconds)
    if record.measures.empty:
        text = f"{record.reference['text']} Nothing else was run, so there is nothing to compare."
    else:
        text = _sentence(record, known, found)
    return Advice(known, record.tolerance, tuple(found), text)


def _settings(record: SceneRecord, quantities: tuple[str, ...]) -> Iterable[Setting]:
    if not record.measures.empty:
        for (method, resolution), own in record.measures.groupby(["method", "resolution"]):
            yield _setting(record, quantities, str(method), int(resolution), own)
    truth = _truth(record, quantities)
    if truth is not None:
        yield truth


def _setting(
    record: SceneRecord,
    quantities: tuple[str, ...],
    method: str,
    resolution: int,
    own: pd.DataFrame,
) -> Setting:
    errors, verdicts, certain = {}, [], []
    for name in quantities:
        row = own[(own["quantity"] == name) & (own["at"] == main_axis(record.along, name))]
        errors[name] = _first(row, "rms")
        verdicts.append(str(row["verdict"].iloc[0]) if "verdict" in row and len(row) else NO_RESULT)
        certain.append(_first(row, "maximum") + _first(row, "uncertainty"))
    verdict = next((each for each in _WORST_FIRST if each in verdicts), NO_RESULT)
    most = float(np.max(certain)) if certain else float("nan")
    return Setting(method, resolution, _first(own, "seconds"), errors, verdict, most)


def _first(rows: pd.DataFrame, name: str) -> float:
    """Return the first value of a column; NaN where there is none (folders may be a stranger's)."""
    values = pd.to_numeric(rows[name], errors="coerce") if name in rows else rows.iloc[:0]
    return float(values.iloc[0]) if len(values) else float("nan")


def _truth(record: SceneRecord, quantities: tuple[str, ...]) -> Setting | None:
    method, resolution = (record.reference.get(key) for key in ("method", "resolution"))
    rows = record.rows
    if rows.empty or "seconds" not in rows:
        return None
    own = rows[(rows["method"] == method) & (rows["resolution"] == resolution)]
    if own.empty:
        return None
    bars = {name: _bar(record, name) for name in quantities}
    errors = {name: float("nan") if bar is None else bar for name, bar in bars.items()}
    widest = max((np.inf if np.isnan(bar) else bar for bar in errors.values()), default=np.inf)
    verdict = judge(0.0, widest, record.tolerance)
    seconds = _first(own, "seconds")
    return Setting(str(method), int(resolution), seconds, errors, verdict, widest, True)


def _measured(record: SceneRecord, name: str) -> bool:
    table = record.measures
    if table.empty:
        return False
    own = table[(table["quantity"] == name) & (table["at"] == main_axis(record.along, name))]
    return bool(own["rms"].notna().any())


def _bar(record: SceneRecord, name: str) -> float | None:
    if record.reference.get("method") == "closed_form" and not _measured(record, name):
        return None
    bar: float | None = record.reference.get("uncertainty", {}).get(name)
    return bar


def _sentence(record: SceneRecord, quantities: tuple[str, ...], settings: list[Setting]) -> str:
    """Return the advice.

    For example: "For 1 % in force: reduced model 0.7 ms (N = 10), FFT BEM 16 ms (N = 16); not
    reached by ...; truth: ..., known to 0.03 %." N is the resolution.
    """
    told: dict[str, list[tuple[float, str]]] = {heading: [] for heading in _HEADINGS}
    for method in dict.fromkeys(each.method for each in settings):
        own = [each for each in settings if each.method == method]
        heading, seconds, text = _standing(own, record.tolerance)
        if heading:
            told[heading].append((seconds, text))
    text = f"For {tolerance(record.tolerance)} in {_words(quantities)}: "
    text += _list(told.pop(_REACHED)) or "no method is sure to get there"
    for heading, methods in told.items():
        text += f"; {heading} {_list(methods)}" if methods else ""
    return f"{text}; truth: {_known_to(record, quantities)}."


def _usual(own: list[Setting]) -> list[Setting]:
    """Return the settings that have an error, coarse to fine; the truth has none."""
    ascending = sorted(own, key=lambda each: each.resolution)
    return [each for each in ascending if not each.is_truth and np.isfinite(each.worst)]


def _time_to(own: list[Setting], wanted: float, asked: float) -> tuple[float, Setting | None]:
    """Return when the settings of one method are sure of an error, and the setting that is.

    A setting counts only where its bars are narrow enough to say so; for the error that was
    `asked`, its verdict says it.
    """
    usual = _usual(own)
    sure = [e.verdict == WITHIN if wanted == asked else e.certain <= wanted for e in usual]
    errors = [
        e.worst if s else max(e.worst, 1.01 * wanted) for e, s in zip(usual, sure, strict=True)
    ]
    times = np.array([each.seconds for each in usual])
    seconds, index = time_at_error(times, np.array(errors), wanted)
    return seconds, None if index is None else usual[index]


def _standing(own: list[Setting], wanted: float) -> tuple[str, float, str]:
    """Return under which heading a method stands, its time, and its words."""
    title = own[0].title
    usual = _usual(own)
    seconds, reaching = _time_to(own, wanted, wanted)
    if reaching is not None:
        return _REACHED, seconds, f"{title} {duration(seconds)} (N = {reaching.resolution})"
    truth = next((each for each in own if each.is_truth), None)
    if truth is not None and truth.method == "closed_form":
        return "", 0.0, ""
    if truth is not None and truth.verdict == WITHIN:
        text = f"{title} {duration(truth.seconds)} (N = {truth.resolution}, the truth itself)"
        return _REACHED, truth.seconds, text
    if not usual:
        return ("", 0.0, "") if truth is not None else (_INCOMPLETE, 0.0, title)
    best = min(each.worst for each in usual)
    if best <= wanted or NOT_RESOLVED in {each.verdict for each in usual}:
        return _UNRESOLVED, best, f"{title} ({'round-off' if best < ROUND_OFF else relative(best)})"
    return _MISSED, best, f"{title} (best {relative(best)})"


def _list(methods: list[tuple[float, str]]) -> str:
    return ", ".join(text for _, text in sorted(methods))


def _known_to(record: SceneRecord, quantities: tuple[str, ...]) -> str:
    method = record.reference["method"]
    if method == "closed_form":
        return "closed form"
    title = METHODS[method].title if method in METHODS else method
    bars = [bar for name in quantities if (bar := _bar(record, name)) is not None]
    ensemble = "realisation" in record.rows and (record.rows["realisation"] == "mean").any()
    of = "as a mean over the surfaces " if ensemble else ""
    known = f"{of}known to {relative(max(bars))}" if bars else "its error is not known"
    return f"{title} (N = {record.reference['resolution']}), {known}"


def _words(names: tuple[str, ...]) -> str:
    words = [name.replace("_", " ") for name in names]
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))
