"""Calibration of bars on rough surfaces: the last change between two grids, against finer grids.

Surfaces of 32 x 32 points are solved on grids of 32 and 64, whose bar is held against the answer
on 512: eight times finer. Hurst exponents, cutoffs and roll-offs vary, free and periodic, at loads
over two decades; and parts of the height map that comes with the suite. Cases are single surfaces,
and the means over them, as ensembles use.

The factor of each quantity (`uncertainty.RoughRule`) is fixed on FITTING; REPORTED has other Hurst
exponents, and other parts of the map.
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
POINTS, LEVELS, TRUTH = 32, (32, 64), 512
REALISATIONS = 2
LOADS = [0.002, 0.01, 0.05, 0.2]
# Cells to the shortest wave, and longest waves to a side.
CUTOFFS, ROLL_OFFS = (2, 4), (1, 4)
MAP = "measured-map"
# Required coverage of each quantity on the fitting half; and the factors that are tried.
LEAST_COVERAGE, FACTORS = 0.975, np.arange(0.3, 5.05, 0.1)


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


FITTING: dict[str, dict[str, Any]] = _spectra((0.3, 0.8)) | _crops(0)
REPORTED: dict[str, dict[str, Any]] = _spectra((0.5, 0.9)) | _crops(POINTS)


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
    grids = [solved[GRID, n] for n in (*LEVELS, TRUTH)]
    if not all(solution.converged.all() for solution in grids):
        return
    for quantity in QUANTITIES:
        values = np.array([solution.quantities[quantity] for solution in grids])
        single = [values[:, k] for k in range(values.shape[1])]
        for series in (*single, *([values.mean(axis=1)] if len(single) > 1 else [])):
            known = series[: len(LEVELS)]
            yield Case(
                half=half,
                shape=name,
                method=GRID,
                control="force",
                quantity=quantity,
                resolutions=LEVELS,
                errors=np.abs(relative_error(known[-1], series[-1])),
                bars=rough_uncertainty(np.array(LEVELS), known, quantity),
                curves=known,
                bars_beside_grid=np.zeros(len(LOADS)),
                rough=True,
            )


def with_rule(case: Case, rule: RoughRule) -> Case:
    """Return a case of a rough surface with the bar of another rule."""
    grids = np.array(case.resolutions)
    return replace(case, bars=rough_uncertainty(grids, case.curves, case.quantity, rule))


def fitted_factors(cases: list[Case]) -> dict[str, float]:
    """Return each quantity's smallest factor that covers enough of the fitting half.

    Quantities that no factor covers are left out.
    """
    factors = {}
    for name in QUANTITIES:
        fitting = [c for c in cases if c.rough and c.half == "fitting" and c.quantity == name]
        for factor in FACTORS if fitting else ():
            rule = replace(ROUGH_RULE, factors=((name, float(factor)),))
            if summary(with_rule(c, rule) for c in fitting).coverage >= LEAST_COVERAGE:
                factors[name] = round(float(factor), 1)
                break
    return factors
