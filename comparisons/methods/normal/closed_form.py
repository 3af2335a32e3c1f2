"""The method `closed_form`: exact solutions of single contacts."""

from __future__ import annotations

from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.normal.radial import profile_fields, unit_rings
from comparisons.methods.solver import Solver, needed
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference import closed_form as closed_forms


def form_of(indenter: Indenter, modulus: float) -> closed_forms.ClosedForm | None:
    """Return the closed form of a shape, or None where there is none."""
    return indenter.made_by(closed_forms, effective_modulus=modulus)


class ClosedForm(Solver[IndenterGeometry]):
    """Exact solution on the half-space; no discretisation, so its resolution is 1."""

    name = "closed_form"
    only_indenters = "a rough surface has no closed form"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter = needed(scene.indenter, self.only_indenters)
        self.modulus = scene.effective_modulus
        self.form = needed(
            form_of(self.indenter, self.modulus),
            f"no closed form is known for a {self.indenter.in_words}",
        )
        self.note = self.form.source

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Half-spaces: `DepthForm` has layers."""
        return scene.half_space.uniform

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Return one: a closed form needs no refinement."""
        return (1,)

    def model(self, geometry: IndenterGeometry) -> str:
        """Cite the solution."""
        return f"exact solution, nothing is discretised ({self.note})"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Evaluate the solution at all loads at once."""
        form, loads = self.form, task.loads.values
        depth = loads if task.loads.control == "penetration" else form.penetration(loads)
        curves = {
            "penetration": depth,
            "force": form.force(depth),
            "contact_area": form.contact_area(depth),
            "stiffness": form.stiffness(depth),
            "energy": form.energy(depth),
        }
        if form.contact_radius is not None:
            curves["contact_radius"] = form.contact_radius(depth)
        solution = Solution.of(task, curves, violation=0.0)
        solution.fields = {"penetration": np.array(depth[-1])}
        if task.wants_pressure:
            solution.fields |= _pressure(form, float(depth[-1]))
            for step, value in enumerate(depth):
                solution.keep((0, step), partial(_pressure, form, float(value)))
        return solution


def _pressure(form: closed_forms.ClosedForm, depth: float) -> dict[str, np.ndarray]:
    """Pressure along the x axis."""
    half_x, half_y = (float(half) for half in form.semi_axes(depth))
    x = half_x * unit_rings()[0]
    return profile_fields(half_x, half_y, x, np.asarray(form.pressure(x, 0.0, depth)))
