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

import math
from collections.abc import Iterator

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from reference.arrays import Array
from reference.bounds.ellipses import ellipses_below
from reference.bounds.interval import EPSILON, Interval, above, below, inverse
from reference.bounds.potentials import Expansion, GridPotential
from reference.bounds.trigonometric import Waves, levelled
from reference.contact.press import press
from reference.errors import count_faults, positive_faults, refuse
from reference.halfspace import FreeOperator
from reference.loads import Load

# Squares per side of a cell.
_SQUARES = 4
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


class Block:
    """Square cells, and the surface above them: what pressures on them prove of it, for E* = 1.

    The gap g on a small square about a point c is g(c) + g'(c) (x - c) and a rest that its largest
    curvatures bound. With the same of the displacement (`GridPotential`) the conditions of the
    linear programme are proved everywhere on a cell, not at its middle.

    The gap is counted from the height `top`; the body rises above that by `above_samples` at most.
    Cell (0, 0) has its outer corner at (corner, corner) from the first point of the map; of the
    cells from `first` on, as many as `shape` says, `centres` (n, m) are the gaps in their middles.
    """

    def __init__(
        self,
        waves: Waves,
        top: float,
        spacing: float,
        corner: float,
        first: tuple[int, int],
        shape: tuple[int, int],
    ) -> None:
        self.shape, self.spacing = shape, spacing
        self.above_samples = max(waves.highest()[1] - top, 0.0)
        self.potential = GridPotential(shape, spacing, _SQUARES)
        self.operator = FreeOperator(shape, (spacing, spacing), 1.0)
        x, y = (
            corner / spacing + k + 0.5 + np.arange(float(n))
            for k, n in zip(first, shape, strict=True)
        )

        def height(place: tuple[float, float], order: tuple[int, int] = (0, 0)) -> Array:
            return waves.on((x + place[0]) * spacing, (y + place[1]) * spacing, order)

        places = self.potential.places
        self.centres = top - height((0.0, 0.0))
        self._gaps = [top - height(place) for place in places]
        self._slopes = [(-height(place, (1, 0)), -height(place, (0, 1))) for place in places]
        xx, xy, yy = waves.curvatures()
        half = self.potential.half
        rounding = 4 * waves.rounding + 4 * EPSILON * abs(top)
        # of the gap against the linear part, and of its mean over a square against the middle: the
        # mean along x for every y first, which leaves no mixed derivative
        self._rest = 0.5 * half**2 * (xx + 2 * xy + yy) + rounding
        self._bulge = half**2 / 6 * (xx + yy) + rounding

    def pressed(self, penetration: float, raised: Array | float = 0.0) -> Array:
        """Return the pressure under the body, raised in places, that is met in the cells' middles.

        It proves nothing by itself.
        """
        gap = self.centres - raised
        lowest = min(float(gap.min()), 0.0)
        load = Load("penetration", penetration - lowest)
        return press(self.operator, gap - lowest, load).pressure

    def shortfall(self, pressure: Array, penetration: float) -> tuple[Array, float]:
        """By how much a pressure fails at most, anywhere in each cell, to reach d - g.

        With an upper bound of <p, K p>.
        """
        worst, stored = np.zeros(self.shape), 0.0
        half = self.potential.half
        for gap, (along, across), u in zip(
            self._gaps, self._slopes, self.potential.expansions(pressure), strict=True
        ):
            sway = half * (np.abs(u.slope_x + along) + np.abs(u.slope_y + across))
            missing = penetration - gap - u.value + sway + u.under + self._rest
            # beyond the body's reach d - g is negative everywhere on the square
            reach = half * (np.abs(along) + np.abs(across)) + self._rest
            worst = np.maximum(worst, np.where(penetration - gap + reach > 0, missing, 0.0))
            stored += self._stored(pressure, u)
        return worst, stored

    def deepest(self, pressure: Array) -> tuple[Array, float]:
        """Upper bound of the displacement on each loaded cell; zero elsewhere. And of <p, K p>."""
        most, stored = np.zeros(self.shape), 0.0
        for u in self.potential.expansions(pressure):
            sway = self.potential.half * (np.abs(u.slope_x) + np.abs(u.slope_y))
            most = np.maximum(most, np.where(pressure > 0, u.value + sway + u.over, 0.0))
            stored += self._stored(pressure, u)
        return most, stored

    def _stored(self, pressure: Array, u: Expansion) -> float:
        """Upper bound of the integral of p u over a square of each cell, p >= 0."""
        # the mean of value and slopes over a square about its middle is the value
        total = math.fsum((pressure * (u.value + u.over)).flat) * (1 + 16 * EPSILON)
        return total * (2 * self.potential.half) ** 2

    def force(self, pressure: Array) -> float:
        """Integral of a pressure."""
        return math.fsum(pressure.flat) * self.spacing**2

    def work(self, pressure: Array, penetration: float) -> float:
        """Lower bound of the integral of p (d - g), p >= 0."""
        mean = sum(self._gaps) / len(self._gaps)
        terms = pressure * (penetration - mean - self._bulge)
        rounding = 32 * EPSILON * math.fsum((pressure * (penetration + np.abs(mean))).flat)
        return (math.fsum(terms.flat) - rounding) * self.spacing**2


class Patch:
    """A square patch of a band-limited rough surface over an elastic half-space.

    It is the trigonometric polynomial through heights (n, n), which grow towards the half-space,
    over the cells about these points (`reference.surfaces.subdivide`), so many times finer along a
    side. Penetrations are counted from its highest sample.
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
        """Force at a penetration."""
        refuse(positive_faults(penetration=penetration, effective_modulus=effective_modulus))
        block = self.block(penetration)
        lower, upper = force_below(block, penetration), force_above(block, penetration)
        if lower < _SHARP * upper:
            # cells larger than the contacts prove little, ellipses on the summits then more
            lower = max(lower, self.by_ellipses(penetration, 1.0))
        return effective_modulus * Interval(lower, upper)

    def energy(self, penetration: Interval, effective_modulus: float) -> Interval:
        """Energy at a penetration in an interval; it grows with the penetration.

        If cells of this size prove nothing from below, ArithmeticError.
        """
        ends = penetration.lower, penetration.upper
        block = self.block(ends[0])
        pressure = block.pressed(ends[0])
        work = block.work(pressure, ends[0])
        if work <= 0:
            raise ArithmeticError(f"no energy is proved at a penetration of {ends[0]:.4g}")
        lower = below(work**2 / (2 * block.deepest(pressure)[1]), 16)
        return effective_modulus * Interval(lower, energy_above(self.block(ends[1]), ends[1]))

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
        """Penetration at a force, which grows with it; see `inverse`, also for what it raises."""
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
        """Lower bound of the force by flat punches on the summits: without cells."""
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
        ratio = self.grid[0] / self._looks
        first, shape = [], []
        for squares in np.nonzero(highest > self.top - penetration):
            # whole cells; one more where rounding might decide
            least = max(math.floor(squares.min() * ratio - 1e-6), 0)
            beyond = min(math.ceil((squares.max() + 1) * ratio + 1e-6), self.grid[0])
            first.append(least)
            shape.append(beyond - least)
        start, count = (first[0], first[1]), (shape[0], shape[1])
        return Block(waves, self.top, self.spacing, self._corner, start, count)

    def on_grid(self, penetration: float) -> float:
        """Return the force by the conditions at the cells' middles for E* = 1: no bound."""
        block = self.block(penetration)
        return block.force(block.pressed(penetration))


def force_above(block: Block, penetration: float) -> float:
    """Least force of pressures under a body that is raised wherever they failed, for E* = 1."""

    def made_up(shortfall: Array) -> float:
        """Force of flat punches that push by what is missing: one on each cell, or one on all."""
        per_cell = math.sqrt(2) * block.spacing * math.fsum(shortfall.flat)
        for_all = math.hypot(*block.shape) * block.spacing * float(shortfall.max())
        return above(min(per_cell, for_all), 16)

    # no pressure at all fails by d at most, and where the body is higher than its samples by more
    best = made_up(np.full(block.shape, penetration + block.above_samples))
    for pressure, shortfall, _ in _raised(block, penetration):
        best = min(best, block.force(pressure) + made_up(shortfall))
    return above(best, 16)


def energy_above(block: Block, penetration: float) -> float:
    """Least energy of displacements that reach d - g everywhere, for E* = 1."""
    best = math.inf
    radius = 0.5 * above(math.hypot(*block.shape) * block.spacing, 4)
    for pressure, shortfall, stored in _raised(block, penetration):
        most = float(shortfall.max())
        best = min(best, 0.5 * stored + most * (block.force(pressure) + radius * most))
    return above(best, 16)


def _raised(block: Block, penetration: float) -> Iterator[tuple[Array, Array, float]]:
    """Pressures under a body that is raised wherever the last one failed, and their `shortfall`."""
    raised = np.zeros(block.shape)
    for _ in range(_ROUNDS):
        pressure = block.pressed(penetration, raised)
        shortfall, stored = block.shortfall(pressure, penetration)
        yield pressure, shortfall, stored
        if not shortfall.any():
            break
        raised += shortfall


def force_below(block: Block, penetration: float) -> float:
    """Largest mean of d - g under pressures that push nowhere they act deeper than a unit."""
    inside = np.flatnonzero(block.pressed(penetration) > 0)
    if not inside.size:
        return 0.0

    def displacement(values: Array) -> Array:
        field = np.zeros(block.shape)
        field.flat[inside] = values
        return block.operator.apply(field).flat[inside]

    operator = LinearOperator((len(inside),) * 2, matvec=displacement, dtype=float)
    target, best = np.ones(len(inside)), 0.0
    for _ in range(_ROUNDS):
        # the pressure for these displacements of the cells' middles, cut at zero
        values, _ = cg(operator, target, rtol=1e-6, maxiter=400)
        pressure = np.zeros(block.shape)
        pressure.flat[inside] = np.maximum(values, 0.0)
        deepest, _ = block.deepest(pressure)
        best = max(best, block.work(pressure, penetration) / float(deepest.max()))
        under = deepest.flat[inside]
        target -= np.maximum(under - np.quantile(under, 0.5), 0.0)
    return below(best, 16)
