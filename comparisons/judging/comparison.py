"""From solutions to rows, errors and measures: everything that is said about one scene."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from comparisons.facts.methods import METHODS
from comparisons.facts.quantities import CURVES, FIELDS, main_axis, quantity
from comparisons.judging.fields import distribution_rows, field_bar, field_measures
from comparisons.judging.levels import Levels
from comparisons.judging.metrics import rms_and_maximum
from comparisons.judging.truth import EXACT, Bar, Truth, Verification, choose_truth, verified
from comparisons.judging.uncertainty import combined
from comparisons.judging.verdicts import LAST_LOAD, NAN, NEVER, OUTSIDE, Verdict, judged
from comparisons.methods.normal.proved import enclosures_asked_for
from comparisons.solving.plan import Plan
from comparisons.tasks.solution import Solved

# Realisations that have rows of their own: bands need no more, and lines come in tens of thousands.
MOST_REALISATIONS = 450
# On grids that are coarser than the finest, of which nothing draws a band.
MOST_COARSE = 20
BARS = "reference_uncertainty"
FLAGS = ("converged", "no_equilibrium", "undetermined")
# Of values of single surfaces, and of their errors: their scatter is in the second.
DIGITS, ERROR_DIGITS = 8, 5


@dataclass(frozen=True)
class Comparison:
    """What was found for one scene, as tables; with its bars held against what is proved."""

    truth: Truth | None
    rows: pd.DataFrame
    verdicts: tuple[Verdict, ...]
    verification: Verification | None = None
    distributions: pd.DataFrame = field(default_factory=pd.DataFrame)


def compare(
    plan: Plan, solved: Solved, constants: dict[str, Any], *, prove: bool = True
) -> Comparison:
    """Compare all solutions of a scene with its best reference.

    `constants` are columns that are the same in every row, unless a solution knows its machine. To
    `prove` (hold the truth against theorems, where the scene asks) can outlast the solves.
    """
    truth = choose_truth(solved, plan.loads.axis, plan.compared)
    levels = {method: Levels.of(solved, method) for method, _ in solved}
    tables = [
        table
        for method, resolution in solved
        for table in _solution_tables(plan, levels[method], resolution, truth)
    ]
    nowhere = {"options": "", "resolution": NAN, "step": NAN, **dict.fromkeys(FLAGS, False)}
    tables += [
        pd.DataFrame(
            [{"scene": plan.scene.name, "method": m.method, **nowhere, "reason": m.reason}]
        )
        for m in plan.methods
        if not m.supported
    ]
    table = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()
    verification = None
    started = time.perf_counter()
    sides: dict[str, np.ndarray] = {}
    if truth is not None and prove:
        sides = enclosures_asked_for(plan.scene, plan.geometry, plan.loads)
    if truth is not None and sides:
        verification = verified(truth, sides, time.perf_counter() - started)
        own = (table["method"] == truth.method) & (table["resolution"] == truth.resolution)
        steps = table.loc[own, "step"].astype(int)
        for name, values in sides.items():
            table.loc[own, name] = values[steps]
    verdicts = [
        verdict
        for method, resolution in solved
        for verdict in _verdicts(plan, solved, levels[method], resolution, truth)
    ]
    # The columns of the machine come last, as far as no solution knows its own.
    for name, value in constants.items():
        known = table.pop(name).fillna(value) if name in table else value
        table[name] = known
    distributions = pd.DataFrame(distribution_rows(plan, solved))
    return Comparison(truth, table, tuple(verdicts), verification, distributions)


def _solution_tables(
    plan: Plan, levels: Levels, resolution: int, truth: Truth | None
) -> Iterator[pd.DataFrame]:
    """Yield the rows of the first surfaces and of lost ones, and of the mean over all."""
    solution = levels.solutions[resolution]
    count = len(solution.converged)
    most = MOST_REALISATIONS if resolution == levels.finest else MOST_COARSE
    lost = ~solution.converged.all(axis=1)
    shown = np.flatnonzero((np.arange(count) < most) | lost)[:MOST_REALISATIONS]
    # what all rows share; times are of one surface or line, unless "all"
    common: dict[str, Any] = {"machine": solution.machine} if solution.machine else {}
    common |= {
        "scene": plan.scene.name,
        "method": levels.method,
        "options": plan.scene.methods.of(levels.method).changed(),
        "resolution": resolution,
        "surfaces": count,
        "seconds": solution.seconds / count,
        "setup_seconds": solution.setup_seconds / count,
        **levels.cost(resolution),
        "compile_seconds": solution.compile_seconds,
        "unknowns": solution.unknowns,
        "memory": solution.memory,
    }
    curves = {name: values[shown] for name, values in solution.quantities.items()}
    names = [str(k) for k in shown]
    reasons = np.full(solution.converged[shown].shape, "", dtype=object)
    places = {int(k): place for place, k in enumerate(shown)}
    for (k, step), reason in solution.reasons.items():
        if k in places:
            reasons[places[k], step] = reason
    own: dict[str, Any] = {
        "iterations": solution.iterations[shown].ravel(),
        "violation": solution.violation[shown].ravel(),
        **{name: getattr(solution, name)[shown].ravel() for name in FLAGS},
        "reason": reasons.ravel(),
    }
    gone = solution.valueless_steps
    columns = _columns(plan, curves, names, common, truth, gone)
    if count > 1:  # bars and the machine are in the rows of the mean
        columns = {name: v for name, v in columns.items() if not name.startswith(BARS)}
        digits = dict.fromkeys(curves, DIGITS)
        digits |= {name: ERROR_DIGITS for name in columns if name.startswith("error_")}
        columns |= {
            name: np.array([f"{value:.{most}g}" for value in columns[name]], dtype=float)
            for name, most in digits.items()
        }
        own["machine"] = ""
    yield pd.DataFrame(common | columns | own)
    if count > 1:
        means = {name: values[None, :] for name, values in levels.curves(resolution).items()}
        own = {name: getattr(solution, name).all(axis=0) for name in FLAGS}
        own |= {f"stderr_{name}": levels.standard_error(name, resolution) for name in means}
        yield pd.DataFrame(common | _columns(plan, means, ["mean"], common, truth, gone) | own)


def _columns(
    plan: Plan,
    curves: dict[str, np.ndarray],
    realisations: list[str],
    common: dict[str, Any],
    truth: Truth | None,
    apart: np.ndarray,
) -> dict[str, Any]:
    """Return values, errors and bars of some realisations, step by step; curves are (m, k)."""
    steps, count = len(plan.loads.values), len(realisations)
    columns: dict[str, Any] = {
        "realisation": np.repeat(np.array(realisations, dtype=object), steps),
        "step": np.tile(np.arange(steps), count),
    }
    columns |= {name: values.astype(float).ravel() for name, values in curves.items()}
    # What is prescribed stands in the row of a step that failed, and in place of its rounding.
    for name, values in plan.loads.columns.items():
        prescribed = np.tile(np.asarray(values, dtype=float), count)
        solved = columns.get(name, np.full(len(prescribed), np.nan))
        other = np.abs(solved - prescribed) > EXACT * np.abs(prescribed)
        columns[name] = np.where(other, solved, prescribed)
    columns["reference"] = "" if truth is None else truth.label
    if truth is None:
        return columns
    is_truth = (truth.method, truth.resolution) == (common["method"], common["resolution"])
    widest = np.full(steps, np.nan)
    for name in CURVES:
        if not truth.knows(name, curves):
            continue
        bar = truth.bar(name)
        error = truth.errors(curves, name, main_axis(truth.axis, name), apart)
        columns[f"error_{name}"] = np.full(error.size, np.nan) if is_truth else error.ravel()
        columns[f"{BARS}_{name}"] = np.tile(bar, count)
        if name in plan.compared:
            widest = np.fmax(widest, np.where(np.isfinite(bar), bar, np.nan))
    return columns | {BARS: np.tile(widest, count)}


def _verdicts(
    plan: Plan, solved: Solved, levels: Levels, resolution: int, truth: Truth | None
) -> Iterator[Verdict]:
    """Yield the verdict on each quantity of a solution, at each equal load."""
    method, solution = levels.method, levels.solutions[resolution]
    if truth is None or (method, resolution) == (truth.method, truth.resolution):
        return
    curves = levels.curves(resolution)

    def verdict(name: str, at: str, error: np.ndarray, bar: np.ndarray, **more: Any) -> Verdict:
        lost = ~np.isfinite(error)
        some_lost = 0 < lost.sum() < lost.size
        found = judged(
            error,
            bar,
            plan.scene.compare.tolerance,
            method=method,
            resolution=float(resolution),
            quantity=name,
            at=at,
            ratio=not plan.loads.is_path,
            rms=rms_and_maximum(error)[0],
            steps=len(plan.loads.values),
            reason=truth.why_missing(curves, name, at, lost) if some_lost else "",
            **more,
        )
        # to cling on where no equilibrium exists: no error tells how wrong
        gone = truth.solution.no_equilibrium.all(axis=0) & (at == truth.axis)
        if some_lost and truth.exact and (gone & lost & ~np.isnan(curves[name])).any():
            return replace(found, word=OUTSIDE, low=NAN, high=NAN)
        return found

    if set(plan.compared) & set(FIELDS):
        for name, error, bar in field_measures(plan, solved, method, resolution, truth):
            signed = not quantity(name).norm
            yield verdict(name, LAST_LOAD, np.array([error]), np.array([bar]), signed=signed)
    for name in plan.compared:
        if not truth.knows(name, curves):
            continue
        beyond = steps_outside(levels, resolution, truth, name)
        axis = plan.loads.axis
        axes = (axis, quantity(axis).counterpart) if plan.loads.compares_itself else (axis,)
        for at in axes:
            # a quantity is never compared at itself, nor where it is prescribed
            if at == name or (name in plan.loads.columns and not plan.loads.compares_itself):
                continue
            errors = truth.errors(curves, name, at, solution.valueless_steps)
            bars = combined(*truth.error_sources(levels, resolution, name, at).values())
            single = single_errors(truth.errors(solution.quantities, name, at))
            band = {}
            if beyond is not None and at == main_axis(truth.axis, name):
                band = {"outside_band": " ".join(str(k + 1) for k in beyond) or NEVER}
            yield verdict(name, at, errors, bars, **single, **band)


def truth_bars(plan: Plan, truth: Truth) -> dict[str, Bar]:
    """Return the truth's widest bar of each quantity: whether it may itself be the answer."""
    widest = {}
    for name in plan.compared:
        bar: Any = None
        if name in FIELDS:
            bar = field_bar(plan, truth, name)
        elif truth.knows(name):
            bar = truth.bar(name, same_surfaces=True)
        if bar is not None:
            decided = judged(np.zeros(np.size(bar)), bar, plan.scene.compare.tolerance)
            widest[name] = Bar(decided.uncertainty, decided.step)
    return widest


# Single lines scatter beside their mean, and a time of one line belongs to their errors. The one
# surface of a measured map is a sample like the lines with its spectrum: where its value lies among
# theirs, the error of their mean may be no more than scatter. 90 % of the lines lie in this band.
BAND = (0.05, 0.95)
# Fewer lines have no such quantiles.
FEWEST = 20


def single_errors(errors: np.ndarray) -> dict[str, float]:
    """Return the band of single realisations' errors (m, k), at the step where it is widest."""
    known = np.isfinite(errors).sum(axis=0) >= FEWEST
    if not known.any():
        return {}
    low, high = np.full((2, errors.shape[1]), np.nan)
    low[known], high[known] = np.nanquantile(errors[:, known], BAND, axis=0)
    step = int(np.nanargmax(np.fmax(np.abs(low), np.abs(high))))
    ends = float(low[step]), float(high[step])
    return {"single_low": ends[0], "single_high": ends[1], "single_step": step}


def steps_outside(judged: Levels, resolution: int, truth: Truth, name: str) -> list[int] | None:
    """Return the load steps, from 0, at which the surface is outside the band of the lines.

    By more than the bar of its value. None where there is no such band.
    """
    solution = judged.solutions[resolution]
    values = solution.quantities.get(name)
    one_surface = truth.levels.rough and len(truth.solution.converged) == 1
    if METHODS[judged.method].dimension != 1 or not one_surface or values is None:
        return None
    if len(values) < FEWEST or name not in truth.curves or not np.isfinite(values).all():
        return None
    low, high = np.quantile(values, BAND, axis=0)
    value = truth.curves[name]
    bar = np.abs(value) * np.nan_to_num(truth.bar(name), nan=np.inf)
    beyond = (value - bar > high) | (value + bar < low)
    return [int(step) for step in np.flatnonzero(beyond)]
