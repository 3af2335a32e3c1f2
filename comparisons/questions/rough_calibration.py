"""Calibration of bars on rough surfaces: the last change between grids, against finer grids.

Surfaces of 16 x 16 points are solved on grids of 16, 32 and 64. The bar of all three, and that of
the finer two, is held against the answer on 512: eight times finer. Hurst exponents, cutoffs and
roll-offs vary, free and periodic, at loads over two decades; and parts of the height map that comes
with the suite. Cases are single surfaces, and the means over them, as ensembles use.

The factors (`uncertainty.RoughRule`) are fixed on FITTING, which has the Hurst exponents of either
end; REPORTED has those between, and other parts of the map.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.facts.methods import GRID
from comparisons.judging.metrics import relative_error
from comparisons.judging.uncertainty import ROUGH_RULE, RoughRule, rough_uncertainty
from comparisons.questions.calibration_cases import Case, summary
from comparisons.scene.scene import load_scene, make_scene
from comparisons.solving.inquiries import Inquiry, curves
from comparisons.solving.planning import Plan, plan_scene
from comparisons.tasks.solution import Solved

QUANTITIES = ("contact_area", "penetration", "mean_gap", "stiffness")
POINTS, LEVELS, TRUTH = 16, (16, 32, 64), 512
SERIES = (LEVELS, LEVELS[1:])
REALISATIONS = 3
LOADS = [0.002, 0.01, 0.05, 0.2]
# Cells to the shortest wave, and longest waves to a side.
CUTOFFS, ROLL_OFFS = (2, 4), (1, 2)
MAP = "measured-map"
# Required coverage of each quantity on the fitting half, of some 30 cases all but one; the factors
# that are tried; and by how much they are raised, as 30 cases say little about the last per cents.
LEAST_COVERAGE, FACTORS, MARGIN = 0.96, tuple(k / 10 for k in range(1, 51)), 1.1


def _spectra(hurst: tuple[float, ...]) -> dict[str, dict[str, Any]]:
    surfaces = {}
    for h, cutoff, roll_off, periodic in product(hurst, CUTOFFS, ROLL_OFFS, (False, True)):
        name = (
            f"H = {h}, {cutoff} cells, {roll_off} long waves, {'periodic' if periodic else 'free'}"
        )
        surfaces[name] = {
            "kind": "self_affine",
            "hurst": h,
            "size": 1.0,
            "points": POINTS,
            "rms_slope": 0.1,
            "periodic": periodic,
            "short_cutoff": cutoff / POINTS,
            "long_cutoff": 1 / roll_off,
            "realisations": REALISATIONS,
        }
    return surfaces


def _crops(first: int) -> dict[str, dict[str, Any]]:
    corners = [(first, 0), (first, POINTS)]
    return {f"map, points from {x}, {y}": {"crop": [x, y, POINTS, POINTS]} for x, y in corners}


FITTING: dict[str, dict[str, Any]] = _spectra((0.3, 0.9)) | _crops(0)
REPORTED: dict[str, dict[str, Any]] = _spectra((0.5, 0.8)) | _crops(POINTS)


def rough_cases(half: str, name: str, surface: dict[str, Any]) -> Inquiry[list[Case]]:
    """Solve the surfaces of one spectrum; return their cases, and those of their mean."""
    solved = yield from curves(_plan(surface))
    return list(_cases(half, name, solved))


def _plan(surface: dict[str, Any]) -> Plan:
    changes = {
        "loading": {"force": {"values": LOADS, "relative_to": "E* A0 h'"}},
        "compare": {"quantities": list(QUANTITIES), "methods": [GRID]},
    }
    if "crop" in surface:
        scene = load_scene(MAP, changes | {"surface.crop": surface["crop"]})
    else:
        data = {"name": "calibration", "half_space": {"effective_modulus": 1.0}} | changes
        scene = make_scene(data | {"surface": surface}, "calibration", Path())
    plan = plan_scene(scene)[0]
    levels = {GRID: (*LEVELS, TRUTH)}
    methods = (replace(m, resolutions=levels.get(m.method, ()), numbers=()) for m in plan.methods)
    return replace(plan, methods=tuple(methods))


def _cases(half: str, name: str, solved: Solved) -> Iterator[Case]:
    grids = {n: solved[GRID, n] for n in (*LEVELS, TRUTH)}
    if not all(solution.converged.all() for solution in grids.values()):
        return
    kind = grids[TRUTH].rough
    for quantity, levels in product(QUANTITIES, SERIES):
        values = np.array([grids[n].quantities[quantity] for n in (*levels, TRUTH)])
        single = [values[:, k] for k in range(values.shape[1])]
        for series in (*single, *([values.mean(axis=1)] if len(single) > 1 else [])):
            known = series[:-1]
            yield Case(
                half=half,
                shape=name,
                method=GRID,
                control="force",
                quantity=quantity,
                resolutions=levels,
                errors=np.abs(relative_error(known[-1], series[-1])),
                bars=rough_uncertainty(np.array(levels), known, (quantity, kind)),
                curves=known,
                bars_beside_grid=np.zeros(len(LOADS)),
                rough=kind,
            )


def with_rule(case: Case, rule: RoughRule) -> Case:
    """Return a case of a rough surface with the bar of another rule."""
    grids, quantity = np.array(case.resolutions), (case.quantity, case.rough)
    return replace(case, bars=rough_uncertainty(grids, case.curves, quantity, rule))


def fitted_rule(cases: list[Case]) -> RoughRule:
    """Return the narrowest rule that covers enough of the fitting half.

    Every factor covers LEAST_COVERAGE of its cases with three grids, then `two` as much of all
    cases with two; the factors are then raised by MARGIN. What nothing covers keeps its value.
    """
    fitting = [case for case in cases if case.rough and case.half == "fitting"]
    three = [case for case in fitting if len(case.resolutions) > 2]
    factors = dict(ROUGH_RULE.factors)
    for quantity in factors:
        own = [case for case in three if (case.quantity, case.rough) == quantity]
        rules = {f: replace(ROUGH_RULE, factors=((quantity, f),)) for f in FACTORS}
        factors[quantity] = _narrowest(own, rules, factors[quantity] / MARGIN)
    rule = replace(ROUGH_RULE, factors=tuple(factors.items()))
    two = [case for case in fitting if len(case.resolutions) == 2]
    rules = {f: replace(rule, two=f) for f in FACTORS}
    raised = tuple((quantity, round(MARGIN * f, 2)) for quantity, f in factors.items())
    return replace(rule, factors=raised, two=_narrowest(two, rules, rule.two))


def _narrowest(cases: list[Case], rules: dict[float, RoughRule], other: float) -> float:
    """Return the first of some numbers whose rule covers enough of the cases; else another one."""
    for number, rule in rules.items() if cases else ():
        if summary(with_rule(case, rule) for case in cases).coverage >= LEAST_COVERAGE:
            return number
    return other
