"""Storage of a solved task in one npz file, which --resume reads back."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from comparisons.errors import ResultsError
from comparisons.files import read_arrays, write_arrays
from comparisons.tasks.solution import Solution

PREFIX = "solution."
_ARRAYS = ("converged", "iterations", "violation")
_NUMBERS = ("unknowns", "truncation", "seconds", "setup_seconds", "compile_seconds", "memory")


def save_solution(path: Path, solution: Solution) -> None:
    """Write a solution atomically."""
    write_arrays(path, arrays_of(solution))


def arrays_of(solution: Solution) -> dict[str, np.ndarray]:
    """Return everything in a solution as named arrays, the numbers and reasons as one JSON text."""
    arrays = dict(solution.fields)
    arrays |= {f"{PREFIX}{name}": getattr(solution, name) for name in _ARRAYS}
    arrays |= {f"{PREFIX}q.{name}": value for name, value in solution.quantities.items()}
    arrays |= {f"{PREFIX}d.{name}": value for name, value in solution.distributions.items()}
    document = {name: _plain(getattr(solution, name)) for name in _NUMBERS} | {
        "machine": solution.machine,
        "exact": solution.exact,
        "path": solution.path,
        "contact": solution.contact,
        "reasons": [[*index, reason] for index, reason in solution.reasons.items()],
    }
    return arrays | {f"{PREFIX}json": np.array(json.dumps(document))}


def load_solution(path: Path) -> Solution:
    """Read a solution back.

    Raises
    ------
    comparisons.errors.ResultsError
        If the file cannot be read, or holds something else.
    """
    arrays = read_arrays(path)
    try:
        return solution_of(arrays)
    except (KeyError, TypeError, ValueError) as error:
        raise ResultsError(f"{path}: not the arrays of a solved task ({error})") from error


def solution_of(arrays: dict[str, np.ndarray]) -> Solution:
    """Return the solution that `arrays_of` took apart.

    Raises
    ------
    KeyError, TypeError, ValueError
        If the arrays are something else.
    """
    document = json.loads(str(arrays.pop(f"{PREFIX}json")))
    solution_arrays = {name: arrays.pop(name) for name in list(arrays) if name.startswith(PREFIX)}
    start = len(PREFIX) + 2
    numbers = {name: _number(document[name]) for name in _NUMBERS}

    def named(kind: str) -> dict[str, np.ndarray]:
        whole = solution_arrays.items()
        return {k[start:]: v for k, v in whole if k.startswith(f"{PREFIX}{kind}.")}

    return Solution(
        quantities=named("q"),
        distributions=named("d"),
        reasons={(row, step): reason for row, step, reason in document["reasons"]},
        fields=arrays,
        converged=solution_arrays[f"{PREFIX}converged"],
        iterations=solution_arrays[f"{PREFIX}iterations"],
        violation=solution_arrays[f"{PREFIX}violation"],
        unknowns=document["unknowns"],
        truncation=numbers["truncation"],
        seconds=numbers["seconds"],
        setup_seconds=numbers["setup_seconds"],
        compile_seconds=numbers["compile_seconds"],
        memory=numbers["memory"],
        exact=tuple(document["exact"]),
        path=bool(document["path"]),
        contact=document["contact"],
        machine=str(document.get("machine", "")),
    )


def _plain(value: float) -> float | None:
    """Return None for NaN, which JSON does not know."""
    return value if isinstance(value, int) or np.isfinite(value) else None


def _number(value: float | None) -> float:
    return float("nan") if value is None else value
