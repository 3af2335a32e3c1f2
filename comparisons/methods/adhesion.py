"""Adhesion under a path of loads: springs, JKR closed forms, half-space on a grid."""

from __future__ import annotations

from typing import Any

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods.adhesive_grid import cohesive_walk, edge_doubt, peeled_walk
from comparisons.methods.base import Solution, Support, Task
from comparisons.methods.bem_fft import BemFft
from comparisons.methods.closed_form import ClosedForm
from comparisons.methods.reduced import Reduced, profile_of
from comparisons.scene.scene import Scene
from comparisons.scene.shapes import Indenter, PowerLaw
from reduced import errors as reduced_errors
from reduced.adhesion.adhere import Adhesion, adhere, pull_off
from reduced.adhesion.walk import State
from reduced.profiles.shapes import paraboloid
from reference import errors as reference_errors
from reference.closed_form import adhesive

PHYSICS = frozenset({"adhesion"})


def _refused(scene: Scene) -> str:
    """Return why a scene is no adhesive contact of a shape, "" where it is."""
    if scene.indenter is None:
        return "only single contacts adhere here: the area rule (19.29) says nothing about edges"
    if isinstance(scene.indenter, PowerLaw) and scene.indenter.exponent <= 0.5:
        return "the tip is sharper than the root of r: adhesion does not hold it"
    return ""


def _curves(
    radius: np.ndarray, penetration: np.ndarray, force: np.ndarray, pull: float, round_one: bool
) -> dict[str, np.ndarray]:
    """Return the quantities of circular contacts; the pull stands in every step."""
    area = np.pi * radius**2
    curves = {
        "penetration": penetration,
        "force": force,
        "contact_area": area,
        "contact_area_raw": area,
        "equivalent_radius": radius,
        "pull_off_force": np.full(len(radius), pull),
    }
    return curves | ({"contact_radius": radius} if round_one else {})


class ReducedAdhesion(Reduced):
    """The edge-stretch rule, whatever the range of attraction and the outline."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Every shape with an equivalent profile."""
        reason = _refused(scene)
        return Support(False, reason) if reason else super().supports(scene)

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the line, and what is taken for zero."""
        assert scene.adhesion is not None
        taken = "" if scene.adhesion.short_range else "; the range is taken for zero"
        return f"{super().model(scene, geometry)}; edges hold a stretch √(2π a w/E*){taken}"

    def warm_up(self, task: Task) -> None:
        """Compile the half line for the control of the task."""
        load: dict[str, Any] = {task.loads.control: [0.1, -1.0]}
        adhere(paraboloid(1.0), 1.0, 0.01, **load, springs=4)

    def solve(self, task: Task) -> Solution:
        """Walk the whole path."""
        scene, solution = task.scene, Solution.empty(task)
        assert scene.indenter is not None
        assert scene.adhesion is not None
        body = profile_of(scene), scene.effective_modulus, scene.adhesion.work
        try:
            contact = adhere(*body, **task.loads.keyword, springs=task.resolution)
            strongest = pull_off(*body, springs=task.resolution).before
        except reduced_errors.ConvergenceError as error:
            for step in range(len(task.loads.values)):
                solution.fail((0, step), error.reason)
            return solution
        curves = _curves(
            contact.contact_radius,
            contact.penetration,
            contact.force,
            _largest_pull(contact, strongest),
            scene.indenter.axisymmetric,
        )
        curves["energy"] = contact.elastic_energy
        solution.quantities = {name: values[None, :] for name, values in curves.items()}
        solution.converged[:] = True
        solution.unknowns = 2 * task.resolution
        return solution


def _largest_pull(contact: Adhesion, strongest: State) -> float:
    """Return the largest pull along the path, between the steps too.

    Steps and jumps tell it, but for the fold of the force that a falling penetration passes.
    """
    forces = [*contact.force, *(s.force for e in contact.events for s in (e.before, e.after))]
    radii = contact.contact_radius
    if contact.events and contact.events[-1].kind == "pull_off":
        radii = np.append(radii, 0.0)
    if radii.max() >= strongest.contact_radius > radii[int(np.argmax(radii)) :].min():
        forces.append(strongest.force)
    return max(0.0, -min(forces))


def adhesive_form_of(
    indenter: Indenter, modulus: float, work: float
) -> adhesive.AdhesiveForm | None:
    """Return the JKR solution of a shape, or None where there is none."""
    parameters: dict[str, Any] = indenter.model_dump()
    constructor = getattr(adhesive, str(parameters.pop("shape")), None)
    if constructor is None or not indenter.axisymmetric:
        return None
    form: adhesive.AdhesiveForm = constructor(**parameters, effective_modulus=modulus, work=work)
    return form


class ClosedFormAdhesion(ClosedForm):
    """Johnson, Kendall & Roberts for bodies of revolution; Kendall's punch."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Short range, and a shape whose solution is known."""
        reason = _refused(scene)
        if reason:
            return Support(False, reason)
        assert scene.indenter is not None
        assert scene.adhesion is not None
        if not scene.adhesion.short_range:
            return Support(False, "the closed forms are those of short range")
        form = adhesive_form_of(scene.indenter, scene.effective_modulus, scene.adhesion.work)
        if form is None:
            kind = scene.indenter.model_dump()["shape"].replace("_", " ")
            return Support(False, f"no adhesive closed form is known for a {kind}")
        return Support(True, form.source)

    def solve(self, task: Task) -> Solution:
        """Follow the stable branch, with its jumps."""
        scene, solution = task.scene, Solution.empty(task)
        assert scene.indenter is not None
        assert scene.adhesion is not None
        form = adhesive_form_of(scene.indenter, scene.effective_modulus, scene.adhesion.work)
        assert form is not None
        path = form.follow(task.loads.control, task.loads.values)
        curves = _curves(
            path.contact_radius, path.penetration, path.force, path.largest_pull, round_one=True
        )
        solution.quantities = {name: values[None, :] for name, values in curves.items()}
        solution.converged[:] = True
        solution.violation[:] = 0.0
        return solution


class GridAdhesion(BemFft):
    """Half-space on a grid: calibrated detachment at short range, else a constant tension."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Single contacts."""
        reason = _refused(scene)
        return Support(not reason, reason)

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Cells per contact radius at the largest load."""
        assert scene.adhesion is not None
        return (6, 12, 24) if scene.adhesion.short_range else (8, 16, 32)

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the law of detachment."""
        assert scene.adhesion is not None
        if scene.adhesion.short_range:
            law = "cells let go at a tension calibrated to the mesh (Pohrt & Popov 2015)"
        else:
            law = "a constant tension out to the range, over a ramp of ±30 % of it (Maugis 1992)"
        return f"square cells, free space around them; {law}"

    def warm_up(self, task: Task) -> None:
        """Compile the convolution."""
        self.operator(task, (8, 8), (1.0, 1.0)).apply(np.ones((8, 8)))

    def refused(self, task: Task) -> str:
        """Refuse grids whose way takes minutes: work grows as the fourth power of their number."""
        assert task.scene.adhesion is not None
        most = 32 if task.scene.adhesion.short_range else 48
        if task.resolution <= most:
            return ""
        return f"takes a contact apart cell by cell: at most {most} cells per contact radius"

    def solve(self, task: Task) -> Solution:
        """Follow the path of equilibria, and read the loads off it."""
        assert task.scene.adhesion is not None
        assert isinstance(task.geometry, IndenterGeometry)
        solution = Solution.empty(task)
        walk = peeled_walk if task.scene.adhesion.short_range else cohesive_walk
        try:
            found = walk(task.scene, task.geometry, task.loads, task.resolution)
        except reference_errors.ConvergenceError as error:
            for step in range(len(task.loads.values)):
                solution.fail((0, step), error.reason)
            return solution
        flat = task.geometry.indenter.flat
        curves = _curves(
            np.sqrt(found.area / np.pi),
            found.penetration,
            found.force,
            found.largest_pull,
            task.geometry.indenter.axisymmetric,
        )
        solution.quantities = {name: values[None, :] for name, values in curves.items()}
        solution.converged[:] = True
        solution.violation[:] = found.residual
        if task.scene.adhesion.short_range:
            solution.truncation = edge_doubt(task.geometry, task.resolution)
            solution.exact = ("contact_area", "contact_area_raw") if flat else ()
        solution.unknowns = found.unknowns
        return solution


WIRINGS = (ReducedAdhesion(), ClosedFormAdhesion(), GridAdhesion())
