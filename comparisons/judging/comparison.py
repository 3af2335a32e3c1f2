"""From solutions to rows, errors and measures: everything that is said about one scene."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from comparisons.facts.quantities import CURVES, FIELDS, counterpart, main_axis
from comparisons.judging.bands import steps_outside
from comparisons.judging.distributions import distribution_rows
from comparisons.judging.fields import field_bar, field_measures
from comparisons.judging.levels import Levels
from comparisons.judging.metrics import rms_and_maximum
from comparisons.judging.proofs import Verification, verified
from comparisons.judging.truth import Truth, choose_truth
from comparisons.judging.uncertainty import combined
from comparisons.judging.verdicts import judged
from comparisons.methods.normal.proved import enclosures_asked_for
from comparisons.solving.plan import Plan
from comparisons.tasks.solution import Solution, Solved

# Realisations that have rows of their own: bands need no more, and lines come in tens of thousands.
MOST_REALISATIONS = 450


@dataclass(frozen=True)
class Comparison:
    """What was found for one scene, as tables; with its bars held against what is proved."""

    truth: Truth | None
    rows: pd.DataFrame
    measures: pd.DataFrame
    verification: Verification | None = None
    distributions: pd.DataFrame = field(default_factory=pd.DataFrame)


def compare(plan: Plan, solved: Solved, constants: dict[str, Any]) -> Comparison:
    """Compare all solutions of a scene with its best reference.

    Parameters
    ----------
    plan : Plan
    solved : dict
        (method, resolution) -> Solution.
    constants : dict
        Columns that are the same in every row (threads, versions, machine), but where a solution
        knows the machine that found it.
    """
    truth = choose_truth(solved, plan.loads.axis, plan.compared)
    levels = {method: Levels.of(solved, method) for method, _ in solved}
    rows = [
        row
        for method, resolution in solved
        for row in _solution_rows(plan, levels[method], resolution, truth)
    ]
    rows += [
        _refusal_row(plan, planned.method, planned.reason)
        for planned in plan.methods
        if not planned.supported
    ]
    verification = None
    started = time.perf_counter()
    sides = {} if truth is None else enclosures_asked_for(plan.scene, plan.loads)
    if truth is not None and sides:
        verification = verified(truth, sides, time.perf_counter() - started)
        for row in rows:
            if (row["method"], row["resolution"]) == (truth.method, truth.resolution):
                row |= {name: float(values[int(row["step"])]) for name, values in sides.items()}
    measures = [
        row
        for method, resolution in solved
        for row in _measure_rows(plan, solved, levels[method], resolution, truth)
    ]
    table = pd.DataFrame([constants | row for row in rows])
    last = [name for name in constants if name in table]
    table = table[[*(name for name in table if name not in constants), *last]]
    distributions = pd.DataFrame(distribution_rows(plan, solved))
    return Comparison(truth, table, pd.DataFrame(measures), verification, distributions)


def _solution_rows(
    plan: Plan, levels: Levels, resolution: int, truth: Truth | None
) -> list[dict[str, Any]]:
    """Return the rows of the first MOST_REALISATIONS surfaces, and of the mean over all."""
    rows = []
    solution = levels.solutions[resolution]
    count = len(solution.converged)
    common = _common(plan, levels.method, resolution, solution)
    for k in range(min(count, MOST_REALISATIONS)):
        curves = {name: values[k] for name, values in solution.quantities.items()}
        rows += _curve_rows(plan, curves, common | {"realisation": str(k)}, truth)
        for step, row in enumerate(rows[-len(plan.loads.values) :]):
            row["iterations"] = int(solution.iterations[k, step])
            row["violation"] = float(solution.violation[k, step])
            row["converged"] = bool(solution.converged[k, step])
            row["reason"] = solution.reasons.get((k, step), "")
    if count > 1:
        curves = levels.curves(resolution)
        errors = {name: levels.standard_error(name, resolution) for name in curves}
        mean = _curve_rows(plan, curves, common | {"realisation": "mean"}, truth)
        for step, row in enumerate(mean):
            row["converged"] = bool(solution.converged[:, step].all())
            for name, values in errors.items():
                row[f"stderr_{name}"] = float(values[step])
        rows += mean
    return rows


def _common(plan: Plan, method: str, resolution: int, solution: Solution) -> dict[str, Any]:
    """Return what all rows of a solution share; times are those of one surface or line."""
    where = {"machine": solution.machine} if solution.machine else {}
    count = len(solution.converged)
    return where | {
        "scene": plan.scene.name,
        "method": method,
        "options": plan.scene.methods.of(method).changed(),
        "resolution": resolution,
        "surfaces": count,
        "seconds": solution.seconds / count,
        "setup_seconds": solution.setup_seconds / count,
        "compile_seconds": solution.compile_seconds,
        "unknowns": solution.unknowns,
        "memory": solution.memory,
    }


def _curve_rows(
    plan: Plan,
    curves: dict[str, np.ndarray],
    common: dict[str, Any],
    truth: Truth | None,
) -> list[dict[str, Any]]:
    steps = len(plan.loads.values)
    rows = [common | {"step": step} for step in range(steps)]
    is_truth = truth is not None and (
        (truth.method, truth.resolution) == (common["method"], common["resolution"])
    )
    for step, row in enumerate(rows):
        for name, values in curves.items():
            row[name] = float(values[step])
        # What is prescribed stands in the row of a step that failed, too.
        for name, values in plan.loads.columns.items():
            if not np.isfinite(row.get(name, np.nan)):
                row[name] = float(values[step])
        row["reference"] = "" if truth is None else truth.label
    if truth is None:
        return rows
    compared = [n for n in plan.compared if truth.knows(n)]
    for name in CURVES:
        if not truth.knows(name, curves):
            continue
        bar = truth.bar(name)
        error = truth.errors(curves, name, main_axis(truth.axis, name))
        for step, row in enumerate(rows):
            row[f"error_{name}"] = float("nan") if is_truth else float(error[step])
            row[f"reference_uncertainty_{name}"] = float(bar[step])
    for row in rows:
        bars = [row.get(f"reference_uncertainty_{name}", np.nan) for name in compared]
        row["reference_uncertainty"] = max((b for b in bars if np.isfinite(b)), default=np.nan)
    return rows


def _refusal_row(plan: Plan, method: str, reason: str) -> dict[str, Any]:
    return {
        "scene": plan.scene.name,
        "method": method,
        "options": "",
        "resolution": float("nan"),
        "step": float("nan"),
        "converged": False,
        "reason": reason,
    }


def _measure_rows(
    plan: Plan,
    solved: Solved,
    levels: Levels,
    resolution: int,
    truth: Truth | None,
) -> list[dict[str, Any]]:
    method, solution = levels.method, levels.solutions[resolution]
    if truth is None or (method, resolution) == (truth.method, truth.resolution):
        return []
    curves = levels.curves(resolution)
    common = _common(plan, method, resolution, solution)
    del common["compile_seconds"], common["options"]
    common["converged"] = bool(solution.converged.all())
    rows = []
    if set(plan.compared) & set(FIELDS):
        rows += [
            {"quantity": measure["quantity"], "at": "last load"}
            | _measure(plan, np.array([measure["error"]]), np.array([measure["bar"]]))
            for measure in field_measures(plan, solved, method, resolution, truth)
        ]
    for name in plan.compared:
        if not truth.knows(name, curves):
            continue
        for at in _compared_at(plan, name):
            error = truth.errors(curves, name, at)
            bar = combined(*truth.error_sources(levels, resolution, name, at).values())
            rows.append({"quantity": name, "at": at} | _measure(plan, error, bar))
            beyond = steps_outside(levels, resolution, truth, name)
            if beyond is not None and at == main_axis(truth.axis, name):
                rows[-1]["outside_band"] = " ".join(str(k + 1) for k in beyond) or "never"
    return [common | row for row in rows]


def _compared_at(plan: Plan, name: str) -> tuple[str, ...]:
    """Return at which equal loads a quantity is compared: never at itself."""
    loads = plan.loads
    if loads.compares_itself:
        return tuple(at for at in (loads.axis, counterpart(loads.axis)) if at != name)
    return (loads.axis,)


def _measure(plan: Plan, error: np.ndarray, bar: np.ndarray) -> dict[str, Any]:
    """Return the verdict on all steps, and size and bar of the error at the step that decided."""
    decided = judged(error, bar, plan.scene.compare.tolerance)
    return {
        "rms": rms_and_maximum(error)[0],
        "maximum": decided.error,
        "uncertainty": decided.uncertainty,
        "verdict": decided.word,
        "step": decided.step,
        "low": decided.low,
        "high": decided.high,
    }


def truth_bars(plan: Plan, truth: Truth) -> dict[str, dict[str, Any]]:
    """Return the widest bar of the truth in each quantity that it gives, and at which load step.

    On the very same surfaces: what decides whether the truth may itself be taken as an answer.
    """
    widest = {}
    for name in plan.compared:
        if name in FIELDS:
            bar = np.array(field_bar(plan, truth, name))
        else:
            bar = truth.bar(name, same_surfaces=True) if truth.knows(name) else np.array([])
        if len(bar):
            decided = judged(np.zeros(len(bar)), bar, plan.scene.compare.tolerance)
            widest[name] = {"bar": decided.uncertainty, "step": decided.step}
    return widest
