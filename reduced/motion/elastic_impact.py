"""The contact of Fig. 19.4, and impacts of a rigid mass on it from energy, without time steps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reduced.errors import ConvergenceError, list_faults, positive_faults, refuse
from reduced.profiles.quadrature import gauss_legendre
from reduced.profiles.section import Profile
from reduced.springs.indent import fall
from reduced.springs.line import Springs

_NEAR = 0.02  # fraction of the depth in which energy differences lose digits


_LEAST, _MOST = 1e-150, 1e150  # beyond this, energies exceed the range of floating point


class SpringContact:
    """A profile on springs for penetrations up to `deepest`, to which `per_radius` refers.

    Deeper, the last cell is continued.

    >>> from reduced.profiles.equivalents import paraboloid
    >>> ball = SpringContact(Springs(paraboloid(1.0), 1.0), 0.25)
    >>> force, energy, stiffness = ball.respond(0.25)
    >>> round(float(force), 12), round(float(stiffness), 12)  # (4/3) E* sqrt(R) d^1.5, 2 E* a
    (0.166666666667, 1.0)
    """

    def __init__(self, springs: Springs, deepest: float) -> None:
        refuse(positive_faults(deepest=deepest))
        self.line = springs.lay(float(springs.profile.contact_radius(deepest)))
        self.effective_modulus = float(springs.effective_modulus)

    def respond(self, penetration: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return force, energy and stiffness dF/dd = E* times the contact length; 0 for d <= 0."""
        d = np.asarray(penetration, dtype=float)
        flat = d.ravel()
        touching = flat > 0
        out = np.zeros((3, flat.size))
        out[:, touching] = self.effective_modulus * np.array(self.line.respond(flat[touching]))
        stiffness, force, energy = (row.reshape(d.shape) for row in out)
        return force, energy, stiffness


def impact_depth(
    profile: Profile, effective_modulus: float, kinetic_energy: float, load: float = 0.0
) -> float:
    """Return a penetration at most 1 % beyond that at which the springs stop the mass.

    It sizes the springs for the motion, with few springs. `kinetic_energy` is m v^2/2 at first
    touch, 0 if only the constant load on the mass (its weight) moves it.
    """
    wrong = positive_faults(effective_modulus=effective_modulus)
    if not (min(kinetic_energy, load) >= 0 and 0 < kinetic_energy + load < np.inf):
        wrong.append(f"expected kinetic energy or load, got {kinetic_energy!r} and {load!r}")
    refuse(wrong)
    few = Springs(profile, effective_modulus, per_radius=8)

    def stops(depth: float) -> bool:
        contact = SpringContact(few, depth)
        return bool(contact.respond(depth)[1] - load * depth >= kinetic_energy)

    depth, factor = float(profile.length), 4.0
    while stops(depth) and depth > _LEAST:
        depth /= factor
    while factor > 1.01:
        while not stops(depth):
            depth *= factor
            if not depth < _MOST:
                raise ConvergenceError("the contact stops the mass at no depth", [kinetic_energy])
        depth, factor = depth / factor, np.sqrt(factor)
    return depth * factor**2


@dataclass(frozen=True)
class ElasticImpact:
    """Impacts of one mass at k velocities, shape (k,).

    Penetration and force are the largest, the duration is that of contact. The restitution is 1,
    because the springs conserve energy.
    """

    velocity: np.ndarray
    duration: np.ndarray
    penetration: np.ndarray
    force: np.ndarray
    restitution: np.ndarray


def strike(springs: Springs, mass: float, velocity: ArrayLike) -> ElasticImpact:
    """Solve the impact of a rigid mass with a profile on springs: m x'' = -F(x).

    Velocities at first touch are positive and strictly increasing, shape (k,); the springs are
    sized for the largest. The largest penetration d solves U(d) = m v^2/2; the time is
    2 int_0^d dx/w with m w^2/2 = U(d) - U(x), integrated over x = d sin^2(t), without
    singularities.

    >>> from reduced.profiles.equivalents import paraboloid
    >>> hertz = strike(Springs(paraboloid(1.0), 1.0), 1.0, 1e-3)
    >>> round(float(hertz.duration[0] * 1e-3 / hertz.penetration[0]), 4)  # Hertz: 2.9432 d/v
    2.9433
    """
    refuse(positive_faults(mass=mass) + list_faults(increasing=True, velocity=velocity))
    speeds = np.array(velocity, dtype=float, ndmin=1)
    energy = 0.5 * mass * speeds**2
    deepest = impact_depth(
        springs.profile, springs.effective_modulus, 0.5 * mass * float(speeds[-1]) ** 2
    )
    law = SpringContact(springs, deepest)
    # the turning points, by Newton's method from the deep side, where U(d) is convex
    depth = np.full(energy.shape, deepest)
    for _ in range(200):
        short = law.respond(depth)[1] < energy
        if not short.any():
            break
        depth[short] *= 2

    def step(d: np.ndarray) -> np.ndarray:
        force, stored, _ = law.respond(d)
        return (stored - energy) / force

    depth = fall(step, depth, "the largest penetration was not found")
    nodes, weights = gauss_legendre(48)
    angle = np.pi / 2 * nodes
    approach = depth[:, None] * np.cos(angle) ** 2  # d - x, without cancellation
    x = depth[:, None] * np.sin(angle) ** 2
    # U(d) - U(x), near d as an integral of the force to keep its digits
    c, shares = gauss_legendre(8)
    mean = law.respond(x[..., None] + approach[..., None] * c)[0] @ shares
    far = law.respond(depth[:, None])[1] - law.respond(x)[1]
    near = approach < _NEAR * depth[:, None]
    speed = np.sqrt(2 / mass * np.where(near, mean * approach, far))
    swept = depth[:, None] * np.sin(2 * angle) / speed
    duration = 2 * (np.pi / 2) * (swept @ weights)
    if not np.isfinite(duration).all():
        raise ConvergenceError("the impact has no finite duration", duration.tolist())
    force = law.respond(depth)[0]
    return ElasticImpact(speeds, duration, depth, force, np.ones(speeds.size))
