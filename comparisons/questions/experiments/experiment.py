"""Experiments: measurements of statements that no single scene can decide.

Far fields, impacts, ensembles against a theory, a kernel as printed: an experiment is a function
that returns what a statement says beside what is true. A claim names it by ``experiment = NAME``
in place of a scene. Its first keyword is varied; the types of all say which values they take; the
first line of its docstring is its title::

    @experiment("far-field", "distance r/D")
    def far_field(
        effort: Effort, *, ratio: Positive = 2.0, reading: Literal["a", "b"] = "a"
    ) -> Finding:
        '''Displacement far from a contact.'''
"""

from __future__ import annotations

import inspect
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, TypeVar, get_type_hints

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, create_model
from scipy import stats

from comparisons.errors import InputError
from comparisons.judging.metrics import relative_error
from comparisons.reasons import near
from comparisons.scene.fields import fail
from comparisons.scene.problems import in_file

Effort = Literal["quick", "full"]
Details = dict[str, float | str]


@dataclass(frozen=True)
class Measurement:
    """A measured error of a statement."""

    parameter: float | None  # value of the experiment's parameter, None without a parameter
    # Signed error of the statement: what it states over the truth, less one; or a share that it
    # says is none.
    error: float
    # 95 % half-width of `error` from all sources: the true error lies in [|error| - uncertainty,
    # |error| + uncertainty].
    uncertainty: float
    # Additional information: measured numbers, parts of the uncertainty, text.
    details: Details = field(default_factory=dict)
    seconds: float = 0.0  # time of the measurement
    # What `error` is called: "error", or "share" and the like, which have no sign.
    noun: str = "error"


@dataclass(frozen=True)
class Finding:
    """One quantity as the statement has it and as it is; the error is formed here alone."""

    # Both of the quantity that the claim names.
    stated: float
    true: float
    uncertainty: float  # 95 % half-width of the error
    details: Mapping[str, float | str]  # further numbers and text for the report
    of: float | None = None  # what the difference is relative to; by default the truth

    noun: ClassVar[str] = "error"

    @property
    def error(self) -> float:
        """Stated over true, less one."""
        if self.of is not None:
            return float((self.stated - self.true) / self.of)
        return float(relative_error(np.array(self.stated), np.array(self.true)))


@dataclass(frozen=True)
class Share:
    """What the statement says is none, of a whole: energy that is lost, patches that fail."""

    value: float
    uncertainty: float  # 95 % half-width
    details: Mapping[str, float | str]  # as of `Finding`
    # What it is called instead: the largest "deviation" along a course, of its largest value.
    noun: str = "share"

    @property
    def error(self) -> float:
        """The share itself."""
        return float(self.value)


Run = TypeVar("Run", bound=Callable[..., Finding | Share])

# Types of keywords: what a claim's file may give them. Upper limits of counts are against exhausted
# memory and endless runs.
Positive = Annotated[float, Field(gt=0)]
Fraction = Annotated[float, Field(gt=0, lt=1)]
Points = Annotated[int, Field(strict=False, gt=3, le=2048)]
Count = Annotated[int, Field(strict=False, gt=2, le=100_000)]


def one_of(*choices: str) -> AfterValidator:
    """Return a rule for the type of a text: one of several names, as those of a table."""

    def chosen(value: str) -> str:
        if value not in choices:
            raise fail(f"expected one of {', '.join(choices)}", value)
        return value

    return AfterValidator(chosen)


@dataclass(frozen=True)
class Experiment:
    """A named measurement as a function of its parameter."""

    name: str  # slug used in claim files
    title: str  # the measured quantity, in one sentence
    # The varied parameter in words, with its symbol ("distance over diameter s/D"); "" if none.
    parameter: str
    # ``run(effort, **parameters)`` returns a `Finding` or a `Share`; all parameters are keywords
    # with defaults.
    run: Callable[..., Finding | Share]
    varied: str = ""  # the keyword of the varied value, if it is not the first

    @property
    def along(self) -> str:
        """The keyword of the varied value; a claim may choose another one by its `along`."""
        return self.varied or next(iter(self.defaults), "")

    @cached_property
    def defaults(self) -> Mapping[str, Any]:
        """What the function gets for parameters that are not given."""
        return {name: field.default for name, field in self._keywords.model_fields.items()}

    @cached_property
    def _groups(self) -> dict[str, Any]:
        """Keywords that stand for several, the fields of a dataclass, as those of a surface."""
        entries = inspect.signature(self.run).parameters.values()
        return {entry.name: entry.default for entry in entries if is_dataclass(entry.default)}

    @cached_property
    def _keywords(self) -> type[BaseModel]:
        """All keywords with their types and defaults."""
        hints = get_type_hints(self.run, include_extras=True)
        known: dict[str, Any] = {}
        for entry in list(inspect.signature(self.run).parameters.values())[1:]:
            group = self._groups.get(entry.name)
            if group is None:
                known[entry.name] = hints.get(entry.name, Any), entry.default
            else:
                types = get_type_hints(type(group), include_extras=True)
                known |= {f.name: (types[f.name], getattr(group, f.name)) for f in fields(group)}
        strict = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)
        return create_model(self.name, __config__=strict, **known)

    def arguments(self, value: float | None, parameters: Mapping[str, Any]) -> dict[str, Any]:
        """Return all that a measurement hangs on beside its effort, however it is spelled."""
        given = dict(parameters)
        along = given.pop("along", self.along)
        varied = {} if value is None else {along: value}
        return {
            key: float(entry) if isinstance(entry, int) and not isinstance(entry, bool) else entry
            for key, entry in {**self.defaults, **given, **varied}.items()
        }

    def checked(self, value: float | None, *, along: str = "", **parameters: Any) -> dict[str, Any]:
        """Return the arguments of the function, apart from the effort.

        InputError for a parameter that is unknown, of another type than its keyword, given twice,
        or refused.
        """
        along, wrong = along or self.along, []
        if value is not None:
            if along in parameters:
                wrong.append(f"{along} is varied and given, too")
            parameters = {**parameters, along: value}
        elif along not in self.defaults:
            wrong.append(f"{along}: unknown key{near(along, self.defaults)}")
        try:
            arguments = dict(self._keywords(**parameters))
        except ValidationError as error:
            wrong += in_file(error, self._keywords)
        if wrong:
            raise InputError(f"experiment {self.name}: " + "; ".join(wrong))
        for name, group in self._groups.items():
            of = {entry.name: arguments.pop(entry.name) for entry in fields(group)}
            arguments[name] = replace(group, **of)
        return arguments

    def measure(
        self, value: float | None, effort: Effort = "full", **parameters: Any
    ) -> Measurement:
        """Measure at a value of the parameter; `parameters` are those of the claim file.

        InputError: see `checked`; or for values that the function refuses. ArithmeticError for a
        result that is not finite.
        """
        if effort not in ("quick", "full"):
            raise InputError(f"effort is 'quick' or 'full', not {effort!r}")
        arguments = self.checked(value, **parameters)
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


EXPERIMENTS: dict[str, Experiment] = {}


def experiment(name: str, parameter: str = "", along: str = "") -> Callable[[Run], Run]:
    """Make a function known as an experiment, see `Experiment`."""

    def known(run: Run) -> Run:
        title = (run.__doc__ or f"{name}.").partition("\n")[0].removesuffix(".")
        EXPERIMENTS[name] = Experiment(name, title, parameter, run, along)
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


def number_of(realisations: int, effort: str, quick: int) -> int:
    """Return how many realisations are drawn: all asked for at full effort, else at most `quick`.

    >>> number_of(60, "full", 12), number_of(60, "quick", 12), number_of(8, "quick", 12)
    (60, 12, 8)
    """
    return realisations if effort == "full" else min(realisations, quick)
