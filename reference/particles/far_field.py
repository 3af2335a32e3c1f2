"""The half-space beyond the automata: Boussinesq fields of what presses, held in a shell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse
from reference.fem.far_field import boussinesq
from reference.particles.packing import Packing

Floats = NDArray[np.float64]

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


@dataclass(frozen=True)
class Domain:
    """Sizes of a body of automata in units of their spacing.

    Attributes
    ----------
    loaded : (float, float)
        Half-widths of the region that may be loaded.
    margin : float
        Automata around and below it.
    """

    loaded: tuple[float, float]
    margin: float

    def __post_init__(self) -> None:
        half_x, half_y = self.loaded
        refuse(positive_faults(loaded_x=half_x, loaded_y=half_y, margin=self.margin))

    @property
    def half_widths(self) -> tuple[float, float, float]:
        """Semi-axes of the half ellipsoid."""
        half_x, half_y = self.loaded
        return half_x + self.margin, half_y + self.margin, np.sqrt(half_x * half_y) + self.margin

    @property
    def count(self) -> float:
        """Number of automata, about.

        >>> round(Domain((4.5, 4.5), 10.5).count / 1000)
        12
        """
        x, y, z = (half + 1.0 for half in self.half_widths)
        return float(np.sqrt(2) * 2 / 3 * np.pi * x * y * z)


class FarField:
    """Fields in the shell of point forces on a net over the loaded region.

    Attributes
    ----------
    shares : (m, k) ndarray
        How much of a force on each automaton of the surface goes to each point force: bilinear, so
        that sum and first moments stay.
    """

    def __init__(self, domain: Domain, packing: Packing, poisson_ratio: float) -> None:
        axes = [_net(half, domain.margin) for half in domain.loaded]
        places = packing.places
        weights = [
            _hats(axis, places[: packing.surface, k].clip(axis[0], axis[-1]))
            for k, axis in enumerate(axes)
        ]
        shares = weights[0][:, :, None] * weights[1][:, None, :]
        self.shares = shares.reshape(packing.surface, -1)
        shell = places[packing.free :]
        self._fields = np.stack(
            [_held(shell - (x, y, 0.0), poisson_ratio) for x in axes[0] for y in axes[1]]
        )

    def at_shell(self, sources: Floats) -> Floats:
        """Return displacement, rotation and change of volume (n, 7) in the shell."""
        return np.tensordot(sources, self._fields, axes=1)


def _net(half: float, margin: float) -> Floats:
    count = max(2, int(np.ceil(2 * half / (SOURCE_STEP * margin))))
    return np.linspace(-half, half, count + 1)


def _hats(axis: Floats, places: Floats) -> Floats:
    """Return the values of the piecewise linear functions of a net at some places."""
    step = axis[1] - axis[0]
    return np.maximum(1 - np.abs(places[:, None] - axis) / step, 0.0)


def _held(points: Floats, poisson_ratio: float) -> Floats:
    """Return displacement, rotation (half its curl) and divergence of Boussinesq's field."""
    displacement, gradient = boussinesq(points, poisson_ratio)
    curl = np.stack([gradient[:, k - 1, k - 2] - gradient[:, k - 2, k - 1] for k in range(3)], -1)
    volume = np.trace(gradient, axis1=1, axis2=2)
    return np.column_stack([displacement, 0.5 * curl, volume])


class Search:
    """Where the far field and the depth come to agree with the contact, and with its force.

    Attributes
    ----------
    moved, sources, depth : as of the next round
    force : float
        That of the last round.
    history : list of float
        What they differ by, by round.
    """

    def __init__(self, moved: Floats, sources: Floats, depth: float) -> None:
        self.moved, self.sources, self.depth = moved, sources, depth
        self.target: float | None = None
        self.origin = 0.0
        self.force = float(sources.sum())
        self.history: list[float] = []
        self._before: tuple[float, float] | None = None

    def guess(self, origin: float, target: float) -> float:
        """Return the depth at which a force is likely, where contact begins at `origin`."""
        way = max(self.depth - origin, LEAST_WAY * self.depth)
        return float(origin + way * (target / self.force) ** (1 / USUAL_EXPONENT))

    def towards(self, depth: float, target: float | None, origin: float = 0.0) -> Search:
        """Return the search for the next load, from the state of this one.

        Parameters
        ----------
        depth : float
            The penetration, or a guess of it.
        target : float or None
            The force that is prescribed.
        origin : float
            The depth at which contact begins.
        """
        if target is not None:
            growth = target / self.force
        else:
            way = max(self.depth - origin, LEAST_WAY * self.depth)
            growth = ((depth - origin) / way) ** USUAL_EXPONENT
        search = Search(self.moved, growth * self.sources, depth)
        search.target, search.origin = target, origin
        return search

    def improve(self, sources: Floats, moved: Floats) -> bool:
        """Take what a round came to; return whether all agree."""
        self.moved, self.force = moved, float(sources.sum())
        if not self.force > 0.0:  # the far field alone has pushed the surface out of reach
            self.history.append(np.inf)
            self.sources = RETREAT * self.sources
            return False
        wrong = float(np.linalg.norm(sources - self.sources) / np.linalg.norm(sources))
        if self.target is not None:
            wrong = max(wrong, abs(self.force / self.target - 1))
        self.history.append(wrong)
        if wrong <= AGREEMENT:
            return True
        if self.target is None:
            self._extrapolate(sources)
        else:
            self._follow(sources, self.target)
        return False

    def _extrapolate(self, sources: Floats) -> None:
        """Solve q = T(q) for a T that is linear along the last step (Aitken)."""
        total, feedback = float(self.sources.sum()), USUAL_FEEDBACK
        if self._before is not None and total != self._before[0]:
            slope = (self.force - self._before[1]) / (total - self._before[0])
            feedback = slope if abs(slope) < 0.9 else feedback
        self._before = total, self.force
        self.sources = (sources - feedback * self.sources) / (1 - feedback)

    def _follow(self, sources: Floats, target: float) -> None:
        """Follow F ~ (d - d0)^n to the prescribed force, d0 where contact begins."""
        exponent, way = USUAL_EXPONENT, self.depth - self.origin
        if self._before is not None and way != self._before[0]:
            before, force = self._before
            slope = np.log(self.force / force) / np.log(way / before)
            exponent = float(np.clip(slope, *EXPONENTS))
        self._before = way, self.force
        self.depth = self.origin + way * (target / self.force) ** (1 / exponent)
        self.sources = sources * (target / self.force)
