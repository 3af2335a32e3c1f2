"""The solution of a task: curves over the load steps, reasons for failures, time and memory.

It is stored in one npz file, which --resume reads back.
"""

from __future__ import annotations

import json
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from comparisons.errors import ResultsError
from comparisons.files import read_arrays, write_arrays
from comparisons.geometry.prepare import RoughGeometry
from comparisons.reasons import in_kind, one_line
from comparisons.tasks.shown_loads import Fields, shown_steps
from comparisons.tasks.stresses import FROM_PRESSURE
from comparisons.tasks.task import Task

REALISATIONS, STEPS = 0, 1
UNDERFLOW = "force came out as 0.0 in a contact: below the smallest number (underflow)"
MAY_BE_INFINITE = ("stiffness", "contact_length_stiffness")
Contact = Literal["", "single", "pair", "free", "periodic"]


class Stopwatch:
    """Seconds that a block of code takes."""

    seconds = 0.0

    def __enter__(self) -> Stopwatch:
        self._start = time.perf_counter()
        return self

    def __exit__(self, *ended: object) -> None:
        self.seconds = time.perf_counter() - self._start


class MalformedError(ValueError):
    """A method returned something else than numbers by quantity."""


def curve_of(name: str, values: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    """Return a quantity as (realisations, steps), of the steps of one realisation or one number.

    MalformedError if it is something else.
    """
    try:
        curve = np.asarray(values)
    except ValueError:  # lists in a list, of several lengths
        curve = np.asarray(None)
    fits = curve.shape in ((), shape) or shape == (1, *curve.shape)
    if curve.dtype.kind not in "biuf" or not fits:
        count = " x ".join(str(n) for n in shape if n != 1)
        wanted = f"{count} numbers" if count else "a number"
        raise MalformedError(f"{name}: expected {wanted}, got {in_kind(values)}")
    return np.broadcast_to(curve, shape).astype(float)


@dataclass
class Solution:
    """Results of a method, per realisation (axis 0) and load step (axis 1)."""

    # Name -> array (realisations, steps); NaN where a step failed. Names absent were not asked for
    # or are not defined for the method.
    quantities: dict[str, np.ndarray]
    converged: np.ndarray
    # Where no equilibrium exists, where many do, and where a load is beyond the range that the
    # method states: answers, too, of a step without values.
    no_equilibrium: np.ndarray
    undetermined: np.ndarray
    out_of_range: np.ndarray
    # Solver iterations, and the largest relative overlap or tension (NaN for direct methods).
    iterations: np.ndarray
    violation: np.ndarray
    unknowns: int
    # (realisation index, step) -> why it failed.
    reasons: dict[tuple[int, int], str] = field(default_factory=dict)
    # Name -> histograms at the last load (realisations, bins), of the first realisations (see
    # `comparisons.tasks.distributions`); NaN where there is no answer.
    distributions: dict[str, np.ndarray] = field(default_factory=dict)
    # Name -> (realisations, steps): relative half-widths of what reading a quantity off cells
    # (`tasks.stresses`) or elements adds; of others nothing.
    bars: dict[str, np.ndarray] = field(default_factory=dict)
    # Arrays of realisation 0 at the last load: ``pressure``, ``pressure_x``, ...
    fields: dict[str, np.ndarray] = field(default_factory=dict)
    # Relative 95 % half-width of what a bounded domain leaves out, or of the place of an edge
    # inside a cell (0: nothing of the kind).
    truncation: float = 0.0
    # Quantities that no grid and no truncation touches: the area of a flat face.
    exact: tuple[str, ...] = ()
    # Steps follow each other along a path or in time: errors and bars are then relative to the
    # largest value along it, because single values pass zero.
    path: bool = False
    # It has the fields that pages show of the finest grid of a method alone, where there are any.
    whole: bool = True
    # Elastic contact without other physics, of one body, of two that are both meshed, or of a rough
    # surface: what error a change between grids leaves was measured there.
    contact: Contact = ""
    apparent_area: float = float("nan")  # of a rough surface, in m2; NaN of others
    # (realisation index, step) -> function that returns the pressure there, for the steps that are
    # shown of realisation 0 (`shown_loads.shown_steps`), and for all from which quantities follow
    # (`tasks.stresses`); not part of the solve.
    pressures: dict[tuple[int, int], Callable[[], Fields]] = field(default_factory=dict)
    # Computes the fields in the body, where a task asks for them; not part of the solve.
    body_fields: Callable[[], Fields] | None = None
    # Everything done for the task on warm code; the part another list of loads could reuse;
    # compilation (apart); peak memory in bytes (NaN where it cannot be measured).
    seconds: float = float("nan")
    setup_seconds: float = 0.0
    compile_seconds: float = 0.0
    memory: float = float("nan")
    # Where it was solved, in one short text; " + " between the machines of several blocks.
    machine: str = ""
    # What the numerics complained of, where somebody listens (hard cases).
    warnings: tuple[str, ...] = ()

    @classmethod
    def empty(cls, task: Task, unknowns: int = 0) -> Solution:
        """Return a solution to be filled step by step: nothing converged yet."""
        geometry, scene = task.geometry, task.scene
        contact: Contact = ""
        if scene.physics or scene.body is not None:
            pass
        elif isinstance(geometry, RoughGeometry):
            contact = "periodic" if geometry.periodic else "free"
        elif scene.indenter is not None and scene.indenter.regular and scene.half_space.uniform:
            contact = "single"
        return cls(
            quantities={},
            converged=np.zeros(task.shape, dtype=bool),
            no_equilibrium=np.zeros(task.shape, dtype=bool),
            undetermined=np.zeros(task.shape, dtype=bool),
            out_of_range=np.zeros(task.shape, dtype=bool),
            iterations=np.zeros(task.shape, dtype=int),
            violation=np.full(task.shape, np.nan),
            unknowns=unknowns,
            path=task.loads.is_path,
            contact=contact,
            apparent_area=geometry.area if isinstance(geometry, RoughGeometry) else float("nan"),
        )

    @classmethod
    def of(
        cls,
        task: Task,
        quantities: Mapping[str, ArrayLike],
        *,
        unknowns: int = 0,
        iterations: ArrayLike = 0,
        violation: ArrayLike = np.nan,
        setup_seconds: float = 0.0,
    ) -> Solution:
        """Return a solution of curves: every step has an answer.

        A curve is (realisations, steps), or (steps,) of a single realisation, or one number that
        belongs to the whole path and stands in every step; ValueError where it is not.
        """
        solution = cls.empty(task, unknowns)
        for name, values in quantities.items():
            solution.quantities[name] = curve_of(name, values, task.shape)
        solution.converged[:] = True
        solution.iterations[:] = iterations
        solution.violation[:] = violation
        solution.setup_seconds = setup_seconds
        return solution

    @classmethod
    def lost(cls, task: Task, reason: str) -> Solution:
        """Return a solution without answers, for a task that could not be solved at all."""
        solution = cls.empty(task)
        for row, step in np.ndindex(task.shape):
            solution.fail((row, step), reason)
        return solution

    @property
    def answered(self) -> np.ndarray:
        """Where it has an answer, be it one without values; as `converged`."""
        return self.converged | self.no_equilibrium | self.undetermined | self.out_of_range

    @property
    def valueless_steps(self) -> np.ndarray:
        """At which load steps it answers without values, whatever the realisation, (steps,)."""
        return np.asarray((self.no_equilibrium | self.undetermined).all(axis=0))

    def put_distributions(self, row: int, histograms: Mapping[str, np.ndarray]) -> None:
        """Store the distributions of one realisation at the last load."""
        for name, counts in histograms.items():
            if name not in self.distributions:
                shape = len(self.converged), len(counts)
                self.distributions[name] = np.full(shape, np.nan)
            self.distributions[name][row] = counts

    def put(
        self,
        index: tuple[int, int],
        values: Mapping[str, float],
        bars: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        """Store the quantities of one converged step."""
        for curves, numbers in (self.quantities, values), (self.bars, bars):
            for name, number in numbers.items():
                if name not in curves:
                    curves[name] = np.full(self.converged.shape, np.nan)
                curves[name][index] = number
        self.converged[index] = True

    def keep(self, task: Task, index: tuple[int, int], build: Callable[[], Fields]) -> None:
        """Remember how to make the pressure of a load step, if it is needed."""
        row, step = index
        shown = row == 0 and step in shown_steps(self.converged.shape[1])
        if shown or not FROM_PRESSURE.isdisjoint(task.quantities):
            self.pressures[index] = build

    def fail(
        self,
        index: tuple[int, int],
        reason: str,
        *,
        no_equilibrium: bool = False,
        undetermined: bool = False,
        out_of_range: bool = False,
    ) -> None:
        """Record that one step has no answer, or none with values, and why in one line."""
        self.reasons[index] = one_line(f"no equilibrium: {reason}" if no_equilibrium else reason)
        self.converged[index] = False
        self.no_equilibrium[index], self.undetermined[index] = no_equilibrium, undetermined
        self.out_of_range[index] = out_of_range

    def refuse_nan(self) -> None:
        """Take away the answer of each step that failed, or has a quantity that is no number.

        Stiffness may be infinite: where a whole period touches it is. A contact of one body that
        bears nothing is one whose force is below the smallest number. MalformedError if a quantity
        has another shape than the solution.
        """
        for name, given in self.quantities.items():
            self.quantities[name] = values = curve_of(name, given, self.converged.shape)
            known = ~np.isnan(values) if name in MAY_BE_INFINITE else np.isfinite(values)
            for row, step in np.argwhere(self.converged & ~known):
                self.fail((int(row), int(step)), f"{name} came out as {values[row, step]}")
        if self.contact == "single" and {"force", "contact_area"} <= self.quantities.keys():
            idle = (self.quantities["force"] == 0) & (self.quantities["contact_area"] > 0)
            for row, step in np.argwhere(self.converged & idle):
                self.fail((int(row), int(step)), UNDERFLOW)
        for index in self.reasons:
            for values in self.quantities.values():
                values[index] = np.nan
            if index[1] == self.converged.shape[1] - 1:
                for histograms in self.distributions.values():
                    histograms[index[0]] = np.nan

    @contextmanager
    def setup(self) -> Iterator[None]:
        """Count the time inside as set-up: the part that another list of loads would reuse."""
        with Stopwatch() as watch:
            yield
        self.setup_seconds += watch.seconds

    @classmethod
    def concat(cls, parts: Sequence[Solution], axis: int) -> Solution:
        """Join solutions along their realisations (axis 0) or their load steps (axis 1).

        Times add up, memory is the largest. Fields are those of the first realisation at the last
        load; a quantity that a part has not is NaN there.
        """
        if len(parts) == 1:
            return parts[0]
        sizes = [part.converged.shape[axis] for part in parts]
        starts = np.cumsum([0, *sizes[:-1]]).tolist()
        base = parts[-1] if axis == STEPS else parts[0]
        places = list(zip(parts, starts, strict=True))

        def by_place(name: str) -> dict[tuple[int, int], Any]:
            """Return what parts have by realisation and step, by those of the whole."""
            return {
                (row + start * (axis == REALISATIONS), step + start * (axis == STEPS)): item
                for part, start in places
                for (row, step), item in getattr(part, name).items()
            }

        histograms = base.distributions
        if axis == REALISATIONS:  # of all parts that have them: the lines of later ones have none
            histograms = {
                name: np.concatenate(
                    [p.distributions[name] for p in parts if name in p.distributions]
                )
                for name in dict.fromkeys(name for part in parts for name in part.distributions)
            }

        def joined(kind: str) -> dict[str, np.ndarray]:
            curves = [
                defaultdict(partial(np.full, p.converged.shape, np.nan), getattr(p, kind))
                for p in parts
            ]
            names = dict.fromkeys(name for part in curves for name in part)
            return {name: np.concatenate([c[name] for c in curves], axis=axis) for name in names}

        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(p, name) for p in parts], axis) for name in _ARRAYS
        }
        return replace(
            base,
            quantities=joined("quantities"),
            bars=joined("bars"),
            distributions=histograms,
            **arrays,
            unknowns=max(p.unknowns for p in parts),
            truncation=max(p.truncation for p in parts),
            reasons=by_place("reasons"),
            pressures=by_place("pressures"),
            # Of methods that take their own time; steps without an answer have none.
            seconds=float((np.nansum if axis == STEPS else np.sum)([p.seconds for p in parts])),
            setup_seconds=sum(p.setup_seconds for p in parts),
            compile_seconds=sum(p.compile_seconds for p in parts),
            memory=max(p.memory for p in parts),
            machine=" + ".join(sorted({p.machine for p in parts if p.machine})),
            warnings=tuple(text for p in parts for text in p.warnings),
        )


# The solutions of a scene: (method, resolution) -> what came back, all realisations joined.
Solved = dict[tuple[str, int], Solution]


PREFIX = "solution."
FLAGS = ("converged", "no_equilibrium", "undetermined", "out_of_range")
_ARRAYS = (*FLAGS, "iterations", "violation")
# Arrays by name, and what their names begin with in a file.
_CURVES = {"quantities": "q.", "distributions": "d.", "bars": "b."}
_NUMBERS = (
    *("unknowns", "truncation", "apparent_area"),
    *("seconds", "setup_seconds", "compile_seconds", "memory"),
)


def save_solution(path: Path, solution: Solution) -> None:
    """Write a solution atomically."""
    write_arrays(path, arrays_of(solution))


def arrays_of(solution: Solution) -> dict[str, np.ndarray]:
    """Return everything in a solution as named arrays, the numbers and reasons as one JSON text."""
    arrays = dict(solution.fields)
    arrays |= {f"{PREFIX}{name}": getattr(solution, name) for name in _ARRAYS}
    for kind, start in _CURVES.items():
        curves: dict[str, np.ndarray] = getattr(solution, kind)
        arrays |= {f"{PREFIX}{start}{name}": values for name, values in curves.items()}
    numbers = {name: getattr(solution, name) for name in _NUMBERS}
    # JSON knows no NaN
    document = {name: n if np.isfinite(n) else None for name, n in numbers.items()} | {
        "machine": solution.machine,
        "exact": solution.exact,
        "path": solution.path,
        "whole": solution.whole,
        "contact": solution.contact,
        "reasons": [[*index, reason] for index, reason in solution.reasons.items()],
    }
    return arrays | {f"{PREFIX}json": np.array(json.dumps(document))}


def load_solution(path: Path) -> Solution:
    """Read a solution back; raise ResultsError for a file that holds something else."""
    arrays = read_arrays(path)
    try:
        return solution_of(arrays)
    except (KeyError, TypeError, ValueError) as error:
        raise ResultsError(f"{path}: not the arrays of a solved task ({error})") from error


def solution_of(arrays: dict[str, np.ndarray]) -> Solution:
    """Return the solution of `arrays_of`; KeyError, TypeError, ValueError for other arrays."""
    own = {n[len(PREFIX) :]: arrays.pop(n) for n in list(arrays) if n.startswith(PREFIX)}
    document = json.loads(str(own["json"]))
    parts: dict[str, Any] = {
        kind: {n[len(start) :]: values for n, values in own.items() if n.startswith(start)}
        for kind, start in _CURVES.items()
    }
    numbers = {name: document[name] for name in _NUMBERS}
    parts |= {name: float("nan") if n is None else n for name, n in numbers.items()}
    parts |= {name: own[name] for name in _ARRAYS}
    return Solution(
        **parts,
        reasons={(row, step): reason for row, step, reason in document["reasons"]},
        fields=arrays,
        exact=tuple(document["exact"]),
        path=bool(document["path"]),
        whole=bool(document["whole"]),
        contact=document["contact"],
        machine=str(document["machine"]),
    )
