r"""Round contacts on layered bodies, from an integral equation over the contact.

A rigid body of revolution, whose section f gives the line g = x int_0^x f'(r)/sqrt(x^2 - r^2) dr,
touches a half-space of modulus E within r <= a. The pressure summed along a line, s(x) = 2
int_x^a p r/sqrt(r^2 - x^2) dr, is then E (d - g(x)). Over layers (N. N. Lebedev and Ia. S.
Ufliand, PMM 22 (1958) 442) it obeys

    s(x) + int_-a^a K(x - t) s(t) dt = E1 (d - g(x)),
    K(x) = (1/pi) int_0^inf (M(q) - 1) cos(q x) dq,

with M as in `Stack.softening`, and it vanishes at the edge of a smooth contact, which gives d. Sums
of even Legendre polynomials solve it: their transforms are spherical Bessel functions, and they
crowd at the edge, where thin layers have their boundary layer. Force 2 int_0^a s dx; dF/dd is that
of the flat punch of the same radius. This shares the compliance with the grid solvers, and nothing
else.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from scipy.optimize import brentq
from scipy.special import beta, eval_legendre, spherical_jn

from reference.arrays import Array
from reference.closed_form.numerics import gauss_rule
from reference.errors import ConvergenceError, choice_faults, positive_faults, refuse
from reference.layered.stack import Graded, Stack

Line = Callable[[Array], Array]

# Short waves that see only the uppermost layer, in its thickness: exp(-2 x 14) = 1e-12.
_SHORT = 14.0
# Values of Bessel functions that are held at once: 0.1 GB with what they are made of.
_AT_ONCE = 2**22


@dataclass(frozen=True)
class RoundStep:
    """A round contact of one radius; `stiffness` is dF/dd on the fixed contact."""

    contact_radius: float
    penetration: float
    force: float
    stiffness: float
    energy: float


@dataclass(frozen=True)
class RoundContact:
    """A rigid body of revolution on a stack of layers.

    A paraboloid of radius 1, g = x^2, on a half-space is Hertz's:

    >>> from reference.elasticity import Material
    >>> ball = RoundContact(Stack([], [], Material(1 - 0.3**2, 0.3)), lambda x: x**2)
    >>> step = ball.at_radius(0.5)
    >>> float(round(step.penetration, 12)), float(round(step.force, 12))
    (0.25, 0.166666666667)
    """

    body: Stack
    line: Line  # g(x) of the section for x >= 0, 0 at x = 0 and increasing
    edge: float = np.inf  # radius at which the body ends in a sharp edge

    def at_radius(self, contact_radius: float) -> RoundStep:
        """Return the smooth contact of a radius."""
        a = float(contact_radius)
        # so many polynomials, and more by the root of radius over thickness
        thin = a / min(self.body.thicknesses, default=np.inf)
        number = int(16 + 3.0 * np.sqrt(thin))
        n = np.arange(number)[:, None]

        # the equation in even Legendre polynomials of x/a
        matrix = np.diag(1.0 / (4 * n[:, 0] + 1))
        if self.body.thicknesses:
            # Gauss points for what varies with log q or with cos 2q: twelve on each of 44 panels
            # below q = 1, each half of the next, and above 40 on each panel of length 40
            reach = _SHORT * a / self.body.thicknesses[0]
            first = min(1.0, reach)
            small = np.append(0.0, first * 0.5 ** np.arange(44, -1, -1.0))
            large = np.linspace(first, reach, int(np.ceil((reach - first) / 40.0)) + 1)
            points = []
            for ends, count in ((small, 12), (large, 40)):
                nodes, weights = gauss_rule(count)
                half = np.diff(ends)[:, None] / 2
                points.append(
                    [(ends[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()]
                )
            q, weights = np.concatenate(points, axis=1)
            weights *= 2 / np.pi * self._excess(q / a)
            for part in np.array_split(np.arange(q.size), 1 + q.size * number // _AT_ONCE):
                # (-1)^n j_2n(q), the transforms of P_2n
                x = q[part]
                near, bessel = x < 2 * number, np.empty((number, x.size))
                bessel[:, near] = spherical_jn(2 * n, x[near])
                # upwards, which is stable below the argument
                far = x[~near]
                lower, order = np.cos(far) / far, np.sin(far) / far
                for k in range(2 * number - 1):
                    if k % 2 == 0:
                        bessel[k // 2, ~near] = order
                    lower, order = order, (2 * k + 1) / far * order - lower
                bessel *= (-1.0) ** n
                matrix += (bessel * weights[part]) @ bessel.T

        # solved in units of the modulus for two sides: one, and the line
        nodes, weights = gauss_rule(4 * number)
        x, weights = (nodes + 1) / 2, weights / 2
        basis = eval_legendre(2 * n, x)
        height = self.line(a * x)
        sides = np.stack([basis @ weights, basis @ (weights * height)], axis=1)
        solved = np.linalg.solve(matrix, sides)

        # the part that the layers add is smooth: its polynomials sum up at the edge
        added = (solved - sides * (4 * n + 1)).sum(axis=0)
        depth = (float(self.line(np.array([a]))[0]) + added[1]) / (1 + added[0])
        unit = 2 * a * self.body.top.effective_modulus
        mean = unit * solved[0]
        # half of int s (d - g), of which sides are the polynomials
        moment = unit * (sides[:, 1] @ (depth * solved[:, 0] - solved[:, 1]))
        force = depth * mean[0] - mean[1]
        energy = (force * depth - moment) / 2
        return RoundStep(a, depth, float(force), float(mean[0]), float(energy))

    def at(self, control: str, value: float, guess: float, tolerance: float = 1e-13) -> RoundStep:
        """Return the contact at a penetration or a force, whichever `control` names.

        The tolerance is that of the radius. ConvergenceError if no radius has it.
        """
        at_radius = cache(self.at_radius)
        low = high = at_radius(min(guess, self.edge))
        for _ in range(200):
            if getattr(low, control) <= value <= getattr(high, control):
                break
            if getattr(low, control) > value:
                high, low = low, at_radius(low.contact_radius / 2)
            elif high.contact_radius == self.edge:
                # the whole face: a flat punch takes what is added
                depth, force = value, high.force + high.stiffness * (value - high.penetration)
                if control == "force":
                    depth, force = high.penetration + (value - high.force) / high.stiffness, value
                work = (force + high.force) / 2 * (depth - high.penetration)
                return replace(high, penetration=depth, force=force, energy=high.energy + work)
            else:
                wider = min(2 * high.contact_radius, self.edge)
                low, high = high, at_radius(wider)
        else:
            raise ConvergenceError(f"no contact radius has a {control} of {value:g}", [])
        if low is high:
            return low

        def over(a: float) -> float:
            # loads go with powers of the radius between one and three: a cube root is nearly
            # straight, and zero below a flat face
            return float(np.cbrt(getattr(at_radius(a), control) / value) - 1)

        for end in (low, high):
            if abs(over(end.contact_radius)) <= np.finfo(float).eps:  # the sign is rounding
                return end
        radius = brentq(
            over,
            *(low.contact_radius, high.contact_radius),
            xtol=tolerance * low.contact_radius,
            rtol=tolerance,
        )
        return at_radius(radius)

    @cached_property
    def _excess(self) -> Line:
        # long waves to 1e-12 of the thickness of all layers
        return self.body.softening(1e-12 / self.body.total, _SHORT / self.body.thicknesses[0])


def line_factor(exponent: float, grading: float = 0.0) -> float:
    """G over f for a section f ~ r^n: (n/2) B(n/2, (1 + k)/2), two for a paraboloid and k = 0.

    >>> round(line_factor(2.0), 12)
    2.0
    """
    return float(exponent / 2 * beta(exponent / 2, (1 + grading) / 2))


def face_stiffness(body: Graded, radius: float) -> float:
    """F/d of a flat circular face: 2 c_N a^(1+k)/((1 + k) c0^k)."""
    k = body.exponent
    return float(2 * body.spring_modulus * radius * (radius / body.depth) ** k / (1 + k))


@dataclass(frozen=True)
class GradedContact:
    """A rigid body of revolution f = c r^n on a graded half-space (Hess 2016).

    d = kappa c a^n, and F is the integral of c_N |x/c0|^k (d - g) over the contact; Giannakopoulos
    & Suresh (1997) have the cone and the paraboloid.

    Hertz, k = 0:

    >>> from reference.elasticity import Material
    >>> ball = GradedContact(Graded(Material(0.75, 0.5), 0.0, 1.0), 2.0, 0.5)
    >>> round(ball.at("penetration", 0.25).force, 12)
    0.166666666667
    """

    body: Graded
    # n and c
    exponent: float
    coefficient: float

    def __post_init__(self) -> None:
        refuse(positive_faults(exponent=self.exponent, coefficient=self.coefficient))

    def at_radius(self, contact_radius: float) -> RoundStep:
        """Return the contact of a radius."""
        n, k, a = self.exponent, self.body.exponent, contact_radius
        depth = line_factor(n, k) * self.coefficient * a**n
        stiffness = face_stiffness(self.body, a)
        force = stiffness * depth * n / (n + k + 1)
        return RoundStep(a, depth, force, stiffness, force * depth * n / (2 * n + k + 1))

    def at(self, control: str, value: float) -> RoundStep:
        """Return the contact at a penetration or a force, whichever `control` names."""
        refuse(choice_faults("control", control, ("penetration", "force")))
        power = self.exponent + (self.body.exponent + 1 if control == "force" else 0)
        unit = self.at_radius(1.0)
        return self.at_radius(float((value / getattr(unit, control)) ** (1 / power)))
