"""Partial slip of a frictional contact from its normal solution: along a path, and in torsion.

Cattaneo (1938) and Mindlin (1949) for spheres, Jaeger (1995, 1998) and Ciavarella (1998) for every
body of revolution: under a constant normal force the tangential tractions are mu times the
difference of two normal pressures of the same body,

    q(r) = mu [p(r; d) - p(r; d_c)],   G* u = mu E* (d - d_c),   F_x = mu [F(d) - F(d_c)],

and the stick area is the contact area at d_c. Along a path with reversals the tractions are a sum
of such terms, one per turning point still remembered, with twice the friction after the first: a
reversal must first undo the slip (Mindlin & Deresiewicz 1953).

Exact within two assumptions: no coupling of normal and tangential displacement (elastically similar
bodies, or nu = 1/2 on a rigid one), and friction that acts along x only; the true slip has a
component along y for nu > 0. For nu = 0 without coupling the second is exact, and the superposition
holds for every shape, also rough ones, because both operators are equal.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, ellipk

from reference.arrays import Array
from reference.closed_form.form import ClosedForm, keep_positive, require_positive
from reference.closed_form.numerics import gauss_rule
from reference.errors import poisson_faults, refuse

# A reversal smaller than the friction by this factor is below the rounding of the forces.
_ROUNDING = 16 * np.finfo(float).eps


def stiffness_ratio(half_x: float, half_y: float, poisson_ratio: float) -> float:
    """Return k_x/k_z of a sticking elliptic contact without coupling (Mindlin 1949).

    The semi-axes are a along the tangential force and b transverse to it. A traction ~
    1/sqrt(1 - (x/a)^2 - (y/b)^2) displaces the ellipse uniformly. At its centre, in polar
    coordinates, pressure and traction differ by the factor (1 - nu + nu cos^2)/(1 - nu) only, so

        k_x/k_z = (1 - nu)/(1 - nu + nu s),   s = <cos^2> = [K(m) - E(m)]/(m K(m)),

    m = 1 - b^2/a^2 for a >= b; for a < b, s is one minus the value of the exchanged axes. A circle
    has s = 1/2: (19.18).

    >>> round(stiffness_ratio(1.0, 1.0, 0.5), 12)  # 2 (1 - nu)/(2 - nu)
    0.666666666667
    """
    require_positive("stiffness ratio", half_x=half_x, half_y=half_y)
    refuse(poisson_faults(poisson_ratio))
    short, long = sorted((half_x, half_y))
    m = (1 - short / long) * (1 + short / long)
    # series for small m, where K - E loses digits
    share = (ellipk(m) - ellipe(m)) / (m * ellipk(m)) if m > 1e-5 else 0.5 + m / 16
    along = float(share if half_x >= half_y else 1 - share)
    return (1 - poisson_ratio) / (1 - poisson_ratio + poisson_ratio * along)


class Term(NamedTuple):
    """One term of the superposition, factor mu [p(d) - p(d_c)]; d_c has the force `inner`."""

    factor: float
    inner: float


@dataclass(frozen=True)
class PartialSlip:
    """A contact under constant normal force and any tangential path.

    Exact for bodies of revolution. The `friction` is mu, the `modulus_ratio` G*/E*,
    2 (1 - nu)/(2 - nu) for one elastic body on a rigid one.

    Cattaneo-Mindlin: c = a (1 - F_x/(mu F))^(1/3).

    >>> from reference.closed_form import paraboloid
    >>> slip = PartialSlip(paraboloid(1.0, 1.0), penetration=1.0, friction=0.5, modulus_ratio=0.8)
    >>> round(float(slip.along([7 / 12]).stick_radius[0]), 12)
    0.5
    """

    form: ClosedForm
    penetration: float
    friction: float
    modulus_ratio: float

    def __post_init__(self) -> None:
        keep_positive("partial slip", vars(self))

    @cached_property
    def force(self) -> float:
        """The normal force F."""
        return float(self.form.force(self.penetration))

    @property
    def limit(self) -> float:
        """Tangential force mu F of full sliding."""
        return self.friction * self.force

    def along(self, tangential_force: ArrayLike) -> PartialSlipPath:
        """Return the response along a path of tangential forces (k,), monotone between them.

        A force that is not finite or above mu F raises ValueError.
        """
        path = np.atleast_1d(np.asarray(tangential_force, dtype=float))
        force, limit = self.force, self.limit
        if not (np.abs(path) <= limit * (1 + _ROUNDING)).all():
            raise ValueError(
                f"tangential forces must be finite and at most mu F = {limit!r}, "
                f"not {tangential_force!r}"
            )
        states: list[tuple[Term, ...]] = []
        terms: list[Term] = []
        at = 0.0
        for goal in np.clip(path, -limit, limit).tolist():
            if abs(goal - at) > _ROUNDING * limit:
                sign = 1.0 if goal > at else -1.0
                if terms and sign * terms[-1].factor > 0:  # the slip zone grows on
                    terms.pop()
                # The new slip zone grows into the stick zone from its rim. Where it reaches further
                # in than the last term, that one and the one before are forgotten.
                while True:
                    carried = sum(t.factor * self.friction * (force - t.inner) for t in terms)
                    factor = 2.0 if terms else 1.0
                    inner = force - sign * (goal - carried) / (factor * self.friction)
                    inner = max(inner, 0.0)
                    if not terms or inner > terms[-1].inner:
                        break
                    terms.pop()
                    if terms and sign * terms[-1].factor > 0:
                        terms.pop()
                terms.append(Term(sign * factor, inner))
            states.append(tuple(terms))
            at = goal
        return PartialSlipPath(self, path, tuple(states))


@dataclass(frozen=True)
class PartialSlipPath:
    """Exact response along a path of tangential forces; arrays have shape (k,)."""

    contact: PartialSlip
    tangential_force: Array
    terms: tuple[tuple[Term, ...], ...]  # terms of the tractions at the points of the path

    @property
    def tangential_displacement(self) -> Array:
        """u, relative to the undeformed half-space."""
        contact = self.contact
        scale, depth = contact.friction / contact.modulus_ratio, contact.penetration
        return np.array(
            [
                scale * sum(term.factor * (depth - self._inner_depth(term)) for term in terms)
                for terms in self.terms
            ]
        )

    @property
    def stick_radius(self) -> Array:
        """Radius of the stick area on arrival at the points."""
        form = self.contact.form
        if form.contact_radius is None:
            raise ValueError(f"{form.name}: the stick area is no circle")
        depth = self.contact.penetration
        inner = [self._inner_depth(terms[-1]) if terms else depth for terms in self.terms]
        return np.array([float(form.contact_radius(d)) for d in inner])

    def traction(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Traction q along x at points, after the end of the path."""
        form = self.contact.form
        pressure = form.pressure(x, y, self.contact.penetration)
        total = np.zeros(np.shape(pressure))
        for term in self.terms[-1]:
            inner = form.pressure(x, y, self._inner_depth(term))
            total += term.factor * self.contact.friction * (pressure - inner)
        return total

    def _inner_depth(self, term: Term) -> float:
        """Return the penetration d_c whose contact area is the stick area of a term."""
        return float(self.contact.form.penetration(term.inner))


# Gauss points of an integral over the slip annulus, smooth in the angle.
_POINTS = 400


@dataclass(frozen=True)
class Torsion:
    """A body of revolution under a constant penetration that is twisted once (Lubkin 1951).

    Circumferential tractions have no divergence, so that they neither lift the surface nor depend
    on Poisson's ratio. A disc of radius s that sticks and turns by an angle b carries (Reissner &
    Sagoci 1944)

        q = (4 G b/pi) r/sqrt(s^2 - r^2),    M = (16/3) G s^3 b.

    With discs of radii from c to a, none of which turns points within c against each other, the
    traction is mu p outside c if (an Abel equation)

        b(c) = mu/(2 G) int_c^a p(r)/sqrt(r^2 - c^2) dr,

    the angle by which the circle that sticks has turned; the torque is that of the discs. The
    `friction` is mu, the `shear_modulus` G that of the half-space under a rigid body, or
    1/G = 1/G1 + 1/G2 of two.

    A ball that sticks in half its radius: b = mu p0/(2 G) [K(k) - E(k)], k^2 = 1 - (c/a)^2.

    >>> from reference.closed_form import paraboloid
    >>> ball = Torsion(paraboloid(1.0, 1.0), penetration=1.0, friction=0.3, shear_modulus=0.25)
    >>> exact = 0.3 * (2 / np.pi) / (2 * 0.25) * (ellipk(0.75) - ellipe(0.75))
    >>> round(float(ball.angle(0.5) / exact), 9)
    1.0
    """

    form: ClosedForm
    penetration: float
    friction: float
    shear_modulus: float

    def __post_init__(self) -> None:
        if self.form.contact_radius is None:
            raise ValueError(f"{self.form.name}: torsion is known of round contacts only")
        keep_positive("torsion", vars(self))

    @cached_property
    def contact_radius(self) -> float:
        """The radius a."""
        return float(self.form.semi_axes(self.penetration)[0])

    def angle(self, stick_radius: float) -> float:
        """Return the twist b in radians at which the circle of this radius sticks."""
        return float(self._angles(np.array([stick_radius]))[0])

    def torque(self, stick_radius: float) -> float:
        """Return M = (16/3) G [c^3 b(c) + 3 int_c^a s^2 b(s) ds]."""
        a = self.contact_radius
        nodes, weights = gauss_rule(_POINTS)
        s = stick_radius + (a - stick_radius) * (nodes + 1) / 2
        outer = (a - stick_radius) / 2 * float(weights @ (s**2 * self._angles(s)))
        inner = stick_radius**3 * self.angle(stick_radius)
        return 16 / 3 * self.shear_modulus * (inner + 3 * outer)

    def _angles(self, c: Array) -> Array:
        a = self.contact_radius
        if not ((c > 0) & (c <= a)).all():
            raise ValueError(f"a stick radius lies between 0 and the contact radius {a!r}: {c}")
        nodes, weights = gauss_rule(_POINTS)
        t = np.pi / 4 * (nodes + 1)
        width = np.sqrt((a - c) * (a + c))[:, None]
        # r^2 = c^2 + (a^2 - c^2) sin^2 t
        r = np.sqrt(c[:, None] ** 2 + (width * np.sin(t)) ** 2)
        pressure = self.form.pressure(r, 0.0, self.penetration)
        integral = np.pi / 4 * ((pressure * width * np.cos(t) / r) @ weights)
        return np.asarray(self.friction / (2 * self.shear_modulus) * integral)
