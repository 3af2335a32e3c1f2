"""Adhesion under a path of loads: springs, JKR closed forms, the half-space on a grid."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from comparisons.formatting import unpadded
from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods import Refused, Scene, Solution, Solver, Task, needed
from comparisons.methods.normal.bem import HalfSpaceGrid
from comparisons.methods.normal.closed_form import form_of
from comparisons.methods.normal.reduced import ProfileSolver
from comparisons.scene.indenters.axisymmetric import Paraboloid, PowerLaw
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.physics.tables.adhesion import Adhesion as AdhesionTable
from reduced.adhesion import adhere, pull_off
from reduced.loads import LoadPath
from reduced.springs.line import Springs
from reference.closed_form.adhesive import AdhesiveEquilibria, AdhesiveForm, MaugisForm
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator
from reference.halfspace.cohesive import CohesiveContact, CohesiveProblem, dugdale, trace
from reference.halfspace.detachment import peel

# The first set of cells is wider than the largest contact by this share.
_MARGIN = 1.1
_TOLERANCE = 1e-7
# Half the width of the ramp in place of Maugis' step, as a share of the range, and 1.5 times what
# it adds to the pull-off force at most, whatever the range (docs/adhesion.md).
_RAMP, _RAMP_DOUBT = 0.3, 0.0015
# Where the axis lies between cells.
_OFF = (0.13, -0.21)
_STEPS, _EXTENSIONS = 40, 12
# What the calibrated tension may cost, in cells of the contact radius.
_FLAT_DOUBT, _ROUND_DOUBT = 1.05, 2.1
# Penetration, force and area of a body that is apart, under a pull that moves it further off.
_APART = (np.nan, np.nan, 0.0)


PHYSICS = frozenset({"adhesion"})
ONLY_INDENTERS = (
    "adhesion is for single contacts only: the area rule (19.29) does not describe edges"
)


def _adhesive(scene: Scene) -> tuple[Indenter, AdhesionTable]:
    """Return what adheres; refuse what is no adhesive contact of a shape."""
    indenter = needed(scene.indenter, ONLY_INDENTERS)
    if isinstance(indenter, PowerLaw) and indenter.exponent <= 0.5:
        raise Refused("the tip is sharper than r^(1/2), so that adhesion cannot hold it")
    return indenter, needed(scene.adhesion, "no [adhesion]")


class ReducedAdhesion(ProfileSolver):
    """The edge-stretch rule, whatever the range of attraction and the outline."""

    name = "reduced"
    physics = PHYSICS
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        _, self.adhesion = _adhesive(scene)
        range_note = "" if self.adhesion.short_range else "; the range is taken as zero"
        self.beside = f"edges hold a stretch √(2π a w/E*){range_note}"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        springs = Springs(self.profile, self.modulus, task.resolution)
        path = LoadPath(task.loads.control, task.loads.values)
        contact = adhere(springs, self.adhesion.work, path)
        strongest = pull_off(springs, self.adhesion.work).before
        # the largest pull along the path, between the steps too: steps and jumps tell it, but for
        # the fold of the force that a falling penetration passes
        forces = [*contact.force, *(s.force for e in contact.events for s in (e.before, e.after))]
        radii = contact.contact_radius
        if contact.events and contact.events[-1].kind == "pull_off":
            radii = np.append(radii, 0.0)
        if radii.max() >= strongest.contact_radius > radii[int(np.argmax(radii)) :].min():
            forces.append(strongest.force)
        curves: dict[str, ArrayLike] = {
            "penetration": contact.penetration,
            "force": contact.force,
            "equivalent_radius": contact.contact_radius,
            "pull_off_force": max(0.0, -np.nanmin([0.0, *forces])),
            "energy": contact.elastic_energy,
        }
        return _held(task, curves, strongest.force, unknowns=2 * task.resolution)


def adhesive_form_of(indenter: Indenter, modulus: float, work: float) -> AdhesiveForm | None:
    """Return the JKR solution of a shape, or None where there is none."""
    form = form_of(indenter, modulus)
    return AdhesiveForm(form, work) if form and form.by_radius else None


class ClosedFormAdhesion(Solver[IndenterGeometry]):
    """Johnson, Kendall & Roberts for bodies of revolution; Kendall's punch; Maugis' paraboloid."""

    name = "closed_form"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        indenter, adhesion = _adhesive(scene)
        modulus, work = scene.effective_modulus, adhesion.work
        self.form: AdhesiveEquilibria
        if adhesion.short_range:
            unknown = f"no adhesive closed form is known for a {indenter.in_words}"
            self.form = needed(adhesive_form_of(indenter, modulus, work), unknown)
        elif isinstance(indenter, Paraboloid):
            self.form = MaugisForm(indenter.radius, modulus, work, work / adhesion.range)
        else:
            raise Refused("attraction with a range has a closed form for paraboloids only")
        self.note = self.form.source

    def model(self, geometry: IndenterGeometry) -> str:
        return f"exact solution, nothing is discretised ({self.note})"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        path = self.form.follow(task.loads.control, task.loads.values)
        curves: dict[str, ArrayLike] = {
            "penetration": path.penetration,
            "force": path.force,
            "equivalent_radius": path.contact_radius,
            "pull_off_force": path.largest_pull,
        }
        return _held(task, curves, path.pull_off, violation=0.0)


class GridAdhesion(HalfSpaceGrid):
    """Half-space on a grid: calibrated detachment at short range, else a constant tension."""

    name = "bem_fft"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter, self.adhesion = _adhesive(scene)

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Cells per contact radius at the largest load."""
        return (6, 12, 24) if self.adhesion.short_range else (8, 16, 32)

    def model(self, geometry: Geometry) -> str:
        if self.adhesion.short_range:
            law = "cells detach at a mesh-dependent tension (Pohrt & Popov 2015)"
        else:
            law = "a constant tension out to the range, over a ramp of ±30 % of it (Maugis 1992)"
        return f"square cells, free space around them; {law}"

    def warm_up(self, task: Task) -> None:
        FreeOperator((8, 8), (1.0, 1.0), 1.0).apply(np.ones((8, 8)))

    def refusal(self, task: Task) -> str:
        """Refuse grids whose way takes minutes: work grows as the fourth power of their number."""
        most = 32 if self.adhesion.short_range else 48
        if task.resolution <= most:
            return ""
        return f"takes a contact apart cell by cell: at most {most} cells per contact radius"

    def solve(self, task: Task) -> Solution:
        return self._peeled(task) if self.adhesion.short_range else self._cohesive(task)

    def _peeled(self, task: Task) -> Solution:
        """Short range: the sets of cells that hold, largest first, serve the way in and out.

        That is right for bodies with one stable contact at a load: single compact ones.
        """
        geometry, control, flat = task.geometry, task.loads.control, self.indenter.flat
        # the gap of the undeformed body at the edge of the widest set of cells
        radius, widest = _MARGIN * geometry.contact_radius, 0.0
        if self.indenter.axisymmetric and not flat:
            widest = float(self.indenter.gap(np.array(radius), np.array(0.0)))
        elif not flat:
            # an ellipsoid: the gap on the ellipse of the same area as the circle
            half_x, half_y = self.indenter.reach(1.0)
            widest = radius**2 / (half_x * half_y)
        operator, gap = self._grid(task, widest)
        touching = np.isfinite(gap) & (gap <= widest)
        # Share of the cells that need not be peeled off any more: far inside every fold.
        until = 0.3 if flat else 0.02
        work = self.adhesion.work
        way = peel(operator, gap, touching, work, tolerance=_TOLERANCE, until=until)
        curve = way.force if control == "force" else way.penetration
        states, pull, attached = [], 0.0, False
        for load in map(float, task.loads.values):
            attached = attached or load >= 0
            count = way.at(load, control) if attached else way.cells.size
            depth, force, area = (load, 0.0, 0.0) if control == "penetration" else _APART
            if count < way.cells.size:
                stiffness, offset = float(way.stiffness[count]), float(way.offset[count])
                area = float(way.area[count])
                if control == "penetration":
                    force = stiffness * load - offset
                else:
                    depth, force = (load + offset) / stiffness, load
            states.append((depth, force, area))
            pull = max(pull, -force)
            if attached and count > 0:  # the sets that a falling load has taken apart one by one
                passed = np.flatnonzero(curve[:count] <= np.minimum.accumulate(curve)[:count])
                pull = max(pull, float(-way.force[passed].min()))
            attached = attached and count < way.cells.size
        curves = _curves(states, pull)
        unknowns, strongest = int(touching.sum()), float(way.force.min())
        solution = _held(task, curves, strongest, unknowns=unknowns, violation=_TOLERANCE)
        solution.truncation = edge_doubt(geometry, task.resolution)
        solution.exact = ("contact_area", "contact_area_raw") if flat else ()
        return solution

    def _cohesive(self, task: Task) -> Solution:
        """Any range: the whole path of equilibria, and on it the places where the loads lead."""
        work, reach, geometry = self.adhesion.work, self.adhesion.range, task.geometry
        modulus, depth = self.scene.effective_modulus, max(geometry.penetration, 0.0)
        law = dugdale(work, work / reach, ramp=_RAMP)
        pulled = float(np.sqrt(2 * np.pi * work / modulus * geometry.contact_radius))
        operator, gap = self._grid(task, (1 + _RAMP) * reach + pulled + depth)
        problem = CohesiveProblem(operator, gap, law)
        control, values, length = task.loads.control, task.loads.values, pulled + reach
        # the path from beyond the largest load to far apart
        top, lowest = depth + 0.05 * length, -0.7 * length
        if control == "penetration":
            top = max(depth, float(values.max())) + 0.05 * length
            lowest = min(lowest, float(values.min()) - 0.05 * length)
        for _ in range(_EXTENSIONS):
            path = trace(problem, top, lowest, steps=_STEPS, tolerance=_TOLERANCE)
            if (path.force if control == "force" else path.penetration)[0] >= values.max():
                break
            top += 0.5 * length + 0.2 * abs(top)
        else:
            raise ConvergenceError("the largest load of an adhesive path was not reached")
        # at zero force it touches, however far apart bodies bear nothing, too
        slight = 1e-9 * float(path.force.max()) if control == "force" else 0.0
        places = path.follow(control, np.where(values == 0, slight, values))
        states, residuals = [], []
        for (i, part), load in zip(places, map(float, values), strict=True):
            before, after = path.points[i : i + 2]
            if part == 1.0 and i == len(path.points) - 2 and control == "force":  # apart
                states.append(_APART)
                residuals.append(after.residual)
                continue
            pressure = before.pressure + part * (after.pressure - before.pressure)
            contact: CohesiveContact
            if control == "penetration":
                contact = problem.at_penetration(load, pressure, _TOLERANCE)
            else:
                guess = before.penetration + part * (after.penetration - before.penetration)
                contact = problem.at_force(load, guess, pressure, _TOLERANCE)
            area = float(contact.mask.sum()) * operator.cell_area
            states.append((contact.penetration, contact.force, area))
            residuals.append(contact.residual)
        # the largest pull at the loads, and on the stretches of the path between two falling ones
        pull = max(0.0, *(-force for _, force, _ in states))
        at, strongest = int(np.argmin(path.force)), float(path.force.min())
        spots = [path.force.size - 1.0, *(i + part for i, part in places)]
        for start, end in pairwise(spots):
            # a rising force jumps over its own minimum; a rising penetration may not
            passed = (start < at < end) or (start > at > end and control == "penetration")
            if passed:
                pull = max(pull, -strongest)
        unknowns = int(np.isfinite(gap).sum())
        violation = float(np.max(residuals))
        curves = _curves(states, pull)
        solution = _held(task, curves, strongest, unknowns=unknowns, violation=violation)
        solution.truncation = _RAMP_DOUBT
        return solution

    def _grid(self, task: Task, level: float) -> tuple[FreeOperator, np.ndarray]:
        """Operator and gap on square cells wherever the undeformed gap is at most `level`."""
        cell = task.geometry.contact_radius / task.resolution
        halves = self.indenter.reach(level)
        nx, ny = (2 * max(1, int(np.ceil(half / cell - 1e-9))) for half in halves)
        # off the axis, lest whole rings of mirror images change sides at once
        x, y = (
            cell * (np.arange(n) - (n - 1) / 2 + off) for n, off in zip((nx, ny), _OFF, strict=True)
        )
        gap = self.indenter.gap(*np.meshgrid(x, y, indexing="ij"))
        return FreeOperator((nx, ny), (cell, cell), self.scene.effective_modulus), gap


def _curves(states: list[tuple[float, float, float]], pull: float) -> dict[str, ArrayLike]:
    """Return the curves of penetrations, forces and areas, with the largest pull on the way."""
    penetration, force, area = np.array(states).T
    radius = np.sqrt(area / np.pi)
    steps = {"penetration": penetration, "force": force, "equivalent_radius": radius}
    return {**steps, "pull_off_force": pull}


def _held(
    task: Task[IndenterGeometry], curves: Mapping[str, ArrayLike], pull_off: float, **more: Any
) -> Solution:
    """Return the solution of a path; a pull on a body that is apart has a reason instead."""
    solution = Solution.of(task, curves, **more)
    for step in np.flatnonzero(np.isnan(solution.quantities["force"][0])):
        lets_go = f"a contact lets go at {unpadded(pull_off, 'N')}"
        reason = f"out of contact nothing bears a pull, {lets_go}"
        solution.fail((0, int(step)), reason, no_equilibrium=True)
    return solution


def edge_doubt(geometry: IndenterGeometry, resolution: int) -> float:
    """Return how far the calibrated tension may be wrong, relative, by cells per contact radius.

    It errs in proportion to the cells. Measured errors of the pull-off force in cells of the
    radius: 0.2 for discs, 1.4 for paraboloids (docs/adhesion.md, against closed forms), 0.4 for
    squares and 0.7 for ellipses to 4 : 1 (against the experiment ``adhesive-face``). The bar is
    1.5 times the largest of flat faces and of round bodies; tests hold it against all of them.
    """
    return (_FLAT_DOUBT if geometry.indenter.flat else _ROUND_DOUBT) / resolution
