"""A rigid shape pressed into a half-space of automata.

Automata fill half an ellipsoid around the contact, in a shell of automata that are held in the
field of Boussinesq which the forces of the contact have far away. Both are solved in turn, with the
field extrapolated (the answer is linear in it while the contact set stays), until they agree.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import positive_faults, refuse
from reference.elasticity import von_mises
from reference.errors import ConvergenceError
from reference.loads import Load
from reference.particles.equilibrium import Floor, Rest, largest_stiffness, relax
from reference.particles.far_field import Domain, FarField, Search
from reference.particles.interaction import UNFLOWED, Automata, Elastic, components
from reference.particles.packing import half_space_packing

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]

# Largest imbalance of the automata, over the reactions.
BALANCE = 1e-6
MOST_ROUNDS = 40
# Force of springs of stiffness E*/a under the overlap: Hertz has 0.60 of it, a flat punch 0.64.
WINKLER = 0.6


@dataclass(frozen=True, eq=False)
class ParticleContact:
    """A solved contact, in the units of its loads.

    Attributes
    ----------
    penetration, force, energy : float
    reactions, displacement : (m,) ndarray
        Forces on the automata of the surface, and how far they are pressed in.
    active : (m,) ndarray of bool
        Which of them touch.
    steps : int
        How often the forces between all automata were computed.
    history : list of float
        What is not balanced, over the reactions, by step of the last round.
    moved : (n, 6) ndarray
        Displacements in units of the spacing, and rotations, of all automata.
    traces : (n,) ndarray
        Their relative changes of volume.
    flowed : (n, 3, 3) ndarray
        Their plastic strains; none at all where none can flow.
    """

    penetration: float
    force: float
    reactions: Floats
    displacement: Floats
    active: NDArray[np.bool_]
    steps: int
    history: list[float]
    moved: Floats
    traces: Floats
    flowed: Floats

    @property
    def imbalance(self) -> float:
        """What is not balanced at the end, over the reactions."""
        return self.history[-1]

    @property
    def energy(self) -> float:
        """Elastic energy of the whole half-space: half of force times displacement."""
        return float(0.5 * self.reactions @ self.displacement)


class ParticleHalfSpace:
    """A half-space of automata.

    Parameters
    ----------
    domain : Domain
    poisson_ratio : float
    spacing, youngs_modulus : float
        Units of length, and of pressure.

    Examples
    --------
    Hertz with two automata per contact radius, within a per cent:

    >>> body = ParticleHalfSpace(Domain((3.0, 3.0), 5.0), 0.3)
    >>> x, y = body.points.T
    >>> (contact,) = body.press((x**2 + y**2) / 40, Load("penetration", 0.2))
    >>> exact = 4 / 3 / (1 - 0.3**2) * 20**0.5 * 0.2**1.5
    >>> bool(abs(contact.force / exact - 1) < 0.01)
    True
    """

    # The floor lies under the sum of the displacements of so many bodies, as a unit vector.
    bodies = 1

    def __init__(
        self,
        domain: Domain,
        poisson_ratio: float,
        *,
        spacing: float = 1.0,
        youngs_modulus: float = 1.0,
    ) -> None:
        refuse(positive_faults(spacing=spacing, youngs_modulus=youngs_modulus))
        self.domain, self.spacing, self.youngs_modulus = domain, spacing, youngs_modulus
        packing = half_space_packing(domain.half_widths)
        self.automata = Automata(packing, Elastic(poisson_ratio))
        self.far = FarField(domain, packing, poisson_ratio)
        self._moved = np.zeros((len(packing.places), 6))
        self._traces = np.zeros(len(packing.places))
        self._forces = np.empty((packing.free, 6))
        self.flowed = UNFLOWED

    @property
    def points(self) -> Floats:
        """Places (m, 2) of the automata on the surface."""
        packing = self.automata.packing
        return packing.places[: packing.surface, :2] * self.spacing

    @property
    def effective_modulus(self) -> float:
        """E* = E/(1 - nu^2)."""
        return self.youngs_modulus / (1 - self.automata.material.poisson_ratio**2)

    def equivalent_stresses(self, contact: ParticleContact) -> Floats:
        """Return the von Mises stress (free,) of each automaton in a contact."""
        tensors = self.automata.stresses(contact.moved, contact.traces, contact.flowed)
        return self.youngs_modulus * von_mises(components(tensors))

    def inside(self, contact: ParticleContact) -> tuple[Floats, Floats, Floats]:
        """Return places, displacements and von Mises stresses of the automata that move."""
        packing = self.automata.packing
        moved = contact.moved[: packing.free, :3] * self.spacing
        places = packing.places[: packing.free] * self.spacing
        return places, moved, self.equivalent_stresses(contact)

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
        return largest_stiffness(lambda way: self._pulls(way, UNFLOWED), self._size)

    def press(
        self, gap: ArrayLike, load: Load, *, balance: float = BALANCE
    ) -> Iterator[ParticleContact]:
        """Yield the contact with a rigid shape at each load.

        Parameters
        ----------
        gap : (m,) array_like
            Distance of the shape from each of `points` at first touch; inf where it ends.
        load : Load
            Penetrations or forces.
        balance : float
            Largest imbalance of the automata, relative to the reactions.

        Raises
        ------
        ValueError
            If the gap does not fit, or the loads.
        ConvergenceError
            If automata, far field and force do not come to agree.
        """
        forced = load.one_of("penetration", "force") == "force"
        gap, search = self._scaled_gap(gap), None
        for value in (load.values / self._unit_of(load.control)).tolist():
            search = self._begun(search, gap, value, 0.0, forced=forced)
            yield self._rounds(gap, search, balance)

    def _unit_of(self, control: str) -> float:
        """Return the unit of penetrations or forces."""
        return self.spacing * (self.youngs_modulus * self.spacing if control == "force" else 1.0)

    def _scaled_gap(self, gap: ArrayLike) -> Floats:
        """Return the gap in spacings, after a check."""
        scaled = np.asarray(gap, dtype=float) / self.spacing
        count = self.automata.packing.surface
        if scaled.shape != (count,) or np.isnan(scaled).any():
            refuse([f"gap must have one number for each of {count} points"])
        return scaled

    def _begun(
        self, search: Search | None, gap: Floats, value: float, origin: float, *, forced: bool
    ) -> Search:
        """Return where to look for the contact of a load, from the one before if there is one.

        Without a force contact begins at the depth `origin`.
        """
        depth = origin + self._winkler_depth(gap, value) if forced else value
        if search is None:
            search = self._first(gap, depth)
        elif forced:
            depth = search.guess(origin, value)
        return search.towards(depth, value if forced else None, origin)

    def _first(self, gap: Floats, depth: float) -> Search:
        """Return where to begin: nothing moved, the force of springs spread over the overlap."""
        overlap = np.maximum(depth - gap, 0.0)
        area = max(int(np.count_nonzero(overlap)), 1)
        spread = self.far.shares.T @ overlap
        sources = WINKLER * self._scaled_modulus * np.sqrt(np.pi / area) * spread
        return Search(np.zeros(self._size), sources, depth)

    def _rounds(self, gap: Floats, search: Search, balance: float) -> ParticleContact:
        """Solve contact and far field in turn until they agree, and the force is the prescribed."""
        steps = 0
        for _ in range(MOST_ROUNDS):
            depth, held = search.depth, search.sources
            rest, near = self._rest(gap, search, balance)
            steps += rest.steps
            if search.improve(self.far.shares[near].T @ rest.reactions, rest.moved):
                return self._contact((depth, held), rest, near, steps)
        raise ConvergenceError(
            f"far field and contact of the automata do not agree after {MOST_ROUNDS} rounds: "
            f"they differ by {search.history[-1]:.1e}",
            search.history,
        )

    def _rest(self, gap: Floats, search: Search, balance: float) -> tuple[Rest, Numbers]:
        """Return the contact in a given far field, and which automata may touch."""
        near = np.flatnonzero(gap < search.depth)
        if not near.size:
            raise ConvergenceError("the shape passes between the automata: their net is too coarse")
        share = self.bodies**-0.5
        floor = Floor(6 * near + 2, share * (search.depth - gap[near]))
        rest = self._relaxed(floor, search, balance)
        return replace(rest, reactions=share * rest.reactions), near

    def _relaxed(self, floor: Floor, search: Search, balance: float) -> Rest:
        """Return the equilibrium above a floor, in a given far field."""
        none = np.zeros(self._size)
        self._hold(search.sources)
        load = self._pulls(none, self.flowed).copy()
        self._hold(None)
        return relax(
            lambda way: -self._pulls(way, UNFLOWED),
            *(load, floor, search.moved),
            tolerance=balance,
            stiffest=self.stiffest,
        )

    def _hold(self, sources: Floats | None) -> None:
        """Put the shell into the far field of some forces, or to rest."""
        free = self.automata.packing.free
        held = np.zeros((1, 7)) if sources is None else self.far.at_shell(sources)
        self._moved[free:], self._traces[free:] = held[:, :6], held[:, 6]

    def _pulls(self, way: Floats, flowed: Floats) -> Floats:
        """Return the forces of the automata on each other, those in the shell as they are held."""
        self._moved[: self.automata.packing.free] = way.reshape(-1, 6)
        return self.automata.forces(self._moved, self._traces, self._forces, flowed).ravel()

    @property
    def _size(self) -> int:
        """Return the number of unknowns."""
        return self.bodies * self._forces.size

    @property
    def _scaled_modulus(self) -> float:
        return self.effective_modulus / self.youngs_modulus

    def _winkler_depth(self, gap: Floats, force: float) -> float:
        """Return the penetration at which springs under the overlap carry a force, about.

        Their stiffness is that of a disc as large as the lowest automata, so many that the next one
        is not reached.
        """
        order = np.sort(gap[np.isfinite(gap)])
        counts = np.arange(1, len(order) + 1)
        springs = WINKLER * self._scaled_modulus * np.sqrt(np.pi / counts)
        depths = (force / springs + np.cumsum(order)) / counts
        return float(depths[np.argmax(depths <= np.append(order[1:], np.inf))])

    def _contact(
        self, held: tuple[float, Floats], rest: Rest, near: Numbers, steps: int
    ) -> ParticleContact:
        packing, (depth, sources) = self.automata.packing, held
        self._hold(sources)
        self._moved[: packing.free] = rest.moved.reshape(-1, 6)
        self.automata.strains(self._moved, self._traces)
        return self._as_contact(depth, rest, near, steps, self._moved[: packing.surface, 2])

    def _as_contact(
        self, depth: float, rest: Rest, near: Numbers, steps: int, displacement: Floats
    ) -> ParticleContact:
        """Return what is now held and moved, in the units of the loads."""
        surface = self.automata.packing.surface
        reactions, active = np.zeros(surface), np.zeros(surface, dtype=bool)
        reactions[near] = self.youngs_modulus * self.spacing**2 * rest.reactions
        active[near] = rest.reactions > 0
        return ParticleContact(
            penetration=depth * self.spacing,
            force=float(reactions.sum()),
            reactions=reactions,
            displacement=displacement * self.spacing,
            active=active,
            steps=steps,
            history=rest.history,
            moved=self._moved.copy(),
            traces=self._traces.copy(),
            flowed=self.flowed.copy(),
        )
