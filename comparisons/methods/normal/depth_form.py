"""The method `closed_form` on layered and graded bodies: round contacts to ten digits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from comparisons.geometry.elastic_body import elastic_body
from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.indenters.axisymmetric import Cone, Cylinder, Paraboloid, PowerLaw
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference.layered import RoundContact, Stack
from reference.layered.graded import GradedContact, face_stiffness, line_factor
from reference.layered.round_contact import RoundStep

At = Callable[[str, float], RoundStep]


class DepthForm(Solver[IndenterGeometry]):
    """Exact solution under a power of the radius or a flat circle; its resolution is 1."""

    name = "closed_form"
    depths = True

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter = needed(scene.indenter, "a rough surface has no closed form")
        if self.indenter.shape != "cylinder" and _power(self.indenter) is None:
            raise Refused(f"no solution is known for a {self.indenter.in_words} on such a body")
        if "pressure" in scene.compare.quantities:
            raise Refused("the solution is evaluated for force and area, not for pressures")
        graded = scene.half_space.grading is not None
        self.note = (
            "Giannakopoulos & Suresh 1997; Hess 2016"
            if graded
            else "integral equation of Lebedev & Ufliand 1958, in Legendre polynomials to 1e-10"
        )

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Bodies that depend on depth."""
        return not scene.half_space.uniform

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Return one: nothing needs refinement."""
        return (1,)

    def model(self, geometry: IndenterGeometry) -> str:
        """Cite the solution."""
        return f"exact solution of the contact ({self.note})"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Solve load after load."""
        control, values = task.loads.control, task.loads.values
        at = self._contact(task.geometry)
        steps = [at(control, float(value)) for value in values]
        names = ("contact_radius", "penetration", "force", "stiffness", "energy")
        curves = {name: np.array([getattr(step, name) for step in steps]) for name in names}
        curves["contact_area"] = np.pi * curves["contact_radius"] ** 2
        solution = Solution.of(task, curves, violation=0.0)
        solution.fields = {"penetration": np.array(steps[-1].penetration)}
        return solution

    def _contact(self, geometry: IndenterGeometry) -> At:
        body, guess = elastic_body(self.scene), geometry.contact_radius
        if isinstance(self.indenter, Cylinder):
            radius = self.indenter.radius
            if isinstance(body, Stack):
                flat = RoundContact(body, np.zeros_like, radius)
                return lambda control, value: flat.at(control, value, radius)
            return _face(radius, face_stiffness(body, radius))
        n, c = needed(_power(self.indenter), "")
        if not isinstance(body, Stack):
            return GradedContact(body, n, c).at
        factor = line_factor(n) * c
        contact = RoundContact(body, lambda x: factor * x**n)
        return lambda control, value: contact.at(control, value, guess)


def _power(indenter: Indenter) -> tuple[float, float] | None:
    """Return n and c of a section c r^n, None for others."""
    if isinstance(indenter, Paraboloid):
        return 2.0, 0.5 / indenter.radius
    if isinstance(indenter, Cone):
        return 1.0, indenter.slope
    return (indenter.exponent, indenter.coefficient) if isinstance(indenter, PowerLaw) else None


def _face(radius: float, stiffness: float) -> At:
    def at(control: str, value: float) -> RoundStep:
        depth = value if control == "penetration" else value / stiffness
        force = stiffness * depth
        return RoundStep(radius, depth, force, stiffness, force * depth / 2)

    return at
