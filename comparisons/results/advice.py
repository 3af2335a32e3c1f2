"""Choice of a method: the cheapest setting that was run and meets a tolerance, bar included.

All times are measured at the resolutions that were run, without interpolation.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from comparisons.facts.methods import CLOSED_FORM, title_of
from comparisons.facts.quantities import quantity
from comparisons.files import plain
from comparisons.formatting import duration, relative, tolerance
from comparisons.judging.multilevel import in_words
from comparisons.judging.verdicts import NO_RESULT, NOT_RESOLVED, OUTSIDE, WITHIN, judged
from comparisons.results import selection
from comparisons.results.decisions import (
    Verdict,
    equal_at,
    finest,
    levels,
    setting_verdicts,
    unanswered,
    worst,
)
from comparisons.results.runs import SLOWER
from comparisons.results.store import SceneRecord, once


@dataclass(frozen=True)
class Setting:
    """One method at one resolution, with its measured time and errors.

    Attributes
    ----------
    method, resolution : str, int
    seconds : float
    verdicts : tuple of Verdict
        One per asked quantity. Of the truth itself: no error, and its bar.
    is_truth : bool
        Whether this is the solution that the others were compared with.
    """

    method: str
    resolution: int
    seconds: float
    verdicts: tuple[Verdict, ...]
    is_truth: bool = False

    @property
    def deciding(self) -> Verdict:
        """The verdict that decides over all quantities."""
        return worst(self.verdicts)

    @property
    def verdict(self) -> str:
        """Over all quantities: "within", "outside", "not resolved" or "no result"."""
        return self.deciding.word

    @property
    def title(self) -> str:
        """The method's title, or the name of one that is not known here."""
        return title_of(self.method)

    @property
    def text(self) -> str:
        """Method, time and resolution."""
        truth = ", the truth itself" if self.is_truth else ""
        return f"{self.title} {duration(self.seconds)} (N = {self.resolution}{truth})"

    @property
    def worst(self) -> float:
        """The largest error over the quantities, of the truth its bar; NaN if one is missing."""
        sizes = [verdict.high if self.is_truth else abs(verdict.error) for verdict in self.counted]
        return float(np.max(sizes)) if sizes else math.nan

    @property
    def counted(self) -> tuple[Verdict, ...]:
        """The verdicts on quantities that can be answered."""
        return tuple(verdict for verdict in self.verdicts if verdict.counts)

    def holds(self, error: float) -> bool:
        """Tell whether |e| + u is at most `error` in every quantity and at every load step."""
        return bool(self.counted) and all(verdict.high <= error for verdict in self.counted)


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
    finest : dict
        Method -> the resolution that its verdict stands on; none for the truth alone.
    unanswered : dict
        Asked quantities that nothing here can answer -> why.
    """

    quantities: tuple[str, ...]
    tolerance: float
    settings: tuple[Setting, ...] = ()
    sentence: str = ""
    finest: dict[str, int] = field(default_factory=dict)
    unanswered: dict[str, str] = field(default_factory=dict)

    @property
    def cheapest(self) -> Setting | None:
        """The fastest setting that is sure to meet the tolerance; closed forms need no choice."""
        return next(iter(self.reaching()), None)

    def reaching(self) -> list[Setting]:
        """Return the cheapest setting of each method for the tolerance, fastest first."""
        reached = self.cheapest_for(self.tolerance)
        choices = [setting for name, setting in reached.items() if setting and name != CLOSED_FORM]
        return sorted(choices, key=_by_time)

    def cheapest_for(self, error: float) -> dict[str, Setting | None]:
        """Return the cheapest setting that was run of each method that is sure of an error.

        A setting counts if it holds the error and so do all finer ones of its method: a coarse
        grid whose errors happen to cancel is no way to get there. The truth counts with its own
        bar, where no other setting of its method will do.
        """
        cheapest = {}
        for method in dict.fromkeys(setting.method for setting in self.settings):
            settings = [setting for setting in self.settings if setting.method == method]
            truth = [setting for setting in settings if setting.is_truth and setting.holds(error)]
            sure = [*self._sure(settings, error)] or truth
            cheapest[method] = min(sure, key=_by_time) if sure else None
        return cheapest

    def _sure(self, settings: list[Setting], error: float) -> Iterable[Setting]:
        compared = [
            s for s in settings if not s.is_truth and s.resolution <= self._finest_of(s.method)
        ]
        for setting in sorted(compared, key=lambda s: s.resolution, reverse=True):
            if setting.holds(error):
                yield setting
            elif setting.verdict != NO_RESULT or setting.resolution == self._finest_of(
                setting.method
            ):
                return

    def _finest_of(self, method: str) -> int:
        return self.finest.get(method, -1)

    def document(self, scene: str) -> dict[str, Any]:
        """Return the advice as plain data for JSON; what is not known is None."""
        return plain(
            {
                "scene": scene,
                "tolerance": self.tolerance,
                "quantities": list(self.quantities),
                "unanswered": self.unanswered,
                "sentence": self.sentence,
                "cheapest": None if self.cheapest is None else _document(self.cheapest),
                "settings": [_document(setting) for setting in self.settings],
            }
        )


def _document(setting: Setting) -> dict[str, Any]:
    names = ("quantity", "at", "step", "error", "uncertainty", "rms", "word", "reason")
    return {
        "method": setting.method,
        "resolution": setting.resolution,
        "seconds": setting.seconds,
        "verdict": setting.verdict,
        "decided_by": setting.deciding.quantity,
        "is_truth": setting.is_truth,
        "verdicts": [
            {name: getattr(verdict, name) for name in names} for verdict in setting.verdicts
        ],
    }


def _by_time(setting: Setting) -> float:
    return setting.seconds if math.isfinite(setting.seconds) else math.inf


@once
def advise(record: SceneRecord) -> Advice:
    """Say which method to use for the asked quantities of a scene at its tolerance.

    A setting meets the tolerance t where |e| + u <= t in every quantity and at every load step,
    with u the bar (`comparisons.results.decisions`). The truth itself is a setting too: it meets
    what its own bar is within.
    """
    nothing = unanswered(record)
    judged_quantities = tuple(name for name in record.quantities if name not in nothing)
    settings = tuple(sorted(_settings(record), key=_by_time))
    depths = {name: finest(record, name) for name in selection.methods(record)}
    deepest = {name: level for name, level in depths.items() if level is not None}
    advice = Advice(judged_quantities, record.tolerance, settings, "", deepest, nothing)
    return Advice(
        judged_quantities, record.tolerance, settings, _sentence(record, advice), deepest, nothing
    )


def _settings(record: SceneRecord) -> Iterable[Setting]:
    for method in selection.methods(record):
        for level in levels(record, method):
            verdicts = setting_verdicts(record, method, level)
            yield Setting(method, level, _seconds(record, method, level), verdicts)
    truth = _truth(record)
    if truth is not None:
        yield truth


def _seconds(record: SceneRecord, method: str, resolution: float) -> float:
    """Return the time of a setting; NaN where there is none (folders may be a stranger's)."""
    values = selection.column(selection.setting_rows(record, method, resolution), "seconds")
    return float(values[0]) if len(values) else math.nan


def _truth(record: SceneRecord) -> Setting | None:
    method, resolution = selection.reference(record)
    if not method or not math.isfinite(resolution):
        return None
    bars = tuple(_truth_verdict(record, name) for name in record.quantities)
    return Setting(method, int(resolution), _seconds(record, method, resolution), bars, True)


def _truth_verdict(record: SceneRecord, name: str) -> Verdict:
    at, nothing = equal_at(record, name), unanswered(record)
    bars = record.reference.get("bars", {}).get(name, {})
    bar = bars.get("bar", record.reference.get("uncertainty", {}).get(name))
    if name in nothing:
        reason = nothing[name]
        return Verdict(name, at, NO_RESULT, record.tolerance, reason=reason, counts=False)
    verdict = judged(0.0, math.nan if bar is None else bar, record.tolerance)
    return Verdict(
        name,
        at,
        verdict.word,
        record.tolerance,
        step=bars.get("step", -1),
        error=0.0,
        uncertainty=verdict.uncertainty,
        low=verdict.low,
        high=verdict.high,
    )


def _sentence(record: SceneRecord, advice: Advice) -> str:
    """Return the advice.

    For example: "For 1 % in force: reduced model 0.7 ms (N = 10), FFT BEM 16 ms (N = 16); outside:
    dense BEM (force 1.5 % at load step 1, N = 20); truth: ..., known to 0.03 %." N is the
    resolution.
    """
    text = str(record.reference.get("text") or "")
    if not record.reference:
        return "No 3-D method finished, so no reference is available."
    if all(setting.is_truth for setting in advice.settings):
        return f"{text} Nothing else was run, so there is nothing to compare."
    left = _left_over(advice.unanswered)
    if not advice.quantities:
        return f"None of the requested quantities can be judged{left}."
    advice_text = f"For {tolerance(record.tolerance)} in {_enumeration(advice.quantities)}: "
    advice_text += _ranked(advice.reaching()) or "no setting that was run is within tolerance"
    for word, methods in _failing(advice).items():
        advice_text += f"; {word}: {', '.join(methods)}" if methods else ""
    return f"{advice_text}{left}; truth: {_truth_words(record, advice.quantities)}."


def _left_over(nothing: dict[str, str]) -> str:
    reasons = [f"{quantity(name).label} ({reason})" for name, reason in nothing.items()]
    return f"; not judged: {', '.join(reasons)}" if reasons else ""


def _ranked(settings: list[Setting]) -> str:
    """Return settings fastest first; what lies closer than times repeat is not ranked."""
    groups: list[list[Setting]] = []
    for setting in settings:
        if groups and setting.seconds <= SLOWER * groups[-1][0].seconds:
            groups[-1].append(setting)
        else:
            groups.append([setting])
    return ", ".join(
        " or ".join(setting.text for setting in group)
        + (" (too close to rank)" if group[1:] else "")
        for group in groups
    )


def _failing(advice: Advice) -> dict[str, list[str]]:
    """Return word -> methods that have no setting for the tolerance, each with what decided."""
    failures: dict[str, list[str]] = {word: [] for word in (NOT_RESOLVED, OUTSIDE, NO_RESULT)}
    for method, reached in advice.cheapest_for(advice.tolerance).items():
        settings = [s for s in advice.settings if s.method == method and not s.is_truth]
        finest_one = [s for s in settings if s.resolution == advice.finest.get(method)]
        if reached is not None or method == CLOSED_FORM or not finest_one:
            continue
        (last,) = finest_one
        luck = [s.resolution for s in settings if s.verdict == WITHIN and last.verdict == OUTSIDE]
        chance = f"; within by chance at N = {min(luck)}" if luck else ""
        level = "" if last.verdict == NO_RESULT else f", N = {last.resolution}"
        failures[last.verdict].append(f"{last.title} ({last.deciding.text}{level}{chance})")
    return failures


def truth_known_to(record: SceneRecord, quantities: tuple[str, ...]) -> float:
    """Return how well the truth is known in the worst of some quantities, NaN where unknown."""
    uncertainties = record.reference.get("uncertainty", {})
    truth_bars = record.reference.get("bars", {})
    bars = [uncertainties.get(name) or truth_bars.get(name, {}).get("bar") for name in quantities]
    return float(max((bar for bar in bars if bar is not None), default=math.nan))


def _truth_words(record: SceneRecord, quantities: tuple[str, ...]) -> str:
    method = str(record.reference["method"])
    if method == CLOSED_FORM:
        return "closed form"
    bar = truth_known_to(record, quantities)
    accuracy = f"known to {relative(bar)}" if math.isfinite(bar) else _unknown(record, method)
    ensemble = _ensemble(selection.solved_rows(record, method))
    level = f"mean over {ensemble}" if ensemble else f"N = {record.reference['resolution']}"
    return f"{title_of(method)} ({level}), {accuracy}"


def _unknown(record: SceneRecord, method: str) -> str:
    """Return that an error is not known, and why."""
    grids = set(selection.column(selection.solved_rows(record, method), "resolution"))
    alone = ": only one resolution was run" if len(grids) == 1 else ""
    return f"its error is not known{alone}"


def _ensemble(rows: pd.DataFrame) -> str:
    """Return how many surfaces a method solved on which grid; "" where there is one surface."""
    means = rows[[text == selection.MEAN for text in selection.texts(rows, "realisation")]]
    if means.empty or "surfaces" not in means:
        return ""
    numbers = means.groupby("resolution")["surfaces"].first()
    return in_words([int(n) for n in numbers], [int(n) for n in numbers.index])


def _enumeration(names: tuple[str, ...]) -> str:
    labels = [quantity(name).label for name in names]
    return " and ".join(filter(None, [", ".join(labels[:-1]), labels[-1]]))
