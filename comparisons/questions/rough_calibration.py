"""Calibration of bars on rough surfaces: changes between grids, against finer grids.

Surfaces of 16 x 16 points are solved on grids of 16, 32 and 64. The bar of all three, and that of
the finer two, is held against the answer on 512: eight times finer. Hurst exponents, cutoffs and
roll-offs vary, free and periodic, at loads over two decades; and parts of the height map that comes
with the suite. Cases are single surfaces, and the means over them, as ensembles use.

Bars of penetration and stiffness of the first surface of each spectrum are held against proved
intervals, too. A load of these takes some seconds, the solves that it judges far less: the other
two surfaces would only add time, and a measured patch has no theorem.

The factors (`uncertainty.Share`) are fixed on FITTING, which has the Hurst exponents of either
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
from comparisons.judging.uncertainty import Kind
from comparisons.methods.normal.proved import enclosures
from comparisons.methods.solver import Refused
from comparisons.questions.calibration_cases import Case, held_against
from comparisons.results.confidence import ROUGH_SURFACES as QUANTITIES
from comparisons.scene.scene import load_scene, make_scene
from comparisons.solving.inquiries import Inquiry, curves
from comparisons.solving.plan import Plan
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solved

POINTS, LEVELS, TRUTH = 16, (16, 32, 64), 512
SERIES = (LEVELS, LEVELS[1:])
REALISATIONS = 3
LOADS = [0.002, 0.01, 0.05, 0.2]
# Cells to the shortest wave, and longest waves to a side.
CUTOFFS, ROLL_OFFS = (2, 4), (1, 2)
MAP = "measured-map"
# Why the bars of other surfaces than the first have no proved interval.
OTHERS = "of the second and third surface of a spectrum, and of means, for the time they take"


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
    sides = sides_of(_plan(surface | ({} if "crop" in surface else {"realisations": 1})))
    return list(_cases(half, name, solved, sides))


def sides_of(plan: Plan) -> dict[str, np.ndarray] | str:
    """Return the sides of the proved intervals; why there are none if no theorem is for it."""
    try:
        return enclosures(plan.scene, plan.geometry, plan.loads)
    except Refused as refusal:
        return f"because {refusal}"


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


def _cases(
    half: str, name: str, solved: Solved, sides: dict[str, np.ndarray] | str
) -> Iterator[Case]:
    grids = {n: solved[GRID, n] for n in (*LEVELS, TRUTH)}
    if not all(solution.converged.all() for solution in grids.values()):
        return
    kind: Kind = "periodic" if grids[TRUTH].contact == "periodic" else "free"
    for quantity, levels in product(QUANTITIES, SERIES):
        values = np.array([grids[n].quantities[quantity] for n in (*levels, TRUTH)])
        single = [values[:, k] for k in range(values.shape[1])]
        means = [values.mean(axis=1)] if len(single) > 1 else []
        finest = grids[levels[-1]].quantities
        areas, counted = (
            _of_surfaces(finest[name], bool(means)) for name in ("contact_area", "contact_area_raw")
        )
        for number, series in enumerate((*single, *means)):
            known = series[:-1]
            case = Case(
                half=half,
                shape=name,
                method=GRID,
                control="force",
                quantity=quantity,
                kind=kind,
                resolutions=levels,
                errors=np.abs(relative_error(known[-1], series[-1])),
                curves=known,
                bars_beside_grid=np.zeros(len(LOADS)),
                areas=areas[number],
                counted=counted[number] if quantity == "contact_area" else None,
            )
            yield held_against(OTHERS if number else sides, case)


def _of_surfaces(values: np.ndarray, mean: bool) -> list[np.ndarray]:
    """Return the values (surfaces, loads) of each surface, then their mean where it is a case."""
    return [*values, *([values.mean(axis=0)] if mean else [])]
