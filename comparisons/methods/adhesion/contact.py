"""Adhesion under a path of loads: springs, JKR closed forms, half-space on a grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods.adhesion.grid import (
    AdhesiveContact,
    cohesive_walk,
    edge_doubt,
    peeled_walk,
)
from comparisons.methods.normal.bem_fft import BemFft
from comparisons.methods.normal.closed_form import ClosedForm, form_of
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.indenters.axisymmetric import PowerLaw
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.physics.tables.adhesion import Adhesion as AdhesionTable
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.adhesion.adhere import Adhesion, State, adhere, pull_off
from reduced.loads import LoadPath
from reduced.profiles.equivalents import paraboloid
from reduced.springs.line import Springs
from reference.closed_form.adhesive import AdhesiveForm

PHYSICS = frozenset({"adhesion"})
ONLY_INDENTERS = (
    "adhesion is for single contacts only: the area rule (19.29) does not describe edges"
)


def _adhesive(scene: Scene) -> tuple[Indenter, AdhesionTable]:
    """Return what adheres.

    Raises
    ------
    Refused
        If the scene is no adhesive contact of a shape.
    """
    indenter = needed(scene.indenter, ONLY_INDENTERS)
    if isinstance(indenter, PowerLaw) and indenter.exponent <= 0.5:
        raise Refused("the tip is sharper than r^(1/2), so that adhesion cannot hold it")
    return indenter, needed(scene.adhesion, "no [adhesion]")


class ReducedAdhesion(ReducedProfile):
    """The edge-stretch rule, whatever the range of attraction and the outline."""

    physics = PHYSICS
    only_indenters = ONLY_INDENTERS
    options_read = frozenset({"rule"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        _, self.adhesion = _adhesive(scene)

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line, and what is taken for zero."""
        range_note = "" if self.adhesion.short_range else "; the range is taken as zero"
        return f"{super().model(geometry)}; edges hold a stretch √(2π a w/E*){range_note}"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the half line for the control of the task."""
        springs = Springs(paraboloid(1.0), 1.0, per_radius=4)
        adhere(springs, 0.01, LoadPath(task.loads.control, [0.1, -1.0]))

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Walk the whole path."""
        springs = Springs(self.profile, self.modulus, task.resolution)
        path = LoadPath(task.loads.control, task.loads.values)
        contact = adhere(springs, self.adhesion.work, path)
        strongest = pull_off(springs, self.adhesion.work).before
        curves: dict[str, ArrayLike] = {
            "penetration": contact.penetration,
            "force": contact.force,
            "equivalent_radius": contact.contact_radius,
            "pull_off_force": _largest_pull(contact, strongest),
            "energy": contact.elastic_energy,
        }
        return Solution.of(task, curves, unknowns=2 * task.resolution)


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


def adhesive_form_of(indenter: Indenter, modulus: float, work: float) -> AdhesiveForm | None:
    """Return the JKR solution of a shape, or None where there is none."""
    form = form_of(indenter, modulus)
    return AdhesiveForm(form, work) if form and form.by_radius else None


class ClosedFormAdhesion(Solver[IndenterGeometry]):
    """Johnson, Kendall & Roberts for bodies of revolution; Kendall's punch."""

    name = "closed_form"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        indenter, adhesion = _adhesive(scene)
        if not adhesion.short_range:
            raise Refused("the closed forms are for short range only")
        self.form = needed(
            adhesive_form_of(indenter, scene.effective_modulus, adhesion.work),
            f"no adhesive closed form is known for a {indenter.in_words}",
        )
        self.note = self.form.source

    resolutions = ClosedForm.resolutions
    model = ClosedForm.model

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Follow the stable branch, with its jumps."""
        path = self.form.follow(task.loads.control, task.loads.values)
        curves: dict[str, ArrayLike] = {
            "penetration": path.penetration,
            "force": path.force,
            "equivalent_radius": path.contact_radius,
            "pull_off_force": path.largest_pull,
        }
        return Solution.of(task, curves, violation=0.0)


class GridAdhesion(BemFft):
    """Half-space on a grid: calibrated detachment at short range, else a constant tension."""

    physics = PHYSICS
    options_read = frozenset()

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter, self.adhesion = _adhesive(scene)

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Cells per contact radius at the largest load."""
        return (6, 12, 24) if self.adhesion.short_range else (8, 16, 32)

    def model(self, geometry: Geometry) -> str:
        """Name the law of detachment."""
        if self.adhesion.short_range:
            law = "cells detach at a mesh-dependent tension (Pohrt & Popov 2015)"
        else:
            law = "a constant tension out to the range, over a ramp of ±30 % of it (Maugis 1992)"
        return f"square cells, free space around them; {law}"

    def warm_up(self, task: Task) -> None:
        """Compile the convolution."""
        self.operator(task, (8, 8), (1.0, 1.0)).apply(np.ones((8, 8)))

    def refusal(self, task: Task) -> str:
        """Refuse grids whose way takes minutes: work grows as the fourth power of their number."""
        most = 32 if self.adhesion.short_range else 48
        if task.resolution <= most:
            return ""
        return f"takes a contact apart cell by cell: at most {most} cells per contact radius"

    def solve(self, task: Task) -> Solution:
        """Follow the path of equilibria, and read the loads off it."""
        short, modulus = self.adhesion.short_range, self.scene.effective_modulus
        body = AdhesiveContact(self.indenter, self.adhesion, modulus, task.geometry)
        walk = peeled_walk if short else cohesive_walk
        path = walk(body, task.loads, task.resolution)
        curves: dict[str, ArrayLike] = {
            "penetration": path.penetration,
            "force": path.force,
            "equivalent_radius": np.sqrt(path.area / np.pi),
            "pull_off_force": path.largest_pull,
        }
        unknowns, residual = path.unknowns, path.residual
        solution = Solution.of(task, curves, unknowns=unknowns, violation=residual)
        if short:
            solution.truncation = edge_doubt(task.geometry, task.resolution)
            flat = self.indenter.flat
            solution.exact = ("contact_area", "contact_area_raw") if flat else ()
        return solution
