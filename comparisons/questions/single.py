"""Solution of one scene by one method at one resolution, for ``roughline solve``."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from comparisons.errors import InputError
from comparisons.facts.methods import CLOSED_FORM, method_named
from comparisons.facts.quantities import QUANTITIES
from comparisons.files import plain, table_text, write_named, write_named_text
from comparisons.geometry.prepare import IndenterGeometry, RoughGeometry
from comparisons.judging.fields import last_histograms
from comparisons.judging.levels import mean_curves
from comparisons.judging.uncertainty import standard_error
from comparisons.methods.normal.proved import enclosures_asked_for
from comparisons.results.store import vtu_file
from comparisons.scene.scene import Scene, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import Plan
from comparisons.solving.planning import plan_scene, single_resolution
from comparisons.tasks.distributions import edges
from comparisons.tasks.shown_loads import at_step, stored_steps
from comparisons.tasks.solution import REALISATIONS, Solution
from reference.contact import pieces


@dataclass(frozen=True)
class SingleResult:
    """A solution with its plan, and the formats in which it is written."""

    plan: Plan
    method: str
    resolution: int
    solution: Solution

    @cached_property
    def proved(self) -> Mapping[str, np.ndarray]:
        """Sides of the proved intervals that the scene asks for; computed when first read."""
        return enclosures_asked_for(self.plan.scene, self.plan.geometry, self.plan.loads)

    @property
    def converged(self) -> bool:
        """Whether every load step of every realisation has an answer, be it one without values."""
        return bool(self.solution.answered.all())

    @property
    def reasons(self) -> list[str]:
        """The distinct reasons of steps without values."""
        return [
            f"{self.method} at resolution {self.resolution}: {reason}"
            for reason in dict.fromkeys(self.solution.reasons.values())
        ]

    def curves(self) -> dict[str, np.ndarray]:
        """Return the quantities over the load steps: means, and standard errors of ensembles."""
        columns, loads = {}, self.plan.loads.columns
        curves = mean_curves(self.solution)
        for name, load in loads.items():  # it stands at steps without an answer, too
            known = curves.get(name, np.nan)
            curves[name] = np.where(np.isnan(known), load, known)
        # The loads first, the others as all lists of quantities have them, whatever the method.
        for name in dict.fromkeys((*loads, *QUANTITIES, *curves)):
            if name in curves:
                columns[name] = curves[name]
                if name not in loads and len(self.solution.converged) > 1:
                    columns[f"{name}_stderr"] = standard_error(self.solution.quantities[name])
        return columns

    @property
    def half_width(self) -> float:
        """Largest relative 95 % half-width (Student's t) of the means over surfaces or lines."""
        solved, count = self.curves(), len(self.solution.converged)
        shares = [
            values / np.abs(solved[name.removesuffix("_stderr")])
            for name, values in solved.items()
            if name.endswith("_stderr")
        ]
        known = [float(share) for share in np.ravel(shares) if np.isfinite(share)]
        return float(stdtrit(max(count - 1, 1), 0.975) * max(known, default=np.nan))

    def columns(self) -> dict[str, np.ndarray]:
        """Return the curves, and what is proved beside them."""
        return self.curves() | dict(self.proved)

    def __getitem__(self, name: str) -> np.ndarray:
        """Return one of `columns` over the load steps, NaN where unsolved.

        KeyError with the names that there are.
        """
        columns = self.curves()
        if name not in columns:
            columns = self.columns()
        if name not in columns:
            raise KeyError(f"{name!r}: expected one of {', '.join(columns)}")
        return columns[name]

    def to_json(self) -> str:
        """Return the solution as a JSON object, in the documented format of the command line."""
        solution = self.solution
        filled = np.where(np.isnan(solution.violation), -np.inf, solution.violation).max(axis=0)
        document: dict[str, Any] = {
            "scene": self.plan.scene.name,
            "method": self.method,
            "resolution": self.resolution,
            "unknowns": solution.unknowns,
            "realisations": len(solution.converged),
            "seconds": solution.seconds,
            "setup_seconds": solution.setup_seconds,
            "compile_seconds": solution.compile_seconds,
            "converged": self.converged,
            "reasons": self.reasons,
            "iterations": solution.iterations.max(axis=0),
            "violation": np.where(np.isfinite(filled), filled, np.nan),
        }
        document |= self.columns()
        if stored := self.stored_pressures():
            document["pressure"] = stored[max(stored)]
        document |= self.distributions()
        return json.dumps(plain(document), indent=1, allow_nan=False)

    def stored_pressures(self) -> dict[int, dict[str, np.ndarray]]:
        """Return load step -> pressure {r, p} or {x, y, p}: at most eight, the last among them."""
        fields, last = self.solution.fields, self.solution.converged.shape[1] - 1
        steps = {k: at_step(fields, k) for k in stored_steps(fields)} | {last: fields}
        names, geometry = ("pressure_x", "pressure_y", "pressure"), self.plan.geometry
        pressures = {}
        for step, own in steps.items():
            if not (fields.keys() >= set(names) <= own.keys()):
                continue
            points = np.stack([own[name] for name in names])
            if isinstance(geometry, IndenterGeometry) and geometry.indenter.axisymmetric:
                r = np.hypot(*points[:2])
                order = np.argsort(r, kind="stable")
                pressures[step] = {"r": r[order], "p": points[2, order]}
                continue
            if isinstance(geometry, IndenterGeometry):
                # Symmetric meshes hold a part of the contact.
                for axis in np.flatnonzero(geometry.indenter.even):
                    if points[axis].min() >= 0:
                        image = points[:, points[axis] > 0]
                        image[axis] *= -1
                        points = np.hstack([points, image])
            pressures[step] = dict(zip("xyp", points, strict=True))
        return pressures

    def distributions(self) -> dict[str, dict[str, np.ndarray]]:
        """Return the distributions at the last load, means over surfaces or lines.

        ``amount`` is the share of the nominal area between ``low`` and ``high``, or the number of
        contacts.
        """
        geometry, several = self.plan.geometry, {}
        for name in self.solution.distributions:
            assert isinstance(geometry, RoughGeometry)
            bins = edges(name, self.plan.scene, geometry)
            (amount,) = last_histograms(name, self.solution)
            some = amount > 0
            several[name] = {"low": bins[:-1][some], "high": bins[1:][some], "amount": amount[some]}
        return several

    def to_csv(self, path: str | Path) -> None:
        """Write the load steps as a table; of an ensemble, the means over its realisations."""
        table = pd.DataFrame(self.columns())
        table.insert(0, "step", range(len(table)))
        write_named_text(Path(path), table_text(table))

    def to_vtu(self, path: str | Path) -> None:
        """Write the fields at the last load for ParaView (of `solve` with ``fields=True``).

        InputError if none are on a mesh.
        """
        content = vtu_file(self.solution.fields)
        if content is None:
            raise InputError(f"--vtu: {self.method} has no field on a mesh for this scene")
        write_named(Path(path), lambda stream: stream.write(content))


def solve_scene(
    source: str | Path | Mapping[str, Any] | Scene,
    method: str,
    resolution: int | None = None,
    overrides: Mapping[str, Any] | None = None,
    *,
    with_fields: bool = False,
    threads: int = 1,
) -> SingleResult:
    """Solve a scene with one method, large grids by several `threads`; no digit changes.

    InputError if the scene, the method or the resolution is refused, with the reason.
    """
    cores = os.cpu_count() or 1
    if not 1 <= threads <= cores:
        limits = f"expected 1 to {cores} (the cores of this machine), got {threads}"
        raise InputError(f"--threads: {limits}")
    method = method_named(method)
    changes = dict(overrides or {}) | {"compare.methods": [method]}
    scene = load_scene(source, changes)
    if with_fields and "pressure" not in scene.compare.quantities:
        changes["compare.quantities"] = [*scene.compare.quantities, "pressure"]
    if resolution is not None:
        least = 2 if scene.body is None else 1  # 1 is a user's original mesh
        if resolution < least and method != CLOSED_FORM:
            raise InputError(f"--resolution: expected at least {least}, got {resolution}")
        changes["compare.resolutions"] = [max(resolution, least)]
    plan = plan_scene(load_scene(source, changes), "full")[0]
    (planned,) = [row for row in plan.methods if row.method == method]
    if not planned.supported:
        at = "" if resolution is None else f" at resolution {resolution}"
        cause = f"cannot solve this scene{at}: {planned.reason}"
        raise InputError(f"{plan.scene.name}: {method} {cause}")
    chosen = single_resolution(planned.resolutions, plan.geometry)
    tasks = plan.tasks_at(method, chosen, with_body=with_fields)
    with pieces.threads(threads):
        solution = Solution.concat([execute(task) for task in tasks], axis=REALISATIONS)
    return SingleResult(plan, method, chosen, solution)
