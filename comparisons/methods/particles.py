"""The method `mca`: movable cellular automata below a rigid indenter or a rough patch."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry, RoughGeometry
from comparisons.methods import NoAnswerError, Row, Scene, Step, Task
from comparisons.methods.normal.grid import Grid, contact_fields, make_grid, pressure_of
from comparisons.methods.solver import G, Refused, Solver, needed
from reference.halfspace import Contact, FreeOperator
from reference.halfspace.areas import located_area
from reference.loads import Load
from reference.particles import Domain, ParticleContact, ParticleHalfSpace


def contact_step(
    task: Task, body: ParticleHalfSpace, contact: ParticleContact, net: tuple[np.ndarray, Grid]
) -> Step:
    """Return the step of a solved contact; `net`: the automata that are cells, and their grid."""
    numbers, grid = net
    # the contact as one on a grid of cells around the automata of the surface
    shape, area = grid.gap.shape, body.spacing**2
    operator = FreeOperator(shape, grid.spacing, body.effective_modulus)
    pressure = contact.reactions[numbers].reshape(shape) / area
    cells = Contact(
        penetration=contact.penetration,
        force=float(pressure.sum() * operator.cell_area),
        pressure=pressure,
        iterations=contact.steps,
        violation=contact.imbalance,
        operator=operator,
        initial_gap=grid.gap,
        history=list(contact.history),
    )
    # that of the automata, not what the operator would make of their pressure
    cells = cells.with_displacement(contact.displacement[numbers].reshape(shape))
    counted = float(np.count_nonzero(contact.active)) * body.spacing**2
    values = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area_raw": counted,
        "contact_area": counted,
    }
    if not contact.flowed.any():  # elastic: the pressure falls to zero at the edge as a root
        area = located_area(cells, patch=isinstance(task.geometry, RoughGeometry))
        values |= {"contact_area": area, "energy": contact.energy}
    face = None if task.scene.indenter is None else task.scene.indenter.face_area
    if face is not None:
        values["contact_area"] = face
    if isinstance(task.geometry, RoughGeometry):
        values["mean_gap"] = float(cells.gap.mean())
        values["penetration_mean_plane"] = contact.penetration - float(grid.gap.mean())
    if {"stiffness", "contact_length_stiffness"} & set(task.quantities):
        # dF/dd of a flat punch on the automata that touch, of the area that is counted
        punch = np.where(contact.active, 0.0, np.inf)
        (pressed,) = body.press(punch, Load("penetration", contact.penetration))
        outline = values["contact_area"] / counted
        values["stiffness"] = np.sqrt(outline) * (pressed.force / pressed.penetration)

    def inside() -> dict[str, np.ndarray]:
        """Return places, displacements and von Mises stresses of the automata that move."""
        places, displacement, stresses = body.inside(contact)
        return {
            "particle_places": places,
            "particle_displacement": displacement,
            "particle_von_mises": stresses,
            "particle_spacing": np.array(body.spacing),
        }

    return Step(
        values,
        iterations=contact.steps,
        violation=contact.imbalance,
        unknowns=body.bodies * 6 * body.automata.packing.free,
        pressure=pressure_of(task, cells, grid),
        fields=partial(contact_fields, task, cells, grid),
        body_fields=inside,
    )


# The mean stress grows as 1/(1 - 2 nu), and the steps to equilibrium as its root. Hertz at four
# automata per radius: 0.4 % at nu = 0.3, 1.0 at 0.45, 1.5 at 0.49, where steps are three times as
# many; at 0.499 they are ten times as many, and the pressure alternates from one to the next.
LARGEST_POISSON = 0.49
# Automata between the edge of the overlap and the shell, in contact radii: 2.5 are as good as 5.5
# within 2e-4 of the force. Of a rough patch, in half sides.
MARGIN, ROUGH_MARGIN = 2.5, 0.5
TRUNCATION, ROUGH_TRUNCATION = 3e-4, 2e-3
# A load takes about a minute on this many.
MOST_AUTOMATA = 200_000
# Measured with a million: 680.
BYTES_PER_AUTOMATON = 900
# Across the narrow side of a contact.
FEWEST_ACROSS = 3


class McaSolver(Solver[G]):
    """A half-space of automata, in a shell that follows Boussinesq."""

    span = 1e6  # each load scales the packing onto its own contact

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        both = scene.counter_body is not None
        self.constants = [scene.elastic_constants]
        if both and scene.methods.mca.coupling == "automata":
            halves = (scene.half_space, needed(scene.counter_body, "no [counter_body]"))
            self.constants = [(half.modulus * (1 - half.nu**2), half.nu) for half in halves]
        largest = max(nu for _, nu in self.constants)
        if largest > LARGEST_POISSON:
            raise Refused(
                f"nu = {largest:g}: the mean stress of automata follows their change of volume, "
                f"which is lost in their pair strains above {LARGEST_POISSON}"
            )
        if scene.loading.control == "mean_gap":
            raise Refused("no mean-gap control: use bem_fft or fem, or prescribe the force")
        if scene.surface is not None and scene.surface.periodic:
            raise Refused("models a free patch, not a periodic half-space")
        self.balance = scene.methods.mca.balance

    def domain(self, geometry: G, resolution: int) -> Domain:
        """Return the sizes of the body for the largest load."""
        raise NotImplementedError

    def refusal(self, task: Task[G]) -> str:
        """Refuse bodies of more automata than a minute per load is enough for."""
        number = self.count(task.geometry, task.resolution)
        if number <= MOST_AUTOMATA:
            return ""
        return f"{number:.0f} automata, more than {MOST_AUTOMATA}"

    def memory(self, task: Task[G]) -> float:
        """Bytes of the automata, their bonds and the arrays of the relaxation."""
        return BYTES_PER_AUTOMATON * self.count(task.geometry, task.resolution)

    def count(self, geometry: G, resolution: int) -> float:
        """Return the number of automata in all bodies, about."""
        return len(self.constants) * self.domain(geometry, resolution).count

    @property
    def _halves(self) -> str:
        if len(self.constants) == 1:
            return "half an ellipsoid"
        return "two half ellipsoids, one for each body, net on net,"

    def warm_up(self, task: Task[G]) -> None:
        body = ParticleHalfSpace(Domain((2.0, 2.0), 1.0), [(1.0, self.constants[0][1])])
        for _ in body.press((body.points**2).sum(axis=1), Load("penetration", 1.5)):
            pass

    def body(self, domain: Domain, spacing: float) -> ParticleHalfSpace:
        """Return the automata of one body, or of two, in SI units."""
        return ParticleHalfSpace(domain, self.constants, spacing=spacing)


class Mca(McaSolver[IndenterGeometry]):
    """Single contacts: a packing that is scaled to each of them."""

    name = "mca"
    rough = False

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter = needed(scene.indenter, "single contacts only")

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Automata per contact radius: seconds for the three, or some ten."""
        return (3, 4, 6) if self.scene.compare.tolerance < 0.01 else (2, 3, 5)

    def domain(self, geometry: IndenterGeometry, resolution: int) -> Domain:
        return self._domain(geometry.penetration, geometry.contact_radius, resolution)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        half = min(task.geometry.reach) / task.geometry.contact_radius
        across = 2 * task.resolution * half
        if across < FEWEST_ACROSS:
            return f"{across:.1f} automata across the narrow side, fewer than {FEWEST_ACROSS}"
        return super().refusal(task)

    def model(self, geometry: IndenterGeometry) -> str:
        number = 100 * round(self.count(geometry, self.resolutions(geometry)[-1]) / 100)
        return (
            f"{self._halves} of up to {number} automata in dense packing, scaled to each load, "
            "with pair forces and a mean stress of all neighbours; around it a shell in the field "
            "of Boussinesq"
        )

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Yield the only row: every load has its own scale."""
        yield Row(partial(self.steps, task), truncation=TRUNCATION)

    def steps(self, task: Task[IndenterGeometry], loads: np.ndarray) -> Iterator[Step]:
        geometry = task.geometry
        for step, load in enumerate(loads, start=len(task.loads.values) - len(loads)):
            depth, radius = geometry.penetrations[step], geometry.contact_radii[step]
            if not (radius > 0.0 and depth > 0.0):
                raise NoAnswerError(geometry.unreached.get(step, "no estimate of its contact"))
            domain = self._domain(depth, radius, task.resolution)
            body = self.body(domain, radius / task.resolution)
            gap = np.asarray(self.indenter.gap(*body.points.T), dtype=float)
            face = self.indenter.face_area
            if face is not None:  # a flat one has the area of the automata below: so far apart
                count = np.count_nonzero(np.isfinite(gap))
                if not count:
                    raise NoAnswerError("no automaton lies under the face: it is too narrow")
                body = self.body(domain, float(np.sqrt(face / count)))
            pressed = Load(task.loads.control, [load])
            for contact in body.press(gap, pressed, balance=self.balance):
                yield contact_step(task, body, contact, net_of(body, gap, domain))

    def _domain(self, depth: float, radius: float, resolution: int) -> Domain:
        half_x, half_y = (half / radius for half in self.indenter.reach(1.05 * depth))
        loaded = half_x * resolution + 0.5, half_y * resolution + 0.5
        return Domain(loaded, MARGIN * resolution)


class McaPatch(McaSolver[RoughGeometry]):
    """A rough patch, an automaton of the surface below each of its points."""

    name = "mca"
    rough = True

    def resolutions(self, geometry: RoughGeometry) -> tuple[int, ...]:
        """Points of the surface, and twice as many where that is affordable."""
        n = geometry.points[0]
        able = [m for m in (n, 2 * n) if self.count(geometry, m) <= MOST_AUTOMATA]
        return tuple(able) or (n,)

    def block(self, resolution: int) -> int:
        """Return one surface per task: each takes seconds."""
        return 1

    def domain(self, geometry: RoughGeometry, resolution: int) -> Domain:
        nx, ny = _points(geometry, resolution)
        return Domain((nx / 2 + 0.5, ny / 2 + 0.5), ROUGH_MARGIN * max(nx, ny) / 2 + 1.0)

    def refusal(self, task: Task[RoughGeometry]) -> str:
        counts = _points(task.geometry, task.resolution)
        dx, dy = (side / n for side, n in zip(task.geometry.size, counts, strict=True))
        if abs(dx / dy - 1) > 1e-6:
            return f"automata form a square net, and the points are {dx:.6g} m by {dy:.6g} m apart"
        return super().refusal(task)

    def model(self, geometry: RoughGeometry) -> str:
        return (
            f"{self._halves} of automata in dense packing below the patch, one of the surface at "
            "each of its points; around it a shell in the field of Boussinesq"
        )

    def rows(self, task: Task[RoughGeometry]) -> Iterator[Row]:
        geometry = task.geometry
        nx, ny = _points(geometry, task.resolution)
        body = self.body(self.domain(geometry, task.resolution), geometry.size[0] / nx)
        # the first point of the patch lies on an automaton; the patch is centred to half a spacing
        corner = np.array([-(nx // 2), -(ny // 2)])
        numbers = _numbers_at(body, corner, (nx, ny))

        def steps(realisation: int, loads: np.ndarray) -> Iterator[Step]:
            grid = make_grid(geometry, task.resolution, realisation)
            gap = np.full(len(body.points), np.inf)
            gap[numbers] = grid.gap.ravel()
            load = Load(task.loads.control, loads)
            for contact in body.press(gap, load, balance=self.balance):
                yield contact_step(task, body, contact, (numbers, grid))

        unknowns = body.bodies * 6 * body.automata.packing.free
        for realisation in task.realisations:
            sweep = partial(steps, realisation)
            yield Row(sweep, unknowns=unknowns, truncation=ROUGH_TRUNCATION)


def _points(geometry: RoughGeometry, resolution: int) -> tuple[int, int]:
    nx, ny = geometry.points
    return resolution, ny * resolution // nx


def net_of(body: ParticleHalfSpace, gap: np.ndarray, domain: Domain) -> tuple[np.ndarray, Grid]:
    """Return the automata around an indenter's overlap, and the grid of cells around them."""
    nx, ny = (int(half) for half in domain.loaded)
    shape = 2 * nx + 1, 2 * ny + 1
    numbers = _numbers_at(body, np.array([-nx, -ny]), shape)
    origin = -0.5 * shape[0] * body.spacing, -0.5 * shape[1] * body.spacing
    return numbers, Grid(gap[numbers].reshape(shape), (body.spacing,) * 2, origin)


def _numbers_at(body: ParticleHalfSpace, corner: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the numbers of the automata of a rectangle of the surface, row by row."""
    places = np.rint(body.points / body.spacing).astype(int) - corner
    inside = ((places >= 0) & (places < shape)).all(axis=1)
    numbers = np.full(shape, -1)
    numbers[tuple(places[inside].T)] = np.flatnonzero(inside)
    return numbers.ravel()
