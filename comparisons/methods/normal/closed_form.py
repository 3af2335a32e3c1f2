"""The method `closed_form`: exact solutions of single contacts."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.normal.radial import profile_fields, unit_rings
from comparisons.methods.solver import Solver, needed
from comparisons.scene.scene import Scene
from comparisons.scene.shapes import Indenter
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference import closed_form as closed_forms

_SOLUTIONS = {
    form.__name__: form
    for form in (
        *(
            closed_forms.paraboloid,
            closed_forms.sphere,
            closed_forms.cone,
            closed_forms.power_law,
            closed_forms.cylinder,
        ),
        *(closed_forms.rounded_punch, closed_forms.ellipsoid, closed_forms.elliptic_punch),
    )
}


def form_of(indenter: Indenter, modulus: float) -> closed_forms.ClosedForm | None:
    """Return the closed form of a shape, or None where there is none."""
    parameters: dict[str, Any] = indenter.model_dump()
    shape = parameters.pop("shape")
    if shape == "elliptic_punch":
        parameters = dict(zip(("semi_axis_x", "semi_axis_y"), parameters["semi_axes"], strict=True))
    if shape not in _SOLUTIONS:
        return None
    return _SOLUTIONS[shape](**parameters, effective_modulus=modulus)


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
            f"no closed form is known for a {shape_of(self.indenter)}",
        )
        self.note = self.form.source

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


def shape_of(indenter: Indenter) -> str:
    """Return the shape in words."""
    return str(indenter.model_dump()["shape"]).replace("_", " ")


def _pressure(form: closed_forms.ClosedForm, depth: float) -> dict[str, np.ndarray]:
    """Pressure along the x axis."""
    half_x, half_y = (float(half) for half in form.semi_axes(depth))
    x = half_x * unit_rings()[0]
    return profile_fields(half_x, half_y, x, np.asarray(form.pressure(x, 0.0, depth)))
