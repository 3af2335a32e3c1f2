"""Fits by Kogut & Etsion and by Jackson & Green, of a deformable ball under a rigid flat."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from scipy.optimize import brentq

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.plasticity.indentation import PHYSICS, radius_of, tables_of
from comparisons.methods.solver import Refused, Solver
from comparisons.scene.physics.absolute_loads import loads_of
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference.plastic.dent_formulas import Fit, FlattenedBall, jackson_green, kogut_etsion

EXACT = (1,)


class FittedBall(Solver[IndenterGeometry]):
    """A fit for an elastic-perfectly plastic ball on loading; for a half-space while a << R."""

    physics = PHYSICS
    dimension = 1

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        indenter, plasticity = tables_of(scene)
        if plasticity.hardens:
            raise Refused("fitted without hardening")
        ball = FlattenedBall(
            radius_of(indenter),
            scene.effective_modulus,
            scene.poisson_ratio,
            plasticity.yield_stress,
        )
        self.fit = self.fitted(ball)
        loads = loads_of(scene)
        if (loads.values < 0).any() or (np.diff(loads.values) < 0).any():
            raise Refused("fitted on loading only")
        largest = float(self._depths(loads.control, loads.values[-1:])[0])
        if largest > self.fit.largest:
            raise Refused(
                f"fitted up to {self.fit.largest:.3g} times the penetration of first yield, and "
                f"the largest load is at {largest:.3g}"
            )
        self.note = self.fit.source

    def fitted(self, ball: FlattenedBall) -> Fit:
        """Return the curves of the fit."""
        raise NotImplementedError

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Return one: a formula."""
        return EXACT

    def _depths(self, control: str, loads: np.ndarray) -> np.ndarray:
        """Return d/d_c of loads; beyond the range of the fit, infinity."""
        if control == "penetration":
            return np.asarray(loads / self.fit.yields_at)
        top = float(self.fit.force(np.array(self.fit.largest)))

        def depth(force: float) -> float:
            if force >= top:
                return self.fit.largest if force == top else np.inf
            root = brentq(
                lambda w: float(self.fit.force(np.array(w))) - force, 0.0, self.fit.largest
            )
            return float(root)

        return np.array([depth(float(load) / self.fit.force_unit) for load in loads])

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Evaluate the fit."""
        fit = self.fit
        w = self._depths(task.loads.control, task.loads.values)
        curves = {
            "penetration": w * fit.yields_at,
            "force": fit.force(w) * fit.force_unit,
            "contact_area": fit.area(w) * fit.area_unit,
            "first_yield": np.full(w.shape, fit.yields_at),
        }
        if fit.residual is not None:
            curves["residual_depth"] = fit.residual(w) * fit.yields_at
        return Solution.of(task, curves, violation=0.0)


class KogutEtsion(FittedBall):
    """Kogut & Etsion (2002): power laws of finite elements, up to d/d_y = 110."""

    name = "kogut_etsion"
    title: ClassVar[str] = "Kogut & Etsion"

    def fitted(self, ball: FlattenedBall) -> Fit:
        """Return the curves of the fit."""
        return kogut_etsion(ball)


class JacksonGreen(FittedBall):
    """Jackson & Green (2005): a hardness that falls with the contact, up to a/R = 0.41."""

    name = "jackson_green"
    title: ClassVar[str] = "Jackson & Green"

    def fitted(self, ball: FlattenedBall) -> Fit:
        """Return the curves of the fit."""
        return jackson_green(ball)
