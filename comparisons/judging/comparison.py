"""From solutions to rows, errors and measures: everything that is said about one scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from comparisons.facts.methods import METHODS
from comparisons.judging.metrics import at_equal, relative_error, rms_and_maximum
from comparisons.judging.pressures import pressure_measures, truth_bar
from comparisons.judging.truth import (
    OTHER_AXIS,
    Reference,
    Sources,
    choose_reference,
    finest,
    main_axis,
    mean_curves,
    on_common_realisations,
    own_discretisation,
    sources_of,
    uncertainty_of,
)
from comparisons.judging.uncertainty import combined, ensemble_uncertainty, standard_error
from comparisons.judging.verdicts import judged
from comparisons.scene.scene import QUANTITIES
from comparisons.solving.planning import Plan
from comparisons.tasks.solution import Solution, Solved

SCALARS = tuple(name for name in QUANTITIES if name != "pressure")
# What the judged method adds to the reference's own sources.
LINES, SPRINGS = "realisations of the line", "discretisation of the line"


@dataclass(frozen=True)
class Comparison:
    """What was found for one scene, as tables."""

    reference: Reference | None
    rows: pd.DataFrame
    measures: pd.DataFrame


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
    solved = on_common_realisations(solved)
    reference = choose_reference(solved, plan.compared)
    rows = [
        row
        for (method, resolution), solution in solved.items()
        for row in _solution_rows(plan, method, resolution, solution, reference)
    ]
    rows += [
        _refusal_row(plan, planned.method, planned.reason)
        for planned in plan.methods
        if not planned.supported
    ]
    measures = [
        row
        for (method, resolution), solution in solved.items()
        for row in _measure_rows(plan, solved, method, resolution, solution, reference)
    ]
    table = pd.DataFrame([constants | row for row in rows])
    last = [name for name in constants if name in table]
    table = table[[*(name for name in table if name not in constants), *last]]
    return Comparison(reference, table, pd.DataFrame(measures))


def errors_of(
    control: str, curves: dict[str, np.ndarray], reference: Reference, name: str, at: str
) -> np.ndarray:
    """Return the signed relative error of a quantity at equal `at`, per load step.

    At the prescribed load the values are compared step by step; at the other one the reference
    is interpolated (`metrics.at_equal`).
    """
    needed = {name} if at == control else {name, at}
    if not (needed <= set(reference.curves) and needed <= set(curves)):
        return np.full(len(next(iter(reference.curves.values()))), np.nan)
    if at == control:
        return relative_error(curves[name], reference.curves[name], path=reference.path)
    truth = at_equal(curves[at], reference.curves[at], reference.curves[name])
    return relative_error(curves[name], truth)


def _solution_rows(
    plan: Plan, method: str, resolution: int, solution: Solution, reference: Reference | None
) -> list[dict[str, Any]]:
    rows = []
    count = len(solution.converged)
    common = _common(plan, method, resolution, solution)
    for k in range(count):
        curves = {name: values[k] for name, values in solution.quantities.items()}
        rows += _curve_rows(plan, curves, common | {"realisation": str(k)}, reference)
        for step, row in enumerate(rows[-len(plan.loads.values) :]):
            row["iterations"] = int(solution.iterations[k, step])
            row["violation"] = float(solution.violation[k, step])
            row["converged"] = bool(solution.converged[k, step])
            row["reason"] = solution.reasons.get((k, step), "")
    if count > 1:
        mean = _curve_rows(plan, mean_curves(solution), common | {"realisation": "mean"}, reference)
        for step, row in enumerate(mean):
            row["converged"] = bool(solution.converged[:, step].all())
            for name, values in solution.quantities.items():
                row[f"stderr_{name}"] = float(standard_error(values)[step])
        rows += mean
    return rows


def _common(plan: Plan, method: str, resolution: int, solution: Solution) -> dict[str, Any]:
    where = {"machine": solution.machine} if solution.machine else {}
    return where | {
        "scene": plan.scene.name,
        "method": method,
        "options": plan.scene.methods.of(method).changed(),
        "resolution": resolution,
        "seconds": solution.seconds,
        "setup_seconds": solution.setup_seconds,
        "compile_seconds": solution.compile_seconds,
        "unknowns": solution.unknowns,
        "memory": solution.memory,
    }


def _curve_rows(
    plan: Plan,
    curves: dict[str, np.ndarray],
    common: dict[str, Any],
    reference: Reference | None,
) -> list[dict[str, Any]]:
    axis = plan.loads.axis
    steps = len(plan.loads.values)
    rows = [common | {"step": step} for step in range(steps)]
    own = reference is not None and (
        (reference.method, reference.resolution) == (common["method"], common["resolution"])
    )
    for step, row in enumerate(rows):
        for name, values in curves.items():
            row[name] = float(values[step])
        # What is prescribed stands in the row of a step that failed, too.
        for name, values in plan.loads.columns.items():
            if not np.isfinite(row.get(name, np.nan)):
                row[name] = float(values[step])
        row["reference"] = "" if reference is None else reference.label
    if reference is None:
        return rows
    asked = [n for n in plan.compared if n in reference.curves]
    for name in SCALARS:
        if name not in curves or name not in reference.curves:
            continue
        at = main_axis(axis, name)
        bar = uncertainty_of(axis, reference, name, at)
        error = errors_of(axis, curves, reference, name, at)
        for step, row in enumerate(rows):
            row[f"error_{name}"] = float("nan") if own else float(error[step])
            row[f"reference_uncertainty_{name}"] = float(bar[step])
    for row in rows:
        bars = [row.get(f"reference_uncertainty_{name}", np.nan) for name in asked]
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
    method: str,
    resolution: int,
    solution: Solution,
    reference: Reference | None,
) -> list[dict[str, Any]]:
    if reference is None or (method, resolution) == (reference.method, reference.resolution):
        return []
    axis = plan.loads.axis
    curves = mean_curves(solution)
    common = _common(plan, method, resolution, solution)
    del common["compile_seconds"], common["options"]
    common["converged"] = bool(solution.converged.all())
    rows = []
    for name in plan.compared:
        if name == "pressure":
            rows += [
                {"quantity": each["quantity"], "at": "last load"}
                | _measure(plan, np.array([each["error"]]), np.array([each["bar"]]))
                for each in pressure_measures(plan, solved, method, resolution, reference)
            ]
            continue
        if name not in curves or name not in reference.curves:
            continue
        for at in _compared_at(plan, name):
            error = errors_of(axis, curves, reference, name, at)
            parts = error_sources(plan, solved, method, resolution, reference, name, at)
            bar = combined(*parts.values())
            rows.append({"quantity": name, "at": at} | _measure(plan, error, bar))
    return [common | row for row in rows]


def _compared_at(plan: Plan, name: str) -> tuple[str, ...]:
    """Return at which equal loads a quantity is compared: never at itself."""
    loads = plan.loads
    if loads.compares_itself:
        return tuple(at for at in (loads.axis, OTHER_AXIS[loads.axis]) if at != name)
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


def truth_bars(plan: Plan, solved: Solved, reference: Reference) -> dict[str, dict[str, Any]]:
    """Return the widest bar of the truth in each quantity that it gives, and at which load step.

    On the very same surfaces: what decides whether the truth may itself be taken as an answer.
    """
    found = {}
    for name in plan.compared:
        if name == "pressure":
            known = truth_bar(plan, solved, reference)
            bar = np.array([] if known is None else [known])
        else:
            at = main_axis(plan.loads.axis, name)
            same = reference.curves.get(name)
            bar = (
                np.array([])
                if same is None
                else uncertainty_of(plan.loads.axis, reference, name, at, same_surfaces=True)
            )
        if len(bar):
            widest = judged(np.zeros(len(bar)), bar, plan.scene.compare.tolerance)
            found[name] = {"bar": widest.uncertainty, "step": widest.step}
    return found


def error_sources(
    plan: Plan,
    solved: Solved,
    method: str,
    resolution: int,
    reference: Reference,
    name: str,
    at: str,
) -> Sources:
    """Return the sources of an error's bar: the reference's, the ensemble's, the method's grid's.

    3-D methods solve the very same surfaces as the reference, so the scatter over realisations
    is not an uncertainty of the difference.
    """
    line = METHODS[method].dimension == 1
    parts = sources_of(plan.loads.axis, reference, name, at, same_surfaces=not line)
    solution = solved[method, resolution]
    if line:
        parts[LINES] = ensemble_uncertainty(solution.quantities[name], path=solution.path)
        if resolution == finest(solved, method):
            own = own_discretisation(solved, method, name)
            parts[SPRINGS] = np.nan_to_num(own, nan=0.0)
    return parts
