r"""Force of a free rough patch at a penetration, between proved bounds.

The force is the value of a linear programme and of its dual (Barber 1974; u = K p everywhere):

    F = min { int q : q >= 0, K q >= d - g } = max { int (d - g) dm : m >= 0, K m <= 1 on supp m }.

So any pressure that pushes the surface down to the body *everywhere* carries at least F, and any
pressure that pushes the surface nowhere it acts deeper than a unit carries at most F in the mean of
d - g. Both are pressures uniform on the cells of a `Block`, which covers all places where d - g is
positive: elsewhere the first condition holds for any pressure, and the second asks for nothing.

What a pressure still fails to reach is made up for by flat circular punches over it: one of radius
b that pushes a depth s carries 2 E* b s, and lifts the surface nowhere.

The same pressures enclose the energy U, the integral of F. Any p >= 0 has U >= <p, d - g>^2 over
2 <p, K p>; and a q that fails by s at most has, with one punch over all, K q + s >= d - g, whose
energy is <q, K q>/2 + s int q + b s^2, as the punch pushes by no more than s anywhere. The
stiffness lies between chords of the force, which is convex as the contact area grows (Barber 1974).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, cg

from reference.arguments import count_faults, positive_faults, refuse
from reference.bounds.blocks import Block
from reference.bounds.interval import Interval, above, below, inverse
from reference.bounds.summit_punches import ellipses_below
from reference.bounds.trigonometric import Waves, levelled

Array = NDArray[np.float64]

# Rounds in which a penetration too shallow is deepened, and a displacement too deep taken back.
_ROUNDS = 8
# Roughly the power of the penetration with which the force grows.
_POWER = 1.8
# Steps of the chords of the force, over the penetration.
_CHORD = 0.05, 0.6
# Fraction of the upper bound below which ellipses are tried for a better lower one.
_SHARP = 0.5
# Squares per point of the map that locates where the body is not reached.
_LOOK = 8


class Patch:
    """A square patch of a band-limited rough surface over an elastic half-space.

    Parameters
    ----------
    heights : (n, n)
        Heights, growing towards the half-space; the surface is the trigonometric polynomial
        through them, over the cells about these points (`reference.surfaces.subdivide`).
    size : float
        Side of the patch.
    finer : int
        Cells per point along a side.
    """

    def __init__(self, heights: Array, size: float, finer: int = 4) -> None:
        heights = levelled(heights)
        points = len(heights)
        faults = positive_faults(size=size) + count_faults(1, finer=finer)
        if heights.shape != (points, points):
            faults.append(f"heights must be a square map, not of shape {heights.shape}")
        refuse(faults)
        self.size, self._rms = float(size), float(heights.std())
        self.grid = (int(finer) * points, int(finer) * points)
        self.spacing = self.size / self.grid[0]
        self._waves = Waves(heights, (self.size, self.size))
        self.top = self._waves.highest()[0]
        self._corner = -0.5 * self.size / points
        self._looks = _LOOK * points

    def force(self, penetration: float, effective_modulus: float) -> Interval:
        """Force at a penetration, counted from the highest sample of the surface."""
        refuse(positive_faults(penetration=penetration, effective_modulus=effective_modulus))
        block = self.block(penetration)
        lower, upper = force_below(block, penetration), force_above(block, penetration)
        if lower < _SHARP * upper:
            # cells larger than the contacts prove little, ellipses on the summits then more
            lower = max(lower, self.by_ellipses(penetration, 1.0))
        return effective_modulus * Interval(lower, upper)

    def energy(self, penetration: Interval, effective_modulus: float) -> Interval:
        """Energy at a penetration in an interval; it grows with the penetration.

        Raises
        ------
        ArithmeticError
            If cells of this size prove nothing from below.
        """
        ends = penetration.lower, penetration.upper
        least = energy_below(self.block(ends[0]), ends[0])
        if not least > 0:
            raise ArithmeticError(f"no energy is proved at a penetration of {ends[0]:.4g}")
        return effective_modulus * Interval(least, energy_above(self.block(ends[1]), ends[1]))

    def stiffness(
        self, penetration: Interval, force: Interval, effective_modulus: float
    ) -> Interval:
        """Stiffness where penetration and force are enclosed, one of them given exactly or both.

        As F is convex and zero at some depth -s above all samples, for d below d2 and F(d) not
        below F1 it is not below (F1 - F(d2 - h))/h and F1/(d2 + s), not above (F(d2 + h) - F1)/h.
        """
        refuse(positive_faults(effective_modulus=effective_modulus))
        deep, least = penetration.upper, force.lower / effective_modulus
        # of a power law d^1.8: the chord's excess, 0.4 h/d, against the force's width over the rise
        width = force.width + _POWER * penetration.width
        step = deep * min(max(math.sqrt(1.4 * width), _CHORD[0]), _CHORD[1])
        near, far = (force_above(self.block(d), d) for d in (deep - step, deep + step))
        started = deep + self.block(deep).above_samples
        lower = max((least - near) / step, least / started)
        return effective_modulus * Interval(below(lower, 8), above((far - least) / step, 8))

    def penetration(self, force: float, effective_modulus: float) -> Interval:
        """Penetration at a force, counted as in `force`: a force grows with it.

        Raises
        ------
        ValueError
            For a force or modulus that is not positive and finite.
        ArithmeticError
            If cells of this size prove nothing that reaches the force.
        """
        refuse(positive_faults(force=force, effective_modulus=effective_modulus))
        value = force / effective_modulus
        near = inverse(value, self.on_grid, self.on_grid, self._rms, _POWER).middle
        return inverse(
            value,
            lambda depth: force_below(self.block(depth), depth),
            lambda depth: force_above(self.block(depth), depth),
            near,
            _POWER,
        )

    def by_ellipses(self, penetration: float, effective_modulus: float) -> float:
        """Lower bound of the force by flat punches on the summits (`summits`): without cells.

        Raises
        ------
        ValueError
            As `force`.
        """
        refuse(positive_faults(penetration=penetration, effective_modulus=effective_modulus))
        far = self._corner + self.size
        corners = (self._corner, self._corner), (far, far)
        bound = ellipses_below(self._waves, self.top, corners, penetration)
        return below(effective_modulus * bound, 4)

    def block(self, penetration: float) -> Block:
        """Return the cells of the patch about all places that are less than d below the top."""
        waves, step = self._waves, self.size / self._looks
        middles = self._corner + (np.arange(float(self._looks)) + 0.5) * step
        height, along, across = (
            waves.on(middles, middles, order) for order in ((0, 0), (1, 0), (0, 1))
        )
        xx, xy, yy = waves.curvatures()
        highest = height + 0.5 * step * (np.abs(along) + np.abs(across))
        highest += 0.125 * step**2 * (xx + 2 * xy + yy) + 8 * waves.rounding
        reached = np.nonzero(highest > self.top - penetration)
        ratio = self.grid[0] / self._looks
        first, beyond = [], []
        for squares in reached:
            # whole cells; one more where rounding might decide
            first.append(max(math.floor(squares.min() * ratio - 1e-6), 0))
            beyond.append(min(math.ceil((squares.max() + 1) * ratio + 1e-6), self.grid[0]))
        shape = (beyond[0] - first[0], beyond[1] - first[1])
        start = first[0], first[1]
        return Block(waves, self.top, self.spacing, self._corner, start, shape)

    def on_grid(self, penetration: float) -> float:
        """Return the force by the conditions at the cells' middles for E* = 1: no bound."""
        block = self.block(penetration)
        return block.force(block.pressed(penetration))


def force_above(block: Block, penetration: float) -> float:
    """Least force of pressures under a body that is raised wherever they failed, for E* = 1."""
    raised = np.zeros(block.shape)
    # no pressure at all fails by d at most, and where the body is higher than its samples by more
    best = _made_up(block, np.full(block.shape, penetration + block.above_samples))
    for _ in range(_ROUNDS):
        pressure = block.pressed(penetration, raised)
        shortfall, _ = block.shortfall(pressure, penetration)
        best = min(best, block.force(pressure) + _made_up(block, shortfall))
        raised += shortfall
        if not shortfall.any():
            break
    return above(best, 16)


def energy_above(block: Block, penetration: float) -> float:
    """Least energy of displacements that reach d - g everywhere, for E* = 1."""
    raised, best = np.zeros(block.shape), math.inf
    radius = 0.5 * above(math.hypot(*block.shape) * block.spacing, 4)
    for _ in range(_ROUNDS):
        pressure = block.pressed(penetration, raised)
        shortfall, stored = block.shortfall(pressure, penetration)
        most = float(shortfall.max())
        best = min(best, 0.5 * stored + most * (block.force(pressure) + radius * most))
        raised += shortfall
        if not most:
            break
    return above(best, 16)


def energy_below(block: Block, penetration: float) -> float:
    """Energy that the pressure under the body proves, for E* = 1."""
    pressure = block.pressed(penetration)
    work = block.work(pressure, penetration)
    if work <= 0:
        return 0.0
    _, stored = block.deepest(pressure)
    return below(work**2 / (2 * stored), 16)


def _made_up(block: Block, shortfall: Array) -> float:
    """Force of flat punches that push by what is missing: one on each cell, or one on all."""
    per_cell = math.sqrt(2) * block.spacing * math.fsum(shortfall.flat)
    for_all = math.hypot(*block.shape) * block.spacing * float(shortfall.max())
    return above(min(per_cell, for_all), 16)


def force_below(block: Block, penetration: float) -> float:
    """Largest mean of d - g under pressures that push nowhere they act deeper than a unit."""
    loaded = block.pressed(penetration) > 0
    if not loaded.any():
        return 0.0
    target = np.ones(block.shape)
    best = 0.0
    for _ in range(_ROUNDS):
        pressure = _pushing(block, target, loaded)
        deepest, _ = block.deepest(pressure)
        best = max(best, block.work(pressure, penetration) / float(deepest.max()))
        target -= np.maximum(deepest - np.quantile(deepest[loaded], 0.5), 0.0) * loaded
    return below(best, 16)


def _pushing(block: Block, target: Array, loaded: NDArray[np.bool_]) -> Array:
    """Pressure on loaded cells for given displacements of their middles, cut at zero."""
    inside = np.flatnonzero(loaded)

    def displacement(values: Array) -> Array:
        field = np.zeros(block.shape)
        field.flat[inside] = values
        return block.operator.apply(field).flat[inside]

    operator = LinearOperator((len(inside),) * 2, matvec=displacement, dtype=float)
    values, _ = cg(operator, target.flat[inside], rtol=1e-6, maxiter=400)
    pressure = np.zeros(block.shape)
    pressure.flat[inside] = np.maximum(values, 0.0)
    return pressure
