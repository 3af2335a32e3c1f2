"""Experiments: measurements of statements that no single scene can decide.

Far fields, impacts, ensembles against a theory, a kernel as printed: an experiment is a function
that returns what a statement says beside what is true. A claim names it by ``experiment = NAME``
in place of a scene. Its first keyword is varied; the types of all say which values they take; the
first line of its docstring is its title::

    @experiment("far-field", "distance r/D")
    def far_field(
        effort: Effort, *, ratio: Annotated[float, Above(1)] = 2.0, reading: Literal["a", "b"] = "a"
    ) -> Finding:
        '''Displacement far from a contact.'''
"""

from __future__ import annotations

import inspect
import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from scipy import stats

from comparisons.errors import InputError
from comparisons.judging.metrics import relative_error
from comparisons.reasons import near

Effort = Literal["quick", "full"]
Details = dict[str, float | str]

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


@dataclass(frozen=True)
class Measurement:
    """A measured error of a statement.

    Attributes
    ----------
    parameter : float or None
        Value of the experiment's parameter, None without a parameter.
    error : float
        Signed error of the statement: what it states over the truth, less one; or a share that it
        says is none.
    uncertainty : float
        95 % half-width of `error` from all sources: the true error lies in
        [|error| - uncertainty, |error| + uncertainty].
    details : dict
        Additional information: measured numbers, parts of the uncertainty, text.
    seconds : float
        Time of the measurement.
    noun : str
        What `error` is called: "error", or "share" and the like, which have no sign.
    """

    parameter: float | None
    error: float
    uncertainty: float
    details: Details = field(default_factory=dict)
    seconds: float = 0.0
    noun: str = "error"


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
    details: Mapping[str, float | str]
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
    details: Mapping[str, float | str]
    noun: str = "share"

    @property
    def error(self) -> float:
        """The share itself."""
        return float(self.value)


Run = TypeVar("Run", bound=Callable[..., Finding | Share])


class Rule:
    """What a value of a parameter must be; part of its type, or asked for by `checked`."""

    def fault(self, name: str, value: Any) -> str:
        """Return what is wrong with a value, "" if nothing is."""
        raise NotImplementedError

    def checked(self, name: str, value: Any) -> None:
        """Raise ValueError for a wrong value."""
        fault = self.fault(name, value)
        if fault:
            raise ValueError(fault)


@dataclass(frozen=True)
class Above(Rule):
    """Finite and above a limit."""

    limit: float

    def fault(self, name: str, value: Any) -> str:
        """See `Rule`."""
        if math.isfinite(value) and value > self.limit:
            return ""
        return f"{name} must be finite and above {self.limit:g}, not {value!r}"


@dataclass(frozen=True)
class Between(Rule):
    """Between two limits, which it does not reach."""

    low: float
    high: float

    def fault(self, name: str, value: Any) -> str:
        """See `Rule`."""
        if self.low < value < self.high:
            return ""
        return f"{name} must be between {self.low:g} and {self.high:g}, not {value!r}"


class OneOf(Rule):
    """One of several names, as those of a table."""

    def __init__(self, *choices: str) -> None:
        self.choices = choices

    def fault(self, name: str, value: Any) -> str:
        """See `Rule`."""
        if value in self.choices:
            return ""
        return f"{name} must be one of {', '.join(self.choices)}, not {value!r}"


@dataclass(frozen=True)
class Experiment:
    """A named measurement as a function of its parameter.

    Attributes
    ----------
    name : str
        Slug used in claim files.
    title : str
        The measured quantity, in one sentence.
    along : str
        The keyword of the varied value; a claim may choose another one with
        ``parameters = { along = "..." }``.
    parameter : str
        The varied parameter in words, with its symbol ("distance over diameter s/D"); "" if none.
    run : callable
        ``run(effort, **parameters)`` returns a `Finding` or a `Share`; all parameters are keywords
        with defaults.
    """

    name: str
    title: str
    along: str
    parameter: str
    run: Callable[..., Finding | Share]

    @property
    def module(self) -> str:
        """The module that defines it."""
        return self.run.__module__

    @cached_property
    def defaults(self) -> Mapping[str, Any]:
        """What the function gets for parameters that are not given."""
        entries = list(inspect.signature(self.run).parameters.values())[1:]
        return {entry.name: entry.default for entry in entries}

    def arguments(self, value: float | None, parameters: Mapping[str, Any]) -> dict[str, Any]:
        """Return all that a measurement hangs on beside its effort, however it is spelled."""
        given = dict(parameters)
        along = given.pop("along", self.along)
        varied = {} if value is None else {along: value}
        return {
            key: float(entry) if isinstance(entry, int) and not isinstance(entry, bool) else entry
            for key, entry in {**self.defaults, **given, **varied}.items()
        }

    def measure(
        self, value: float | None, effort: Effort = "full", *, along: str = "", **parameters: Any
    ) -> Measurement:
        """Measure at a value of the parameter; `parameters` are those of the claim file.

        Raises
        ------
        InputError
            For a parameter that is unknown, of another type than its default, given twice, or
            refused.
        ArithmeticError
            For a result that is not finite.
        """
        along = along or self.along
        wrong = list(self._faults(value, effort, along, parameters))
        if wrong:
            raise InputError(f"experiment {self.name}: " + "; ".join(wrong))
        arguments = parameters if value is None else {**parameters, along: value}
        wrong = [
            f"{key} must be at most {_MOST[key]}, not {arguments[key]:g}"
            for key in _MOST.keys() & arguments.keys()
            if arguments[key] > _MOST[key]
        ]
        for name, hint in get_type_hints(self.run, include_extras=True).items():
            if name in arguments and get_origin(hint) is Literal:
                wrong.append(OneOf(*get_args(hint)).fault(name, arguments[name]))
            elif name in arguments and get_origin(hint) is Annotated:
                wrong += [limit.fault(name, arguments[name]) for limit in hint.__metadata__]
        if any(wrong):
            raise InputError(f"experiment {self.name}: " + "; ".join(filter(None, wrong)))
        started = time.perf_counter()
        try:
            finding = self.run(effort, **arguments)
        except ValueError as fault:
            raise InputError(f"experiment {self.name}: {fault}") from fault
        if not (math.isfinite(finding.error) and math.isfinite(finding.uncertainty)):
            raise ArithmeticError(
                f"experiment {self.name}: {finding.error} +- {finding.uncertainty}"
            )
        details = dict(finding.details)
        if isinstance(finding, Finding):
            details |= {"stated": float(finding.stated), "true": float(finding.true)}
        return Measurement(
            parameter=None if value is None else float(value),
            error=float(finding.error),
            uncertainty=float(finding.uncertainty),
            details=details,
            seconds=time.perf_counter() - started,
            noun=finding.noun,
        )

    def _faults(
        self, value: float | None, effort: str, along: str, parameters: dict[str, Any]
    ) -> Iterator[str]:
        """Yield what is wrong with the names and the types of parameters."""
        for name in (along, *parameters):
            if name not in self.defaults:
                known = list(self.defaults)
                hint = near(name, known) or f"; known: {', '.join(known)}"
                yield f"no parameter {name!r}{hint}"
        for name, given in parameters.items():
            default = self.defaults.get(name, given)
            if isinstance(default, bool):
                alike, kind = isinstance(given, bool), "true or false"
            elif isinstance(default, str):
                alike, kind = isinstance(given, str), "a text"
            else:
                number = isinstance(given, (int, float)) and not isinstance(given, bool)
                alike, kind = number, "a number"
            if not alike:
                yield f"{name} must be {kind}, not {given!r}"
        if effort not in ("quick", "full"):
            yield f"effort is 'quick' or 'full', not {effort!r}"
        if value is not None and along in parameters:
            yield f"{along} is varied and given, too"


EXPERIMENTS: dict[str, Experiment] = {}


def experiment(name: str, parameter: str = "") -> Callable[[Run], Run]:
    """Make a function known as an experiment, see `Experiment`."""

    def known(run: Run) -> Run:
        title = (run.__doc__ or f"{name}.").partition("\n")[0].removesuffix(".")
        _, along, *_ = (*inspect.signature(run).parameters, "")
        EXPERIMENTS[name] = Experiment(name, title, along, parameter, run)
        return run

    return known


def worst(stated: np.ndarray, true: np.ndarray) -> tuple[float, float]:
    """Return the stated and the true value where the relative error is the largest.

    >>> worst(np.array([1.0, 1.5, 3.0]), np.array([1.0, 2.0, 2.9]))
    (1.5, 2.0)
    """
    place = np.argmax(np.abs(relative_error(stated, true)))
    return float(stated.flat[place]), float(true.flat[place])


def share_of(number: int, count: int, details: Mapping[str, float | str]) -> Share:
    """Return the share of `count` independent runs, with the 95 % interval of Clopper and Pearson.

    The interval is one-sided at none and all.
    """
    level = 0.90 if number in (0, count) else 0.95
    interval = stats.binomtest(number, count).proportion_ci(level, method="exact")
    share = number / count
    return Share(share, float(max(share - interval.low, interval.high - share)), details)


def number_of(realisations: float, effort: str, quick: int) -> int:
    """Return how many realisations are drawn: all asked for at full effort, else at most `quick`.

    >>> number_of(60, "full", 12), number_of(60, "quick", 12), number_of(8, "quick", 12)
    (60, 12, 8)
    """
    return int(realisations) if effort == "full" else min(int(realisations), quick)
