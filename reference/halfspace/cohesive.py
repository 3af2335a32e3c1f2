"""Contact on the half-space with a cohesive law, by Newton's method.

Pressures p and gaps h = g - d + K p obey h = 0 where p >= -sigma(0), and p = -sigma(h) elsewhere.
Linearised about an iterate, with k = -sigma'(h) and the residual r = p + sigma(h), the change of
the gap is dh = K dp - dd, and

    dh = -h          on cells in contact,
    dp = k dh - r    on all others.

With dp = omega z - r, omega = sqrt(k) outside the contact, this is the symmetric system

    (1_outside - omega K omega) z = omega (h 1_contact - K r - dd),

solved by MINRES: its conditioning depends neither on the far cells, where k vanishes, nor on the
sign of the stiffness, so unstable equilibria are computed like stable ones.

Their path, which determines their stability, is followed by arc length in penetration and force,
beyond folds of either; jumps and hysteresis under a prescribed load are derived from it afterwards.
Folds are equilibria of the path, found by Brent's method between their neighbours: the minimum of
a long-range attraction is nearly a kink, which no parabola through points of the path meets.
"""

from __future__ import annotations

from bisect import bisect, insort
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar
from scipy.sparse.linalg import LinearOperator, minres

from reference.arrays import Array, Mask
from reference.contact.body import ElasticBody
from reference.contact.press import check_gap, effort_faults, press
from reference.errors import ConvergenceError, choice_faults, positive_faults, refuse
from reference.loads import Load

# (a, b, value): a d + b F = value.
Constraint = tuple[float, float, float]


@dataclass(frozen=True)
class CohesiveLaw:
    """Non-increasing tension sigma(h) >= 0 at gaps h >= 0; at h = 0 the surfaces are hard."""

    name: str
    work: float  # work of adhesion w, the integral of the tension over all gaps
    strength: float  # sigma(0), the largest tension
    reach: float  # w/sigma(0), the range
    # sigma(h), -sigma'(h) >= 0 and the integral of sigma from h to infinity, on arrays
    tension: Callable[[Array], Array]
    softening: Callable[[Array], Array]
    energy: Callable[[Array], Array]

    def weakened(self, share: float) -> CohesiveLaw:
        """Return the law with all tensions scaled by a factor, and the same range."""
        return replace(
            self,
            work=share * self.work,
            strength=share * self.strength,
            tension=lambda h: share * self.tension(h),
            softening=lambda h: share * self.softening(h),
            energy=lambda h: share * self.energy(h),
        )


def exponential(work: float, reach: float) -> CohesiveLaw:
    """Return the smooth law sigma = (w/rho) exp(-h/rho) (Rey, Anciaux & Molinari 2017).

    >>> law = exponential(2.0, 0.5)
    >>> float(law.tension(np.array(0.0)))
    4.0
    """
    refuse(positive_faults(work=work, reach=reach))
    strength = work / reach

    def tension(h: Array) -> Array:
        return strength * np.exp(-h / reach)

    return CohesiveLaw(
        name="exponential",
        work=work,
        strength=strength,
        reach=reach,
        tension=tension,
        softening=lambda h: tension(h) / reach,
        energy=lambda h: tension(h) * reach,
    )


def dugdale(work: float, strength: float, ramp: float = 0.3) -> CohesiveLaw:
    """Return Maugis' law, sigma0 up to the gap w/sigma0, with a ramp instead of the step.

    The tension decreases from sigma0 at (1 - ramp) w/sigma0 to zero at (1 + ramp) w/sigma0, as a
    cubic with zero end slopes: the same work of adhesion, and a continuous slope for Newton's
    method.

    `ramp` is the relative half-width of the ramp, in (0, 1].
    """
    refuse(positive_faults(work=work, strength=strength, ramp=ramp))
    if ramp > 1:
        raise ValueError(f"ramp must be at most 1, not {ramp!r}")
    reach = work / strength
    low, high = (1 - ramp) * reach, (1 + ramp) * reach

    def tension(h: Array) -> Array:
        t = np.clip((high - h) / (high - low), 0.0, 1.0)
        return strength * t * t * (3 - 2 * t)

    def softening(h: Array) -> Array:
        t = np.clip((high - h) / (high - low), 0.0, 1.0)
        return 6 * strength / (high - low) * t * (1 - t)

    def energy(h: Array) -> Array:
        t = np.clip((high - h) / (high - low), 0.0, 1.0)
        return strength * ((high - low) * t**3 * (1 - t / 2) + np.maximum(low - h, 0.0))

    return CohesiveLaw("dugdale", work, strength, reach, tension, softening, energy)


_FORCING = 1e-3  # tolerance of MINRES relative to the residual of Newton's method
# Tolerances of the response to the penetration, nearly singular close to a fold: as the direction
# of a step, whose error the next one finds (at 1e-6 some do not converge), and as a result.
_DIRECTION, _STIFFNESS = 1e-8, 1e-10
_ROUNDS = 2000
_LEAST_SHARE = 1e-3


@dataclass(frozen=True)
class CohesiveContact:
    """One equilibrium of an adhesive contact."""

    # d (negative before first touch) and F (negative when pulling)
    penetration: float
    force: float
    pressure: Array = field(repr=False)  # (nx, ny): cell values; negative in tension
    gap: Array = field(repr=False)  # remaining gap, zero in contact
    mask: Mask = field(repr=False)  # cells in contact
    iterations: int  # number of Newton steps
    # largest error of a gap relative to the reach of the law, or of a tension relative to its
    # strength
    residual: float


class CohesiveProblem:
    """A half-space, the gap of a rigid body and a cohesive law.

    The grid must resolve the zone in which the tension falls: its width is about 0.8 E*
    w/sigma(0)^2 at the edge of a contact, two cells across it give errors of some per cent. The
    gap is >= 0, +inf outside the body.
    """

    def __init__(self, operator: ElasticBody, gap: ArrayLike, law: CohesiveLaw) -> None:
        self.operator, self.law = operator, law
        gap = check_gap(operator, gap)
        self.solid = np.isfinite(gap)
        # cells without material carry no load; any finite gap will do
        self.initial_gap = np.where(self.solid, gap, 0.0)
        one_cell = np.zeros(operator.shape)
        one_cell[0, 0] = 1.0
        self.cell_compliance = float(operator.apply(one_cell).max())

    def force(self, pressure: Array) -> float:
        """Return the sum of the pressures times the cell area."""
        return float(pressure.sum()) * self.operator.cell_area

    def at_penetration(
        self,
        penetration: float,
        start: Array | None = None,
        tolerance: float = 1e-8,
        max_iterations: int = 40,
    ) -> CohesiveContact:
        """Return the equilibrium at a penetration that Newton's method reaches from the start.

        Beyond a fold there is none nearby.
        """
        refuse(effort_faults(tolerance, max_iterations))
        fixed = (1.0, 0.0, penetration)
        if start is None:
            # the contact without adhesion, then the tension in steps up to nearly the full one
            gap, start = np.where(self.solid, self.initial_gap, np.inf), np.zeros(self.solid.shape)
            if penetration > 0:
                load = Load("penetration", penetration)
                start = press(self.operator, gap, load, tolerance=1e-4).pressure
            share, step = 0.0, 0.25
            while share < 1.0:
                law = self.law.weakened(min(share + step, 1.0))
                weak = CohesiveProblem(self.operator, gap, law)
                try:
                    start = weak.newton(start, penetration, fixed, 1e-4, max_iterations).pressure
                    share += step
                except ConvergenceError:
                    step /= 2
                    if step < _LEAST_SHARE:
                        raise
        return self.newton(start, penetration, fixed, tolerance, max_iterations)

    def at_force(
        self, force: float, penetration: float, start: Array, tolerance: float = 1e-8
    ) -> CohesiveContact:
        """Return the equilibrium at a force, from a penetration and pressures close to it."""
        fixed = (0.0, 1.0, force)
        return self.newton(start, penetration, fixed, tolerance, 40)

    def newton(
        self,
        pressure: Array,
        penetration: float,
        constraint: Constraint,
        tolerance: float,
        max_iterations: int,
    ) -> CohesiveContact:
        """Return an equilibrium that satisfies the constraint, by Newton's method."""
        by_depth, by_force, value = constraint
        # the scale of the constraint: the reach of the law, and its strength on one cell
        cell = self.law.strength * self.operator.cell_area
        unit = abs(by_depth) * self.law.reach + abs(by_force) * cell
        history: list[float] = []
        for _ in range(max_iterations):
            state = _Linearised(self, pressure, penetration)
            forcing = _FORCING * min(1.0, state.error)
            missing = value - by_depth * penetration - by_force * self.force(pressure)
            history.append(max(state.error, abs(missing) / unit))
            if history[-1] <= tolerance:
                return CohesiveContact(
                    penetration=penetration,
                    force=self.force(pressure),
                    pressure=pressure,
                    gap=np.where(self.solid, state.gap, np.inf),
                    mask=state.contact,
                    iterations=len(history),
                    residual=history[-1],
                )
            if not np.isfinite(history[-1]) or history[-1] > 1e6:
                break
            # the change of the penetration that satisfies the constraint
            if by_force == 0:
                depth = missing / by_depth
                pressure = pressure + state.change(depth, with_residual=True, rtol=forcing)
            else:
                fixed = state.change(0.0, with_residual=True, rtol=forcing)
                per_depth = state.change(1.0, with_residual=False, rtol=_DIRECTION)
                rate = by_depth + by_force * self.force(per_depth)
                depth = (missing - by_force * self.force(fixed)) / rate
                pressure = pressure + fixed + depth * per_depth
            penetration += depth
        raise ConvergenceError("Newton's method found no adhesive equilibrium nearby", history)

    def stiffness(self, contact: CohesiveContact) -> float:
        """Return dF/dd at an equilibrium, the slope of the path."""
        state = _Linearised(self, contact.pressure, contact.penetration)
        return self.force(state.change(1.0, with_residual=False, rtol=_STIFFNESS))


class _Linearised:
    """Newton's equations about one iterate."""

    def __init__(self, problem: CohesiveProblem, pressure: Array, penetration: float) -> None:
        self.problem = problem
        apply, law, solid = problem.operator.apply, problem.law, problem.solid
        self.gap = problem.initial_gap - penetration + apply(pressure)
        above = np.maximum(self.gap, 0.0)
        residual = np.where(solid, pressure + law.tension(above), 0.0)
        self.contact = solid & (residual * problem.cell_compliance > self.gap)
        apart = solid & ~self.contact
        self.apart = apart
        self.residual = np.where(apart, residual, 0.0)
        # in units of the cell compliance, cells in contact and outside have equal weight
        weight = np.where(
            apart, np.sqrt(law.softening(above)), 1 / np.sqrt(problem.cell_compliance)
        )
        self.weight = np.where(solid, weight, 0.0)
        self.error = max(
            float(np.abs(self.gap[self.contact]).max(initial=0.0)) / law.reach,
            float(np.abs(self.residual).max()) / law.strength,
        )

    def change(self, depth: float, *, with_residual: bool, rtol: float) -> Array:
        """Return the change of the pressures with the penetration, with or without the residual.

        MINRES ends at the tolerance `rtol`, relative to the right-hand side.
        """
        apply, weight = self.problem.operator.apply, self.weight
        right = np.full(weight.shape, -depth)
        if with_residual:
            right += np.where(self.contact, self.gap, 0.0) - apply(self.residual)
        shape = weight.shape

        def act(flat: Array) -> Array:
            z = flat.reshape(shape)
            return (np.where(self.contact, 0.0, z) - weight * apply(weight * z)).ravel()

        system = LinearOperator((weight.size, weight.size), matvec=act, dtype=float)
        right = (weight * right).ravel()
        size = float(np.linalg.norm(right))
        z = np.zeros_like(right)
        if size > 0:
            # SciPy adds the norm of the right-hand side to its estimate of the matrix norm and
            # divides the residual by it: a large one (a small unit of length) would end early
            unit = 2.0 ** np.round(np.log2(size))
            z = unit * minres(system, right / unit, rtol=max(rtol, 1e-12), maxiter=_ROUNDS)[0]
        return weight * z.reshape(shape) - (self.residual if with_residual else 0.0)


_SHRINKS = 12
_MOST = 2000  # largest number of points of a path
_EASY, _ITERATIONS = 6, 30
_PARTED = 1e-3  # force without contact, over the lowest one, at which a path ends
# Sharper turns than this cosine are taken in smaller steps, down to those of a corner of the path,
# because a step over a fold would reach another branch; so would a corner that leads far, by a step
# of a straight path or more.
_TURN, _CORNER = 0.7, 0.05
_FOLD = 1e-6  # error of a fold's load, relative to the largest beside it


@dataclass(frozen=True)
class CohesivePath:
    """Equilibria in the order of the path, from compression to separation; arrays of shape (k,)."""

    # d and F
    penetration: Array
    force: Array
    contact_area: Array  # area of the cells in contact
    points: tuple[CohesiveContact, ...]  # the equilibria

    def follow(self, control: str, loads: ArrayLike) -> list[tuple[int, float]]:
        """Return the positions of loads on the path from separation: (segment, fraction of it).

        An increasing load moves towards compression, a decreasing one towards separation, to the
        first position with this load; across folds this is a jump. Loads without equilibrium stay
        at the end.
        """
        curve = self._load(control)
        place = last = (curve.size - 2, 1.0)
        places = []
        for load in np.asarray(loads, dtype=float):
            i, part = place
            now = curve[i] + part * (curve[i + 1] - curve[i])
            if load != now:
                # the next segment with this load, and the fraction of it
                ahead = np.flatnonzero(curve[: i + 1] >= load)[::-1]
                if load < now:
                    ahead = i + np.flatnonzero(curve[i + 1 :] <= load)
                place = (0, 0.0) if load > now else last
                for at in ahead[:1].tolist():
                    place = at, float((load - curve[at]) / (curve[at + 1] - curve[at]))
            places.append(place)
        return places

    def _load(self, control: str) -> Array:
        refuse(choice_faults("control", control, ("force", "penetration")))
        return self.force if control == "force" else self.penetration

    def pull_off(self, control: str = "force") -> tuple[float, float] | None:
        """Return penetration and force at which a decreasing load is lost; None without a fold.

        It is the lowest fold on unloading; under penetration control, long-range attraction has
        none.
        """
        at = _fold(self._load(control), 1)
        return None if at is None else (float(self.penetration[at]), float(self.force[at]))


def _fold(load: Array, sign: int) -> int | None:
    """Return the lowest minimum of a load along a path (sign 1), or its last maximum (-1)."""
    load = sign * load
    folds = np.flatnonzero((load[1:-1] <= load[:-2]) & (load[1:-1] < load[2:])) + 1
    if not folds.size:
        return None
    return int(folds[-1] if sign < 0 else folds[np.argmin(load[folds])])


def trace(
    problem: CohesiveProblem,
    penetration: float,
    lowest: float,
    *,
    steps: int = 40,
    tolerance: float = 1e-7,
    risen: float = np.inf,
) -> CohesivePath:
    """Return the equilibria from compression to separation.

    From a penetration in compression, where the path begins, so many steps lead to the lowest
    one of interest on a straight path; folds and jumps of the grid take more. The tolerance is
    that of every equilibrium, see `CohesiveContact.residual`. The path ends when the force has
    risen by the fraction `risen` of its lowest value, which suffices for the pull-off, or else when
    the bodies have parted.
    """
    first = problem.at_penetration(penetration, tolerance=tolerance, max_iterations=100)
    stride = (penetration - lowest) / steps
    units = stride, problem.stiffness(first) * stride
    points = [first]
    previous = problem.at_penetration(penetration - stride, first.pressure, tolerance)
    points.append(previous)
    length = 1.0
    while True:
        last, pulled = points[-1], min(point.force for point in points)
        pulled_off = pulled < 0 and last.force - pulled > risen * abs(pulled)
        parted = not last.mask.any() and (
            last.penetration < lowest or abs(last.force) <= _PARTED * abs(pulled)
        )
        if pulled_off or parted:
            break
        if len(points) >= _MOST:
            raise ConvergenceError(
                f"the path has not ended after {_MOST} points: the grid may be too coarse "
                "for the range of the law",
                [],
            )
        # an earlier point far enough to define the direction
        for before in reversed(points[:-1]):
            moved = last.penetration - before.penetration, last.force - before.force
            way = np.array(moved) / units
            if np.hypot(*way) >= _CORNER:
                break
        done = float(np.hypot(*way))
        way /= done
        # a step of arc length ahead, halved until it ends on the same branch
        for _ in range(_SHRINKS):
            ratio = length / done
            pressure = last.pressure + ratio * (last.pressure - before.pressure)
            depth = last.penetration + length * way[0] * units[0]
            force = last.force + length * way[1] * units[1]
            # the plane normal to the path: (d - d_predicted, F - F_predicted) . way = 0
            normal = way[0] / units[0], way[1] / units[1]
            plane = (*normal, normal[0] * depth + normal[1] * force)
            try:
                contact = problem.newton(pressure, depth, plane, tolerance, _ITERATIONS)
            except ConvergenceError as failure:
                history = failure.history
            else:
                moved = (contact.penetration - last.penetration, contact.force - last.force)
                step = np.array(moved) / units
                far = np.hypot(*step)
                corner = length < _CORNER and step @ way > 0 and far < 1
                if step @ way > _TURN * far or corner:
                    break
                history = [contact.residual]
            length /= 2
        else:
            raise ConvergenceError(
                "the path of an adhesive contact was lost: the grid is too coarse for the range of "
                "the law",
                history,
            )
        points.append(contact)
        length = min(1.0, 1.5 * length) if contact.iterations <= _EASY else length
    # the last maximum of the penetration is the jump into contact on approach
    for load, sign in (("force", 1), ("penetration", 1), ("penetration", -1)):
        at = _fold(np.array([getattr(point, load) for point in points]), sign)
        if at is not None:
            near = slice(at - 1, at + 2)
            points[near] = _refined(problem, points[near], load, sign, units, tolerance)
    return CohesivePath(
        np.array([point.penetration for point in points]),
        np.array([point.force for point in points]),
        np.array([point.mask.sum() for point in points]) * problem.operator.cell_area,
        tuple(points),
    )


def _refined(
    problem: CohesiveProblem,
    points: list[CohesiveContact],
    load: str,
    sign: int,
    units: tuple[float, float],
    tolerance: float,
) -> list[CohesiveContact]:
    """Return three equilibria about a fold, and between them those on the way to its load."""
    (first, _, last), points = points, list(points)
    chord = np.array([last.penetration - first.penetration, last.force - first.force])
    normal = chord / np.square(units)

    def place(point: CohesiveContact) -> float:
        return float(normal @ (point.penetration, point.force))

    def solve(at: float) -> float:
        # on the plane normal to the chord, from between the nearest equilibria
        after = int(np.clip(bisect(points, at, key=place), 1, len(points) - 1))
        low, high = points[after - 1 : after + 1]
        part = (at - place(low)) / (place(high) - place(low))
        pressure = low.pressure + part * (high.pressure - low.pressure)
        depth = low.penetration + part * (high.penetration - low.penetration)
        found = problem.newton(pressure, depth, (*normal, at), tolerance, _ITERATIONS)
        insort(points, found, key=place)
        return sign * float(getattr(found, load))

    ends = place(first), place(last)
    # the load changes at most so much per place, where it is a kink; a smooth one is found closer
    values = np.array([getattr(point, load) for point in points])
    close = _FOLD * np.abs(values).max() / np.abs(np.diff(values)).max()
    width = {"xatol": min(close, _CORNER) * (ends[1] - ends[0])}
    minimize_scalar(solve, bounds=ends, method="bounded", options=width)
    return points
