"""Bodies that yield below an indenter: J2 finite elements, axisymmetric or in 3-D, and automata."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry, equivalent_profile
from comparisons.methods import Refused, Scene, Solution, Solver, Task
from comparisons.methods.fem.indenter import PARTS, contact_stretch
from comparisons.methods.particles import Mca, contact_step, net_of
from comparisons.methods.plasticity.laws import (
    FIRST_PRESSURE,
    PHYSICS,
    estimated_radius,
    material_of,
    tables_of,
)
from comparisons.scene.indenters.not_round import Ellipsoid
from comparisons.scene.loading import loads_of
from comparisons.tasks.shown_loads import Fields
from comparisons.tasks.steps import Row, Step, record
from reduced.loads import Load
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference import loads as reference_loads
from reference.elasticity import LARGEST_POISSON_RATIO, von_mises
from reference.errors import ConvergenceError
from reference.loads import LoadPath
from reference.particles import Domain, ParticleHalfSpace
from reference.particles.yielding import PlasticHalfSpace
from reference.plastic import DentMoment, OutgrownError, Walk
from reference.plastic.indentation import first_yield

# Meshes resolve contacts down to this share of the largest.
_SMALLEST = 1 / 3
# Meshes are widened where a contact turns out larger than estimated.
_WIDENINGS, _WIDER = 4, 1.25
# Measured on Hertz's contact, of which this is all that the mesh leaves out (docs/plasticity.md).
TRUNCATION, TRUNCATION_BLOCK = 2e-4, 1e-3
_OF_AREA = frozenset({"contact_area", "contact_radius", "equivalent_radius"})
# The area by the stiffness of unloading is known to this share of one over the elements per radius,
# however little grids happen to differ (2, 1 and 0.4 % were seen on 3, 4 and 6).
AREA = 0.06
# Longest contacts in three dimensions, as length over width: the mesh grows with their logarithm.
_SLENDEREST = 10


class FemPlasticity(Solver[IndenterGeometry]):
    """Finite elements of a half-space that yields, beyond them Boussinesq fields."""

    name = "fem"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter, self.plasticity = tables_of(scene)
        self.round = self.indenter.axisymmetric
        _, nu = scene.elastic_constants
        if nu > LARGEST_POISSON_RATIO:
            raise Refused(f"nu = {nu:g}: displacement elements are limited to 0.4999")
        self.material = material_of(scene)
        self.profile = equivalent_profile(self.indenter)
        ellipse = isinstance(self.indenter, Ellipsoid)
        self.stretch = contact_stretch(self.indenter) if ellipse else (1.0, 1.0)
        if max(self.stretch) ** 2 > _SLENDEREST:
            raise Refused(f"contacts of up to {_SLENDEREST} : 1 on this mesh")
        if self.indenter.sharp_tip:
            self.note = "below a sharp tip the half-space yields at once: no first_yield"
        if not self.round:
            counted = (
                "the contact area is counted: on four to two elements 5 to 12 % low at the largest "
                "load, more at smaller ones"
            )
            self.note = "; ".join(filter(None, [self.note, counted]))

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Elements per contact radius, or half-width: on nine the force is known to 0.5 %.

        In three dimensions a load takes seconds on two, a minute on four.
        """
        if not self.round:
            return (2, 3) if self.scene.compare.tolerance >= 0.01 else (2, 3, 4)
        finest = int(np.clip(9 * np.sqrt(0.01 / self.scene.compare.tolerance), 9, 24))
        finest -= finest % 3
        return finest // 3, 2 * finest // 3, finest

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of elements, and of the factor of their matrix."""
        if self.round:
            return 60_000.0 * (3.2 * task.resolution + 12) * (1.6 * task.resolution + 12)
        halves = 2.0 ** (2 - sum(self.indenter.even))
        return 800_000.0 * halves * (1.25 * task.resolution + 6) ** 2 * (task.resolution + 6)

    def model(self, geometry: IndenterGeometry) -> str:
        parts = PARTS[sum(self.indenter.even)]
        mesh = "axisymmetric elements" if self.round else f"hexahedra of {parts}the body"
        return (
            f"quadratic {mesh} (B-bar) with von Mises plasticity, radial return; "
            "outside them the Boussinesq field of the force"
        )

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Walk the path; on a wider mesh where the contact outgrows the one estimated."""
        pressing = task.loads.values[task.loads.values > 0]
        smallest, largest = (
            estimated_radius(self.scene, self.profile, task.loads.control, float(v))
            for v in (pressing.min(), pressing.max())
        )
        yields_at = self._yields_at(task)
        # a contact that is not round is counted (`note`)
        radii = dict.fromkeys(("contact_radius", "equivalent_radius"), AREA / 2)
        of_area = {"contact_area": AREA, "pressure_mean": AREA} | radii if self.round else {}
        for _ in range(_WIDENINGS):
            solution = Solution.empty(task)
            solution.truncation = TRUNCATION if self.round else TRUNCATION_BLOCK
            with solution.setup():
                walk = Walk(
                    self.material,
                    self._gap,
                    self._widths(largest),
                    smallest=min(max(smallest, _SMALLEST * largest), largest),
                    per_radius=task.resolution,
                    even=self.indenter.even,
                )
            solution.unknowns = walk.mesh.size
            path, before = LoadPath(task.loads.control, task.loads.values), 0
            try:
                for step, moment in enumerate(walk.along(path)):
                    values = {
                        "penetration": moment.penetration,
                        "force": moment.force,
                        "contact_area_raw": moment.counted_area,
                        "energy": moment.elastic,
                        **yields_at,
                    }
                    # both unload on the side, which may fail: the path itself goes on
                    if not _OF_AREA.isdisjoint(task.quantities):
                        with suppress(ConvergenceError):
                            values["contact_area"] = walk.contact_area(moment)
                    if "residual_depth" in task.quantities:
                        with suppress(ConvergenceError):
                            values["residual_depth"] = walk.residual_depth(moment)
                    found = Step(
                        values,
                        bars={name: share / task.resolution for name, share in of_area.items()},
                        iterations=moment.iterations - before,
                        violation=moment.residual,
                        fields=partial(self._fields, walk, moment),
                    )
                    record(solution, (0, step), found, task)
                    before = moment.iterations
                break
            except ConvergenceError as error:
                for lost in range(int(solution.converged.sum()), task.shape[1]):
                    solution.fail((0, lost), error.reason)
                if not isinstance(error, OutgrownError):
                    break
            largest *= _WIDER
        return solution

    def _yields_at(self, task: Task[IndenterGeometry]) -> dict[str, float]:
        """Return the penetration of first yield, where it is asked for and exists."""
        if "first_yield" not in task.quantities or self.indenter.sharp_tip:
            return {}
        largest = Load(task.loads.control, float(task.loads.values.max()))
        contact = indent(Springs(self.profile, self.scene.effective_modulus), largest)
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
                lambda d: self._widths(float(self.profile.contact_radius(d))),
                start,
                per_radius=task.resolution,
                even=self.indenter.even,
            )
        except ConvergenceError:
            return {}
        return {"first_yield": depth}

    def _widths(self, radius: float) -> float | tuple[float, float]:
        """Return the half-widths of a contact of the area of a circle; its radius if it is one."""
        x, y = self.stretch
        return radius if self.round else (radius * x, radius * y)

    def _gap(self, x: np.ndarray, y: np.ndarray | None = None) -> np.ndarray:
        return self.indenter.gap(x, np.zeros(x.shape) if y is None else y)

    def _fields(self, walk: Walk, moment: DentMoment) -> Fields:
        """Return the section along x: where it has yielded, and the shape of the surface."""
        mesh, state = walk.mesh, moment.state
        place, (on_top, sunk) = mesh.place * walk.length, walk.surface(moment)
        cut, rim = (np.ones(at.shape[1:], dtype=bool) for at in (place, on_top))
        if not self.round:  # the points next to y = 0
            beyond = (np.where(at[0] >= 0, np.abs(at[1]), np.inf) for at in (place, on_top))
            cut, rim = (far <= far.min() * (1 + 1e-6) for far in beyond)
        return {
            "penetration": np.array(moment.penetration),
            "section_r": place[0][cut],
            "section_z": place[-1][cut],
            "section_plastic_strain": state.points.amount[cut],
            "section_von_mises": von_mises(state.stress)[cut] * walk.modulus,
            "surface_r": on_top[0][rim],
            "surface_depth": sunk[rim],
        }


# Of the stages in which a load is reached: measured at sixty times the depth of first yield.
TRUNCATION_AUTOMATA = 0.015
# First yield is known where the stress of the last contact tried differs from Y by no more.
_AGREED, _TRIALS = 1e-3, 12


class McaPlasticity(Mca):
    """One body of automata for a whole path, scaled to its largest contact."""

    physics = PHYSICS
    span = 1.0

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter, self.plasticity = tables_of(scene)
        self.material = material_of(scene)
        self.profile = equivalent_profile(self.indenter)

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Automata per contact radius at the largest load: seconds for each step."""
        return (3, 4, 6) if self.scene.compare.tolerance < 0.01 else (3, 4, 5)

    def model(self, geometry: IndenterGeometry) -> str:
        return f"{super().model(geometry)}; von Mises plasticity by radial return in each automaton"

    def domain(self, geometry: IndenterGeometry, resolution: int) -> Domain:
        return self._sized(resolution)[0]

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        domain, spacing = self._sized(task.resolution)
        body = PlasticHalfSpace(domain, self.material, spacing=spacing)
        yields_at, gap = self._yields_at(task), self._gap(body)
        net = net_of(body, gap, domain)

        def steps(loads: np.ndarray) -> Iterator[Step]:
            path = LoadPath(task.loads.control, loads)
            for contact in body.walk(gap, path, balance=self.balance):
                step = contact_step(task, body, contact, net)
                more = dict(yields_at)
                if "residual_depth" in task.quantities:
                    with suppress(ConvergenceError):  # the path itself goes on without the dent
                        more["residual_depth"] = body.residual_depth(gap, balance=self.balance)
                yield replace(step, quantities={**step.quantities, **more})

        yield Row(steps, unknowns=6 * body.automata.packing.free, truncation=TRUNCATION_AUTOMATA)

    def _yields_at(self, task: Task[IndenterGeometry]) -> dict[str, float]:
        """Return the penetration of first yield, where it is asked for and exists.

        Elastic contacts, each on a packing of its own scale, follow sigma ~ d^(1/2), which is that
        of curved shapes.
        """
        if "first_yield" not in task.quantities or self.indenter.sharp_tip:
            return {}
        depth, limit = task.geometry.penetration, self.plasticity.yield_stress
        for _ in range(_TRIALS):
            radius = float(self.profile.contact_radius(depth))
            domain = self._domain(depth, radius, task.resolution)
            body = self.body(domain, radius / task.resolution)
            try:
                (contact,) = body.press(self._gap(body), reference_loads.Load("penetration", depth))
            except ConvergenceError:
                return {}
            ratio = limit / body.largest_stress(contact)
            if abs(ratio - 1) < _AGREED:
                return {"first_yield": depth}
            depth *= ratio**2
        return {}

    def _gap(self, body: ParticleHalfSpace) -> np.ndarray:
        return np.asarray(self.indenter.gap(*body.points.T), dtype=float)

    def _sized(self, resolution: int) -> tuple[Domain, float]:
        """Return the body for the largest load, and its spacing.

        Under a force the dent is no deeper than an elastic body's under a contact as wide.
        """
        loads = loads_of(self.scene)
        load = float(loads.values.max())
        radius = estimated_radius(self.scene, self.profile, loads.control, load)
        depth = load
        if loads.control == "force":
            depth = float(self.indenter.gap(*np.array([[np.sqrt(2) * radius], [0.0]]))[0])
        return self._domain(depth, radius, resolution), radius / resolution
