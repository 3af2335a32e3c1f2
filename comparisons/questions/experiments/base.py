"""Experiments: measurements of statements that no single scene can decide.

Far fields, impacts, ensembles against a theory, a kernel as printed: an experiment is a small
program that measures the error of a statement and its uncertainty. A claim file refers to it by
``experiment = NAME`` instead of a scene.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Effort = Literal["quick", "full"]


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
    details: dict[str, float | str] = field(default_factory=dict)
    seconds: float = 0.0
    noun: str = "error"


@dataclass(frozen=True)
class Experiment:
    """A named measurement as a function of its parameter.

    Attributes
    ----------
    name : str
        Slug used in claim files.
    title : str
        The measured quantity, in one sentence.
    parameter : str
        The varied parameter in words, with its symbol ("distance over diameter s/D"); "" if none.
    measure : callable
        ``measure(parameter_value, effort, **parameters) -> Measurement``; `parameters` is the table
        of that name in the claim file.
    defaults : mapping
        What its function gets for parameters that are not given.
    along : str
        Which of them the value is, where the parameters name none.
    """

    name: str
    title: str
    parameter: str
    measure: Callable[..., Measurement]
    defaults: Mapping[str, Any] = field(default_factory=dict)
    along: str = "value"

    def arguments(self, value: float | None, parameters: Mapping[str, Any]) -> dict[str, Any]:
        """Return all that a measurement hangs on beside its effort, however it is spelled."""
        given = dict(parameters)
        along = given.pop("along", self.along)
        varied = {} if value is None else {along: value}
        return {
            key: float(entry) if isinstance(entry, int) and not isinstance(entry, bool) else entry
            for key, entry in {**self.defaults, **given, **varied}.items()
        }
