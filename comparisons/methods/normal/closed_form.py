"""The method `closed_form`: exact solutions of single contacts, layers and grading included."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np

from comparisons.facts.quantities.rows import HALF_AXES
from comparisons.geometry.prepare import IndenterGeometry, elastic_body
from comparisons.methods import Refused, Scene, Solution, Solver, Task, needed
from comparisons.scene.indenters.axisymmetric import Cone, Cylinder, Paraboloid, PowerLaw
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.indenters.not_round import Ellipsoid
from reference import closed_form as closed_forms
from reference.layered import Graded, RoundContact, Stack
from reference.layered.round_contact import GradedContact, RoundStep, face_stiffness, line_factor

# The pressure is exact at each point; their number only sets how smooth a plot is.
POINTS = 200


@lru_cache(maxsize=1)
def unit_rings() -> tuple[np.ndarray, np.ndarray]:
    """Return relative radii in (0, 1) and the areas that they stand for, on the unit disc.

    Gauss points of t with rho = sin t: they crowd towards the edge, where a pressure falls or
    rises steeply, and their weights integrate even an inverse square root there exactly.
    """
    node, weight = np.polynomial.legendre.leggauss(POINTS)
    angle = np.pi / 4 * (node + 1)
    rho = np.sin(angle)
    ring = np.pi / 4 * weight * np.cos(angle) * 2 * np.pi * rho
    for array in (rho, ring):
        array.setflags(write=False)
    return rho, ring


def profile_fields(
    half_x: float, half_y: float, x: np.ndarray, pressure: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the fields of a pressure known along the x axis of an elliptic contact."""
    return {
        "pressure_x": x,
        "pressure_y": np.zeros_like(x),
        "pressure": pressure,
        "pressure_weight": unit_rings()[1] * (half_x * half_y),
    }


def form_of(indenter: Indenter, modulus: float) -> closed_forms.ClosedForm | None:
    """Return the closed form of a shape, or None where there is none."""
    return indenter.made_by(closed_forms, effective_modulus=modulus)


class FormSolver(Solver[IndenterGeometry]):
    """The closed form of a shape, whatever happens to it: what all physics share."""

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

    def model(self, geometry: IndenterGeometry) -> str:
        return f"exact solution, nothing is discretised ({self.note})"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Find the radii of pressures: once in a process, fifty times as long as a solve."""
        unit_rings()


class ClosedForm(FormSolver):
    """Exact solution on the half-space; no discretisation, so its resolution is 1."""

    name = "closed_form"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
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
        if isinstance(self.indenter, Ellipsoid):
            curves |= zip(HALF_AXES, form.semi_axes(depth), strict=True)
        solution = Solution.of(task, curves, violation=0.0)
        solution.fields = {"penetration": np.array(depth[-1])}
        if task.wants_pressure:
            solution.fields |= form_pressure(form, float(depth[-1]))
            for step, value in enumerate(depth):
                solution.keep(task, (0, step), partial(form_pressure, form, float(value)))
        return solution


def form_pressure(form: closed_forms.ClosedForm, depth: float) -> dict[str, np.ndarray]:
    """Return the fields of the pressure, along the x axis.

    Where it is finite the innermost ring, 1e-8 of the area, is taken at the centre: its peak.
    """
    half_x, half_y = (float(half) for half in form.semi_axes(depth))
    x = half_x * unit_rings()[0]
    if form.singular_at is None:
        x[0] = 0.0
    return profile_fields(half_x, half_y, x, np.asarray(form.pressure(x, 0.0, depth)))


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
        return not scene.half_space.uniform

    def model(self, geometry: IndenterGeometry) -> str:
        return f"exact solution of the contact ({self.note})"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        control, values = task.loads.control, task.loads.values
        body, guess = elastic_body(self.scene), task.geometry.contact_radius
        at: Callable[[str, float], RoundStep]
        if isinstance(self.indenter, Cylinder) and isinstance(body, Stack):
            radius = self.indenter.radius
            at = partial(RoundContact(body, np.zeros_like, radius).at, guess=radius)
        elif isinstance(self.indenter, Cylinder):
            assert isinstance(body, Graded)
            radius = self.indenter.radius
            stiffness = face_stiffness(body, radius)

            def at(control: str, value: float) -> RoundStep:
                depth = value if control == "penetration" else value / stiffness
                force = stiffness * depth
                return RoundStep(radius, depth, force, stiffness, force * depth / 2)

        else:
            n, c = needed(_power(self.indenter), "")
            if isinstance(body, Stack):
                factor = line_factor(n) * c
                at = partial(RoundContact(body, lambda x: factor * x**n).at, guess=guess)
            else:
                at = GradedContact(body, n, c).at
        steps = [at(control, float(value)) for value in values]
        names = ("contact_radius", "penetration", "force", "stiffness", "energy")
        curves = {name: np.array([getattr(step, name) for step in steps]) for name in names}
        curves["contact_area"] = np.pi * curves["contact_radius"] ** 2
        solution = Solution.of(task, curves, violation=0.0)
        solution.fields = {"penetration": np.array(steps[-1].penetration)}
        return solution


def _power(indenter: Indenter) -> tuple[float, float] | None:
    """Return n and c of a section c r^n, None for others."""
    if isinstance(indenter, Paraboloid):
        return 2.0, 0.5 / indenter.radius
    if isinstance(indenter, Cone):
        return 1.0, indenter.slope
    return (indenter.exponent, indenter.coefficient) if isinstance(indenter, PowerLaw) else None
