"""Measurement of a claim on its scenes: the error of what is stated, and its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from comparisons.errors import InputError, NotInstalledError
from comparisons.facts.methods import CLOSED_FORM, GRID, INDEPENDENT, METHODS, references
from comparisons.facts.quantities import FIELDS, main_axis
from comparisons.geometry.prepare import IndenterGeometry
from comparisons.judging.fields import field_measures
from comparisons.judging.levels import Levels
from comparisons.judging.metrics import relative_error, rms_and_maximum
from comparisons.judging.refinement import SHARE, refinements
from comparisons.judging.truth import Sources, Truth, candidate, choose_truth
from comparisons.judging.uncertainty import combined
from comparisons.judging.verdicts import OUTSIDE, WITHIN, judged, severity
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refusal
from comparisons.questions.claims.claim import (
    AREA_FROM_STIFFNESS,
    REMAINING_SHARE,
    RESOLUTION,
    Claim,
    scene_of,
)
from comparisons.questions.claims.parameters import Side
from comparisons.questions.experiments import Measurement
from comparisons.questions.experiments.experiment import Effort
from comparisons.solving.inquiries import Inquiry, curves
from comparisons.solving.plan import MethodPlan, Plan
from comparisons.solving.planning import plan_scene, refusal
from comparisons.tasks.solution import Solved

# Largest time in seconds of a further refinement of the reference at full effort.
REFINEMENT_BUDGET = 30.0
# What a measurement says of references that differ by more than their bars; a source of its bar.
DISAGREE = "references disagree"
DISPUTE = "references disagree by"
# Target accuracy of references that only check a closed form.
CHECKING = 0.01
MOST_SPRINGS = 20_000
# Signed error, bar and details of one quantity.
Measured = tuple[float, float, dict[str, float | str]]


def measure_scene(
    claim: Claim, value: float | None, effort: Effort, *, independent: bool
) -> Inquiry[Measurement]:
    """Solve a claim's sides at one value of its parameter and measure the claim's error.

    Full effort refines the reference until its bar is a fifth of the tolerance. Quick effort solves
    the coarsest grid and one of its half first, where three times the bar has to decide, then all
    but the finest of three, then all. If `independent`, all 3-D methods solve, so that references
    check each other; else the cheapest suitable one. InputError if a scene cannot be prepared at
    this value.
    """
    stated, true = claim.sides(value)
    together = true.same_scene(stated)
    judged_here = [claim.method] if together else []
    plan = None
    if true.solved:
        plan = _plan(claim, value, true, effort, judged=judged_here, independent=independent)
    stages = [(plan, 1)]
    if plan is not None and effort == "quick" and claim.factor is None:
        last = plan.methods
        for coarser, safety in ((_but_the_finest, 1), (_coarsest, 3)):
            methods = tuple(
                m if m.method in judged_here else coarser(plan, m) for m in plan.methods
            )
            if methods != last:
                stages.insert(0, (replace(plan, methods=methods), safety))
            last = methods
    for planned, safety in stages:
        if together:
            assert planned is not None
            found = yield from _measure_together(claim, value, effort, planned)
        else:
            found = yield from _measure_apart(claim, value, effort, planned, independent)
        told = judged(found.error, safety * found.uncertainty, claim.tolerance)
        disputed = safety > 1 and DISAGREE in found.details  # their bars are too small there
        if told.word in (WITHIN, OUTSIDE) and not disputed:
            break
    return found


def _measure_together(
    claim: Claim, value: float | None, effort: Effort, plan: Plan
) -> Inquiry[Measurement]:
    """Measure the error of the judged method on the scene of the truth, with springs refined."""
    solved: Solved = yield from curves(plan)
    if effort == "full":
        plan, solved = yield from _truth_refined(plan, solved)
    truth = _truth(claim.true, plan, solved)
    if truth is not None and not _fixed(claim):
        solved = yield from _springs_refined(claim, plan, solved)
    judged_at = Levels.of(solved, claim.method).finest
    if truth is None or judged_at is None:
        return _nothing(value, solved)
    measured = [_measured(claim, plan, solved, truth, name) for name in claim.quantity]
    error, bar, details = _deciding(measured, claim.tolerance)
    details |= {"truth": truth.label, "resolution": float(judged_at)}
    differing = truth.disagreements(plan.compared)
    if differing:
        details[DISAGREE] = " ".join(differing)
    return Measurement(value, error, bar, details)


def _nothing(value: float | None, solved: Solved) -> Measurement:
    reasons = [reason for s in solved.values() for reason in s.reasons.values()]
    details: dict[str, float | str] = {"no result": next(iter(reasons), "nothing was solved")}
    return Measurement(value, np.nan, np.nan, details)


def _deciding(measured: list[Measured], tolerance: float) -> Measured:
    """Return the decisive quantity, as for verdicts on scenes."""
    return min(measured, key=lambda found: severity(judged(found[0], found[1], tolerance)))


def _measure_apart(
    claim: Claim, value: float | None, effort: Effort, true_plan: Plan | None, independent: bool
) -> Inquiry[Measurement]:
    """Measure a claim on two scenes, or a number for one of them."""
    known: list[dict[str, tuple[np.ndarray, Sources]]] = []
    details: dict[str, float | str] = {}
    path = False
    stated, true = claim.sides(value)
    for side, word in ((stated, "stated"), (true, "true")):
        if not side.solved:
            number, width = side.in_si(claim.quantity)
            digits = {"digits of the number": np.array([width / abs(number)])}
            known.append(dict.fromkeys(claim.quantity, (np.array([number]), digits)))
            details[f"source of the {word} value"] = side.source
            continue
        plan = true_plan if side is true else None
        plan = plan or _plan(claim, value, side, effort, independent=independent)
        solved: Solved = yield from curves(plan)
        if side is stated and not _fixed(claim):
            solved = yield from _springs_refined(claim, plan, solved)
        elif side is true and effort == "full":
            plan, solved = yield from _truth_refined(plan, solved)
        found = _truth(side, plan, solved)
        if found is None:
            return _nothing(value, solved)
        values: dict[str, tuple[np.ndarray, Sources]] = {}
        for name in claim.quantity:
            if not found.knows(name):
                raise InputError(f"{found.label}: {name} is not known here")
            sources = found.bar_sources(name, main_axis(found.axis, name))
            sources[DISPUTE] = found.disputed(name)
            if METHODS[found.method].dimension != 3:  # all springs are zero before first yield
                sources = {key: np.nan_to_num(part, nan=0.0) for key, part in sources.items()}
            values[name] = found.curves[name], sources
        known.append(values)
        details[word if side is stated else "truth"] = found.label
        path = path or found.path
        differing = found.disagreements(plan.compared)
        if differing:
            details[DISAGREE] = " ".join(differing)

    def compared(name: str) -> Measured:
        (ours, of_ours), (theirs, of_theirs) = (values[name] for values in known)
        errors = relative_error(ours, theirs, path=path)
        scale = np.ones(errors.shape) if path else np.abs(1 + errors)
        parts = {f"{source}, stated": part * scale for source, part in of_ours.items()}
        parts |= {f"{source}, true": part * scale for source, part in of_theirs.items()}
        error, bar, told = interval(claim, name, errors, parts)
        if errors.size == 1:
            told |= {"value stated": float(ours[0]), "value true": float(theirs[0])}
        return error, bar, told

    error, bar, deciding = _deciding([compared(name) for name in claim.quantity], claim.tolerance)
    return Measurement(value, error, bar, deciding | details)


def _truth(side: Side, plan: Plan, solved: Solved) -> Truth | None:
    """Return the solution that a side is: of its method, else of the best reference."""
    if side.method is not None:
        return candidate(solved, side.method, plan.loads.axis)
    return choose_truth(solved, plan.loads.axis, plan.compared)


def _plan(
    claim: Claim,
    value: float | None,
    side: Side,
    effort: Effort,
    *,
    judged: Sequence[str] = (),
    independent: bool,
) -> Plan:
    """Plan what is judged and what a side needs: its own method, or references.

    Beside a closed form coarse grids suffice. At quick effort, what only checks omits its finest
    grid.
    """
    scene = scene_of(claim, side)
    exact = not isinstance(solver_for(CLOSED_FORM, scene), Refusal)
    methods = [*judged, side.method or CLOSED_FORM]
    for name in methods:
        able = solver_for(name, scene)
        if isinstance(able, Refusal) and able.missing:
            raise NotInstalledError(f"{METHODS[name].title}: {able.reason}")
    if side.method is None:
        if independent or not exact:
            methods.append(GRID)
        if independent and (effort == "full" or not exact):
            methods += INDEPENDENT
        if scene.physics and not exact:
            # Another grid method may be the only half-space with this physics.
            grids = [name for name in references() if METHODS[name].grid]
            methods += grids
            if all(isinstance(solver_for(name, scene), Refusal) for name in grids):
                methods += INDEPENDENT  # no half-space has it: at every value
    more: dict[str, Any] = {"compare.methods": list(dict.fromkeys(methods))}
    if exact and side.method is None:
        more["compare.tolerance"] = CHECKING
    (plan, *_) = plan_scene(scene_of(claim, side, more), effort)
    if effort == "quick" and side.method is None:
        checks = {m for m in methods if exact or (not METHODS[m].grid and scene.physics)}
        checks -= {claim.method}
        made = (_but_the_finest(plan, m) if m.method in checks else m for m in plan.methods)
        plan = replace(plan, methods=tuple(made))
    if not _fixed(claim) or claim.method not in methods:
        return plan
    assert value is not None
    reason = refusal(plan, claim.method, int(value))
    if reason:
        raise InputError(f"{RESOLUTION} {int(value)}: {reason}")
    return replace(plan, methods=tuple(_with(m, claim, (int(value),)) for m in plan.methods))


def _fixed(claim: Claim) -> bool:
    """Return whether the claim is about the judged method at one resolution."""
    return claim.vary is not None and claim.vary.path == (RESOLUTION,)


def _but_the_finest(_: Plan, planned: MethodPlan) -> MethodPlan:
    """Omit the finest of three grids of a method."""
    fewer = planned.resolutions[:-1]
    return replace(planned, resolutions=fewer) if len(fewer) > 1 else planned


def _coarsest(plan: Plan, planned: MethodPlan) -> MethodPlan:
    """Take the coarsest grid of a method and one of its half, where these tell something.

    Fewer than four cells do not, of quadratic elements two do. Of an ensemble the coarsest grid,
    which has most surfaces, is no cheaper than the others. Grids that a scene lists are meant.
    """
    fewer = _but_the_finest(plan, planned)
    listed = plan.scene.compare.resolutions is not None
    if len(planned.resolutions) < 2 or planned.numbers or listed:
        return fewer
    first, elements = planned.resolutions[0], not METHODS[planned.method].grid
    half = max(first // 2, 2) if elements else first // 2
    tells = (2 if elements else 4) <= half < first
    if not tells or refusal(plan, planned.method, half):
        return fewer
    return replace(planned, resolutions=(half, first))


def _with(planned: MethodPlan, claim: Claim, resolutions: tuple[int, ...]) -> MethodPlan:
    return replace(planned, resolutions=resolutions) if planned.method == claim.method else planned


def _truth_refined(plan: Plan, solved: Solved) -> Inquiry[tuple[Plan, Solved]]:
    """Refine the reference to the tolerance within the time limit."""
    solutions = dict(solved)
    for finer in refinements(plan, lambda _: solutions, REFINEMENT_BUDGET):
        plan = finer
        solutions.update((yield from curves(plan, solutions)))
    return plan, solutions


def _springs_refined(claim: Claim, plan: Plan, solved: Solved) -> Inquiry[Solved]:
    """Add springs until convergence: the claim is about the model, not its discretisation."""
    if METHODS[claim.method].dimension == 3 or not isinstance(plan.geometry, IndenterGeometry):
        return solved
    while True:
        levels = Levels.of(solved, claim.method)
        level = levels.finest
        if level is None or 2 * level > MOST_SPRINGS:
            return solved
        quantities = levels.solutions[level].quantities
        bars = [levels.discretisation(name) for name in claim.quantity if name in quantities]
        if not bars or not np.fmax.reduce(bars, axis=None) > SHARE * claim.tolerance:
            return solved
        planned = tuple(_with(m, claim, (2 * level,)) for m in plan.methods)
        solved = yield from curves(replace(plan, methods=planned), solved)


def _measured(claim: Claim, plan: Plan, solved: Solved, truth: Truth, name: str) -> Measured:
    """Return signed error, bar and details of a quantity at the judged method's finest level."""
    if name == AREA_FROM_STIFFNESS:
        # the inverse of D = k/E* (19.13), A = (pi/4) (k/E*)^2, against the true area
        area = np.pi / 4 * (truth.curves["stiffness"] / plan.scene.effective_modulus) ** 2
        errors = area / truth.curves["contact_area"] - 1
        parts = {
            "stiffness, twice": 2 * truth.bar("stiffness"),
            DISPUTE: 2 * truth.disputed("stiffness"),
        }
        # the area of a flat face is known
        if not (isinstance(plan.geometry, IndenterGeometry) and plan.geometry.indenter.flat):
            parts["area"] = truth.bar("contact_area")
        return interval(claim, name, errors, parts)
    levels = Levels.of(solved, claim.method)
    assert levels.finest is not None
    if name in FIELDS:
        measures = field_measures(plan, solved, claim.method, levels.finest, truth)
        for measured, error, bar in measures:
            if measured == name:
                return interval(claim, name, np.array([error]), {"field": np.array([bar])})
        reason = "no pressure field" if not measures else "the true pressure has no finite peak"
        return np.nan, np.nan, {"no result": reason}
    remains = name == REMAINING_SHARE
    name = "residual_depth" if remains else name
    at = claim.at or main_axis(truth.axis, name)
    curves = levels.curves(levels.finest)
    if not truth.knows(name, curves):
        return np.nan, np.nan, {"no result": f"{name} is not known here"}
    parts = truth.error_sources(levels, levels.finest, name, at)
    parts[DISPUTE] = truth.disputed(name)
    apart = levels.solutions[levels.finest].valueless_steps
    errors = truth.errors(curves, name, at, apart)
    if remains:
        depth, whole = truth.curves["penetration"], np.nanmax(truth.curves[name])
        errors = (curves[name] - truth.curves[name]) / depth
        # along a path they are relative to the largest dent; where there is none, it is exact
        parts = {k: np.where(whole > 0, part * whole / depth, 0.0) for k, part in parts.items()}
    return interval(claim, name, errors, parts)


def interval(
    claim: Claim, name: str, errors: np.ndarray, sources: dict[str, np.ndarray]
) -> Measured:
    """Reduce errors with bars over the load steps to one signed error with half-width.

    For any true errors within the bars u, the maximum of |e| lies between max(|e| - u) and max(|e|
    + u), the rms by rms(e) -+ rms(u): the midpoint and half-width of this interval, with the sign
    of the largest error, or of the last. A load step without a value or a bar leaves the upper end
    unknown.
    """
    bars = combined(*sources.values())
    finite = np.isfinite(errors) & np.isfinite(bars)
    if not finite.any():
        return np.nan, np.nan, {"no result": f"{name}: no error, or no bar, at any load step"}
    sizes, widths = np.abs(errors[finite]), bars[finite]
    if claim.measure == "last":
        low, high = sizes[-1] - widths[-1], sizes[-1] + widths[-1]
    elif claim.measure == "rms":
        middle, half = rms_and_maximum(sizes)[0], rms_and_maximum(widths)[0]
        low, high = middle - half, middle + half
    else:
        low, high = np.max(sizes - widths), np.max(sizes + widths)
    told = -1 if claim.measure == "last" else np.argmax(sizes)
    worst = int(np.flatnonzero(finite)[told])
    details: dict[str, float | str] = {"quantity": name}
    details |= {f"bar: {key}": float(part[worst]) for key, part in sources.items() if part[worst]}
    missing = int((~finite).sum())
    if missing:
        details["load steps without a value"] = float(missing)
        if low <= claim.tolerance:
            high = np.inf
    sign = -1.0 if errors[worst] < 0 else 1.0
    return sign * float(0.5 * (low + high)), float(0.5 * (high - low)), details
