"""Pieces of proved bounds: flat ellipses, energies of elements, the allowance for rounding."""

import math

import mpmath
import numpy as np
import pytest
from numba import njit
from scipy import fft

from reference import closed_form, surfaces
from reference.bounds import outlines
from reference.bounds.dirichlet import Prisms, fan
from reference.bounds.duality import mutual_energies
from reference.bounds.ellipses import (
    ConvexGap,
    Ellipse,
    Face,
    WavyGap,
    best_ellipse,
    deepest,
    force_of_ellipse,
    force_of_ellipses,
    shares,
)
from reference.bounds.interval import EPSILON, complete, first_kind_above
from reference.bounds.patches import Patch
from reference.bounds.trigonometric import Waves, transform_rounding

SQUARE = [(1, -1), (1, 1), (-1, 1), (-1, -1)]
L_SHAPE = [(3, 0), (3, 1), (1, 1), (1, 3), (0, 3), (0, 0)]


def _heights():
    spectrum = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1)
    return surfaces.self_affine(8, 1.0, spectrum, seed=1, realisation=0)


def _shadow(points=120):
    """Places on the unit disc under a uniform sphere, each of the same weight."""
    heights, _ = np.polynomial.legendre.leggauss(points)
    turn = 2 * np.pi * (np.arange(2 * points) + 0.5) / (2 * points)
    r = np.sqrt(1 - heights**2)[:, None]
    return np.stack([r * np.cos(turn), r * np.sin(turn)]), _[:, None] / 2 / len(turn)


def _displacement(source, place):
    """Under unit force on an elliptic punch, outside of it, E* = 1: the mean of 1/(pi r)."""
    places, weights = _shadow()
    x, y = np.tensordot(source.axes, places, 1)
    r = np.hypot(source.x + x - place[0], source.y + y - place[1])
    return float((weights / r).sum() / np.pi)


@pytest.mark.parametrize(
    ("source", "target"),
    [
        (Ellipse(0, 0, 1.0, 1.0), Ellipse(3.0, 0.0, 1.0, 1.0)),
        (Ellipse(0, 0, 2.0, 0.5, 0.4), Ellipse(1.0, 2.5, 1.5, 0.3, 1.0)),
        (Ellipse(1.0, 2.0, 0.2, 1.0, -0.7), Ellipse(-1.0, 1.0, 0.8, 0.4, 2.0)),
    ],
)
def test_no_place_of_another_ellipse_sinks_in_deeper_than_its_bound(source, target):
    """The bound is that of the nearest place on it: sharp to 1 % by 64 directions."""
    bound = deepest([source, target])[1, 0]
    turn = np.linspace(0, 2 * np.pi, 60)
    rim = target.axes @ np.stack([np.cos(turn), np.sin(turn)])
    sampled = max(_displacement(source, (target.x + x, target.y + y)) for x, y in rim.T)
    assert sampled <= bound < 1.01 * sampled


def test_two_discs_far_apart_carry_twice_less_what_they_take_from_each_other():
    """Discs of radius 1, 20 apart: f (1/2 + asin(1/r)/pi) = 1 where r = 19 at the nearest place."""
    discs = [Ellipse(0, 0, 1.0, 1.0), Ellipse(20.0, 0.0, 1.0, 1.0)]

    class Flat:
        def within(self, ellipse):
            return ellipse

        def above(self, ellipse):
            return 0.0

    expected = 2 / (0.5 + math.asin(1 / 19) / math.pi)
    assert force_of_ellipses(Flat(), discs, 1.0) == pytest.approx(expected, rel=1e-9)
    forces = shares(Flat(), discs, 1.0)
    assert (deepest(discs) @ forces <= 1).all()


def test_the_best_ellipse_of_an_ellipsoid_is_its_contact():
    form = closed_form.ellipsoid(1.0, 5.0, 1.0)

    def gap(x, y):
        return 0.5 * (x**2 + y**2 / 5)

    start = Ellipse(0.1, 0.2, 1.0, 1.0, 0.3)
    ellipse, force = best_ellipse(ConvexGap(gap), 1.0, [start])
    # chords of 64 rings and 48 arcs exceed the gap by 2e-3, of second order
    assert 0 < 1 - force / float(form.force(1.0)) < 1e-3
    short, long = (float(axis) for axis in form.semi_axes(1.0))
    assert sorted([ellipse.a, ellipse.b]) == pytest.approx([short, long], rel=0.01)
    fine = force_of_ellipse(ConvexGap(gap, 256, 192), ellipse, 1.0) / float(form.force(1.0))
    assert 1 - 1e-4 < fine < 1


@pytest.mark.parametrize("faces", [3, 4])
def test_means_of_convex_gaps_are_not_below_the_closed_form(faces):
    # <r> = pi/4, and the mean of cos over half a face's angle is sin(pi/n)/(pi/n)
    normals = [2 * np.pi * k / faces for k in range(faces)]

    def pyramid(x, y):
        return np.max([np.cos(a) * x + np.sin(a) * y for a in normals], axis=0)

    mean = 0.25 * faces * math.sin(math.pi / faces)
    assert 0 <= ConvexGap(pyramid).above(Ellipse(0, 0, 1.0, 1.0)) / mean - 1 < 5e-4
    # off its middle and drawn out: against points under the sphere
    ellipse = Ellipse(0.3, -0.1, 1.2, 0.5, 0.6)
    places, weights = _shadow()
    x, y = np.tensordot(ellipse.axes, places, 1)
    sampled = (weights * pyramid(ellipse.x + x, ellipse.y + y)).sum()
    assert 0 <= ConvexGap(pyramid).above(ellipse) / sampled - 1 < 1e-3


def test_the_mean_of_waves_is_that_of_points_under_the_sphere():
    heights = _heights()
    waves = Waves(heights, (1.0, 1.0))
    ellipse = Ellipse(0.4, 0.5, 0.3, 0.1, 0.5)
    gap = WavyGap(waves, waves.highest()[0], ((0.0, 0.0), (1.0, 1.0)))
    places, weights = _shadow(40)
    x, y = np.tensordot(ellipse.axes, places, 1)
    sampled = 0.0
    for u, v, w in zip(x.ravel(), y.ravel(), np.broadcast_to(weights, x.shape).flat, strict=True):
        sampled += w * (gap._top - waves.on(ellipse.x + np.array([u]), ellipse.y + np.array([v])))
    assert gap.above(ellipse) == pytest.approx(float(sampled[0, 0]), rel=1e-9)


@pytest.mark.parametrize("corners", [SQUARE, L_SHAPE, SQUARE[::-1]])
def test_ellipses_stay_on_their_face(corners):
    face = Face(corners)
    rng = np.random.default_rng(2)
    turn = np.linspace(0, 2 * np.pi, 100)
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    touched = 0
    for _ in range(40):
        x, y = rng.uniform(low, high)
        ellipse = face.within(Ellipse(x, y, *rng.uniform(0.1, 3, 2), rng.uniform(0, 3)))
        rim = ellipse.axes @ np.stack([np.cos(turn), np.sin(turn)])
        u, v = x + rim[0], y + rim[1]
        inside = (low[0] <= u) & (u <= high[0]) & (low[1] <= v) & (v <= high[1])
        if len(corners) == 6:
            inside &= (u <= 1 + 1e-12) | (v <= 1 + 1e-12)
        assert inside.all() or ellipse.a == 0
        touched += ellipse.a > 0
    assert touched > 15
    assert face.within(Ellipse(2.5, 2.5, 1.0, 1.0)).stiffness == 0.0


@pytest.mark.slow
def test_summits_of_a_rough_patch_carry_most_of_its_force():
    heights = _heights()
    depth = 0.3 * heights.std()
    patch = Patch(heights, 1.0, 1)
    together = patch.by_ellipses(depth, 3.0)
    # three summits: 95 % in closed form, where 16^2 cells prove 56 %
    assert 0.93 < together / (3.0 * Patch(heights, 1.0, 16).on_grid(depth)) < 1
    assert together == pytest.approx(patch.by_ellipses(depth, 1.0) * 3.0)


@pytest.mark.parametrize("seed", range(5))
def test_the_energy_of_prisms_is_bounded_from_above_with_its_rounding(seed):
    """Exact sums of the elements' v' K v/2 are below the bound, of which rounding is 1e-12."""
    corners = [(1.0, -0.6), (1.2, 0.5), (-0.7, 0.9), (-0.9, -0.8)]
    outline = outlines.polygon(corners, 1, 1.0)
    section, _ = fan(np.array([0.4, 1.9])[:, None, None] * outline.points, closed=outline.closed)
    body = Prisms(section, np.array([0.0, 0.7, 1.5]), np.arange(len(section.points)))
    values = np.random.default_rng(seed).standard_normal(body.unknowns)
    local = values[body.places]
    terms = local[:, :, None] * body.matrices * local[:, None, :]
    exact = 0.5 * math.fsum(terms.ravel())
    assert 1e-13 < body.energy_above(values) / exact - 1 < 1e-11


@pytest.mark.parametrize("complement", [1.0, 0.7, 0.1, 1e-3, 1e-8, 1e-14, 1e-30])
def test_complete_elliptic_integrals_lie_between_bounds_a_few_roundings_apart(complement):
    with mpmath.workdps(60):
        m = 1 - mpmath.mpf(complement)
        first, second = mpmath.ellipk(m), mpmath.ellipe(m)
        other = (first - second) / m if m else mpmath.pi / 4
        for cosine, sine in ((1.0, 1.0), (1.0, complement), (0.0, 1.0), (2.0, complement)):
            exact = cosine * (first - other) + sine * other
            lower, upper = complete(complement, cosine, sine)
            assert lower <= exact <= upper
            assert upper / lower - 1 < 200 * EPSILON


@pytest.mark.parametrize("at", [(0.1, 0.5, 1.0), (1e-6, 0.3, 2.0), (1e-20, 1.0, 1e3)])
def test_carlsons_integral_is_not_above_its_bound(at):
    exact = mpmath.elliprf(*at)
    assert exact <= float(first_kind_above(*map(np.array, at))) <= exact * (1 + 1e-10)


def test_energies_of_discs_that_nearly_agree_lie_within_their_errors():
    """K - E and the like cancel as the radii agree: a few roundings of each are not enough."""
    radii = np.array([0.5, 1 - 1e-7, 1.0])
    energies, errors = mutual_energies(radii)
    with mpmath.workdps(40):
        for b, a, energy, error in zip(
            radii[:2], radii[1:], np.diag(energies, 1), np.diag(errors, 1), strict=True
        ):
            m = (mpmath.mpf(b) / mpmath.mpf(a)) ** 2
            first, second = mpmath.ellipk(m), mpmath.ellipe(m)
            bracket = first - (first - second) / m + second
            exact = 8 * mpmath.pi / 3 * a * mpmath.mpf(b) ** 2 * bracket
            assert abs(energy - exact) <= error < 1e-13 * energy


@pytest.mark.parametrize("count", [2, 30, 48, 53, 101, 128, 211])
def test_transforms_err_by_less_than_the_theorem_says(count):
    """Of small factors; of a prime taken directly, and by a convolution (101 and 211)."""
    values = np.random.default_rng(0).standard_normal(count)
    rows = range(0, count, -(-count // 40))
    with mpmath.workdps(30):
        turn = [mpmath.expjpi(mpmath.mpf(-2) * k / count) for k in range(count)]
        exact = [mpmath.fsum(x * turn[j * k % count] for j, x in enumerate(values)) for k in rows]
        off = [abs(e - mpmath.mpc(v)) for e, v in zip(exact, fft.fft(values)[rows], strict=True)]
        size = mpmath.sqrt(sum(abs(e) ** 2 for e in exact))
        assert mpmath.sqrt(sum(o**2 for o in off)) < transform_rounding(count) * size
        # the factors themselves: an impulse goes through all passes
        impulse = fft.fft(np.eye(1, count, 1)[0])
        amiss = max(abs(t - mpmath.mpc(f)) for t, f in zip(turn, impulse, strict=True))
        assert amiss < transform_rounding(count)


_SERIES = np.concatenate([np.geomspace(1e-12, 1e6, 150), np.linspace(0.01, 12.0, 150)])


@njit
def _compiled(x):
    return np.arcsinh(x)


@pytest.mark.parametrize(
    ("library", "exact"),
    [
        (np.arcsinh, mpmath.asinh),
        (_compiled, mpmath.asinh),
        (np.log1p, mpmath.log1p),
        (np.sin, mpmath.sin),
        (np.cos, mpmath.cos),
        (np.exp, lambda x: mpmath.exp(x)),
        (lambda x: x**1.7, lambda x: mpmath.mpf(x) ** mpmath.mpf(1.7)),
        (lambda x: np.hypot(x, 1.3), lambda x: mpmath.hypot(x, mpmath.mpf(1.3))),
    ],
)
def test_the_c_library_is_within_four_units_in_the_last_place(library, exact):
    places = _SERIES[_SERIES < 700] if library is np.exp else _SERIES
    with mpmath.workdps(40):
        for x, value in zip(places, library(places), strict=True):
            true = exact(mpmath.mpf(float(x)))
            assert abs(true - mpmath.mpf(float(value))) <= 4 * EPSILON * abs(true)
