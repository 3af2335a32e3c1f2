"""Automata that yield below a rigid indenter."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry, equivalent_profile
from comparisons.methods.particles.mca import Mca, net_of
from comparisons.methods.particles.step import contact_step
from comparisons.methods.plasticity.indentation import (
    PHYSICS,
    estimated_radius,
    material_of,
    tables_of,
)
from comparisons.scene.physics.absolute_loads import loads_of
from comparisons.scene.scene import Scene
from comparisons.tasks.steps import Row, Step
from comparisons.tasks.task import Task
from reference.errors import ConvergenceError
from reference.loads import Load, LoadPath
from reference.particles import Domain, ParticleHalfSpace
from reference.particles.yielding import PlasticHalfSpace

# Of the stages in which a load is reached: measured at sixty times the depth of first yield.
TRUNCATION = 0.015
# First yield is known where the stress of the last contact tried differs from Y by no more.
_AGREED, _TRIALS = 1e-3, 12


class McaPlasticity(Mca):
    """One body of automata for a whole path, scaled to its largest contact."""

    physics = PHYSICS
    span = 1.0

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter, self.plasticity = tables_of(scene)
        self.material = material_of(scene)
        self.profile = equivalent_profile(self.indenter)

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Automata per contact radius at the largest load: seconds for each step."""
        return (3, 4, 6) if self.scene.compare.tolerance < 0.01 else (3, 4, 5)

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the body, and how it yields."""
        return f"{super().model(geometry)}; von Mises plasticity by radial return in each automaton"

    def domain(self, geometry: IndenterGeometry, resolution: int) -> Domain:
        """Return the overlap at the largest load, and a margin."""
        return self._sized(resolution)[0]

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Yield the path, which is walked on one body."""
        domain, spacing = self._sized(task.resolution)
        body = PlasticHalfSpace(domain, self.material, spacing=spacing)
        yields_at = self._yields_at(task)
        sweep = partial(self._walked, task, body, domain, yields_at)
        yield Row(sweep, unknowns=6 * body.automata.packing.free, truncation=TRUNCATION)

    def _walked(
        self,
        task: Task[IndenterGeometry],
        body: PlasticHalfSpace,
        domain: Domain,
        yields_at: dict[str, float],
        loads: np.ndarray,
    ) -> Iterator[Step]:
        gap = self._gap(body)
        net = net_of(body, gap, domain)
        path = LoadPath(task.loads.control, loads)
        for contact in body.walk(gap, path, balance=self.balance):
            step = contact_step(task, body, contact, net)
            more = dict(yields_at)
            if "residual_depth" in task.quantities:
                with suppress(ConvergenceError):  # the path itself goes on without the dent
                    more["residual_depth"] = body.residual_depth(gap, balance=self.balance)
            yield replace(step, quantities={**step.quantities, **more})

    def _yields_at(self, task: Task[IndenterGeometry]) -> dict[str, float]:
        """Return the penetration of first yield, where it is asked for and exists.

        Elastic contacts, each on a packing of its own scale, follow sigma ~ d^(1/2), which is that
        of curved shapes.
        """
        if "first_yield" not in task.quantities or self.indenter.sharp_tip:
            return {}
        depth, limit = task.geometry.penetration, self.plasticity.yield_stress
        for _ in range(_TRIALS):
            radius = float(self.profile.contact_radius(depth))
            domain = self._domain(depth, radius, task.resolution)
            body = self.body(domain, radius / task.resolution)
            try:
                (contact,) = body.press(self._gap(body), Load("penetration", depth))
            except ConvergenceError:
                return {}
            ratio = limit / body.largest_stress(contact)
            if abs(ratio - 1) < _AGREED:
                return {"first_yield": depth}
            depth *= ratio**2
        return {}

    def _gap(self, body: ParticleHalfSpace) -> np.ndarray:
        return np.asarray(self.indenter.gap(*body.points.T), dtype=float)

    def _sized(self, resolution: int) -> tuple[Domain, float]:
        """Return the body for the largest load, and its spacing.

        Under a force the dent is no deeper than an elastic body's under a contact as wide.
        """
        loads = loads_of(self.scene)
        load = float(loads.values.max())
        radius = estimated_radius(self.scene, self.profile, loads.control, load)
        depth = load
        if loads.control == "force":
            depth = float(self.indenter.gap(*np.array([[np.sqrt(2) * radius], [0.0]]))[0])
        return self._domain(depth, radius, resolution), radius / resolution
