"""Calibration of bars: the estimated uncertainty of references against their true error.

Rough surfaces have a rule and cases of their own (`rough_calibration`). Otherwise every reference
is solved at many resolutions on shapes with a known exact solution. Every series of resolutions
yields a bar, as for any scene, which is compared with the true error of the finest solution. Bars
are right if they cover the error in 95 % of the cases without being far wider.

The parameters of the estimator are fitted to half of the shapes (FITTING); only the other half
(REPORTED) is reported. Both halves have smooth shapes, kinks and tips, flat punches with sharp
edges, and ellipses.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.facts.methods import CLOSED_FORM, METHODS
from comparisons.files import write_table, write_text
from comparisons.judging.metrics import relative_error
from comparisons.judging.truth import GRID, truths
from comparisons.judging.uncertainty import combined
from comparisons.questions import rough_calibration
from comparisons.questions.calibration_cases import Case, Held, held, held_against, table
from comparisons.questions.campaign import Campaign
from comparisons.questions.rough_calibration import rough_cases, sides_of
from comparisons.results.confidence import SINGLE_CONTACTS as QUANTITIES
from comparisons.results.folder import PAGE, Layout
from comparisons.results.header import Header
from comparisons.scene.scene import make_scene
from comparisons.solving.inquiries import Inquiry, curves, together
from comparisons.solving.plan import Plan
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solution, Solved

FITTING: dict[str, dict[str, Any]] = {
    "paraboloid": {"shape": "paraboloid", "radius": 1.0},
    "cone": {"shape": "cone", "slope": 0.1},
    "power law n = 3": {"shape": "power_law", "exponent": 3, "coefficient": 0.1},
    "rounded punch, narrow": {"shape": "rounded_punch", "flat_radius": 0.5, "edge_radius": 2.0},
    "ellipsoid 2 : 1": {"shape": "ellipsoid", "radius_x": 2.0, "radius_y": 1.0},
    "flat ellipse 1.3 : 1": {"shape": "elliptic_punch", "semi_axes": [1.3, 1.0]},
    "flat ellipse 2 : 1": {"shape": "elliptic_punch", "semi_axes": [2.0, 1.0]},
}
REPORTED: dict[str, dict[str, Any]] = {
    "sphere": {"shape": "sphere", "radius": 1.0},
    "power law n = 1.5": {"shape": "power_law", "exponent": 1.5, "coefficient": 0.1},
    "power law n = 4": {"shape": "power_law", "exponent": 4, "coefficient": 0.1},
    "rounded punch, wide": {"shape": "rounded_punch", "flat_radius": 1.0, "edge_radius": 1.0},
    "ellipsoid 5 : 1": {"shape": "ellipsoid", "radius_x": 5.0, "radius_y": 1.0},
    "cylinder": {"shape": "cylinder", "radius": 1.0},
    "flat ellipse 3 : 1": {"shape": "elliptic_punch", "semi_axes": [3.0, 1.0]},
}
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
        halves = {"fitting": FITTING, "reported": REPORTED}
        shapes = {
            name: shape_cases(half, name, table)
            for half, shapes in halves.items()
            for name, table in shapes.items()
        }
        rough = {"fitting": rough_calibration.FITTING, "reported": rough_calibration.REPORTED}
        return shapes | {
            name: rough_cases(half, name, surface)
            for half, surfaces in rough.items()
            for name, surface in surfaces.items()
        }

    def answer(self, header: Header, answers: Mapping[str, list[Case]]) -> CalibrationRecord:
        """Return the cases of the completed shapes in order."""
        names = (*FITTING, *REPORTED, *rough_calibration.FITTING, *rough_calibration.REPORTED)
        return CalibrationRecord(header, [case for n in names for case in answers.get(n, [])])

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
    """Solve one shape under both controls; return its cases."""
    controls = ("penetration", "force")
    # Meshes take seconds and are the same under force control.
    names = {c: [m for m in series if METHODS[m].grid or c == "penetration"] for c in controls}
    plans = [_plan(table, c, {name: series[name] for name in names[c]}) for c in controls]
    cases: list[Case] = []
    enclosed = {control: sides_of(plan) for control, plan in zip(controls, plans, strict=True)}
    for control, solved in zip(controls, (yield from together(map(curves, plans))), strict=True):
        exact = solved[CLOSED_FORM, 1].quantities
        for method in names[control]:
            for levels in series[method]:
                part = {(method, n): solved[method, n] for n in levels}
                cases += _series(half, shape, control, part, exact, table["shape"] in FLAT)
    return [held_against(enclosed[case.control], case) for case in cases]


def _plan(
    table: dict[str, Any], control: str, series: dict[str, tuple[tuple[int, ...], ...]]
) -> Plan:
    data = {
        "name": "calibration",
        "half_space": {"effective_modulus": 1.0},
        "indenter": table,
        "loading": {control: LOADS},
        # the finest intervals that a scene asks for
        "compare": {"quantities": list(QUANTITIES), "tolerance": 1e-3},
    }
    (plan, *_) = plan_scene(make_scene(data, "calibration", Path()))
    levels = {name: tuple(sorted(set(sum(all_levels, ())))) for name, all_levels in series.items()}
    levels[CLOSED_FORM] = (1,)
    methods = (replace(m, resolutions=levels.get(m.method, ())) for m in plan.methods)
    return replace(plan, methods=tuple(methods))


def _series(
    half: str,
    shape: str,
    control: str,
    solved: Solved,
    exact: dict[str, np.ndarray],
    flat: bool,
) -> Iterable[Case]:
    """Yield one case per quantity, without the area of flat punches, which is given."""
    references = truths(solved, control)
    if not references or not all(_complete(solution) for solution in solved.values()):
        return
    (truth,) = references
    levels = tuple(n for _, n in solved)
    for name in QUANTITIES:
        if name == control or name not in truth.curves or (flat and name == "contact_area"):
            continue
        parts = truth.sources[name]
        yield Case(
            half=half,
            shape=shape,
            method=truth.method,
            control=control,
            quantity=name,
            kind=truth.levels.kind,
            resolutions=levels,
            errors=np.abs(relative_error(truth.curves[name], exact[name][0])),
            curves=np.array([solution.quantities[name][0] for solution in solved.values()]),
            bars_beside_grid=combined(*(part for key, part in parts.items() if key != GRID)),
            areas=truth.curves["contact_area"],
        )


def _complete(solution: Solution) -> bool:
    return bool(solution.converged.all())
