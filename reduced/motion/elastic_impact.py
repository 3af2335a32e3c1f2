"""Impact of a rigid mass on a reduced contact (Fig. 19.4) from energy, without time stepping."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from reduced.arguments import increasing_faults, nonnegative_faults, positive_faults, refuse
from reduced.errors import ConvergenceError
from reduced.motion.contact import impact_depth, spring_contact
from reduced.profiles.quadrature import gauss_legendre
from reduced.springs.line import Springs

_ITERATIONS = 200
_NODES = 48
_NEAR = 0.02  # fraction of the depth in which energy differences lose digits


class ContactLaw(Protocol):
    """A contact law with force, energy and stiffness of penetrations, like `SpringContact`."""

    def respond(self, penetration: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return force, energy, stiffness of an array of penetrations."""


@dataclass(frozen=True)
class ElasticImpact:
    """Impacts of one mass at k velocities; all arrays have shape (k,).

    Attributes
    ----------
    velocity : ndarray
        Velocity before the impact.
    duration : ndarray
        Time in contact.
    penetration, force : ndarray
        Largest penetration and largest force.
    restitution : ndarray
        Ratio of the speeds after and before: 1, because the springs conserve energy.
    """

    velocity: np.ndarray
    duration: np.ndarray
    penetration: np.ndarray
    force: np.ndarray
    restitution: np.ndarray


def strike(springs: Springs, mass: float, velocity: ArrayLike, load: float = 0.0) -> ElasticImpact:
    """Solve the impact of a rigid mass with a profile on springs: m x'' = f - F(x).

    Parameters
    ----------
    springs : Springs
        The profile and its springs, sized for the largest velocity.
    mass : float
        m.
    velocity : array_like, shape (k,)
        At first touch; positive, strictly increasing.
    load : float
        Constant force f >= 0 on the mass during the impact (its weight).

    Raises
    ------
    ConvergenceError
        If the contact stops the mass at no depth.

    Examples
    --------
    >>> from reduced.profiles.equivalents import paraboloid
    >>> hertz = strike(Springs(paraboloid(1.0), 1.0), 1.0, 1e-3)
    >>> round(float(hertz.duration[0] * 1e-3 / hertz.penetration[0]), 4)  # Hertz: 2.9432 d/v
    2.9433
    """
    speeds = _checked(mass, velocity, load)
    energy = 0.5 * mass * float(speeds[-1]) ** 2
    deepest = impact_depth(springs.profile, springs.effective_modulus, energy, load)
    return rebound(spring_contact(springs, deepest), mass, speeds, deepest, load)


def rebound(
    law: ContactLaw, mass: float, velocity: ArrayLike, deepest: float, load: float = 0.0
) -> ElasticImpact:
    """Solve the impact of a mass on any conservative contact law.

    The largest penetration d solves U(d) - f d = m v^2/2; the time is 2 int_0^d dx/w with
    m w^2/2 = U(d) - U(x) - f (d - x), integrated over x = d sin^2(t), without singularities.

    Parameters
    ----------
    law : ContactLaw
        Springs under a profile or a line.
    velocity : array_like, shape (k,)
    deepest : float
        A penetration near the largest one, to start the search.
    load : float
        f.
    """
    speeds = _checked(mass, velocity, load)
    energy = 0.5 * mass * speeds**2
    # the turning points, by Newton's method from the deep side, where U(d) - f d is convex
    depth = np.full(energy.shape, float(deepest))
    for _ in range(_ITERATIONS):
        short = law.respond(depth)[1] - load * depth < energy
        if not short.any():
            break
        depth[short] *= 2
    history: list[float] = []
    for _ in range(_ITERATIONS):
        force, stored, _ = law.respond(depth)
        step = (stored - load * depth - energy) / (force - load)
        history.append(float(np.max(np.abs(step) / depth)))
        depth = depth - step
        # quadratic convergence, until rounding limits the step
        if history[-1] <= 4 * np.finfo(float).eps or (
            history[-1] < 1e-13 and len(history) > 1 and history[-1] >= history[-2]
        ):
            break
    else:
        raise ConvergenceError("the largest penetration was not found", history)
    nodes, weights = gauss_legendre(_NODES)
    angle = np.pi / 2 * nodes
    approach = depth[:, None] * np.cos(angle) ** 2  # d - x, without cancellation
    x = depth[:, None] * np.sin(angle) ** 2
    # U(d) - U(x), near d as an integral of the force to keep its digits
    c, shares = gauss_legendre(8)
    mean = law.respond(x[..., None] + approach[..., None] * c)[0] @ shares
    far = law.respond(depth[:, None])[1] - law.respond(x)[1]
    near = approach < _NEAR * depth[:, None]
    released = np.where(near, mean * approach, far) - load * approach
    speed = np.sqrt(2 / mass * released)
    swept = depth[:, None] * np.sin(2 * angle) / speed
    duration = 2 * (np.pi / 2) * (swept @ weights)
    if not np.isfinite(duration).all():
        raise ConvergenceError("the impact has no finite duration", duration.tolist())
    force = law.respond(depth)[0]
    return ElasticImpact(speeds, duration, depth, force, np.ones(speeds.size))


def _checked(mass: float, velocity: ArrayLike, load: float) -> np.ndarray:
    wrong = positive_faults(mass=mass) + increasing_faults(velocity=velocity)
    refuse(wrong + nonnegative_faults(load=load))
    return np.array(velocity, dtype=float, ndmin=1)
