"""Flat elliptic punches as a lower bound of the force, against quadrature and closed forms."""

import math

import numpy as np
import pytest

from reference import closed_form, surfaces
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
from reference.bounds.patches import Patch
from reference.bounds.trigonometric import Waves

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
