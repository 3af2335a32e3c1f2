"""The method `closed_form`: exact solutions of single contacts."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods.base import Method, Solution, Support, Task
from comparisons.methods.radial import profile_fields, unit_rings
from comparisons.scene.method_names import METHOD_NAMES
from comparisons.scene.scene import Scene
from comparisons.scene.shapes import Indenter
from reference import closed_form as forms


def form_of(indenter: Indenter, modulus: float) -> forms.ClosedForm | None:
    """Return the closed form of a shape, or None where there is none."""
    parameters: dict[str, Any] = indenter.model_dump()
    shape = parameters.pop("shape")
    if shape == "elliptic_punch":
        parameters = dict(zip(("semi_axis_x", "semi_axis_y"), parameters["semi_axes"], strict=True))
    constructor = getattr(forms, shape, None)
    if constructor is None:
        return None
    form: forms.ClosedForm = constructor(**parameters, effective_modulus=modulus)
    return form


class ClosedForm(Method):
    """Exact solution on the half-space; no discretisation, so its resolution is 1."""

    name = "closed_form"
    title = METHOD_NAMES[name].title

    def supports(self, scene: Scene) -> Support:
        """Only single contacts whose solution is known."""
        if scene.indenter is None:
            return Support(False, "a rough surface has no closed form")
        form = form_of(scene.indenter, scene.effective_modulus)
        if form is None:
            kind = scene.indenter.model_dump()["shape"].replace("_", " ")
            return Support(False, f"no closed form is known for a {kind}")
        return Support(True, form.source)

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Return one: a closed form needs no refinement."""
        return (1,)

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Cite the solution."""
        return f"exact solution, nothing is discretised ({self.supports(scene).reason})"

    def solve(self, task: Task) -> Solution:
        """Evaluate the solution at all loads at once."""
        assert isinstance(task.geometry, IndenterGeometry)
        solution = Solution.empty(task, unknowns=0)
        form = form_of(task.geometry.indenter, task.scene.effective_modulus)
        assert form is not None
        loads = task.loads.values
        depth = loads if task.loads.control == "penetration" else form.penetration(loads)
        area = form.contact_area(depth)
        curves = {
            "penetration": depth,
            "force": form.force(depth),
            "contact_area": area,
            "contact_area_raw": area,
            "equivalent_radius": np.sqrt(area / np.pi),
            "stiffness": form.stiffness(depth),
            "contact_length_stiffness": form.stiffness(depth) / task.scene.effective_modulus,
            "energy": form.energy(depth),
        }
        if form.contact_radius is not None:
            curves["contact_radius"] = form.contact_radius(depth)
        solution.quantities = {k: np.array(v, dtype=float)[None, :] for k, v in curves.items()}
        solution.converged[:] = True
        solution.violation[:] = 0.0
        solution.fields = {"penetration": np.array(depth[-1])}
        if task.wants_pressure:
            solution.fields |= _profile(form, float(depth[-1]))
            for step, each in enumerate(depth):
                solution.keep((0, step), partial(_profile, form, float(each)))
        return solution


def _profile(form: forms.ClosedForm, depth: float) -> dict[str, np.ndarray]:
    """Pressure along the x axis."""
    half_x, half_y = (float(each) for each in form.semi_axes(depth))
    x = half_x * unit_rings()[0]
    return profile_fields(half_x, half_y, x, np.asarray(form.pressure(x, 0.0, depth)))
