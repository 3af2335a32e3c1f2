"""A piece of work, how a folder keeps its answer, and its outcome."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from comparisons.solving.forecast import Kind


@dataclass(frozen=True)
class Archive:
    """How a folder keeps an answer.

    Attributes
    ----------
    suffix : str
    save : callable
        ``save(path, answer)``, atomically.
    load : callable
        ``load(path)``; raises ResultsError for a torn file.
    is_final : callable
        Whether an answer of an earlier run is taken: what broke it may have been mended since.
    without_bulk : callable
        What of an answer stays in memory once it is written; default: all.
    """

    suffix: str
    save: Callable[[Path, Any], None]
    load: Callable[[Path], Any]
    is_final: Callable[[Any], bool]
    without_bulk: Callable[[Any], Any] = lambda answer: answer


@dataclass(frozen=True)
class Job:
    """One independent piece of work.

    Attributes
    ----------
    key : str
        Names it, and the file that keeps its answer: the same exactly when the answer is.
    work : callable
        A function of an importable module. What it needs comes in its arguments.
    arguments : tuple
        Picklable, unless the work is done in this process.
    memory : float
        Estimate of the peak memory in bytes that the work takes beyond what a process with all
        packages has; 0 is "little".
    kind : Kind
        What its time depends on.
    archive : Archive, optional
        How a folder keeps its answer.
    """

    key: str
    work: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    memory: float = 0.0
    kind: Kind = field(default_factory=Kind)
    archive: Archive | None = None


@dataclass(frozen=True)
class Done:
    """The outcome of a job.

    Attributes
    ----------
    job : Job
    value : object
        What the work returned.
    seconds : float
        Wall time of the work, where it was done.
    lost : str
        Why there is no value: the process that did the work was ended, again and again.
    """

    job: Job
    value: Any = None
    seconds: float = float("nan")
    lost: str = ""
