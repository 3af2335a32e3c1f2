"""Proved bounds of a scene's force, energy and stiffness.

Two computations that share no code bound the same number from both sides (`reference.bounds`). The
theorems cover a rigid convex body or a rough surface on one elastic half-space without friction;
other scenes are refused with the reason. Free rough patches are bounded by a linear programme and
its dual, periodic surfaces by energies at some mean pressures; their rigid surface is the
band-limited function through its points, which grids only sample.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from scipy.spatial import ConvexHull
from threadpoolctl import threadpool_limits

from comparisons.facts.quantities import quantity
from comparisons.facts.quantities.rows import ENCLOSED
from comparisons.formatting import told_apart
from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.normal.grid import SMALL_BALL, ball
from comparisons.methods.solver import Refused
from comparisons.scene.indenters import axisymmetric as round_shapes
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.indenters.not_round import Ellipsoid, EllipticPunch
from comparisons.scene.loading import AbsoluteLoads
from comparisons.scene.scene import Scene
from reference.bounds import flat_faces, homogeneous, revolution
from reference.bounds.ellipses import elliptic_stiffness
from reference.bounds.interval import POWER, Interval, above, below
from reference.bounds.patches import Patch
from reference.bounds.periodic import PeriodicSurface
from reference.bounds.revolution import (
    ConvexGap,
    cone,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
)
from reference.contact.press import SHORTEST_COARSENED

At = Callable[[float], Interval]
# Of penetration and force, one of which is given and the other an interval.
Of = Callable[[Interval, Interval], Interval]

# From the origin to the edge, for a tolerance of 1 %: rings and elements of bodies of revolution;
# elements of the upper bound and cells of the lower one of ellipsoids and of flat faces. All three
# enclose to about a tenth of that, in less than half a second where no side is over ten
# times the other. Elements and time grow with the ratio of the sides, and beyond these (about 4 s
# and 3 s at a tolerance of 1 %) so does the width of the interval.
_ROUND, _ELLIPTIC, _FACE = 16, (6, 8), (8, 12)
_SLENDER_CONTACT, _SLENDER_FACE = 60.0, 30.0


@dataclass(frozen=True)
class Proof:
    """Intervals that theorems prove for an indenter, computed on request."""

    force: At  # ``force(penetration) -> Interval``, in SI units
    penetration: At  # at a force
    # ``energy(penetration, force) -> Interval``, of which one is given and the other enclosed.
    energy: Of
    stiffness: Of
    # Largest penetration and force at which anything is proved.
    deepest: float = math.inf
    heaviest: float = math.inf


def enclosures(scene: Scene, geometry: Geometry, loads: AbsoluteLoads) -> dict[str, np.ndarray]:
    """Return lower and upper bounds of all quantities that are enclosed, over the load steps.

    ``force_lower``, ``force_upper`` and so on -> (k,). Of a prescribed force the penetration, and
    energy and stiffness at the ends of its interval. About a tenth as wide as the scene's
    tolerance, or less; of rough surfaces a few per cent, their energy some times, their stiffness
    ten times that. NaN at loads at which the bounds prove nothing, such as one whose contact is far
    smaller than their cells. On one thread: several wait for each other in systems this small, for
    minutes on a busy machine.
    """
    proof = check_enclosed(scene, geometry, loads)
    given = [Interval(float(load), float(load)) for load in loads.values]
    by_depth = loads.control == "penetration"
    other, at = ("force", proof.force) if by_depth else ("penetration", proof.penetration)
    with threadpool_limits(limits=1):
        enclosed = [_known(at, load.lower) for load in given]
        pairs = [
            (load, answer) if by_depth else (answer, load)
            for load, answer in zip(given, enclosed, strict=True)
        ]
        intervals = {
            other: enclosed,
            "energy": [_known(proof.energy, *pair) for pair in pairs],
            "stiffness": [_known(proof.stiffness, *pair) for pair in pairs],
        }
    assert set(intervals) <= set(ENCLOSED)
    return {
        f"{name}_{side}": np.array([getattr(interval, side, math.nan) for interval in values])
        for name, values in intervals.items()
        for side in ("lower", "upper")
    }


def enclosures_asked_for(
    scene: Scene, geometry: Geometry, loads: AbsoluteLoads
) -> dict[str, np.ndarray]:
    """Return the enclosures that the scene's ``compare.proved`` asks for, empty if it does not."""
    if not scene.compare.proved:
        return {}
    try:
        return enclosures(scene, geometry, loads)
    except Refused:
        if scene.compare.proved == "if_any":
            return {}
        raise


@cache
def warm_up(rough: bool, periodic: bool) -> None:
    """Compile what the bounds run, once in a process, so that no timing of a proof contains it."""
    with threadpool_limits(limits=1):
        if rough and periodic:
            bowl = -ball(SHORTEST_COARSENED // _LEAST)
            PeriodicSurface(bowl, (1.0, 1.0), _LEAST).energy(0.1 * float(np.ptp(bowl)), 1.0)
        elif rough:
            Patch(-SMALL_BALL, 1.0, _LEAST).force(0.5, 1.0)
        else:
            flat_faces.enclosed([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], (2, 2))


def check_enclosed(scene: Scene, geometry: Geometry, loads: AbsoluteLoads) -> Proof:
    """Return the proof of a scene under its loads; raise `Refused` as `enclosures` does."""
    proof = proof_of(scene, geometry)
    if loads.control not in ("penetration", "force") or loads.is_path:
        raise Refused(f"the theorems enclose nothing of this body at a prescribed {loads.control}")
    most = proof.deepest if loads.control == "penetration" else proof.heaviest
    if max(loads.values) > most:
        limit, largest = told_apart(most, max(loads.values), unit=quantity(loads.control).unit)
        raise Refused(
            f"the theorems enclose this body up to a {loads.control} of {limit}, and the largest "
            f"is {largest}"
        )
    return proof


def _known(proof: Callable[..., Interval], *at: float | Interval | None) -> Interval | None:
    """Return what is enclosed at a load; None where the bounds prove nothing."""
    if any(load is None for load in at):
        return None
    try:
        return proof(*at)
    except ArithmeticError:
        return None


def _growing(at: At) -> Of:
    """Enclose what grows with the penetration, over an interval of penetrations."""

    def over(depth: Interval, _: Interval) -> Interval:
        if depth.lower == depth.upper:
            return at(depth.lower)
        return Interval(at(depth.lower).lower, at(depth.upper).upper)

    return over


def proof_of(scene: Scene, geometry: Geometry) -> Proof:
    """Return the enclosures of a scene."""
    if scene.body is not None:
        raise Refused("the theorems are for a half-space, and the [body] is finite")
    if not scene.half_space.uniform:
        raise Refused("the theorems are for a half-space that is the same at all depths")
    if scene.physics:
        raise Refused(
            "the theorems are for a rigid body without friction, adhesion or memory, at rest"
        )
    # widths fall with the third power of the cells; more than twice as many take minutes
    finer = min(max((0.01 / scene.compare.tolerance) ** (1 / 3), 1.0), 2.0)
    if isinstance(geometry, RoughGeometry):
        return proof_of_surface(scene, geometry, finer)
    indenter, modulus = scene.indenter, scene.effective_modulus
    assert indenter is not None
    profile, cells = _profile(indenter), round(_ROUND * finer)
    if profile is not None and profile.degree is None:
        return Proof(
            lambda d: revolution.force(profile, d, modulus, cells=cells),
            energy=_growing(lambda d: revolution.energy(profile, d, modulus, cells=cells)),
            stiffness=_growing(lambda d: revolution.stiffness(profile, d, modulus)),
            penetration=lambda load: revolution.penetration(profile, load, modulus, cells=cells),
            deepest=revolution.deepest(profile),
            heaviest=revolution.heaviest(profile, modulus),
        )
    if profile is not None:
        return _scaling(profile.degree or 1.0, lambda: _round_energy(profile, cells), modulus)
    if isinstance(indenter, Ellipsoid):
        body = homogeneous.paraboloid(indenter.radius_x, indenter.radius_y)
        x, y = body.punch(1).extents
        _check_slender("contact", max(x, y) / min(x, y), _SLENDER_CONTACT)
        return _scaling(2.0, lambda: _elliptic_energy(body, _more(_ELLIPTIC, finer)), modulus)
    # a flat punch, by its stiffness k/E*
    if not isinstance(indenter, round_shapes.Cylinder | EllipticPunch):
        if indenter.outline is None:
            shape = str(indenter.model_dump()["shape"]).replace("_", " ")
            raise Refused(f"no bound is computed for the shape {shape}")
        corners = np.array(_corners(indenter))
        hull = corners[ConvexHull(corners).vertices]
        sides = np.roll(hull, -1, axis=0) - hull
        along = sides / np.hypot(*sides.T)[:, None]
        lengths = np.ptp(along @ hull.T, axis=1)
        widths = np.ptp(along[:, 0, None] * hull[:, 1] - along[:, 1, None] * hull[:, 0], axis=1)
        _check_slender(
            "face", float(max(lengths.max(), widths.max()) / widths.min()), _SLENDER_FACE
        )

    def of_face(force: float) -> Interval:
        k = _stiffness(indenter, finer)
        return Interval(
            below(force / (k.upper * modulus), 4), above(force / (k.lower * modulus), 4)
        )

    return Proof(
        force=lambda d: _stiffness(indenter, finer) * (modulus * d),
        energy=_growing(lambda d: _stiffness(indenter, finer) * (0.5 * modulus * d * d)),
        stiffness=_growing(lambda d: _stiffness(indenter, finer) * modulus),
        penetration=of_face,
    )


def _more(cells: tuple[int, int], finer: float) -> tuple[int, int]:
    return round(cells[0] * finer), round(cells[1] * finer)


def _profile(indenter: Indenter) -> ConvexGap | None:
    if isinstance(indenter, round_shapes.Paraboloid):
        return paraboloid(indenter.radius)
    if isinstance(indenter, round_shapes.Sphere):
        return sphere(indenter.radius)
    if isinstance(indenter, round_shapes.Cone):
        return cone(indenter.slope)
    if isinstance(indenter, round_shapes.RoundedPunch):
        return rounded_punch(indenter.flat_radius, indenter.edge_radius)
    if isinstance(indenter, round_shapes.PowerLaw):
        if indenter.exponent < 1:
            raise Refused("the bounds are for convex bodies, f = c r^n with n >= 1")
        return power_law(indenter.exponent, indenter.coefficient)
    return None


@lru_cache(maxsize=32)
def _round_energy(profile: ConvexGap, cells: int) -> Interval:
    """Energy at a penetration of 1 for E* = 1: a body with a degree has no length of its own."""
    return revolution.energy(profile, 1.0, 1.0, cells=cells)


@lru_cache(maxsize=32)
def _elliptic_energy(body: homogeneous.Body, cells: tuple[int, int]) -> Interval:
    """As `_round_energy`, of a paraboloid with two radii."""
    return homogeneous.force(body, 1.0, 1.0, cells=cells) * (body.degree / (2 * body.degree + 1))


def _scaling(degree: float, unit: Callable[[], Interval], modulus: float) -> Proof:
    """Enclosures by the energy at a penetration of 1, which grows as d^(2 + 1/n)."""
    power = 2 + 1 / degree

    def penetration(force: float) -> Interval:
        scale, root = unit() * (power * modulus), 1 / (power - 1)
        return Interval(
            below((force / scale.upper) ** root, POWER), above((force / scale.lower) ** root, POWER)
        )

    return Proof(
        force=lambda d: unit() * (modulus * power * d ** (power - 1)),
        energy=_growing(lambda d: unit() * (modulus * d**power)),
        stiffness=_growing(lambda d: unit() * (modulus * power * (power - 1) * d ** (power - 2))),
        penetration=penetration,
    )


@lru_cache(maxsize=32)
def _stiffness(indenter: Indenter, finer: float) -> Interval:
    if isinstance(indenter, round_shapes.Cylinder):
        return revolution.disc_stiffness(indenter.radius, 1.0, cells=round(_ROUND * finer))
    if isinstance(indenter, EllipticPunch):
        return elliptic_stiffness(*indenter.semi_axes)
    return flat_faces.enclosed(_corners(indenter), _more(_FACE, finer))


def _check_slender(part: str, ratio: float, most: float) -> None:
    """Raise `Refused` for what is so slender that the bounds would take minutes."""
    if ratio > most:
        raise Refused(
            f"the {part} is {ratio:.3g} times as long as wide, and the finite elements of the "
            f"bounds, whose number grows with that, are for ratios up to {most:g}"
        )


def _corners(indenter: Indenter) -> list[tuple[float, float]]:
    assert indenter.outline is not None
    return [(float(x), float(y)) for x, y in indenter.outline]


# Cells per side, but two to eight per point: intervals a few per cent wide in some seconds a load.
# With more points per side than the last number the bounds take minutes.
_ROUGH_CELLS = {"free": 64, "periodic": 256}
_LEAST, _MOST, _MOST_POINTS = 2, 8, 128
# Share of the mean gap beyond which a period is nearly full: its stiffness has no bound there.
_NEARLY_FULL = 0.9


def proof_of_surface(scene: Scene, geometry: RoughGeometry, finer: float) -> Proof:
    """Return the enclosures of a rough scene; its bounds are computed when asked for.

    Penetrations count from the highest point, depths of the bounds from their highest sample.
    `Refused` where nothing is bounded, or not within minutes.
    """
    if geometry.random and scene.realisations > 1:
        raise Refused(
            f"the theorems enclose one surface, and the scene asks for the mean over "
            f"{scene.realisations}: surface.realisations = 1"
        )
    if not geometry.periodic and geometry.measured is not None:
        raise Refused(
            "the bounds are for surfaces that are sums of waves, synthetic or periodic, and a "
            "measured patch goes on between its points by splines"
        )
    square = geometry.points[0] == geometry.points[1] and geometry.size[0] == geometry.size[1]
    if not geometry.periodic and not square:
        raise Refused("the bounds of a free patch are for square ones")
    if max(geometry.points) > _MOST_POINTS:
        raise Refused(
            f"of more than {_MOST_POINTS} points a side the bounds take minutes a load, and there "
            f"are {max(geometry.points)}"
        )
    modulus, area = scene.effective_modulus, geometry.area
    cells = round(_ROUGH_CELLS["periodic" if geometry.periodic else "free"] * finer)
    cells = min(max(cells // max(geometry.points), _LEAST), _MOST)

    @cache
    def heights() -> np.ndarray:
        return geometry.heights(0, geometry.points[0])

    @cache
    def top() -> float:
        """Return the highest point of the surface, from its mean."""
        return float(geometry.top(0) - heights().mean())

    @cache
    def bounded() -> Patch | PeriodicSurface:
        if geometry.periodic:
            return PeriodicSurface(heights(), geometry.size, cells)
        return Patch(heights(), geometry.size[0], cells)

    def missed() -> float:
        """Return how far the highest sample is below the top."""
        return top() - bounded().top

    def pressed(depth: float) -> Interval:
        """Enclose the force at a depth below the highest sample."""
        surface = bounded()
        if isinstance(surface, Patch):
            return surface.force(depth, modulus)
        return surface.mean_pressure(depth, modulus) * area

    def force(penetration: float) -> Interval:
        depth = penetration - missed()
        if depth > 0:
            return pressed(depth)
        # nothing is proved to touch, and it bears less than where the sample is as deep
        return Interval(0.0, pressed(penetration).upper)

    def penetration(force: float) -> Interval:
        surface = bounded()
        load = force if isinstance(surface, Patch) else force / area
        depth = surface.penetration(load, modulus)
        return Interval(below(depth.lower + missed(), 4), above(depth.upper + missed(), 4))

    def from_samples(penetration: Interval, force: Interval) -> tuple[Interval, Interval]:
        """Return the depth below the highest sample, which has to touch; and the mean pressure."""
        lower, upper = below(penetration.lower, 2), above(penetration.upper, 2)
        depth = Interval(lower - missed(), upper - missed())
        if not depth.lower > 0:
            raise ArithmeticError("the highest sample is not proved to touch")
        return depth, Interval(below(force.lower / area, 4), above(force.upper / area, 4))

    def energy(penetration: Interval, force: Interval) -> Interval:
        surface, (depth, mean) = bounded(), from_samples(penetration, force)
        if isinstance(surface, Patch):
            return surface.energy(depth, modulus)
        return surface.stored(mean, depth, modulus) * area

    def stiffness(penetration: Interval, force: Interval) -> Interval:
        surface, (depth, mean) = bounded(), from_samples(penetration, force)
        if isinstance(surface, Patch):
            return surface.stiffness(depth, force, modulus)
        return surface.stiffness(mean, modulus) * area

    deepest = _NEARLY_FULL * top() if geometry.periodic else math.inf
    return Proof(force, penetration, energy, stiffness, deepest)
