"""Contact on the half-space with a cohesive law, by Newton's method.

Pressures p and gaps h = g - d + K p obey h = 0 where p >= -sigma(0), and p = -sigma(h) elsewhere.
Linearised about an iterate, with k = -sigma'(h) and the residual r = p + sigma(h), the change of
the gap is dh = K dp - dd, and

    dh = -h          on cells in contact,
    dp = k dh - r    on all others.

With dp = omega z - r, omega = sqrt(k) outside the contact, this is the symmetric system

    (1_outside - omega K omega) z = omega (h 1_contact - K r - dd),

solved by MINRES: its conditioning depends neither on the far cells, where k vanishes, nor on the
sign of the stiffness, so unstable equilibria are computed like stable ones. The path determines
their stability, see `cohesive_path`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.linalg import LinearOperator, minres

from reference.arguments import positive_faults, refuse
from reference.contact.body import ElasticBody
from reference.contact.press import check_gap, effort_faults, press
from reference.errors import ConvergenceError
from reference.loads import Load


@dataclass(frozen=True)
class CohesiveLaw:
    """Non-increasing tension sigma(h) >= 0 at gaps h >= 0; at h = 0 the surfaces are hard.

    Attributes
    ----------
    name : str
    work : float
        Work of adhesion w, the integral of the tension over all gaps.
    strength : float
        sigma(0), the largest tension.
    reach : float
        w/sigma(0), the range.
    tension, softening, energy : callable
        sigma(h), -sigma'(h) >= 0 and the integral of sigma from h to infinity, on arrays.
    """

    name: str
    work: float
    strength: float
    reach: float
    tension: Callable[[Field], Field]
    softening: Callable[[Field], Field]
    energy: Callable[[Field], Field]

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

    Examples
    --------
    >>> law = exponential(2.0, 0.5)
    >>> float(law.tension(np.array(0.0)))
    4.0
    """
    refuse(positive_faults(work=work, reach=reach))
    strength = work / reach

    def tension(h: Field) -> Field:
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

    Parameters
    ----------
    work, strength : float
        w and sigma0.
    ramp : float
        Relative half-width of the ramp, in (0, 1].
    """
    refuse(positive_faults(work=work, strength=strength, ramp=ramp))
    if ramp > 1:
        raise ValueError(f"ramp must be at most 1, not {ramp!r}")
    reach = work / strength
    low, high = (1 - ramp) * reach, (1 + ramp) * reach

    def tension(h: Field) -> Field:
        t = np.clip((high - h) / (high - low), 0.0, 1.0)
        return strength * t * t * (3 - 2 * t)

    def softening(h: Field) -> Field:
        t = np.clip((high - h) / (high - low), 0.0, 1.0)
        return 6 * strength / (high - low) * t * (1 - t)

    def energy(h: Field) -> Field:
        t = np.clip((high - h) / (high - low), 0.0, 1.0)
        return strength * ((high - low) * t**3 * (1 - t / 2) + np.maximum(low - h, 0.0))

    return CohesiveLaw("dugdale", work, strength, reach, tension, softening, energy)


Field = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FORCING = 1e-3  # tolerance of MINRES relative to the residual of Newton's method
_DIRECTION = 1e-10  # tolerance of the response to the penetration, nearly singular close to a fold
_ROUNDS = 2000
_LEAST_SHARE = 1e-3


@dataclass(frozen=True)
class CohesiveContact:
    """One equilibrium of an adhesive contact.

    Attributes
    ----------
    penetration, force : float
        d (negative before first touch) and F (negative when pulling).
    pressure : ndarray, shape (nx, ny)
        Cell values; negative in tension.
    gap : ndarray
        Remaining gap, zero in contact.
    mask : ndarray of bool
        Cells in contact.
    iterations : int
        Number of Newton steps.
    residual : float
        Largest error of a gap relative to the reach of the law, or of a tension relative to its
        strength.
    """

    penetration: float
    force: float
    pressure: Field = field(repr=False)
    gap: Field = field(repr=False)
    mask: Mask = field(repr=False)
    iterations: int
    residual: float


class CohesiveProblem:
    """A half-space, the gap of a rigid body and a cohesive law.

    Parameters
    ----------
    operator : FreeOperator or PeriodicOperator
        The grid must resolve the zone in which the tension falls: its width is about
        0.8 E* w/sigma(0)^2 at the edge of a contact, two cells across it give errors of some per
        cent.
    gap : array_like, shape (nx, ny)
        Initial gap g >= 0; +inf outside the body.
    law : CohesiveLaw
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

    def force(self, pressure: Field) -> float:
        """Return the sum of the pressures times the cell area."""
        return float(pressure.sum()) * self.operator.cell_area

    def at_penetration(
        self,
        penetration: float,
        start: Field | None = None,
        tolerance: float = 1e-8,
        max_iterations: int = 40,
    ) -> CohesiveContact:
        """Return the equilibrium at a penetration that Newton's method reaches from the start.

        Raises
        ------
        ConvergenceError
            If it does not converge; beyond a fold there is no equilibrium nearby.
        """
        refuse(effort_faults(tolerance, max_iterations))
        fixed = Constraint(1.0, 0.0, penetration)
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
        self,
        force: float,
        penetration: float,
        start: Field,
        tolerance: float = 1e-8,
        max_iterations: int = 40,
    ) -> CohesiveContact:
        """Return the equilibrium at a force, from a penetration and pressures close to it."""
        refuse(effort_faults(tolerance, max_iterations))
        fixed = Constraint(0.0, 1.0, force)
        return self.newton(start, penetration, fixed, tolerance, max_iterations)

    def newton(
        self,
        pressure: Field,
        penetration: float,
        constraint: Constraint,
        tolerance: float,
        max_iterations: int,
    ) -> CohesiveContact:
        """Return an equilibrium that satisfies the constraint, by Newton's method."""
        history: list[float] = []
        for _ in range(max_iterations):
            state = _Linearised(self, pressure, penetration)
            missing = constraint.missing(penetration, self.force(pressure))
            history.append(max(state.error, abs(missing) / constraint.unit(self)))
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
            if constraint.of_force == 0:
                depth = missing / constraint.of_penetration
                pressure = pressure + state.change(depth, with_residual=True)
            else:
                fixed = state.change(0.0, with_residual=True)
                per_depth = state.change(1.0, with_residual=False)
                rate = constraint.of_penetration + constraint.of_force * self.force(per_depth)
                depth = (missing - constraint.of_force * self.force(fixed)) / rate
                pressure = pressure + fixed + depth * per_depth
            penetration += depth
        raise ConvergenceError("Newton's method found no adhesive equilibrium nearby", history)

    def stiffness(self, contact: CohesiveContact) -> float:
        """Return dF/dd at an equilibrium, the slope of the path."""
        state = _Linearised(self, contact.pressure, contact.penetration)
        return self.force(state.change(1.0, with_residual=False))


@dataclass(frozen=True)
class Constraint:
    """of_penetration * d + of_force * F = value."""

    of_penetration: float
    of_force: float
    value: float

    def missing(self, penetration: float, force: float) -> float:
        """Return the value less the left side."""
        return self.value - self.of_penetration * penetration - self.of_force * force

    def unit(self, problem: CohesiveProblem) -> float:
        """Return the scale of the left side: the reach of the law, and its strength on one cell."""
        law = problem.law
        cell = law.strength * problem.operator.cell_area
        return abs(self.of_penetration) * law.reach + abs(self.of_force) * cell


class _Linearised:
    """Newton's equations about one iterate."""

    def __init__(self, problem: CohesiveProblem, pressure: Field, penetration: float) -> None:
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

    def change(self, depth: float, *, with_residual: bool) -> Field:
        """Return the change of the pressures with the penetration, with or without the residual."""
        apply, weight = self.problem.operator.apply, self.weight
        right = np.full(weight.shape, -depth)
        if with_residual:
            right += np.where(self.contact, self.gap, 0.0) - apply(self.residual)
        shape = weight.shape

        def act(flat: Field) -> Field:
            z = flat.reshape(shape)
            return (np.where(self.contact, 0.0, z) - weight * apply(weight * z)).ravel()

        system = LinearOperator((weight.size, weight.size), matvec=act, dtype=float)
        rtol = _FORCING * min(1.0, self.error) if with_residual else _DIRECTION
        right = (weight * right).ravel()
        size = float(np.linalg.norm(right))
        z = np.zeros_like(right)
        if size > 0:
            # SciPy adds the norm of the right-hand side to its estimate of the matrix norm and
            # divides the residual by it: a large one (a small unit of length) would end early
            unit = 2.0 ** np.round(np.log2(size))
            z = unit * minres(system, right / unit, rtol=max(rtol, 1e-12), maxiter=_ROUNDS)[0]
        return weight * z.reshape(shape) - (self.residual if with_residual else 0.0)
