"""A rigid indenter on an elastic-plastic half-space: first yield, loading, unloading and reloading.

Loads and moments are in the units of the caller, steps and states have E = 1 and lengths in the
contact radius that the mesh is made for. The surface is held off the indenter by stiff springs at
quadrature points; the sum of their forces is the force, exactly. Each step minimises one convex
potential (incremental plasticity, exterior, springs): Newton's method with a line search on its
slope converges from anywhere.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Array
from reference.elasticity import von_mises
from reference.errors import ConvergenceError, count_faults, positive_faults, refuse
from reference.loads import LoadPath
from reference.plastic.elements import Elements
from reference.plastic.j2 import PlasticMaterial, Points, respond

# Stiffness of the surface springs, in E* over the length of an element.
_SPRINGS = 100.0
_ROUNDS, _SEARCHES, _HALVINGS = 30, 12, 6
# Forces of an unloading, over the first, whose beginning has the stiffness of the contact.
_UNLOADED = np.arange(0.9, 0.25, -0.1)
# What a round leaves of the unbalanced forces where the next one has the same factorisation.
_WORN = 0.03
# Unbalanced forces, relative to the force on the indenter.
TOLERANCE = 1e-8
# A rising load goes in steps whose logarithms are so many elements over a radius at its end, and
# the longer the further from it (by this power: what lies before is soon forgotten) from a share of
# the load on. Round contacts: as fine as their energies need to balance to 1e-4 on nine elements.
_STEP, _BLOCK_STEP = 0.1, 0.5
_POWER, _FIRST = 0.75, 1 / 32
# Steps of a stretch that falls, and of the work that an unloading gives back.
_FALLING, _GIVEN_BACK = 3, 6
# Of the search for first yield.
_YIELD_ROUNDS, _YIELD_TOLERANCE = 30, 1e-4


class OutgrownError(ConvergenceError):
    """A contact is larger than its mesh was made for: a wider one may hold it."""


@dataclass(frozen=True)
class PlasticState:
    """An indentation at one load.

    `unknowns` are displacements and the amplitude of the exterior, `stress` is (elements, points,
    components), `peak` the largest force so far. `elastic` is the energy with that of the exterior
    and of the springs; dissipation and the work of the force are integrated along the steps.
    `iterations` counts Newton's steps so far; `residual` is the unbalanced forces over the force.
    The next step starts from `rate`, the change of the unknowns per penetration in the last one.
    """

    penetration: float
    force: float
    unknowns: Array
    points: Points
    stress: Array
    peak: float = 0.0
    elastic: float = 0.0
    dissipated: float = 0.0
    work: float = 0.0
    iterations: int = 0
    residual: float = 0.0
    rate: Array | None = None


def elastic_work(way: float, forces: tuple[float, float]) -> float:
    """Return the work of a force whose power 2/3 is linear along a way.

    That is exact for a ball on an elastic surface, and nearly so on a dented one.

    >>> round(elastic_work(1.0, (0.0, 1.0)), 12)
    0.4
    """
    before, force = (float(f) ** (2 / 3) for f in forces)
    if before == force:
        return way * forces[0]
    return float(0.4 * way * (force**2.5 - before**2.5) / (force - before))


@dataclass(frozen=True)
class DentMoment:
    """A contact at one load of a path.

    `counted_area` of contact lies between the points that touch: to a part of an element. `work` of
    the force and plastic dissipation are those so far, `iterations` Newton's steps so far,
    `residual` the unbalanced forces over the largest force.
    """

    penetration: float
    force: float
    counted_area: float
    work: float
    elastic: float
    dissipated: float
    iterations: int
    residual: float
    state: PlasticState


class Walk:
    """An indentation that is led along a path.

    Parameters
    ----------
    shape : callable
        The gap at first touch, f(r) or f(x, y).
    radius : float or (float, float)
        Contact radius at the largest load, roughly: contacts of up to 1.25 times that fit. Two
        half-widths, in x and y: elements in three dimensions below f(x, y).
    smallest : float
        Radius at the smallest load that shall be resolved, of round contacts.
    per_radius : int
        Elements per contact radius, or half-width.
    even : (bool, bool)
        Whether x = 0, and y = 0, is a plane of symmetry of f(x, y).

    Attributes
    ----------
    step : float
        Of the logarithm of a rising load, at its end.
    length, modulus : float
        Units of states over those of the caller.
    material, shape, gap
        In the units of states: E = 1, `shape` of scaled places, `gap` at those of the springs.

    Examples
    --------
    Elastic, it is Hertz's contact:

    >>> from reference.elasticity import Material
    >>> steel = PlasticMaterial(Material(0.91, 0.3), np.inf)
    >>> ball = Walk(steel, lambda r: r**2 / 2, 0.1, per_radius=4)
    >>> (moment,) = ball.along(LoadPath("penetration", 0.01))
    >>> abs(moment.force / (4 / 3 * 0.01**1.5) - 1) < 1e-3
    True
    """

    def __init__(
        self,
        material: PlasticMaterial,
        shape: Callable[..., Array],
        radius: float | tuple[float, float],
        *,
        smallest: float | None = None,
        per_radius: int = 8,
        even: tuple[bool, bool] = (True, True),
    ) -> None:
        faults = count_faults(2, per_radius=per_radius)
        sides = np.broadcast_to(np.asarray(radius, dtype=float), 2)
        faults += positive_faults(radius=min(sides))
        length = float(np.sqrt(sides[0] * sides[1])) if min(sides) > 0 else 1.0
        least = 1.0 if smallest is None else smallest / length
        if not 0 < least <= 1 + 1e-12:
            faults.append(f"smallest must lie in (0, radius], not {smallest!r}")
        refuse(faults)
        nu = material.elastic.poisson_ratio
        if np.ndim(radius) == 0:
            mesh = Elements.section(least, 1.0, per_radius, nu)
        else:
            mesh = Elements.block((sides[0] / length, sides[1] / length), per_radius, nu, even)
        self.mesh, self.length, self.modulus = mesh, length, material.elastic.youngs_modulus
        self.material = material.scaled(self.modulus)
        self.shape = lambda *at: np.asarray(shape(*(x * length for x in at)), float) / length
        self.gap = self.shape(*mesh.surface.place)
        self.springs = _SPRINGS / (1 - nu**2) / mesh.surface.length[:, None]
        self.step = (_STEP if mesh.hoop else _BLOCK_STEP) / per_radius
        # before anything
        points = Points.virgin(mesh.weight.shape, mesh.components)
        stress = np.zeros((*mesh.weight.shape, mesh.components))
        self.virgin = PlasticState(0.0, 0.0, np.zeros(mesh.size), points, stress)

    def along(self, path: LoadPath) -> Iterator[DentMoment]:
        """Yield the contact at each load of a path of penetrations or forces.

        Raises ConvergenceError if a step does not come to balance, OutgrownError if the contact
        reaches the end of what may be touched.
        """
        control = path.one_of("penetration", "force")
        if control == "force" and (path.values < 0).any():
            raise ValueError("force must not be negative: nothing holds the indenter")
        state, energy = self.virgin, self.modulus * self.length**3
        unit = self.length if control == "penetration" else self.modulus * self.length**2
        for load in (path.values / unit).tolist():
            now = state.penetration if control == "penetration" else state.force
            if load <= max(now, 0.0):
                count = _FALLING if 0 <= load < now else 1
                values = np.linspace(now, load, count + 1)[1:]
            else:
                shares = [1.0]
                while shares[-1] > _FIRST:
                    shares.append(shares[-1] * np.exp(-self.step / shares[-1] ** _POWER))
                values = load * np.array(shares[::-1])
                values = values[values > now * (1 + 1e-9)]
            for value in values:
                state = self.step_to(state, control, value)
            area = 0.0
            if state.force > 0:
                area = self.mesh.contact_area(self.shape, state.penetration, state.unknowns)
            if not np.isfinite(area):
                raise OutgrownError("the contact is larger than its mesh was made for")
            yield DentMoment(
                penetration=state.penetration * self.length,
                force=state.force * self.modulus * self.length**2,
                counted_area=area * self.length**2,
                work=state.work * energy,
                elastic=state.elastic * energy,
                dissipated=state.dissipated * energy,
                iterations=state.iterations,
                residual=state.residual,
                state=state,
            )

    def contact_area(self, moment: DentMoment) -> float:
        """Return the area of contact; of one that is not round as it is counted.

        A round one starts to unload with dF/dd = 2 E* a, whatever has yielded (Pharr, Oliver &
        Brotzen 1992). Its edge sticks within elements, which the unloading passes: F^(2/3), linear
        on Hertz's ball, is a parabola of d over it.
        """
        state = moment.state
        if moment.counted_area == 0 or not self.mesh.hoop:
            return moment.counted_area
        states = [state]
        for share in _UNLOADED:
            states.append(self.step_to(states[-1], "force", share * state.force))
        risen = np.array([s.penetration - state.penetration for s in states])
        root = np.array([s.force / state.force for s in states]) ** (2 / 3)
        unit = -risen[-1]
        _, slope, start = np.polyfit(risen / unit, root, 2)
        stiffness = 1.5 * np.sqrt(start) * slope * state.force / unit
        radius = stiffness * (1 - self.material.elastic.poisson_ratio**2) / 2
        return float(np.pi * radius**2) * self.length**2

    def residual_depth(self, moment: DentMoment) -> float:
        """Return the depth that remains if the indenter is lifted off from here.

        In one step, elastic but for some points: three leave a dent that differs by 4e-7 of
        its depth.
        """
        state = moment.state
        if not state.points.amount.any():
            return 0.0
        left = self.step_to(state, "force", 0.0) if state.force > 0 else state
        return self.length * self._touched(left.unknowns)

    def given_back(self, moment: DentMoment) -> float:
        """Return the work that the body gives back if the indenter is lifted off from here."""
        state, work = moment.state, 0.0
        for share in 1 - np.arange(1, _GIVEN_BACK + 1) / _GIVEN_BACK:
            lifted = self.step_to(state, "force", moment.state.force * share**1.5)
            risen = state.penetration - lifted.penetration
            work += elastic_work(risen, (state.force, lifted.force))
            state = lifted
        return float(work * self.modulus * self.length**3)

    def surface(self, moment: DentMoment) -> tuple[Array, Array]:
        """Return places on the surface (1 or 2, n), and how far it has gone into the body there."""
        surface = self.mesh.surface
        place, sunk = surface.place, surface.sunk(moment.state.unknowns)
        return place.reshape(len(place), -1) * self.length, sunk.ravel() * self.length

    def step_to(
        self, state: PlasticState, control: str, value: float, halvings: int = _HALVINGS
    ) -> PlasticState:
        """Take one step to a penetration or to a force, in the units of states.

        A force of 0 lifts the indenter off. Where a step fails it goes by halves of it.
        """
        try:
            return self._newton(state, control, value)
        except ConvergenceError:
            now = getattr(state, control)
            if halvings == 0 or (control == "force" and value == now == 0):
                raise
        half_way = self.step_to(state, control, (now + value) / 2, halvings - 1)
        return self.step_to(half_way, control, value, halvings - 1)

    def _newton(self, state: PlasticState, control: str, value: float) -> PlasticState:
        """Find the balance at a depth, or under a force, by Newton's method with a line search."""
        mesh, surface = self.mesh, self.mesh.surface
        depth, force = (state.penetration, value) if control == "force" else (value, 0.0)
        # under a force the depth is an unknown, too; one of 0 has lifted the indenter off
        lifted = control == "force" and force == 0
        forced = control == "force" and not lifted
        unknowns, history = state.unknowns, []
        if state.rate is not None and depth > state.penetration:
            unknowns = unknowns + (depth - state.penetration) * state.rate
        if forced and not (depth - self.gap - surface.sunk(unknowns) > 0).any():
            # from where some points touch a force finds its depth
            height = np.sort((self.gap + surface.sunk(unknowns)).ravel())
            depth = float(height[min(2 * self.gap.shape[1], height.size - 1)])
        balance = self._balance(state, unknowns, depth, lifted=lifted)
        for rounds in range(_ROUNDS):
            # what is out of balance: forces on the unknowns, and the prescribed one
            residual, overlap, carried, (stress, points, tangent) = balance
            lack = force - carried if forced else 0.0
            scale = max(carried, force, 1e-3 * state.peak)
            size = float(np.hypot(np.linalg.norm(residual), lack))
            history.append(size / scale if scale > 0 else size)
            if history[-1] <= TOLERANCE:
                if lifted:
                    depth = self._touched(unknowns)
                return replace(
                    self._balanced(state, unknowns, depth, carried, overlap, stress, points),
                    iterations=state.iterations + rounds,
                    residual=history[-1],
                )
            # Newton's direction, of the unknowns and of the depth; a factorisation serves as long
            # as the rounds gain that much by it
            held = self.springs * surface.weight * (overlap > 0)
            if rounds == 0 or history[-1] > _WORN * history[-2]:
                solve = mesh.factorised(tangent, held)
            change, deeper = solve(-residual), 0.0
            if forced:
                column = np.zeros(mesh.size)
                np.add.at(column, surface.unknowns, np.einsum("fpi,fp->fi", surface.shape, held))
                by_depth = solve(column)
                stiffness = held.sum() - column @ by_depth
                if not stiffness > 0:
                    raise ConvergenceError("a force is prescribed where nothing touches")
                deeper = float((lack + column @ change) / stiffness)
                change = change + deeper * by_depth
            # line search: until the slope of the potential is half of the first at most
            first = float(residual @ change - lack * deeper)
            share, low, high = 1.0, (0.0, first), None
            for search in range(_SEARCHES):
                tried = unknowns + share * change, depth + share * deeper
                balance = self._balance(state, *tried, lifted=lifted)
                lack = force - balance[2] if forced else 0.0
                slope = float(balance[0] @ change - lack * deeper)
                if abs(slope) <= 0.5 * abs(first) or search == _SEARCHES - 1:
                    break
                if slope < 0:
                    low = share, slope
                else:
                    high = share, slope
                if high is None:
                    share *= 2
                    continue
                # regula falsi, a tenth of the bracket away from its ends
                width = high[0] - low[0]
                share = low[0] - low[1] * width / (high[1] - low[1])
                share = float(np.clip(share, low[0] + 0.1 * width, high[0] - 0.1 * width))
            unknowns, depth = tried
        raise ConvergenceError("an elastic-plastic step does not come to balance", history)

    def _balance(
        self, state: PlasticState, unknowns: Array, depth: float, *, lifted: bool
    ) -> tuple[Array, Array, float, tuple[Array, Points, Array]]:
        """Return unbalanced forces, overlaps with the indenter, its force, and the response."""
        mesh, surface = self.mesh, self.mesh.surface
        response = respond(self.material, mesh.strain(unknowns), state.points)
        residual = mesh.forces(response[0])
        residual[-1] += mesh.exterior * unknowns[-1]
        overlap = np.zeros(self.gap.shape)
        if not lifted:
            overlap = np.maximum(depth - self.gap - surface.sunk(unknowns), 0.0)
        force = self.springs * overlap * surface.weight
        local = np.einsum("fpk,fp->fk", surface.shape, force)
        residual -= np.bincount(
            surface.unknowns.ravel(), weights=local.ravel(), minlength=residual.size
        )
        return residual, overlap, float(force.sum()), response

    def _balanced(
        self,
        state: PlasticState,
        unknowns: Array,
        depth: float,
        force: float,
        overlap: Array,
        stress: Array,
        points: Points,
    ) -> PlasticState:
        """Return the next state, with its energies."""
        weight, surface = self.mesh.weight, self.mesh.surface
        elastic_strain = self.mesh.strain(unknowns) - points.strain
        stored = 0.5 * float((weight * (stress * elastic_strain).sum(-1)).sum())
        stored += 0.5 * self.mesh.exterior * unknowns[-1] ** 2
        elastic = stored + float((0.5 * self.springs * overlap**2 * surface.weight).sum())
        more = points.amount - state.points.amount
        yielding = more > 0  # elsewhere the resistance may be infinite
        lost = 0.0
        if yielding.any():
            before, after = (self.material.flow_stress(p.amount)[0] for p in (state.points, points))
            lost = float((weight * (0.5 * (before + after)) * more)[yielding].sum())
        if state.peak == 0 and not yielding.any():
            work = elastic - state.elastic  # of a potential, whatever the path
        else:
            # without a force no work is done on the way to the touch
            start, end = state.penetration, depth
            if state.peak and not state.force > 0:
                start = max(start, self._touched(state.unknowns))
            if state.peak and not force > 0:
                end = max(end, self._touched(unknowns))
            if 0 < start < end and 0 < state.force < force:
                # as both rise the force goes with a power of the depth
                power = np.log(force / state.force) / np.log(end / start)
                work = float((force * end - state.force * start) / (power + 1))
            else:
                work = elastic_work(end - start, (state.force, force))
        way = depth - state.penetration
        return replace(
            state,
            penetration=depth,
            force=force,
            peak=max(state.peak, force),
            unknowns=unknowns,
            points=points,
            stress=stress,
            elastic=elastic,
            dissipated=state.dissipated + lost,
            work=state.work + work,
            rate=(unknowns - state.unknowns) / way if way > 0 else None,
        )

    def _touched(self, unknowns: Array) -> float:
        """Return the penetration at which an indenter would just touch the surface as it is."""
        return float((self.gap + self.mesh.surface.sunk(unknowns)).min())


def first_yield(
    material: PlasticMaterial,
    shape: Callable[..., Array],
    contact_radius: Callable[[float], float | tuple[float, float]],
    start: float,
    *,
    per_radius: int = 8,
    even: tuple[bool, bool] = (True, True),
) -> float:
    """Return the penetration at which von Mises' stress first reaches the yield stress.

    `shape`, `per_radius` and `even` as for `Walk`; the mesh is made for the `contact_radius` of the
    elastic contact at a penetration, or its half-widths. The search begins at the penetration
    `start`.

    Raises ConvergenceError if the stress hardly rises with the penetration, as below a cone.
    """
    modulus = material.elastic.youngs_modulus
    elastic = PlasticMaterial(material.elastic, np.inf)

    def excess(depth: float) -> float:
        walk = Walk(elastic, shape, contact_radius(depth), per_radius=per_radius, even=even)
        state = walk.step_to(walk.virgin, "penetration", depth / walk.length)
        return float(np.log(von_mises(state.stress).max() * modulus / material.yield_stress))

    here, value, slope = float(np.log(start)), excess(start), 0.5
    for _ in range(_YIELD_ROUNDS):
        if abs(value) <= _YIELD_TOLERANCE:
            return float(np.exp(here - value / slope))
        step = float(np.clip(-value / slope, -5.0, 5.0))
        before, value = value, excess(float(np.exp(here + step)))
        here, slope = here + step, (value - before) / step
        if not slope > 0.02:
            raise ConvergenceError("the stress does not rise with the penetration: a sharp tip")
    raise ConvergenceError("the penetration of first yield was not found")
