"""The record of one scene: rows, errors, verdicts and summary of its solutions."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from comparisons.facts.methods import METHODS
from comparisons.facts.quantities import CURVES, FIELDS, main_axis, quantity
from comparisons.formatting import count, number
from comparisons.geometry.prepare import RoughGeometry
from comparisons.judging.fields import distribution_rows, field_bar, field_measures
from comparisons.judging.levels import Levels
from comparisons.judging.metrics import rms_and_maximum, sizes_along_path
from comparisons.judging.truth import (
    EXACT,
    NO_REFERENCE,
    Bar,
    Reference,
    Truth,
    choose_truth,
    verified,
)
from comparisons.judging.uncertainty import combined
from comparisons.judging.verdicts import LAST_LOAD, NAN, NO_RESULT, OUTSIDE, Verdict, judged
from comparisons.methods.normal.proved import enclosures_asked_for, warm_up
from comparisons.reasons import UNJUDGED
from comparisons.results.record import NOBODY, SceneRecord
from comparisons.results.rows import Rows
from comparisons.solving.execution import THREADS, this_machine
from comparisons.solving.plan import Plan
from comparisons.tasks.solution import FLAGS, Solved

# Realisations that have rows of their own: bands need no more, and lines come in tens of thousands.
MOST_REALISATIONS = 450
# On grids that are coarser than the finest, of which nothing draws a band.
MOST_COARSE = 20
BARS = "reference_uncertainty"
TIMES = ("seconds", "setup_seconds", "seconds_all", "setup_seconds_all", "compile_seconds")
# The columns of errors, bars and times.
SHORT = {BARS, *TIMES, *(f"{start}_{name}" for start in ("error", BARS) for name in CURVES)}
# Of values of single surfaces, and of their errors: their scatter is in the second.
DIGITS, ERROR_DIGITS = 8, 5


def record_scene(
    plan: Plan,
    solved: Solved,
    fields: Mapping[tuple[str, int], Path] | None = None,
    *,
    prove: bool = True,
) -> SceneRecord:
    """Compare all solutions of a scene with its best reference; `fields`: files with last arrays.

    To `prove` (hold the truth against theorems, where the scene asks) can outlast the solves.
    """
    scene, quantities = plan.scene, plan.compared
    truth = choose_truth(solved, plan.loads.axis, quantities)
    levels = {method: Levels.of(solved, method) for method, _ in solved}
    tables = [_rows(plan, levels[method], n, truth) for method, n in solved]
    nowhere = {"options": "", "resolution": NAN, "step": NAN, **dict.fromkeys(FLAGS, False)}
    tables += [
        pd.DataFrame([{"scene": scene.name, "method": m.method, **nowhere, "reason": m.reason}])
        for m in plan.methods
        if not m.supported
    ]
    table = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()
    reference, verification = NO_REFERENCE, None
    disagreements: tuple[str, ...] = ()
    if truth is not None:
        if prove and scene.compare.proved:
            warm_up(scene.rough, plan.geometry.periodic)
        started = time.perf_counter()
        sides = enclosures_asked_for(scene, plan.geometry, plan.loads) if prove else {}
        if sides:
            verification = verified(truth, sides, time.perf_counter() - started)
            own = (table["method"] == truth.method) & (table["resolution"] == truth.resolution)
            steps = table.loc[own, "step"].astype(int)
            for name, values in sides.items():
                table.loc[own, name] = values[steps]
        titles = {planned.method: planned.title for planned in plan.methods}
        disagreements = truth.disagreements(quantities, scene.compare.tolerance, titles)
        every = truth.disagreements(quantities, titles=titles)
        bars = {}  # the widest of each quantity: whether the truth may itself be the answer
        sources: dict[str, dict[str, list[float]]] = {}  # at each load, where it is judged
        for name in quantities:
            bar: Any = None
            sources[name] = {}
            if name in FIELDS:
                bar = field_bar(plan, truth, name)
            elif truth.knows(name):
                bar = truth.bar(name, same_surfaces=True)
                parts = truth.bar_sources(name, main_axis(truth.axis, name))
                at_loads = np.ones(len(truth.curves[name]))
                sources[name] = {
                    source: (part * at_loads).tolist() for source, part in parts.items()
                }
            if bar is not None:
                decided = judged(np.zeros(np.size(bar)), bar, scene.compare.tolerance)
                bars[name] = Bar(decided.uncertainty, decided.step)
        known = {name: np.array([bar.bar]) for name, bar in bars.items() if name in FIELDS}
        reference = Reference(
            method=truth.method,
            resolution=truth.resolution,
            text=truth.sentence(quantities, known, titles),
            sources=sources,
            bars=bars,
            footnotes=tuple(text for text in every if text not in disagreements),
            proved=verification,
            chance=chance(plan, truth),
        )
        disagreements += verification.sentences if verification else ()
    # Eight digits of errors, bars and times do, and make a quarter of the file less; absurd ones
    # are beyond single precision. By their decimals they are what will be read back.
    for name in table:
        if name in SHORT and not (table[name].abs() > 1e37).any():
            table[name] = table[name].astype(np.float32).astype(str).astype(float)
    # The columns of the machine come last, as far as no solution knows its own.
    for name, value in {"threads": THREADS, "machine": this_machine()}.items():
        table[name] = table.pop(name).fillna(value) if name in table else value
    record = SceneRecord(
        name=scene.name,
        title=scene.heading,
        text=scene.text,
        control=plan.loads.control,
        axis=plan.loads.axis,
        quantities=quantities,
        tolerance=scene.compare.tolerance,
        plan=plan.record,
        reference=reference,
        verdicts=tuple(
            verdict
            for method, resolution in solved
            for verdict in _verdicts(plan, solved, levels[method], resolution, truth)
        ),
        disagreements=disagreements,
        rows=Rows.of(table),
        distributions=Rows.of(pd.DataFrame(distribution_rows(plan, solved))),
        fields=dict(fields or {}),
    )
    return replace(record, verdicts=explained(record))


def _rows(plan: Plan, levels: Levels, resolution: int, truth: Truth | None) -> pd.DataFrame:
    """Return the rows of a solution: of its first surfaces and of lost ones, and the mean over all.

    Bars, standard errors and the machine of several surfaces are in the rows of their mean.
    """
    solution, method = levels.solutions[resolution], levels.method
    count, steps = solution.converged.shape
    most = MOST_REALISATIONS if resolution == levels.finest else MOST_COARSE
    lost = ~solution.converged.all(axis=1)
    shown = np.flatnonzero((np.arange(count) < most) | lost)[:MOST_REALISATIONS]
    several = count > 1  # rows of a mean at each step
    names = [*map(str, shown), *["mean"] * several]
    # rows of one of several surfaces
    single = np.repeat([several and name != "mean" for name in names], steps).astype(bool)

    def with_mean(surfaces: np.ndarray, mean: np.ndarray | float) -> np.ndarray:
        """Return the shown ones of values (surfaces, steps), and below them those of the mean."""
        below = [np.broadcast_to(mean, steps)] * several
        return np.vstack([surfaces[shown], *below])

    def of_mean(values: np.ndarray) -> np.ndarray:
        """Return values (steps,) in the rows of the mean, or of the only surface."""
        return np.where(single, np.nan, np.tile(values, len(names)))

    means = levels.curves(resolution) if several else {}
    curves = {
        name: with_mean(values, means.get(name, np.nan))
        for name, values in solution.quantities.items()
    }
    # times are of one surface or line, unless "all"
    table: dict[str, Any] = {
        "scene": plan.scene.name,
        "method": method,
        "options": plan.scene.methods.of(method).changed(),
        "resolution": resolution,
        "surfaces": count,
        "seconds": solution.seconds / count,
        "setup_seconds": solution.setup_seconds / count,
        **levels.cost(resolution),
        "compile_seconds": solution.compile_seconds,
        "unknowns": solution.unknowns,
        "memory": solution.memory,
        "realisation": np.repeat(np.array(names, dtype=object), steps),
        "step": np.tile(np.arange(steps), len(names)),
    }
    table |= {name: values.astype(float).ravel() for name, values in curves.items()}
    # What is prescribed stands in the row of a step that failed, and in place of its rounding.
    for name, values in plan.loads.columns.items():
        prescribed = np.tile(np.asarray(values, dtype=float), len(names))
        solved = table.get(name, np.full(len(prescribed), np.nan))
        other = np.abs(solved - prescribed) > EXACT * np.abs(prescribed)
        table[name] = np.where(other, solved, prescribed)

    table["reference"] = "" if truth is None else truth.label
    last: dict[str, Any] = {}  # columns of means alone come last
    bars = last if several else table
    if truth is not None:
        widest = np.full(steps, np.nan)
        is_truth = (truth.method, truth.resolution) == (method, resolution)
        for name in CURVES:
            if not truth.knows(name, curves):
                continue
            bar, at = truth.bar(name), main_axis(truth.axis, name)
            error = truth.errors(curves, name, at, solution.valueless_steps).ravel()
            table[f"error_{name}"] = np.full(error.size, np.nan) if is_truth else error
            bars[f"{BARS}_{name}"] = of_mean(bar)
            if name in plan.compared:
                widest = np.fmax(widest, np.where(np.isfinite(bar), bar, np.nan))
        bars[BARS] = of_mean(widest)
    # many surfaces make a large file: fewer digits of each
    for name in table if several else ():
        digits = DIGITS if name in curves else ERROR_DIGITS if name.startswith("error_") else 0
        if digits:
            table[name][single] = [float(f"{v:.{digits}g}") for v in table[name][single]]

    table["iterations"] = with_mean(solution.iterations, np.nan).ravel()
    table["violation"] = with_mean(solution.violation, np.nan).ravel()
    for name in FLAGS:
        flags = getattr(solution, name)
        table[name] = with_mean(flags, flags.all(axis=0)).ravel()
    reasons = np.full((len(names), steps), "", dtype=object)
    places = {int(k): place for place, k in enumerate(shown)}
    for (k, step), reason in solution.reasons.items():
        if k in places:
            reasons[places[k], step] = reason
    table["reason"] = reasons.ravel()
    if solution.machine:
        table["machine"] = np.where(single, "", solution.machine)
    for name in curves if several else ():
        last[f"stderr_{name}"] = of_mean(levels.standard_error(name, resolution))
    return pd.DataFrame(table | last)


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
            band = {"outside_band": beyond} if at == main_axis(truth.axis, name) else {}
            own = {}
            if plan.loads.is_path:
                own = over_own_value(errors, bars, truth.curves[name], plan.scene.compare.tolerance)
            yield verdict(name, at, errors, bars, **single, **band, **own)


def over_own_value(
    errors: np.ndarray, bars: np.ndarray, values: np.ndarray, tolerance: float
) -> dict[str, Any]:
    """Return the error over the value itself that is furthest outside, and its step; or nothing.

    Errors and bars are over the largest value of the path, which hides those of small loads.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        share = sizes_along_path(values) / np.abs(values)
        low = (np.abs(errors) - bars) * share
    low = np.where(np.isfinite(low), low, -np.inf)
    step = int(np.argmax(low))
    if low[step] <= tolerance:
        return {}
    return {"own_error": float(errors[step] * share[step]), "own_step": step}


# Single lines scatter beside their mean, and a time of one line belongs to their errors. The one
# surface of a measured map is a sample like the lines with its spectrum: where its value lies among
# theirs, the error of their mean may be no more than scatter. 90 % of the lines lie in this band.
BAND = (0.05, 0.95)
FEWEST_LINES = 20  # fewer have no such quantiles


def single_errors(errors: np.ndarray) -> dict[str, float]:
    """Return the band of single realisations' errors (m, k), at the step where it is widest."""
    known = np.isfinite(errors).sum(axis=0) >= FEWEST_LINES
    if not known.any():
        return {}
    low, high = np.full((2, errors.shape[1]), np.nan)
    low[known], high[known] = np.nanquantile(errors[:, known], BAND, axis=0)
    step = int(np.nanargmax(np.fmax(np.abs(low), np.abs(high))))
    ends = float(low[step]), float(high[step])
    return {"single_low": ends[0], "single_high": ends[1], "single_step": step}


def steps_outside(
    judged: Levels, resolution: int, truth: Truth, name: str
) -> tuple[int, ...] | None:
    """Return the load steps, from 0, at which the surface is outside the band of the lines.

    By more than the bar of its value. None where there is no such band.
    """
    solution = judged.solutions[resolution]
    values = solution.quantities.get(name)
    one_surface = truth.levels.rough and len(truth.solution.converged) == 1
    if METHODS[judged.method].dimension != 1 or not one_surface or values is None:
        return None
    if len(values) < FEWEST_LINES or name not in truth.curves or not np.isfinite(values).all():
        return None
    low, high = np.quantile(values, BAND, axis=0)
    value = truth.curves[name]
    bar = np.abs(value) * np.nan_to_num(truth.bar(name), nan=np.inf)
    beyond = (value - bar > high) | (value + bar < low)
    return tuple(np.flatnonzero(beyond).tolist())


NOT_COMPUTED = "not computed by the method"


def explained(record: SceneRecord) -> tuple[Verdict, ...]:
    """Return a record's verdicts with one on each asked quantity of each setting, or why none."""
    nothing = {name: _why_unanswered(record, name) for name in record.quantities}
    verdicts = {
        (item.method, item.resolution, item.quantity, item.at): item for item in record.verdicts
    }
    for method in record.methods:
        missing = {name: _why_missing(record, name, method) for name in record.quantities}
        for level in record.resolutions_judged(method) or [0]:
            for name, reason in missing.items():
                key = (method, level, name, record.equal_at(name))
                found = verdicts.get(key)
                if found and found.word != NO_RESULT:
                    continue
                verdicts[key] = Verdict(
                    method=method,
                    resolution=float(level),
                    quantity=name,
                    at=key[-1],
                    tolerance=record.tolerance,
                    reason=nothing[name] or reason,
                    counts=not nothing[name],
                    offered=bool(nothing[name]) or reason != NOT_COMPUTED,
                )
    return tuple(verdicts.values())


def _why_unanswered(record: SceneRecord, name: str) -> str:
    if not record.reference.method:
        return "no reference: no closed form or 3-D method solved it"
    at = record.equal_at(name)
    known = (item for item in record.verdicts if (item.quantity, item.at) == (name, at))
    if any(math.isfinite(item.error) for item in known):
        return ""
    if zero := _why_zero(record, name, record.solved[name]):
        return f"zero in every answer: {zero}"
    if name in record.reference.bars:
        return "prescribed, the same for all" if name == record.control else ""
    judged = {item.quantity for item in record.verdicts if not item.reason}
    if name not in judged and not np.isfinite(record.solved[name]).any():
        return ": ".join(filter(None, [NOBODY, quantity(name).only]))
    truth = record.title_of(record.reference.method)
    return f"{UNJUDGED} ({truth})"


def _why_missing(record: SceneRecord, name: str, method: str) -> str:
    """Return why a method has no error in a quantity that others have."""
    title = record.title_of(method)
    rows, truth = (
        record.rows.where(record.rows["method"] == which)
        for which in (method, record.reference.method)
    )
    lost, untrue = ([text for text in part["reason"] if text] for part in (rows, truth))
    if method == record.reference.method:
        return lost[0] if lost else "this is the reference itself"
    if record.not_asked(method):
        return f"the {title} was not asked for"
    refused = record.unsupported
    if method in refused:
        return refused[method]
    if name in FIELDS:  # no column of the rows, and compared at the last load alone
        rows = rows.where(rows["step"] == record.steps - 1)
        lost = [reason for reason in rows["reason"] if reason]
        own = (item for item in record.verdicts if (item.method, item.quantity) == (method, name))
        gives = any(item.word != NO_RESULT for item in own)
    else:
        gives = np.isfinite(rows[name][rows["converged"]]).any()
    if lost and (gives or not rows["converged"].any()):
        return lost[0]
    if not gives or name in FIELDS:
        return NOT_COMPUTED
    true = record.setting_rows(record.reference.method, record.reference.resolution)
    if zero := _why_zero(record, name, true[name]):
        return f"zero in the reference ({zero}), but not in the {title}: no relative error"
    if untrue:
        return f"the reference has no value at these loads: {untrue[0]}"
    return f"no value of the {title} is in the reference's range of {record.equal_at(name)}"


def _why_zero(record: SceneRecord, name: str, values: np.ndarray) -> str:
    """Return why a quantity is zero at all loads; "" where it is not."""
    known = values[np.isfinite(values)]
    if not len(known) or known.any():
        return ""
    area = record.solved["contact_area"]
    if np.isfinite(area).any() and not np.nan_to_num(area).any():
        return "nothing touches at any load"
    return "nothing yields" if "plasticity" in quantity(name).physics else "nothing happens"


# F/(E* A0 h') from which on claims have compared lines with surfaces (rough_area.toml).
LIGHTEST = 1e-3
# Contacts below which the area of a single one is a large part of the whole.
FEWEST = 30
# Of the apparent area: above it contacts are few because they have merged, and surfaces alike.
MERGED = 0.1
UNKNOWN = np.array([np.nan])


def chance(plan: Plan, truth: Truth | None) -> str:
    """Return why lines that agree at the heaviest load do so by chance; "" where they do not."""
    geometry = plan.geometry
    if truth is None or not isinstance(geometry, RoughGeometry) or plan.scene.physics:
        return ""
    reasons = []
    force, area, contacts = (
        float(truth.curves.get(name, UNKNOWN)[-1])
        for name in ("force", "contact_area", "contact_count")
    )
    load = force / (plan.scene.effective_modulus * geometry.area * geometry.rms_slope)
    if load < LIGHTEST:
        reasons.append(f"F/(E* A₀ h') = {number(load)}, below {number(LIGHTEST, 1)}")
    surfaces = max(len(solution.converged) for solution in truth.levels.solutions.values())
    if area < MERGED * geometry.area and surfaces * contacts < FEWEST:
        number_of = count(surfaces * contacts)
        several = "" if number_of == "1" else "s"
        reasons.append(f"{number_of} contact{several}, fewer than {FEWEST}")
    if area < MERGED * geometry.area and surfaces == 1 and plan.scene.random:
        reasons.append("one surface of the many that its spectrum allows")
    return " and ".join(reasons)
