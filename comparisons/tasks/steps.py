"""Load after load: what a solver yields, and a failure that costs its own step only."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from comparisons.tasks.shown_loads import Fields
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.errors import ConvergenceError as ModelStopped
from reference.errors import ConvergenceError as SolverStopped
from reference.errors import NoEquilibriumError


class NoAnswerError(Exception):
    """A load step has no answer, for a reason of the model and not of its numerics."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class OutOfRangeError(NoAnswerError):
    """A load is beyond the range that a method states."""


# What says itself why there is no answer: the physics, or the numerics of either model.
NO_ANSWER = (NoAnswerError, ModelStopped, SolverStopped)


@dataclass(frozen=True)
class Step:
    """One load step that has an answer."""

    quantities: Mapping[str, float]  # name -> value, in SI units
    # As of a `Solution`.
    iterations: int = 0
    violation: float = float("nan")
    unknowns: int = 0
    bars: Mapping[str, float] = field(default_factory=dict)
    # Makes name -> histogram (`comparisons.tasks.distributions`); called at the last load.
    distributions: Callable[[], Mapping[str, np.ndarray]] | None = None
    # Makes the fields of the pressure, where it is asked for.
    pressure: Callable[[], Fields] | None = None
    # Makes the arrays that plots and pictures use; called at the last load of realisation 0.
    fields: Callable[[], Fields] | None = None
    body_fields: Callable[[], Fields] | None = None  # computes the fields in the body


def steps_of(curves: Mapping[str, np.ndarray], **alike: Any) -> Iterator[Step]:
    """Yield the steps of curves (k,), which are alike in all but their quantities."""
    for values in zip(*curves.values(), strict=True):
        yield Step(dict(zip(curves, map(float, values), strict=True)), **alike)


@dataclass(frozen=True)
class Row:
    """A realisation that is set up: a function that yields the steps of the loads still to do."""

    sweep: Callable[[np.ndarray], Iterable[Step]]
    unknowns: int = 0
    truncation: float = 0.0


def solve_rows(task: Task, rows: Iterable[Row]) -> Solution:
    """Solve realisation after realisation, load after load.

    What happens before a row is yielded is its set-up. A sweep ends at the first load that has no
    answer; a new one starts at the next load. Of a path it is the end: its rest cannot begin anew.
    """
    solution, loads = Solution.empty(task), task.loads.values
    iterator = iter(rows)
    for number, _ in enumerate(task.realisations):
        with solution.setup():
            row = next(iterator)
        solution.unknowns = max(solution.unknowns, row.unknowns)
        solution.truncation = max(solution.truncation, row.truncation)
        done, steps = 0, None
        while done < len(loads):
            try:
                steps = steps or iter(row.sweep(loads[done:]))
                step = next(steps, None)
                if step is None:
                    raise NoAnswerError("the solver ended before this load")
            except NO_ANSWER as error:
                end = len(loads) if task.loads.is_path else done + 1
                flags = {
                    "no_equilibrium": isinstance(error, NoEquilibriumError),
                    "out_of_range": isinstance(error, OutOfRangeError),
                }
                for lost in range(done, end):
                    solution.fail((number, lost), error.reason, **flags)
                done, steps = end, None
            else:
                record(solution, (number, done), step, task)
                done += 1
    return solution


def record(solution: Solution, index: tuple[int, int], step: Step, task: Task) -> None:
    """Store a step in a solution."""
    solution.put(index, step.quantities, step.bars)
    solution.iterations[index] = step.iterations
    solution.violation[index] = step.violation
    solution.unknowns = max(solution.unknowns, step.unknowns)
    if step.pressure is not None and task.wants_pressure:
        solution.keep(task, index, step.pressure)
    if index[1] == task.shape[1] - 1 and step.distributions is not None:
        solution.put_distributions(index[0], step.distributions())
    if index != (0, task.shape[1] - 1):
        return
    if step.fields is not None:
        solution.fields = dict(step.fields())
    if step.body_fields is not None and task.with_body:
        solution.body_fields = step.body_fields
