"""Construction of an `Experiment` from a function: checks, timing, the varied parameter."""

from __future__ import annotations

import inspect
import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy import stats

from comparisons.errors import InputError
from comparisons.judging.metrics import relative_error
from comparisons.questions.experiments.base import Effort, Experiment, Measurement
from comparisons.reasons import near

# Upper limits of counts, against exhausted memory and endless runs.
_MOST = {
    "points": 2048,
    "line_points": 10**6,
    "line_length": 1024,
    "offset": 4096,
    "per_side": 1000,
    "realisations": 10**5,
    "runs": 10**5,
    "cycles": 1000,
    "per_wave": 256,
}


Details = dict[str, float | str]


@dataclass(frozen=True)
class Finding:
    """One quantity as the statement has it and as it is; the error is formed here alone.

    Attributes
    ----------
    stated, true : float
        Both of the quantity that the claim names.
    uncertainty : float
        95 % half-width of the error.
    details : dict
        Further numbers and text for the report.
    of : float or None
        What the difference is relative to; by default the truth.
    """

    stated: float
    true: float
    uncertainty: float
    details: Details
    of: float | None = None

    noun: ClassVar[str] = "error"

    @property
    def error(self) -> float:
        """Stated over true, less one."""
        if self.of is not None:
            return float((self.stated - self.true) / self.of)
        return float(relative_error(np.array(self.stated), np.array(self.true)))


@dataclass(frozen=True)
class Share:
    """What the statement says is none, of a whole: energy that is lost, patches that fail.

    Attributes
    ----------
    value, uncertainty : float
        With the 95 % half-width.
    details : dict
        As of `Finding`.
    noun : str
        What it is called instead: the largest "deviation" along a course, of its largest value.
    """

    value: float
    uncertainty: float
    details: Details
    noun: str = "share"

    @property
    def error(self) -> float:
        """The share itself."""
        return float(self.value)


Run = Callable[..., Finding | Share]


def worst(stated: np.ndarray, true: np.ndarray) -> tuple[float, float]:
    """Return the stated and the true value where the relative error is the largest.

    >>> worst(np.array([1.0, 1.5, 3.0]), np.array([1.0, 2.0, 2.9]))
    (1.5, 2.0)
    """
    place = np.argmax(np.abs(relative_error(stated, true)))
    return float(stated.flat[place]), float(true.flat[place])


def share_of(number: int, count: int, details: Details) -> Share:
    """Return the share of `count` independent runs, with the 95 % interval of Clopper and Pearson.

    The interval is one-sided at none and all.
    """
    level = 0.90 if number in (0, count) else 0.95
    interval = stats.binomtest(number, count).proportion_ci(level, method="exact")
    share = number / count
    return Share(share, float(max(share - interval.low, interval.high - share)), details)


def experiment(name: str, title: str, parameter: str, along: str, run: Run) -> Experiment:
    """Return the experiment that calls ``run(effort, **parameters)``.

    Parameters
    ----------
    name, title, parameter : str
        As for `Experiment`: a slug, a sentence, the varied parameter in words.
    along : str
        Keyword argument of the varied value; a claim file may choose another one with
        ``parameters = { along = "..." }``.
    run : callable
        ``run(effort, **parameters)`` returns a `Finding` or a `Share`; all parameters are keywords
        with defaults.

    Notes
    -----
    ``measure`` raises InputError for a parameter that is unknown, of another type than its default,
    given twice, or refused by `run` (ValueError); ArithmeticError for a result that is not finite.
    """
    entries = list(inspect.signature(run).parameters.values())[1:]
    defaults = {entry.name: entry.default for entry in entries}
    default = along

    def measure(
        value: float | None, effort: Effort = "full", *, along: str = default, **parameters: Any
    ) -> Measurement:
        wrong = [
            *_unknown(list(defaults), [along, *parameters]),
            *_of_other_types(defaults, parameters),
        ]
        if effort not in ("quick", "full"):
            wrong.append(f"effort is 'quick' or 'full', not {effort!r}")
        if value is not None and along in parameters:
            wrong.append(f"{along} is varied and given, too")
        if wrong:
            raise InputError(f"experiment {name}: " + "; ".join(wrong))
        arguments = parameters if value is None else {**parameters, along: value}
        wrong += [
            f"{key} must be at most {_MOST[key]}, not {arguments[key]:g}"
            for key in _MOST.keys() & arguments.keys()
            if arguments[key] > _MOST[key]
        ]
        if wrong:
            raise InputError(f"experiment {name}: " + "; ".join(wrong))
        started = time.perf_counter()
        try:
            finding = run(effort, **arguments)
        except ValueError as fault:
            raise InputError(f"experiment {name}: {fault}") from fault
        if not (math.isfinite(finding.error) and math.isfinite(finding.uncertainty)):
            raise ArithmeticError(f"experiment {name}: {finding.error} +- {finding.uncertainty}")
        return Measurement(
            parameter=None if value is None else float(value),
            error=float(finding.error),
            uncertainty=float(finding.uncertainty),
            details=finding.details
            | (
                {"stated": float(finding.stated), "true": float(finding.true)}
                if isinstance(finding, Finding)
                else {}
            ),
            seconds=time.perf_counter() - started,
            noun=finding.noun,
        )

    return Experiment(name, title, parameter, measure, defaults, default)


def _unknown(parameters: list[str], names: Iterable[str]) -> Iterable[str]:
    for name in names:
        if name not in parameters:
            hint = near(name, parameters) or f"; known: {', '.join(parameters)}"
            yield f"no parameter {name!r}{hint}"


def _of_other_types(defaults: dict[str, Any], arguments: dict[str, Any]) -> Iterable[str]:
    """Return messages for values whose type differs from that of their defaults."""
    for name, value in arguments.items():
        default = defaults.get(name, value)
        if isinstance(default, bool):
            alike, kind = isinstance(value, bool), "true or false"
        elif isinstance(default, str):
            alike, kind = isinstance(value, str), "a text"
        else:
            number = isinstance(value, (int, float)) and not isinstance(value, bool)
            alike, kind = number, "a number"
        if not alike:
            yield f"{name} must be {kind}, not {value!r}"


def one_of(name: str, value: str, *choices: str) -> str:
    """Return the value, or raise ValueError with the choices."""
    if value not in choices:
        raise ValueError(f"{name} must be one of {', '.join(choices)}, not {value!r}")
    return value


def above(name: str, value: float, limit: float) -> float:
    """Return the value as a float, or raise ValueError unless it is finite and above the limit."""
    if not (math.isfinite(value) and value > limit):
        raise ValueError(f"{name} must be finite and above {limit:g}, not {value!r}")
    return float(value)


def number_of(realisations: float, effort: str, quick: int) -> int:
    """Return how many realisations are drawn: all asked for at full effort, else at most `quick`.

    >>> number_of(60, "full", 12), number_of(60, "quick", 12), number_of(8, "quick", 12)
    (60, 12, 8)
    """
    return int(realisations) if effort == "full" else min(int(realisations), quick)
