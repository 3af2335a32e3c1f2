"""What a theorem encloses of a scene: force and energy of an indenter, stiffness of a punch.

Two computations that share no code bound the same number from both sides (`reference.bounds`).
Rigid body, no friction, one elastic half-space: what is outside is refused with its reason.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

from comparisons.scene import indenters
from comparisons.scene.scene import Scene
from reference.bounds import axisymmetric, bodies, homogeneous, outlines, punches
from reference.bounds.interval import Interval
from reference.bounds.profiles import PowerLaw, Profile, RoundedPunch, Sphere, cone, paraboloid


class Unproved(Exception):  # noqa: N818 - no error: for most scenes there is no theorem
    """Raised where no theorem of `reference.bounds` covers a scene, with the reason."""


@dataclass(frozen=True)
class Proof:
    """Enclosures of one indenter at a penetration.

    Attributes
    ----------
    force, energy : callable
        ``force(penetration) -> Interval``, in SI units.
    stiffness : callable or None
        Of dF/dd; None where the theorems say nothing sharp about it.
    """

    force: Callable[[float], Interval]
    energy: Callable[[float], Interval]
    stiffness: Callable[[float], Interval] | None


def proof_of(scene: Scene) -> Proof:
    """Return the enclosures of a scene.

    Raises
    ------
    Unproved
        With the reason.
    """
    if scene.indenter is None:
        raise Unproved(
            "of rough surfaces only the experiments `rough-force-on-grid` and "
            "`rough-penetration-on-grid` prove bounds"
        )
    if scene.body is not None:
        raise Unproved("the theorems are for a half-space, and the [body] is finite")
    if scene.physics:
        raise Unproved(
            "the theorems are for a rigid body without friction, adhesion or memory, at rest"
        )
    return _proof(scene.indenter, scene.effective_modulus)


def _proof(indenter: indenters.Indenter, modulus: float) -> Proof:
    profile = _profile(indenter)
    if profile is not None:
        return _round(profile, modulus)
    if isinstance(indenter, indenters.Ellipsoid):
        return _homogeneous(bodies.Paraboloid(indenter.radius_x, indenter.radius_y), modulus)
    return _punch(_stiffness(indenter), modulus)


def _profile(indenter: indenters.Indenter) -> Profile | None:
    if isinstance(indenter, indenters.Paraboloid):
        return paraboloid(indenter.radius)
    if isinstance(indenter, indenters.Sphere):
        return Sphere(indenter.radius)
    if isinstance(indenter, indenters.Cone):
        return cone(indenter.slope)
    if isinstance(indenter, indenters.RoundedPunch):
        return RoundedPunch(indenter.flat_radius, indenter.edge_radius)
    if isinstance(indenter, indenters.PowerLaw):
        if indenter.exponent < 1:
            raise Unproved("the bounds are for convex bodies, f = c r^n with n >= 1")
        return PowerLaw(indenter.exponent, indenter.coefficient)
    return None


def _round(profile: Profile, modulus: float) -> Proof:
    degree = profile.degree
    if degree is None:
        return Proof(
            lambda d: axisymmetric.force(profile, d, modulus),
            lambda d: axisymmetric.energy(profile, d, modulus),
            None,
        )
    # a power law has no length: one penetration serves for all
    unit = axisymmetric.energy(profile, 1.0, modulus)
    return _scaling(degree, unit)


def _homogeneous(body: bodies.Body, modulus: float) -> Proof:
    n = body.degree
    force = homogeneous.force(body, 1.0, modulus)
    return _scaling(float(n), force * (n / (2 * n + 1)))


def _scaling(degree: float, unit: Interval) -> Proof:
    """Enclosures by the energy at a penetration of 1, which grows as d^(2 + 1/n)."""
    power = 2 + 1 / degree
    return Proof(
        lambda d: unit * (power * d ** (power - 1)),
        lambda d: unit * d**power,
        lambda d: unit * (power * (power - 1) * d ** (power - 2)),
    )


def _punch(stiffness: Interval, modulus: float) -> Proof:
    return Proof(
        lambda d: stiffness * (modulus * d),
        lambda d: stiffness * (0.5 * modulus * d * d),
        lambda d: stiffness * modulus,
    )


@lru_cache(maxsize=32)
def _stiffness(indenter: indenters.Indenter) -> Interval:
    """Stiffness k/E* of a flat punch."""
    if isinstance(indenter, indenters.Cylinder):
        return axisymmetric.disc_stiffness(indenter.radius, 1.0)
    if isinstance(indenter, indenters.RightAngledPunch):
        sides = indenter.lengths
        return punches.bounded(
            outlines.rectangle(*sides, _AROUND[0], punches.DISPLACEMENT_EXPONENT),
            outlines.rectangle(*sides, _AROUND[1], punches.PRESSURE_EXPONENT),
            _CELLS,
        )
    if isinstance(indenter, indenters.PolygonPunch):
        return _of_polygon([(float(x), float(y)) for x, y in indenter.corners])
    raise Unproved(f"no bound is computed for a {type(indenter).__name__.lower()}")


# From the origin to the edge, and around half a side: of the upper and of the lower bound.
_CELLS, _AROUND = (8, 10), (5, 8)


def _of_polygon(corners: list[tuple[float, float]]) -> Interval:
    try:
        coarse = outlines.polygon(corners, 3, punches.DISPLACEMENT_EXPONENT)
        fine = outlines.polygon(corners, 4, punches.PRESSURE_EXPONENT)
    except ValueError as fault:
        raise Unproved(f"polygons are bounded about their centroid: {fault}") from fault
    return punches.bounded(coarse, fine, (6, 8))
