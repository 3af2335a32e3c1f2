"""Storage of a solved task in one npz file, which --resume reads back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.errors import ResultsError
from comparisons.files import read_arrays, write_arrays
from comparisons.tasks.solution import Solution

PREFIX = "solution."
_ARRAYS = ("converged", "iterations", "violation")
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
    arrays |= {f"{PREFIX}q.{name}": value for name, value in solution.quantities.items()}
    arrays |= {f"{PREFIX}d.{name}": value for name, value in solution.distributions.items()}
    arrays |= {f"{PREFIX}b.{name}": value for name, value in solution.bars.items()}
    numbers = {name: getattr(solution, name) for name in _NUMBERS}
    # JSON knows no NaN
    document = {name: n if np.isfinite(n) else None for name, n in numbers.items()} | {
        "machine": solution.machine,
        "exact": solution.exact,
        "path": solution.path,
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
    document = json.loads(str(arrays.pop(f"{PREFIX}json")))
    solution_arrays = {name: arrays.pop(name) for name in list(arrays) if name.startswith(PREFIX)}
    start = len(PREFIX) + 2
    stored = {name: document[name] for name in _NUMBERS}
    numbers: dict[str, Any] = {name: float("nan") if n is None else n for name, n in stored.items()}

    def named(kind: str) -> dict[str, np.ndarray]:
        whole = solution_arrays.items()
        return {k[start:]: v for k, v in whole if k.startswith(f"{PREFIX}{kind}.")}

    return Solution(
        quantities=named("q"),
        distributions=named("d"),
        bars=named("b"),
        reasons={(row, step): reason for row, step, reason in document["reasons"]},
        fields=arrays,
        converged=solution_arrays[f"{PREFIX}converged"],
        iterations=solution_arrays[f"{PREFIX}iterations"],
        violation=solution_arrays[f"{PREFIX}violation"],
        **numbers,
        exact=tuple(document["exact"]),
        path=bool(document["path"]),
        contact=document["contact"],
        machine=str(document["machine"]),
    )
