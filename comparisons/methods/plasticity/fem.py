"""J2 finite elements below a round indenter."""

from __future__ import annotations

from contextlib import suppress
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry, equivalent_profile
from comparisons.methods.plasticity.ball import (
    FIRST_PRESSURE,
    PHYSICS,
    estimated_radius,
    material_of,
    tables_of,
)
from comparisons.methods.solver import Refused, Solver
from comparisons.scene.scene import Scene
from comparisons.tasks.shown_loads import Fields
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import Step, record
from comparisons.tasks.task import Task
from reduced.loads import Load
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference.errors import ConvergenceError
from reference.fem.elasticity import LARGEST_POISSON_RATIO
from reference.fem.recovery import von_mises
from reference.loads import LoadPath
from reference.plastic import Moment, OutgrownError, Walk
from reference.plastic.first_yield import first_yield

# Meshes resolve contacts down to this share of the largest.
_SMALLEST = 1 / 3
# Meshes are widened where a contact turns out larger than estimated.
_WIDENINGS, _WIDER = 4, 1.25
# Measured on Hertz's contact, of which this is all that the mesh leaves out (docs/plasticity.md).
TRUNCATION = 2e-4


class FemPlasticity(Solver[IndenterGeometry]):
    """Axisymmetric finite elements of a half-space that yields, beyond them Boussinesq fields."""

    name = "fem"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter, self.plasticity = tables_of(scene)
        if not self.indenter.axisymmetric:
            raise Refused("plasticity on finite elements: round shapes only")
        _, nu = scene.elastic_constants
        if nu > LARGEST_POISSON_RATIO:
            raise Refused(f"nu = {nu:g}: displacement elements are limited to 0.4999")
        self.material = material_of(scene)
        self.profile = equivalent_profile(self.indenter)
        if self.indenter.shape == "cone":
            self.note = "below a sharp tip the half-space yields at once: no first_yield"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Elements per contact radius: the force is known to about 1 % on nine."""
        finest = int(np.clip(9 * np.sqrt(0.01 / self.scene.compare.tolerance), 9, 24))
        finest -= finest % 3
        return finest // 3, 2 * finest // 3, finest

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of elements, and of the factor of their matrix."""
        return 60_000.0 * (1.6 * task.resolution + 12) ** 2

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the mesh."""
        return (
            "quadratic axisymmetric elements (B-bar) with von Mises plasticity, radial return; "
            "outside them the Boussinesq field of the force"
        )

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Walk the path; on a wider mesh where the contact outgrows the one estimated."""
        smallest, largest = self._radii(task)
        yields_at = self._yields_at(task)
        for _ in range(_WIDENINGS):
            solution = Solution.empty(task)
            solution.truncation = TRUNCATION
            with solution.setup():
                walk = Walk(
                    self.material,
                    self._gap,
                    largest,
                    smallest=min(max(smallest, _SMALLEST * largest), largest),
                    per_radius=task.resolution,
                )
            solution.unknowns = walk.indentation.section.size
            if not self._outgrown(task, walk, solution, yields_at):
                break
            largest *= _WIDER
        return solution

    def _outgrown(
        self,
        task: Task[IndenterGeometry],
        walk: Walk,
        solution: Solution,
        yields_at: dict[str, float],
    ) -> bool:
        """Put the steps of a path into a solution; tell whether the contact outgrew its mesh."""
        path = LoadPath(task.loads.control, task.loads.values)
        before, step = 0, 0
        try:
            for step, moment in enumerate(walk.along(path)):
                record(solution, (0, step), self._step(task, walk, moment, before, yields_at), task)
                before = moment.iterations
        except ConvergenceError as error:
            for lost in range(int(solution.converged.sum()), task.shape[1]):
                solution.fail((0, lost), error.reason)
            return isinstance(error, OutgrownError)
        return False

    def _step(
        self,
        task: Task[IndenterGeometry],
        walk: Walk,
        moment: Moment,
        before: int,
        yields_at: dict[str, float],
    ) -> Step:
        radius = moment.contact_radius
        values = {
            "penetration": moment.penetration,
            "force": moment.force,
            "contact_area": float(np.pi * radius**2),
            "contact_area_raw": float(np.pi * radius**2),
            "energy": moment.elastic,
            **yields_at,
        }
        if "residual_depth" in task.quantities:
            with suppress(ConvergenceError):  # the path itself goes on without the dent
                values["residual_depth"] = walk.residual_depth(moment)
        return Step(
            values,
            iterations=moment.iterations - before,
            violation=moment.residual,
            fields=partial(self._fields, walk, moment),
        )

    def _yields_at(self, task: Task[IndenterGeometry]) -> dict[str, float]:
        """Return the penetration of first yield, where it is asked for and exists."""
        if "first_yield" not in task.quantities or self.indenter.shape == "cone":
            return {}
        contact = indent(Springs(self.profile, self.scene.effective_modulus), _load(task))
        force = float(contact.force[-1])
        mean = force / (np.pi * float(contact.contact_radius[-1]) ** 2)
        start = (
            float(contact.penetration[-1])
            * (FIRST_PRESSURE * self.plasticity.yield_stress / mean) ** 2
        )
        try:
            depth = first_yield(
                self.material,
                self._gap,
                lambda d: float(self.profile.contact_radius(d)),
                start,
                per_radius=task.resolution,
            )
        except ConvergenceError:
            return {}
        return {"first_yield": depth}

    def _radii(self, task: Task[IndenterGeometry]) -> tuple[float, float]:
        """Estimate the contact radii at the smallest and the largest load."""
        values = task.loads.values[task.loads.values > 0]
        radii = [
            estimated_radius(self.scene, self.profile, task.loads.control, float(v))
            for v in (values.min(), values.max())
        ]
        return radii[0], radii[1]

    def _gap(self, r: np.ndarray) -> np.ndarray:
        return self.indenter.gap(r, np.zeros(r.shape))

    def _fields(self, walk: Walk, moment: Moment) -> Fields:
        """Return the section: where it has yielded, and the shape of the surface."""
        section, state = walk.indentation.section, moment.state
        radius, sunk = walk.surface(moment)
        return {
            "penetration": np.array(moment.penetration),
            "section_r": section.place[0].ravel() * walk.length,
            "section_z": section.place[1].ravel() * walk.length,
            "section_plastic_strain": state.points.amount.ravel(),
            "section_von_mises": von_mises(state.stress).ravel() * walk.modulus,
            "surface_r": radius,
            "surface_depth": sunk,
        }


def _load(task: Task[IndenterGeometry]) -> Load:
    """Return the largest load of a path."""
    return Load(task.loads.control, float(task.loads.values.max()))
