"""Bonds that break and heal: one asperity dragged over another.

Where particles leave their neighbours, no packing is left to refer strains to. Here pairs have
central forces only, of their present distance r,

    bonded  f = k (r - r0),      free  f = k min(r - r0, 0),

a Cauchy solid in place of the automata's two moduli. A bond that has stored more than its energy w
in tension breaks, and what it stored is lost; a free pair that is pressed together by the share
`healing` of r0 is bonded. In compression both laws are the same, so that healing costs nothing
and gives nothing: all work of the drag is stored, moving, damped or spent on bonds. Units: r0, k
and the mass of a particle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from reference.arguments import positive_faults, refuse
from reference.particles.packing import LAYER, VOLUME

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

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

    Attributes
    ----------
    overlap : float
        Of their tips, held while the upper one passes.
    energy : float
        w of a bond; it breaks at the strain sqrt(2 w).
    healing : float
        Compression of a free pair that bonds it.
    scatter : float
        Of the bonds' energies, relative.
    radius, height : float
    speed : float
        A wave of compression runs at about 1.4.
    damping : float
        Of the relative velocity along a pair.
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
        lower = self._body()
        upper = lower * (1.0, 1.0, -1.0)
        reach = 2 * np.sqrt(self.radius * self.overlap) + 1.5
        shift = (-reach, float(random.uniform(-0.5, 0.5)), 2 * self.height - self.overlap)
        run = _Run(self, lower, upper + shift, random)
        return run.over(2 * reach)

    def _body(self) -> Floats:
        """Return the places of the lower body, the tip of its asperity at z = height."""
        layers = []
        depth = -(_LAYERS - 1)
        for layer in range(depth, int(np.floor(self.height / LAYER)) + 1):
            half = 0.5 * (layer % 2)
            x = np.arange(-_HALF_LENGTH - half, _HALF_LENGTH + 0.6)
            y = np.arange(-_HALF_WIDTH - half, _HALF_WIDTH + 0.6)
            net = np.stack(np.meshgrid(x, y, [layer * LAYER], indexing="ij"), -1).reshape(-1, 3)
            surface = self.height - (net[:, 0] ** 2 + net[:, 1] ** 2) / (2 * self.radius)
            layers.append(net[(net[:, 2] <= surface) | (layer <= 0)])
        return np.concatenate(layers)


@dataclass(frozen=True, eq=False)
class Drag:
    """What a pass left behind.

    Attributes
    ----------
    way, force, load : ndarray
        Way of the upper body; force against it, and force that presses it away.
    places : (n, 3) ndarray
    upper : (n,) ndarray of bool
        Which particles began in the upper body.
    stress : (n, 6) ndarray
        Half the force moments of the pairs over the volume, at the largest force, in the order of
        `fem.recovery`; `stressed` are the places then.
    broken, healed : int
        Bonds.
    worn : int
        Particles that moved by more than two spacings against the body they belonged to.
    loose : int
        Particles that hold to neither body by bonds.
    work, stored, damped, spent : float
        Of the drag; what more is elastic or moving in the end; lost in dashpots; lost with bonds.
    """

    way: Floats
    force: Floats
    load: Floats
    places: Floats
    upper: Mask
    stress: Floats
    stressed: Floats
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


@dataclass(eq=False)
class _Run:
    """Particles in motion, and their pairs."""

    asperities: Asperities
    lower: Floats
    upper: Floats
    random: np.random.Generator
    ledger: Floats = field(default_factory=lambda: np.zeros(4))  # damped, spent, broken, healed

    def __post_init__(self) -> None:
        self.places = np.concatenate([self.lower, self.upper])
        self.velocities = np.zeros_like(self.places)
        self.is_upper = np.arange(len(self.places)) >= len(self.lower)
        ends = self.lower[:, 2].min(), self.upper[:, 2].max()
        self.bottom = ~self.is_upper & (self.places[:, 2] < ends[0] + 0.1)
        self.top = self.is_upper & (self.places[:, 2] > ends[1] - 0.1)
        pairs = cKDTree(self.places).query_pairs(1.1, output_type="ndarray")
        inside = self.is_upper[pairs[:, 0]] == self.is_upper[pairs[:, 1]]
        self.pairs = np.sort(pairs[inside], axis=1)
        self.bonded = np.ones(len(self.pairs), dtype=bool)
        self.limits = self._energies(len(self.pairs))
        self._began = self.places.copy()
        self._list()

    def over(self, way: float) -> Drag:
        """March until the upper body has moved this way."""
        given, held = self.asperities, self.bottom | self.top
        steps = int(np.ceil(way / (given.speed * _STEP)))
        self.velocities[self.is_upper, 0] = given.speed
        begun = 0.5 * float((self.velocities[~held] ** 2).sum())
        pulls, energy = self._pulls()
        history, work = np.empty((steps, 2)), 0.0
        largest = 0.0, self._stress(), self.places.copy()
        for number in range(steps):
            before = pulls[self.top, 0].sum()
            self.velocities[~held] += 0.5 * _STEP * pulls[~held]
            self.places += _STEP * self.velocities
            if np.abs(self.places - self._listed_at).max() > (_LISTED - _ALWAYS) / 3.5:
                self._list()
            pulls, energy = self._pulls()
            self.velocities[~held] += 0.5 * _STEP * pulls[~held]
            force, load = -pulls[self.top, 0].sum(), pulls[self.top, 2].sum()
            work += 0.5 * (force - before) * given.speed * _STEP
            history[number] = force, load
            if force > largest[0]:
                largest = force, self._stress(), self.places.copy()
        moving = 0.5 * float((self.velocities[~held] ** 2).sum()) - begun
        worn, loose = self._worn(steps * given.speed * _STEP)
        damped, spent, broken, healed = self.ledger.tolist()
        return Drag(
            way=np.arange(1.0, steps + 1) * (given.speed * _STEP),
            force=history[:, 0],
            load=history[:, 1],
            places=self.places,
            upper=self.is_upper,
            stress=largest[1],
            stressed=largest[2],
            broken=int(broken),
            healed=int(healed),
            worn=worn,
            loose=loose,
            work=float(work),
            stored=moving + energy,
            damped=damped,
            spent=spent,
        )

    def _list(self) -> None:
        """List all pairs that may act until some particle has moved far."""
        count = np.array([len(self.places), 1])
        kept, limits = self.pairs[self.bonded] @ count, self.limits[self.bonded]
        pairs = cKDTree(self.places).query_pairs(_LISTED, output_type="ndarray")
        self.pairs = np.sort(pairs, axis=1)
        keys = self.pairs @ count
        self.limits = self._energies(keys.size)
        _, old, new = np.intersect1d(kept, keys, assume_unique=True, return_indices=True)
        self.bonded = np.isin(np.arange(keys.size), new)
        self.limits[new] = limits[old]
        self._listed_at = self.places.copy()

    def _energies(self, count: int) -> Floats:
        """Draw energies of bonds, present ones and those that may form."""
        spread = self.asperities.scatter * self.random.uniform(-1, 1, count)
        energies: Floats = self.asperities.energy * (1 + spread)
        return energies

    def _pulls(self) -> tuple[Floats, float]:
        """Return forces and elastic energy; bonds break and heal."""
        pulls = np.zeros_like(self.places)
        given = self.asperities
        energy = _act(
            *(self.places, self.velocities, self.pairs, (self.bonded, self.limits)),
            *((given.healing, given.damping, _STEP), (pulls, self.ledger)),
        )
        return pulls, energy

    def _stress(self) -> Floats:
        stress = np.zeros((len(self.places), 6))
        _moments(self.places, self.pairs, self.bonded, stress)
        return stress / (2 * VOLUME)

    def _worn(self, way: float) -> tuple[int, int]:
        """Return how many particles have moved against their body, and how many hold to none."""
        count = len(self.places)
        moved = self.places - self._began
        moved[self.is_upper, 0] -= way
        i, j = self.pairs[self.bonded].T
        graph = coo_array((np.ones(i.size), (i, j)), shape=(count, count))
        label = connected_components(graph, directed=False)[1]
        held = np.isin(label, label[self.bottom | self.top])
        return int((np.linalg.norm(moved, axis=1) > _CARRIED).sum()), int((~held).sum())


@njit(cache=True, error_model="numpy")
def _act(
    places: Floats,
    velocities: Floats,
    pairs: NDArray[np.int64],
    bonds: tuple[Mask, Floats],
    constants: tuple[float, float, float],
    out: tuple[Floats, Floats],
) -> float:
    """Add the pulls of all pairs; return their elastic energy, and book what is lost."""
    (bonded, limits), (healing, damping, step), (pulls, ledger) = bonds, constants, out
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


@njit(cache=True, error_model="numpy")
def _moments(places: Floats, pairs: NDArray[np.int64], bonded: Mask, out: Floats) -> None:
    for p in range(len(pairs)):
        i, j = pairs[p, 0], pairs[p, 1]
        way = places[j] - places[i]
        r = np.sqrt((way**2).sum())
        stretch = r - 1.0
        if not bonded[p] and stretch >= 0.0:
            continue
        for entry, (a, b) in enumerate(((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))):
            moment = stretch * way[a] * way[b] / r
            out[i, entry] += moment
            out[j, entry] += moment
