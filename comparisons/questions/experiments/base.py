"""What an experiment is: a measurement of a statement that no single scene can decide.

Far fields, impacts, ensembles against a theory, a kernel as printed: each is a small program
that measures how far a statement is off, and how well it knows that. A claim file names it with
``experiment = NAME`` where others name a scene.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

Effort = Literal["quick", "full"]


@dataclass(frozen=True)
class Measurement:
    """One measured error of a statement.

    Attributes
    ----------
    parameter : float or None
        Where along the experiment's parameter it was measured; None where there is none.
    error : float
        Signed relative error of the statement.
    uncertainty : float
        95 % half-width of `error`, all sources together: the true error lies in
        [|error| - uncertainty, |error| + uncertainty].
    details : dict
        Whatever else a reader wants to see: numbers measured, parts of the uncertainty, words.
    seconds : float
        Time of the measurement.
    """

    parameter: float | None
    error: float
    uncertainty: float
    details: dict[str, float | str] = field(default_factory=dict)
    seconds: float = 0.0


@dataclass(frozen=True)
class Experiment:
    """A measurement under a name, to be called at any value of its parameter.

    Attributes
    ----------
    name : str
        Slug, as claim files write it.
    title : str
        One sentence: what is measured.
    parameter : str
        What is varied, in words with its symbol ("distance over diameter s/D"); "" where nothing.
    measure : callable
        ``measure(parameter_value, effort, **parameters) -> Measurement``; `parameters` are the
        claim file's table of that name.
    """

    name: str
    title: str
    parameter: str
    measure: Callable[..., Measurement]
