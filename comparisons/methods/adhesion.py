"""Adhesion under a path of loads: springs, JKR closed forms, the half-space on a grid."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods.normal.bem_fft import HalfSpaceGrid
from comparisons.methods.normal.closed_form import form_of
from comparisons.methods.normal.reduced import ProfileSolver
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.indenters.axisymmetric import PowerLaw
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.physics.absolute_loads import AbsoluteLoads
from comparisons.scene.physics.tables.adhesion import Adhesion as AdhesionTable
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.adhesion import Adhesion, State, adhere, pull_off
from reduced.loads import LoadPath
from reduced.springs.line import Springs
from reference.closed_form.adhesive import AdhesiveForm
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator
from reference.halfspace.cohesive import CohesiveContact, CohesiveProblem, dugdale
from reference.halfspace.cohesive_path import CohesivePath, trace
from reference.halfspace.detachment import Peeling, peel

# The first set of cells is wider than the largest contact by this share.
_MARGIN = 1.1
_TOLERANCE = 1e-7
# Half the width of the ramp in place of Maugis' step, as a share of the range.
_RAMP = 0.3
# Where the axis lies between cells.
_OFF = (0.13, -0.21)
_STEPS, _EXTENSIONS = 40, 12
# What the calibrated tension may cost, in cells of the contact radius.
_FLAT_DOUBT, _ROUND_DOUBT = 1.05, 2.1


@dataclass(frozen=True)
class AdhesiveContact:
    """What adheres, and an estimate of its contact at the largest load."""

    indenter: Indenter
    adhesion: AdhesionTable
    modulus: float
    geometry: IndenterGeometry


@dataclass(frozen=True)
class GridWalk:
    """What a grid gives along a path: arrays of shape (k,), and the largest pull on the way."""

    penetration: np.ndarray
    force: np.ndarray
    area: np.ndarray
    largest_pull: float
    residual: float
    unknowns: int


def peeled_walk(body: AdhesiveContact, loads: AbsoluteLoads, resolution: int) -> GridWalk:
    """Short range: the sets of cells that hold, largest first, serve the way in and out.

    That is right for bodies with one stable contact at a load: single compact ones.
    """
    widest, work = _widest_gap(body), body.adhesion.work
    operator, gap = _grid(body, resolution, widest)
    touching = np.isfinite(gap) & (gap <= widest)
    # Share of the cells that need not be peeled off any more: far inside every fold.
    until = 0.3 if body.indenter.flat else 0.02
    way = peel(operator, gap, touching, work, tolerance=_TOLERANCE, until=until)
    states, pull, attached = [], 0.0, False
    for load in loads.values:
        attached = attached or load >= 0
        cell_count = way.at(float(load), loads.control) if attached else way.cells.size
        states.append(_peeled_state(way, cell_count, float(load), loads.control))
        pull = max(pull, -states[-1][1], _pull_on_the_way(way, cell_count, attached, loads.control))
        attached = attached and cell_count < way.cells.size
    penetration, force, area = (np.array(part) for part in zip(*states, strict=True))
    return GridWalk(penetration, force, area, pull, _TOLERANCE, int(touching.sum()))


def edge_doubt(geometry: IndenterGeometry, resolution: int) -> float:
    """Return how far the calibrated tension may be wrong, relative, by cells per contact radius.

    It errs in proportion to the cells. Measured errors of the pull-off force in cells of the
    radius: 0.2 for discs, 1.4 for paraboloids (docs/adhesion.md, against closed forms), 0.4 for
    squares and 0.7 for ellipses to 4 : 1 (against the experiment ``adhesive-face``). The bar is
    1.5 times the largest of flat faces and of round bodies; tests hold it against all of them.
    """
    return (_FLAT_DOUBT if geometry.indenter.flat else _ROUND_DOUBT) / resolution


def _peeled_state(
    way: Peeling, cell_count: int, load: float, control: str
) -> tuple[float, float, float]:
    """Penetration, force and area of a set under a load; zeros where nothing holds."""
    if cell_count == way.cells.size:
        return load if control == "penetration" else 0.0, 0.0, 0.0
    stiffness, offset = float(way.stiffness[cell_count]), float(way.offset[cell_count])
    area = float(way.area[cell_count])
    if control == "penetration":
        return load, stiffness * load - offset, area
    return (load + offset) / stiffness, load, area


def _pull_on_the_way(way: Peeling, cell_count: int, attached: bool, control: str) -> float:
    """Largest pull of the sets that a falling load has taken apart one by one."""
    if not attached or cell_count == 0:
        return 0.0
    curve = way.force if control == "force" else way.penetration
    passed = np.flatnonzero(curve[:cell_count] <= np.minimum.accumulate(curve)[:cell_count])
    return float(-way.force[passed].min())


def _widest_gap(body: AdhesiveContact) -> float:
    """Gap of the undeformed body at the edge of the widest set of cells."""
    if body.indenter.flat:
        return 0.0
    radius = _MARGIN * body.geometry.contact_radius
    if body.indenter.axisymmetric:
        return float(body.indenter.gap(np.array(radius), np.array(0.0)))
    # an ellipsoid: the gap on the ellipse of the same area as the circle
    half_x, half_y = body.indenter.reach(1.0)
    return radius**2 / (half_x * half_y)


def _grid(body: AdhesiveContact, resolution: int, level: float) -> tuple[FreeOperator, np.ndarray]:
    """Operator and gap on square cells wherever the undeformed gap is at most `level`."""
    cell = body.geometry.contact_radius / resolution
    nx, ny = (2 * max(1, int(np.ceil(half / cell - 1e-9))) for half in body.indenter.reach(level))
    # off the axis, lest whole rings of mirror images change sides at once
    x, y = (cell * (np.arange(n) - (n - 1) / 2 + o) for n, o in zip((nx, ny), _OFF, strict=True))
    gap = body.indenter.gap(*np.meshgrid(x, y, indexing="ij"))
    return FreeOperator((nx, ny), (cell, cell), body.modulus), gap


def cohesive_walk(body: AdhesiveContact, loads: AbsoluteLoads, resolution: int) -> GridWalk:
    """Any range: the whole path of equilibria, and on it the places where the loads lead."""
    work, reach, geometry = body.adhesion.work, body.adhesion.range, body.geometry
    law = dugdale(work, work / reach, ramp=_RAMP)
    pulled = float(np.sqrt(2 * np.pi * work / body.modulus * geometry.contact_radius))
    level = (1 + _RAMP) * reach + pulled + max(geometry.penetration, 0.0)
    operator, gap = _grid(body, resolution, level)
    problem = CohesiveProblem(operator, gap, law)
    path = _path(problem, loads, max(geometry.penetration, 0.0), pulled + reach)
    places = path.follow(loads.control, loads.values)
    states = [
        _settled(problem, path, place, float(load), loads.control)
        for place, load in zip(places, loads.values, strict=True)
    ]
    penetration, force, area, residual = (np.array(part) for part in zip(*states, strict=True))
    return GridWalk(
        penetration,
        force,
        area,
        _passed_pull(path, places, force, loads.control),
        float(residual.max()),
        int(np.isfinite(gap).sum()),
    )


def _path(
    problem: CohesiveProblem, loads: AbsoluteLoads, penetration: float, length: float
) -> CohesivePath:
    """Path from beyond the largest load to far apart; lengths in units of `length`."""
    top = max(penetration, float(loads.values.max())) if loads.control == "penetration" else 0.0
    top = max(top, penetration) + 0.05 * length
    lowest = -0.7 * length
    if loads.control == "penetration":
        lowest = min(lowest, float(loads.values.min()) - 0.05 * length)
    for _ in range(_EXTENSIONS):
        path = trace(problem, top, lowest, steps=_STEPS, tolerance=_TOLERANCE)
        pressed = path.force if loads.control == "force" else path.penetration
        if pressed[0] >= loads.values.max():
            return path
        top += 0.5 * length + 0.2 * abs(top)
    raise ConvergenceError("the largest load of an adhesive path was not reached")


def _settled(
    problem: CohesiveProblem,
    path: CohesivePath,
    place: tuple[int, float],
    load: float,
    control: str,
) -> tuple[float, float, float, float]:
    """Penetration, force, area and residual at a load, from its place on the path."""
    i, part = place
    before, after = path.points[i : i + 2]
    last = part == 1.0 and i == len(path.points) - 2
    if last and control == "force":
        return 0.0, 0.0, 0.0, after.residual
    pressure = before.pressure + part * (after.pressure - before.pressure)
    depth = before.penetration + part * (after.penetration - before.penetration)
    contact: CohesiveContact
    if control == "penetration":
        contact = problem.at_penetration(load, pressure, _TOLERANCE)
    else:
        contact = problem.at_force(load, depth, pressure, _TOLERANCE)
    area = float(contact.mask.sum()) * problem.operator.cell_area
    return contact.penetration, contact.force, area, contact.residual


def _passed_pull(
    path: CohesivePath, places: list[tuple[int, float]], force: np.ndarray, control: str
) -> float:
    """Largest pull at the loads and on the stretches of the path between two falling ones."""
    pull = float(-force.min())
    fold = path.pull_off()
    if fold is None:
        return max(pull, 0.0)
    at = int(np.argmin(path.force)) + 0.0
    spots = [path.force.size - 1.0, *(i + part for i, part in places)]
    for start, end in pairwise(spots):
        # a rising force jumps over its own minimum; a rising penetration may not
        if (start < at < end) or (start > at > end and control == "penetration"):
            pull = max(pull, -fold[1])
    return max(pull, 0.0)


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


class ReducedAdhesion(ProfileSolver):
    """The edge-stretch rule, whatever the range of attraction and the outline."""

    name = "reduced"
    physics = PHYSICS
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        _, self.adhesion = _adhesive(scene)

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line, and what is taken for zero."""
        range_note = "" if self.adhesion.short_range else "; the range is taken as zero"
        return f"{super().model(geometry)}; edges hold a stretch √(2π a w/E*){range_note}"

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

    def model(self, geometry: IndenterGeometry) -> str:
        """Cite the solution."""
        return f"exact solution, nothing is discretised ({self.note})"

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
        """Name the law of detachment."""
        if self.adhesion.short_range:
            law = "cells detach at a mesh-dependent tension (Pohrt & Popov 2015)"
        else:
            law = "a constant tension out to the range, over a ramp of ±30 % of it (Maugis 1992)"
        return f"square cells, free space around them; {law}"

    def warm_up(self, task: Task) -> None:
        """Compile the convolution."""
        FreeOperator((8, 8), (1.0, 1.0), 1.0).apply(np.ones((8, 8)))

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
