"""Calibration of bars: the estimated uncertainty of references against their true error.

Every reference is solved at many resolutions on shapes with a known exact solution. Bars of every
series of resolutions are right if they cover the true error in 95 % of the cases without being far
wider. Rough surfaces of 16 x 16 points, and parts of the map of the suite, are solved on grids of
16, 32 and 64, and held against the answer on 512, singly and as means. Of the first surface of each
spectrum bars are held against proved intervals, too, which take seconds a load.

The factors of the bars (`uncertainty.Share`) are fitted to one half of the shapes and surfaces;
only the other half is reported. Both halves have smooth shapes, kinks and tips, flat punches with
sharp edges, and ellipses; the fitting half has the Hurst exponents of either end.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.facts.methods import CLOSED_FORM, GRID, METHODS
from comparisons.files import read_toml, write_table, write_text
from comparisons.judging.metrics import relative_error
from comparisons.judging.truth import DISCRETISATION, truths
from comparisons.judging.uncertainty import Kind, combined
from comparisons.methods.normal.proved import enclosures
from comparisons.methods.solver import Refused
from comparisons.questions.calibration_cases import Case, Held, held, held_against, table
from comparisons.questions.campaign import Campaign
from comparisons.results.folder import PAGE, Header, Layout
from comparisons.results.record import ROUGH_SURFACES, SINGLE_CONTACTS
from comparisons.scene.scene import load_scene, make_scene
from comparisons.solving.inquiries import Inquiry, curves, together
from comparisons.solving.plan import Plan
from comparisons.solving.planning import plan_scene

Halves = dict[str, dict[str, dict[str, Any]]]
SHAPES: Halves = read_toml(Path(__file__).with_suffix(".toml"))
# Series of resolutions, those of plans and others.
SERIES: dict[str, tuple[tuple[int, ...], ...]] = {
    "bem_fft": ((8, 16, 32), (11, 22, 44), (16, 32, 64), (8, 11, 16), (16, 22, 32)),
    "bem_dense": ((4, 8, 16), (5, 10, 20), (5, 8, 12), (4, 6, 8)),
    "fem": ((2, 3, 4), (3, 4, 6)),
}
TABLE = "calibration.csv"
# The number of bars beside a proved interval, and of those that miss it.
PROVED = "proved.json"
FLAT = ("cylinder", "elliptic_punch")
LOADS = [0.02, 0.03, 0.05, 0.08]

POINTS, LEVELS, TRUTH = 16, (16, 32, 64), 512
ROUGH_SERIES = (LEVELS, LEVELS[1:])
REALISATIONS = 3
ROUGH_LOADS = [0.002, 0.01, 0.05, 0.2]
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


SURFACES: Halves = {
    half: _spectra(hurst)
    | {f"map, points from {x}, {y}": {"crop": [x, y, POINTS, POINTS]} for y in (0, POINTS)}
    for half, hurst, x in (("fitting", (0.3, 0.9), 0), ("reported", (0.5, 0.8), POINTS))
}


@dataclass(frozen=True)
class CalibrationRecord:
    """All bars with their true errors; an interrupted run writes nothing."""

    header: Header
    cases: list[Case]

    @property
    def held(self) -> Held:
        """How many bars are held against theorems, and how many of them are refuted."""
        return held(self.cases)


class Calibration(Campaign[list[Case], CalibrationRecord]):
    """The calibration of all shapes at all resolutions; replaces calibration.csv."""

    layout = Layout(TABLE, (PAGE, PROVED))

    def inquiries(self) -> dict[str, Inquiry[list[Case]]]:
        """Return one inquiry per shape and per kind of rough surface."""
        return {
            name: cases(half, name, table)
            for cases, halves in ((shape_cases, SHAPES), (rough_cases, SURFACES))
            for half, tables in halves.items()
            for name, table in tables.items()
        }

    def record_of(self, header: Header, answers: Mapping[str, list[Case]]) -> CalibrationRecord:
        """Return the cases of the completed shapes in order."""
        cases = (answers.get(name, []) for name in self.inquiries())
        return CalibrationRecord(header, [case for several in cases for case in several])

    def save(self, record: CalibrationRecord) -> None:
        """Write the cases as a table."""
        if not record.header.interrupted:
            write_table(self.directory / TABLE, table(record.cases))
            write_text(self.directory / PROVED, json.dumps(asdict(record.held), indent=2) + "\n")


def shape_cases(
    half: str,
    shape: str,
    table: dict[str, Any],
    series: dict[str, tuple[tuple[int, ...], ...]] = SERIES,
) -> Inquiry[list[Case]]:
    """Solve one shape under both controls; return its cases, but for areas that are given."""
    plans: dict[str, Plan] = {}
    for control in ("penetration", "force"):
        data = {
            "name": "calibration",
            "half_space": {"effective_modulus": 1.0},
            "indenter": table,
            "loading": {control: LOADS},
            # the finest intervals that a scene asks for
            "compare": {"quantities": list(SINGLE_CONTACTS), "tolerance": 1e-3},
        }
        (plan, *_) = plan_scene(make_scene(data, "calibration", Path()))
        # Meshes take seconds and are the same under force control.
        names = [m for m in series if METHODS[m].grid or control == "penetration"]
        levels = {name: tuple(sorted(set(sum(series[name], ())))) for name in names}
        levels[CLOSED_FORM] = (1,)
        methods = (replace(m, resolutions=levels.get(m.method, ())) for m in plan.methods)
        plans[control] = replace(plan, methods=tuple(methods))
    cases: list[Case] = []
    enclosed = {control: sides_of(plan) for control, plan in plans.items()}
    done = yield from together(map(curves, plans.values()))
    for control, solved in zip(plans, done, strict=True):
        exact = solved[CLOSED_FORM, 1].quantities
        for method, grids in [(m, g) for m in series for g in series[m] if (m, g[0]) in solved]:
            part = {(method, n): solved[method, n] for n in grids}
            references = truths(part, control)
            if not references or not all(s.converged.all() for s in part.values()):
                continue
            (truth,) = references
            for name in SINGLE_CONTACTS:
                given = name == "contact_area" and table["shape"] in FLAT
                if name == control or name not in truth.curves or given:
                    continue
                bars = [b for source, b in truth.sources[name].items() if source != DISCRETISATION]
                case = Case(
                    half=half,
                    shape=shape,
                    method=truth.method,
                    control=control,
                    quantity=name,
                    kind=truth.levels.kind,
                    resolutions=tuple(n for _, n in part),
                    errors=np.abs(relative_error(truth.curves[name], exact[name][0])),
                    curves=np.array([solution.quantities[name][0] for solution in part.values()]),
                    bars_beside_grid=combined(*bars),
                    areas=truth.curves["contact_area"],
                )
                cases.append(held_against(enclosed[control], case))
    return cases


def rough_cases(half: str, name: str, surface: dict[str, Any]) -> Inquiry[list[Case]]:
    """Solve the surfaces of one spectrum; return their cases, and those of their mean."""
    solved = yield from curves(_rough_plan(surface))
    sides = sides_of(_rough_plan(surface | ({} if "crop" in surface else {"realisations": 1})))
    grids = {n: solved[GRID, n] for n in (*LEVELS, TRUTH)}
    if not all(solution.converged.all() for solution in grids.values()):
        return []
    kind: Kind = "periodic" if grids[TRUTH].contact == "periodic" else "free"

    def with_mean(several: np.ndarray) -> list[np.ndarray]:
        return [*several, several.mean(axis=0)] if len(several) > 1 else [*several]

    cases = []
    for quantity, levels in product(ROUGH_SURFACES, ROUGH_SERIES):
        values = np.array([grids[n].quantities[quantity] for n in (*levels, TRUTH)])
        finest = grids[levels[-1]].quantities
        areas, counted = (with_mean(finest[n]) for n in ("contact_area", "contact_area_raw"))
        for number, series in enumerate(with_mean(values.swapaxes(0, 1))):
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
                bars_beside_grid=np.zeros(len(ROUGH_LOADS)),
                areas=areas[number],
                apparent=grids[TRUTH].apparent_area,
                counted=counted[number] if quantity == "contact_area" else None,
            )
            cases.append(held_against(OTHERS if number else sides, case))
    return cases


def sides_of(plan: Plan) -> dict[str, np.ndarray] | str:
    """Return the sides of the proved intervals; why there are none if no theorem is for it."""
    try:
        return enclosures(plan.scene, plan.geometry, plan.loads)
    except Refused as refusal:
        return f"because {refusal}"


def _rough_plan(surface: dict[str, Any]) -> Plan:
    changes = {
        "loading": {"force": {"values": ROUGH_LOADS, "relative_to": "E* A0 h'"}},
        "compare": {"quantities": list(ROUGH_SURFACES), "methods": [GRID]},
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
