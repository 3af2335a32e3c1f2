r"""Half-spaces of automata, below a rigid shape or pressed together in pairs.

Automata fill half an ellipsoid around the contact, in a shell of automata that are held in the
field of Boussinesq which the forces of the contact have far away. Both are solved in turn, with the
field extrapolated (the answer is linear in it while the contact set stays), until they agree.

Two half-spaces meet without friction. Their nets lie upon each other, and an automaton of one may
not enter the one below it: with the displacements u_1 and u_2 of both into their own bodies
u_1 + u_2 >= d - f. The unknowns of a pair of surface automata are w = (u_1 + u_2)/sqrt(2), which
the floor is under, and (u_1 - u_2)/sqrt(2): a rotation, which leaves the stiffness as well
conditioned as that of either body. Nothing is said of an effective modulus.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array, Integers, Mask
from reference.elasticity import von_mises
from reference.errors import ConvergenceError, positive_faults, refuse
from reference.fem.far_field import boussinesq
from reference.loads import Load
from reference.particles.automata import (
    UNFLOWED,
    Automata,
    Domain,
    Packing,
    components,
    half_space_packing,
)
from reference.particles.mprgp import Rest, largest_stiffness, relax

# Largest imbalance of the automata, over the reactions.
BALANCE = 1e-6
MOST_ROUNDS = 40
# Force of springs of stiffness E*/a under the overlap: Hertz has 0.60 of it, a flat punch 0.64.
WINKLER = 0.6
# Relative difference of far field and contact, and of the force and the prescribed one.
AGREEMENT = 1e-5
# Distances between the forces that make the far field, over the width of the margin: their field in
# the shell differs from that of the pressure by less than a per cent.
SOURCE_STEP = 0.175
# The far field acts back on the force by this factor before any is known: a/R = 1/5 of Hertz.
USUAL_FEEDBACK = -0.2
# Share of the far field that is tried where it leaves no contact.
RETREAT = 0.5
# Of the depth, what a contact has at least been pressed in beyond where it began.
LEAST_WAY = 1e-3
# Exponents n of F ~ d^n, the first to be tried and the range of those that are believed.
USUAL_EXPONENT, EXPONENTS = 1.5, (0.8, 5.0)


@dataclass(frozen=True, eq=False)
class ParticleContact:
    """A solved contact, in the units of its loads.

    `reactions` and `displacement` (m,) are forces on the automata of the surface and how far they
    are pressed in; those that touch are `active`. `steps` counts how often the forces between all
    automata were computed; `history` is the unbalanced share of the reactions, by step of the last
    round. Of all automata of each body `moved` (bodies, n, 6) are displacements in units of the
    spacing and rotations, `traces` (bodies, n) relative changes of volume; `flowed` (n, 3, 3)
    plastic strains, none at all where none can flow.
    """

    penetration: float
    force: float
    reactions: Array
    displacement: Array
    active: Mask
    steps: int
    history: list[float]
    moved: Array
    traces: Array
    flowed: Array

    @property
    def imbalance(self) -> float:
        """What is not balanced at the end, over the reactions."""
        return self.history[-1]

    @property
    def energy(self) -> float:
        """Elastic energy of the whole half-space: half of force times displacement."""
        return float(0.5 * self.reactions @ self.displacement)


class FarField:
    """Fields in the shell of point forces on a net over the loaded region.

    `shares` (m, k) is how much of a force on each automaton of the surface goes to each point
    force: bilinear, so that sum and first moments stay.
    """

    def __init__(self, domain: Domain, packing: Packing, poisson_ratio: float) -> None:
        axes, hats = [], []
        for k, half in enumerate(domain.loaded):
            count = max(2, int(np.ceil(2 * half / (SOURCE_STEP * domain.margin))))
            axis = np.linspace(-half, half, count + 1)
            places = packing.places[: packing.surface, k].clip(axis[0], axis[-1])
            axes.append(axis)
            hats.append(np.maximum(1 - np.abs(places[:, None] - axis) / (axis[1] - axis[0]), 0.0))
        self.shares = (hats[0][:, :, None] * hats[1][:, None, :]).reshape(packing.surface, -1)
        fields = []
        for x, y in product(*axes):
            points = packing.places[packing.free :] - (x, y, 0.0)
            displacement, slope = boussinesq(points, poisson_ratio)
            curl = [slope[:, k - 1, k - 2] - slope[:, k - 2, k - 1] for k in range(3)]
            volume = np.trace(slope, axis1=1, axis2=2)
            fields.append(np.column_stack([displacement, 0.5 * np.stack(curl, -1), volume]))
        # displacement, rotation and change of volume in the shell (forces, n, 7)
        self.fields = np.stack(fields)


class Held(NamedTuple):
    """Where automata and far field agree: displacements, far forces, depth and force."""

    moved: Array
    sources: Array
    depth: float
    force: float


class ParticleHalfSpace:
    """A half-space of automata below a rigid shape, or two of the same spacing and domain.

    `materials` are one or two, by Young's modulus and Poisson's ratio. `spacing` and the first
    modulus are the units of length and of pressure. A gap belongs to both bodies.

    Hertz with two automata per contact radius, within a per cent:

    >>> body = ParticleHalfSpace(Domain((3.0, 3.0), 5.0), [(1.0, 0.3)])
    >>> x, y = body.points.T
    >>> (contact,) = body.press((x**2 + y**2) / 40, Load("penetration", 0.2))
    >>> exact = 4 / 3 / (1 - 0.3**2) * 20**0.5 * 0.2**1.5
    >>> bool(abs(contact.force / exact - 1) < 0.01)
    True

    Two equal bodies are half as stiff as one below a rigid shape:

    >>> pair = ParticleHalfSpace(Domain((3.0, 3.0), 5.0), [(1.0, 0.3)] * 2)
    >>> (both,) = pair.press((x**2 + y**2) / 40, Load("penetration", 0.2))
    >>> round(both.force / contact.force, 4)
    0.5
    """

    def __init__(
        self, domain: Domain, materials: Sequence[tuple[float, float]], *, spacing: float = 1.0
    ) -> None:
        moduli = {f"youngs_modulus[{i}]": modulus for i, (modulus, _) in enumerate(materials)}
        refuse(positive_faults(spacing=spacing, **moduli))
        self.domain, self.spacing, self.youngs_modulus = domain, spacing, materials[0][0]
        packing = half_space_packing(domain.half_widths)
        self.all_automata = [Automata(packing, nu) for _, nu in materials]
        self.automata = self.all_automata[0]
        self.ratios = [modulus / self.youngs_modulus for modulus, _ in materials]
        self.bodies = len(materials)
        self._far = [FarField(domain, packing, nu) for _, nu in materials]
        self._moved = np.zeros((self.bodies, len(packing.places), 6))
        self._traces = np.zeros((self.bodies, len(packing.places)))
        self._forces = np.empty((self.bodies, packing.free, 6))
        self.flowed = UNFLOWED

    @property
    def points(self) -> Array:
        """Places (m, 2) of the automata on the surface."""
        packing = self.automata.packing
        return packing.places[: packing.surface, :2] * self.spacing

    @property
    def effective_modulus(self) -> float:
        """E* of all bodies, by which the search begins; the contact does not depend on it."""
        squares = [1 - automata.poisson_ratio**2 for automata in self.all_automata]
        return self.youngs_modulus / sum(np.divide(squares, self.ratios).tolist())

    def equivalent_stresses(self, contact: ParticleContact) -> Array:
        """Return the von Mises stress of each automaton that moves, of one body after the other."""
        tensors = [
            modulus * automata.stresses(moved, traces, contact.flowed)
            for automata, modulus, moved, traces in zip(
                self.all_automata, self.ratios, contact.moved, contact.traces, strict=True
            )
        ]
        return self.youngs_modulus * von_mises(components(np.concatenate(tensors)))

    def inside(self, contact: ParticleContact) -> tuple[Array, Array, Array]:
        """Return places, displacements and von Mises stresses of the automata that move.

        A second body lies above the first.
        """
        packing = self.automata.packing
        sides = np.array([[1.0, 1.0, 1.0], [1.0, 1.0, -1.0]])[: self.bodies, None]
        moved = contact.moved[:, : packing.free, :3] * self.spacing
        places = packing.places[: packing.free] * self.spacing
        return (
            (places * sides).reshape(-1, 3),
            (moved * sides).reshape(-1, 3),
            self.equivalent_stresses(contact),
        )

    def largest_stress(self, contact: ParticleContact) -> float:
        """Return the largest von Mises stress, of the automata or between layers below the centre.

        There it is the top of a parabola through the means of three layers: every second one has an
        automaton on the axis, the others have four around it.
        """
        stresses = self.equivalent_stresses(contact)
        places = self.automata.packing.places[: stresses.size]
        axis = np.hypot(places[:, 0], places[:, 1]) < 0.75
        depths, layer = np.unique(places[axis, 2].round(6), return_inverse=True)
        means = np.bincount(layer, stresses[axis]) / np.bincount(layer)
        k = int(np.clip(np.argmax(means), 1, len(depths) - 2))
        before, middle, after = means[k - 1 : k + 2]
        bend = before + after - 2 * middle
        top = middle - (after - before) ** 2 / (8 * bend) if bend < 0 else middle
        return float(max(top, stresses.max()))

    @cached_property
    def stiffest(self) -> float:
        """Largest eigenvalue of the stiffness, in scaled units."""
        self._hold(None)
        return largest_stiffness(lambda way: self._pulls(way, UNFLOWED), self._forces.size)

    def press(
        self, gap: ArrayLike, load: Load, *, balance: float = BALANCE
    ) -> Iterator[ParticleContact]:
        """Yield the contact with a rigid shape at each penetration or force.

        `gap` (m,) is the distance of the shape from each of `points` at first touch, inf where it
        ends; `balance` the largest imbalance of the automata, relative to the reactions.
        """
        forced = load.one_of("penetration", "force") == "force"
        gap, last = self._scaled_gap(gap), None
        for value in (load.values / self._unit_of(load.control)).tolist():
            contact, last = self._agreed(gap, value, 0.0, last, forced=forced, balance=balance)
            yield contact

    def _unit_of(self, control: str) -> float:
        """Return the unit of penetrations or forces."""
        return self.spacing * (self.youngs_modulus * self.spacing if control == "force" else 1.0)

    def _scaled_gap(self, gap: ArrayLike) -> Array:
        """Return the gap in spacings, after a check."""
        scaled = np.asarray(gap, dtype=float) / self.spacing
        count = self.automata.packing.surface
        if scaled.shape != (count,) or np.isnan(scaled).any():
            refuse([f"gap must have one number for each of {count} points"])
        return scaled

    def _agreed(
        self,
        gap: Array,
        value: float,
        origin: float,
        last: Held | None,
        *,
        forced: bool,
        balance: float,
    ) -> tuple[ParticleContact, Held]:
        """Solve contact and far field in turn until they agree, and the force is the prescribed.

        Without a force contact begins at the depth `origin`; `last` is the contact of the load
        before.
        """
        # start from springs, or from the last contact, along F ~ (d - d0)^n
        depth = value
        if last is None:
            last = self._on_springs(gap, value, origin, forced=forced)
            depth = last.depth
        elif forced:
            way = max(last.depth - origin, LEAST_WAY * last.depth)
            depth = float(origin + way * (value / last.force) ** (1 / USUAL_EXPONENT))
        if forced:
            growth = value / last.force
        else:
            way = max(last.depth - origin, LEAST_WAY * last.depth)
            growth = ((depth - origin) / way) ** USUAL_EXPONENT
        moved, sources = last.moved, growth * last.sources

        steps, history, before = 0, list[float](), None
        for _ in range(MOST_ROUNDS):
            # the contact in a given far field
            near = np.flatnonzero(gap < depth)
            if not near.size:
                raise ConvergenceError(
                    "the shape passes between the automata: their net is too coarse"
                )
            share = self.bodies**-0.5
            floor = share * (depth - gap[near])
            rest = self._relaxed(6 * near + 2, floor, moved, sources, balance)
            moved, reactions = rest.moved, share * rest.reactions
            steps += rest.steps
            # the far field of its forces
            answer = self._far[0].shares[near].T @ reactions
            force = float(answer.sum())
            if not force > 0.0:  # the far field alone has pushed the surface out of reach
                history.append(np.inf)
                sources = RETREAT * sources
                continue
            wrong = float(np.linalg.norm(answer - sources) / np.linalg.norm(answer))
            if forced:
                wrong = max(wrong, abs(force / value - 1))
            history.append(wrong)
            if wrong <= AGREEMENT:
                contact = self._contact(depth, sources, rest, reactions, near, steps)
                return contact, Held(moved, sources, depth, force)
            if forced:
                # F ~ (d - d0)^n, d0 where contact begins
                exponent, way = USUAL_EXPONENT, depth - origin
                if before is not None and way != before[0]:
                    slope = np.log(force / before[1]) / np.log(way / before[0])
                    exponent = float(np.clip(slope, *EXPONENTS))
                before = way, force
                depth = origin + way * (value / force) ** (1 / exponent)
                sources = answer * (value / force)
            else:
                # q = T(q) for a T that is linear along the last step (Aitken)
                total, feedback = float(sources.sum()), USUAL_FEEDBACK
                if before is not None and total != before[0]:
                    slope = (force - before[1]) / (total - before[0])
                    feedback = slope if abs(slope) < 0.9 else feedback
                before = total, force
                sources = (answer - feedback * sources) / (1 - feedback)
        raise ConvergenceError(
            f"far field and contact of the automata do not agree after {MOST_ROUNDS} rounds: "
            f"they differ by {history[-1]:.1e}",
            history,
        )

    def _relaxed(
        self, numbers: Integers, floor: Array, moved: Array, sources: Array, balance: float
    ) -> Rest:
        """Return the equilibrium above the floor of some unknowns, in a given far field."""
        self._hold(sources)
        load = self._pulls(np.zeros(self._forces.size), self.flowed).copy()
        self._hold(None)
        return relax(
            lambda way: -self._pulls(way, UNFLOWED),
            *(load, numbers, floor, moved),
            tolerance=balance,
            stiffest=self.stiffest,
        )

    def _on_springs(self, gap: Array, value: float, origin: float, *, forced: bool) -> Held:
        """Return the contact with Winkler's springs of a disc as large as the contact, about."""
        depth = value
        springs = WINKLER * self.effective_modulus / self.youngs_modulus
        if forced:
            # on so many of the lowest automata that the next one is not reached
            order = np.sort(gap[np.isfinite(gap)])
            counts = np.arange(1, len(order) + 1)
            disc = springs * np.sqrt(np.pi / counts)
            depths = (value / disc + np.cumsum(order)) / counts
            reached = np.argmax(depths <= np.append(order[1:], np.inf))
            depth = origin + float(depths[reached])
        overlap = np.maximum(depth - gap, 0.0)
        area = max(int(np.count_nonzero(overlap)), 1)
        sources = springs * np.sqrt(np.pi / area) * (self._far[0].shares.T @ overlap)
        return Held(np.zeros(self._forces.size), sources, depth, float(sources.sum()))

    def _hold(self, sources: Array | None) -> None:
        """Put the shells into the far field of some forces, or to rest."""
        free = self.automata.packing.free
        self._moved[:, free:], self._traces[:, free:] = 0.0, 0.0
        if sources is not None:
            for body, far in enumerate(self._far):
                held = np.tensordot(sources, far.fields, axes=1) / self.ratios[body]
                self._moved[body, free:], self._traces[body, free:] = held[:, :6], held[:, 6]

    def _pulls(self, way: Array, flowed: Array) -> Array:
        """Return the forces of the automata on each other, those in the shells as they are held."""
        self._moved[:, : self.automata.packing.free] = self._turned(way)
        for body, automata in enumerate(self.all_automata):
            automata.forces(self._moved[body], self._traces[body], self._forces[body], flowed)
            self._forces[body] *= self.ratios[body]
        return self._turned(self._forces).ravel()

    def _turned(self, each: Array) -> Array:
        """Return normal parts of two surfaces as sum and difference over sqrt(2), or back."""
        each = each.reshape(self._forces.shape)
        if self.bodies == 1:
            return each
        surface = self.automata.packing.surface
        first, second = each[:, :surface, 2]
        turned = each.copy()
        turned[0, :surface, 2] = np.sqrt(0.5) * (first + second)
        turned[1, :surface, 2] = np.sqrt(0.5) * (first - second)
        return turned

    def _move(self, moved: Array) -> Array:
        """Take displacements, with changes of volume; return those of the surfaces together."""
        packing = self.automata.packing
        self._moved[:, : packing.free] = self._turned(moved)
        for body, automata in enumerate(self.all_automata):
            automata.strains(self._moved[body], self._traces[body])
        together: Array = self._moved[:, : packing.surface, 2].sum(axis=0)
        return together

    def _contact(
        self, depth: float, sources: Array, rest: Rest, reactions: Array, near: Integers, steps: int
    ) -> ParticleContact:
        """Return an equilibrium in the units of the loads."""
        self._hold(sources)
        displacement = self._move(rest.moved)
        surface = self.automata.packing.surface
        forces, active = np.zeros(surface), np.zeros(surface, dtype=bool)
        forces[near] = self.youngs_modulus * self.spacing**2 * reactions
        active[near] = reactions > 0
        return ParticleContact(
            penetration=depth * self.spacing,
            force=float(forces.sum()),
            reactions=forces,
            displacement=displacement * self.spacing,
            active=active,
            steps=steps,
            history=rest.history,
            moved=self._moved.copy(),
            traces=self._traces.copy(),
            flowed=self.flowed.copy(),
        )
