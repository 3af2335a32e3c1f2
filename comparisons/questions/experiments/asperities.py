"""Bonds that break and heal: one asperity dragged over another.

Where particles leave their neighbours, no packing is left to refer strains to. Here pairs have
central forces only, of their present distance r,

    bonded  f = k (r - r0),      free  f = k min(r - r0, 0),

a Cauchy solid in place of the automata's two moduli. A bond that has stored more than its energy w
in tension breaks, and what it stored is lost; a free pair that is pressed together by the share
`healing` of r0 is bonded, at no cost. Units: r0, k and the mass of a particle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from reference.arrays import Array, Integers, Mask
from reference.errors import positive_faults, refuse
from reference.particles.automata import ENTRIES, LAYER, VOLUME

# The highest frequency is near sqrt(8): thirty steps to a period.
_STEP = 0.07
# Pairs within this distance are listed; a list holds until one has moved by half of the rest.
_LISTED = 1.9
_ALWAYS = 1.35
# Sides of the bases, and a layer that is held or moved at their ends.
_HALF_LENGTH, _HALF_WIDTH, _LAYERS = 7.0, 5.0, 2
# Spacings from where a particle belongs, beyond which it counts as worn.
_CARRIED = 2.0


@dataclass(frozen=True)
class Asperities:
    """Two paraboloidal asperities of bonded particles, one dragged over the other.

    The overlap of their tips is held while the upper one passes. A bond of energy w breaks at the
    strain sqrt(2 w); energies have a relative scatter. `healing` is the compression that bonds a
    free pair, `damping` that of the relative velocity along a pair. A wave of compression runs at
    about 1.4.
    """

    overlap: float = 1.5
    energy: float = 0.005
    healing: float = 0.02
    scatter: float = 0.2
    radius: float = 6.0
    height: float = 4.0
    speed: float = 0.05
    damping: float = 0.2

    def __post_init__(self) -> None:
        numbers = {name: getattr(self, name) for name in self.__dataclass_fields__}
        faults = positive_faults(**{k: v for k, v in numbers.items() if k != "scatter"})
        if not 0 <= self.scatter < 1:
            faults.append(f"scatter must be from 0 to below 1, not {self.scatter!r}")
        if not faults and 2 * self.energy >= (_ALWAYS - 1) ** 2 / (1 + self.scatter):
            faults.append(f"energy must leave bonds shorter than {_ALWAYS}, not {self.energy!r}")
        if not faults and self.overlap >= self.height:
            faults.append(f"overlap must be below the height {self.height!r}: bases do not touch")
        refuse(faults)

    def drag(self, seed: int) -> Drag:
        """Return the pass of one over the other: bonds and lateral position drawn by a seed."""
        random = np.random.default_rng(seed)

        def energies(count: int) -> Array:
            """Draw those of bonds, present ones and others that may form."""
            drawn: Array = self.energy * (1 + self.scatter * random.uniform(-1, 1, count))
            return drawn

        # two bodies, held at the bottom and moved at the top; the tip of the lower at z = height
        layers = []
        for layer in range(1 - _LAYERS, int(np.floor(self.height / LAYER)) + 1):
            half = 0.5 * (layer % 2)
            x = np.arange(-_HALF_LENGTH - half, _HALF_LENGTH + 0.6)
            y = np.arange(-_HALF_WIDTH - half, _HALF_WIDTH + 0.6)
            net = np.stack(np.meshgrid(x, y, [layer * LAYER], indexing="ij"), -1).reshape(-1, 3)
            surface = self.height - (net[:, 0] ** 2 + net[:, 1] ** 2) / (2 * self.radius)
            layers.append(net[(net[:, 2] <= surface) | (layer <= 0)])
        lower = np.concatenate(layers)
        reach = 2 * np.sqrt(self.radius * self.overlap) + 1.5
        shift = (-reach, float(random.uniform(-0.5, 0.5)), 2 * self.height - self.overlap)
        places = np.concatenate([lower, lower * (1.0, 1.0, -1.0) + shift])
        is_upper = np.arange(len(places)) >= len(lower)
        ends = places[~is_upper, 2].min(), places[is_upper, 2].max()
        bottom = ~is_upper & (places[:, 2] < ends[0] + 0.1)
        top = is_upper & (places[:, 2] > ends[1] - 0.1)
        moving, began = ~(bottom | top), places.copy()
        velocities = np.zeros_like(places)
        velocities[is_upper, 0] = self.speed
        # bonds inside each of them, then all pairs that may act
        pairs = cKDTree(places).query_pairs(1.1, output_type="ndarray")
        inside = is_upper[pairs[:, 0]] == is_upper[pairs[:, 1]]
        pairs = pairs[inside]
        bonded, limits = np.ones(len(pairs), dtype=bool), energies(len(pairs))
        pairs, bonded, limits = _listed(places, pairs, bonded, limits, energies)
        listed_at = places.copy()
        ledger = np.zeros(4)  # damped, spent, broken, healed

        def pull() -> tuple[Array, float]:
            """Return forces and elastic energy; bonds break and heal."""
            forces = np.zeros_like(places)
            energy = _act(
                *(places, velocities, pairs, bonded, limits),
                *(self.healing, self.damping, _STEP, forces, ledger),
            )
            return forces, energy

        # march by velocity Verlet until the upper body has moved all the way
        steps = int(np.ceil(2 * reach / (self.speed * _STEP)))
        begun = 0.5 * float((velocities[moving] ** 2).sum())
        forces, energy = pull()
        history, work, largest = np.empty((steps, 2)), 0.0, 0.0
        at_largest = places.copy(), pairs, bonded.copy()
        # Verlet: half a time step of those that move, none of the others
        kick = 0.5 * _STEP * moving[:, None]
        for number in range(steps):
            before = forces[top, 0].sum()
            velocities += kick * forces
            places += _STEP * velocities
            if np.abs(places - listed_at).max() > (_LISTED - _ALWAYS) / 3.5:
                pairs, bonded, limits = _listed(places, pairs, bonded, limits, energies)
                listed_at = places.copy()
            forces, energy = pull()
            velocities += kick * forces
            force, load = -forces[top, 0].sum(), forces[top, 2].sum()
            work += 0.5 * (force - before) * self.speed * _STEP
            history[number] = force, load
            if force > largest:
                largest, at_largest = force, (places.copy(), pairs, bonded.copy())

        # what has moved against its body, and what bonds hold to neither of them
        moved = places - began
        moved[is_upper, 0] -= steps * self.speed * _STEP
        i, j = pairs[bonded].T
        graph = coo_array((np.ones(i.size), (i, j)), shape=(len(places), len(places)))
        label = connected_components(graph, directed=False)[1]
        loose = ~np.isin(label, label[~moving])
        damped, spent, broken, healed = ledger.tolist()
        return Drag(
            way=np.arange(1.0, steps + 1) * (self.speed * _STEP),
            force=history[:, 0],
            load=history[:, 1],
            places=places,
            upper=is_upper,
            stress=_stress(*at_largest),
            stressed=at_largest[0],
            broken=int(broken),
            healed=int(healed),
            worn=int((np.linalg.norm(moved, axis=1) > _CARRIED).sum()),
            loose=int(loose.sum()),
            work=float(work),
            stored=0.5 * float((velocities[moving] ** 2).sum()) - begun + energy,
            damped=damped,
            spent=spent,
        )


@dataclass(frozen=True, eq=False)
class Drag:
    """The outcome of a pass.

    Against the `way` of the upper body stand the force against it and the load that presses it
    away. At the largest force `stress` (n, 6), half the force moments of the pairs over the volume
    in the order of `fem.recover`, and `stressed` (n, 3), the places then. `upper` are particles
    that began in the upper body; `worn` ones moved by more than two spacings against the body they
    belonged to; `loose` ones hold to neither body by bonds. The work of the drag is `stored`
    (elastic and moving at the end, less the beginning), `damped` in dashpots and `spent` on bonds.
    """

    way: Array
    force: Array
    load: Array
    places: Array
    upper: Mask
    stress: Array
    stressed: Array
    broken: int
    healed: int
    worn: int
    loose: int
    work: float
    stored: float
    damped: float
    spent: float

    @property
    def friction(self) -> float:
        """Mean force over mean load of the pass."""
        return float(self.force.mean() / self.load.mean())

    @property
    def imbalance(self) -> float:
        """Work that is not accounted for, relative."""
        return (self.stored + self.damped + self.spent) / self.work - 1


def _listed(
    places: Array, pairs: Integers, bonded: Mask, limits: Array, energies: Callable[[int], Array]
) -> tuple[Integers, Mask, Array]:
    """List all pairs that may act until some particle has moved far; bonds stay as they are."""
    count = np.array([len(places), 1])
    kept, old_limits = pairs[bonded] @ count, limits[bonded]
    pairs = cKDTree(places).query_pairs(_LISTED, output_type="ndarray")
    keys = pairs @ count
    limits = energies(keys.size)
    _, old, new = np.intersect1d(kept, keys, assume_unique=True, return_indices=True)
    limits[new] = old_limits[old]
    return pairs, np.isin(np.arange(keys.size), new), limits


def _stress(places: Array, pairs: Integers, bonded: Mask) -> Array:
    """Return half the force moments of the pairs (n, 6) over the volume."""
    i, j = pairs.T
    way = places[j] - places[i]
    r = np.sqrt((way**2).sum(axis=1))
    stretch = np.where(bonded | (r < 1.0), r - 1.0, 0.0)
    stress = np.zeros((len(places), 6))
    for entry, (a, b) in enumerate(ENTRIES):
        moment = stretch * way[:, a] * way[:, b] / r
        for end in (i, j):
            stress[:, entry] += np.bincount(end, moment, len(places))
    return stress / (2 * VOLUME)


@njit(cache=True, error_model="numpy")
def _act(
    places: Array,
    velocities: Array,
    pairs: Integers,
    bonded: Mask,
    limits: Array,
    healing: float,
    damping: float,
    step: float,
    pulls: Array,
    ledger: Array,
) -> float:
    """Add the pulls of all pairs; return their elastic energy, and book the losses."""
    energy = 0.0
    for p in range(len(pairs)):
        i, j = pairs[p, 0], pairs[p, 1]
        x = places[j, 0] - places[i, 0]
        y = places[j, 1] - places[i, 1]
        z = places[j, 2] - places[i, 2]
        r = np.sqrt(x * x + y * y + z * z)
        stretch = r - 1.0
        if bonded[p]:
            if stretch > 0.0 and 0.5 * stretch * stretch > limits[p]:
                bonded[p] = False
                ledger[1] += 0.5 * stretch * stretch
                ledger[2] += 1
                continue
        elif stretch >= 0.0:
            continue
        elif -stretch > healing:
            bonded[p] = True
            ledger[3] += 1
        x, y, z = x / r, y / r, z / r
        rate = (
            (velocities[j, 0] - velocities[i, 0]) * x
            + (velocities[j, 1] - velocities[i, 1]) * y
            + (velocities[j, 2] - velocities[i, 2]) * z
        )
        pull = stretch + damping * rate
        energy += 0.5 * stretch * stretch
        ledger[0] += damping * rate * rate * step
        pulls[i, 0] += pull * x
        pulls[i, 1] += pull * y
        pulls[i, 2] += pull * z
        pulls[j, 0] -= pull * x
        pulls[j, 1] -= pull * y
        pulls[j, 2] -= pull * z
    return energy
