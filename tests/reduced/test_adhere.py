"""Adhesion on springs: closed forms of pull-off, rates, events against a search, energy balance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from reduced.adhesion import adhere, pull_off
from reduced.loads import LoadPath
from reduced.profiles.equivalents import (
    Profile,
    cone,
    cylinder,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
    tabulated,
)
from reduced.profiles.quadrature import integrate_panels
from reduced.springs.line import Springs

W = 0.013
OFFSETS = st.integers(0, 999).map(lambda i: i / 1000)
# steep, then nearly level, then steep again: two stable contact radii at one load
SHELF = Profile(
    "shelf",
    height=lambda x: 0.3 * (1 - np.exp(-4 * x)) + 0.03 * x**3,
    slope=lambda x: 1.2 * np.exp(-4 * x) + 0.09 * x**2,
    curvature=None,
    length=1.0,
)
SHAPES = {
    "sphere": sphere(1.0),
    "quartic": power_law(4, 0.3),
    "cone": cone(0.3),
    "rounded": rounded_punch(1.0, 2.0),
    "shelf": SHELF,
    "table": tabulated([0, 0.2, 0.4, 0.8], [0, 0.02, 0.08, 0.32]),
}


def equilibrium(profile, modulus, work, radii):
    """d(a) and F(a) = 2 E* int_0^a (d - g) dx of the whole branch, by quadrature, no springs."""
    a = np.asarray(radii, dtype=float)
    marks = np.minimum(np.array([0.0, *profile.breakpoints, np.inf]), a[:, None])
    filled = integrate_panels(lambda x, _: profile.height(x), marks[:, :-1], marks[:, 1:])
    depth = profile.height(a) - np.sqrt(2 * np.pi * work / modulus * a)
    return depth, 2 * modulus * (a * depth - filled)


@pytest.mark.parametrize(("control", "share"), [("force", -1.5), ("penetration", -5 / 6)])
@given(offset=OFFSETS, springs=st.integers(2, 60))
@settings(deadline=None, max_examples=10)
def test_paraboloid_pulls_off_as_johnson_kendall_and_roberts_say(control, share, offset, springs):
    """-(3/2) pi w R and -(5/6) pi w R; cubics hold the parabola, so only rounding is left.

    A fold is flat: its place has half the digits of its load.
    """
    row = Springs(paraboloid(3.0), 2.0, per_radius=springs, offset=offset)
    event = pull_off(row, W, control)
    assert event.kind == "pull_off"
    assert event.before.force == pytest.approx(share * np.pi * W * 3.0, rel=1e-12)
    cube = (9 if control == "force" else 1) * np.pi * W * 3.0**2 / (8 * 2.0)
    assert event.before.contact_radius == pytest.approx(np.cbrt(cube), rel=1e-12)


@pytest.mark.parametrize("control", ["force", "penetration"])
def test_flat_punch_pulls_off_at_once_as_kendall_says(control):
    """-sqrt(8 pi E* w b^3) under both controls, the elastic energy and nothing else lost."""
    b, modulus = 0.7, 3.0
    event = pull_off(Springs(cylinder(b), modulus, offset=0.3), W, control=control)
    assert event.before.force == pytest.approx(-np.sqrt(8 * np.pi * modulus * W * b**3), rel=1e-14)
    # U = F^2/(4 E* b) = 2 pi w b^2, less the surface energy
    assert event.dissipated == pytest.approx(np.pi * W * b**2, rel=1e-13)


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize(("control", "factor"), [("force", 3), ("penetration", 1)])
def test_power_laws_pull_off_at_the_closed_form(n, control, factor):
    """a^(n - 1/2) = factor sqrt(pi w/(2 E*))/(n kappa c), F = 2 E* n/(n+1) kappa c a^(n+1) - ..."""
    kappa = {1: np.pi / 2, 2: 2.0, 3: 3 * np.pi / 4}[n]
    modulus, c = 2.0, 0.4
    a = (factor * np.sqrt(np.pi * W / (2 * modulus)) / (n * kappa * c)) ** (1 / (n - 0.5))
    force = 2 * modulus * n / (n + 1) * kappa * c * a ** (n + 1)
    force -= np.sqrt(8 * np.pi * modulus * W * a**3)
    event = pull_off(Springs(power_law(n, c), modulus, offset=0.21), W, control=control)
    assert event.before.force == pytest.approx(force, rel=1e-12)
    assert event.before.contact_radius == pytest.approx(a, rel=1e-12)


def extremum(profile, modulus, control, low, high):
    """Return the smallest load of the branch between two radii, by a search on the quadrature."""
    part = {"penetration": 0, "force": 1}[control]
    minimum = minimize_scalar(
        lambda a: equilibrium(profile, modulus, W, [a])[part][0],
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-9},
    )
    return equilibrium(profile, modulus, W, [minimum.x])[1][0], minimum.x


@pytest.mark.parametrize("control", ["force", "penetration"])
@pytest.mark.parametrize("shape", ["sphere", "quartic"])
def test_pull_off_converges_with_the_fourth_order(shape, control):
    """The cubics err as dx^4; at 40 springs per radius 1e-6 (1e-5), where 1e-3 is asked for.

    The issue asks for order 2; over random alignments of the springs the rms must show 3.5. Under
    penetration control the force is not at its own extremum and keeps the error of the place, 3.
    """
    profile = SHAPES[shape]
    exact, _ = extremum(profile, 1.0, control, 0.02, 0.9)
    rng = np.random.default_rng(1)
    errors = []
    for springs in (20, 40, 80):
        result = [
            pull_off(
                Springs(profile, 1.0, per_radius=springs, offset=o), W, control=control
            ).before.force
            for o in rng.random(12)
        ]
        errors.append(np.sqrt(np.mean((np.array(result) / exact - 1) ** 2)))
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[1] < (1e-6 if control == "force" else 1e-5)
    assert order.mean() > (3.5 if control == "force" else 2.5)


@pytest.mark.parametrize("control", ["force", "penetration"])
@given(offset=OFFSETS, springs=st.integers(10, 80))
@settings(deadline=None, max_examples=10)
def test_a_fold_close_to_a_broken_power_is_found(control, offset, springs):
    """Rounded punch: g rises as (x - b)^(3/2), the fold is 0.03 b behind: 1e-5, by graded knots."""
    profile = SHAPES["rounded"]
    exact, _ = extremum(profile, 1.0, control, 1.0, 1.5)
    event = pull_off(Springs(profile, 1.0, per_radius=springs, offset=offset), W, control=control)
    assert event.before.force == pytest.approx(exact, rel=1e-5)


def searched_path(profile, control, loads):
    """Follow the contact on 4000 radii: grow to the first and shrink to the last stable one."""
    radius = np.linspace(0, 0.9 if profile.name == "sphere" else min(profile.edge, 4.0), 4_001)[1:]
    branch = equilibrium(profile, 1.0, W, radius)
    own = branch[{"penetration": 0, "force": 1}[control]]
    at, result = -1, []
    for load in loads:
        if at < 0 and load >= 0:
            at = 0
        if at >= 0 and own[at] < load:
            at += int(np.argmax(own[at:] >= load)) if (own[at:] >= load).any() else own.size - at
            at = min(at, own.size - 1)
        elif at >= 0 and own[at] > load:
            below = np.flatnonzero(own[: at + 1] <= load)
            at = int(below[-1]) if below.size else -1
        result.append(radius[at] if at >= 0 else 0.0)
    return np.array(result), radius[1] - radius[0]


@pytest.mark.slow
@pytest.mark.parametrize("control", ["force", "penetration"])
@pytest.mark.parametrize("shape", list(SHAPES))
def test_the_path_is_that_of_a_plain_search(shape, control):
    """Loading, unloading, reloading and parting: contact radii within the step of the search.

    The search goes from load to load and knows of jumps only that they happened; at loads within
    its step of a fold it may jump one load earlier or later, for which no load of these lies close.
    """
    top, low = (0.2, -0.4) if control == "penetration" else (0.25, -0.3)
    up, down = np.linspace(low, top, 23), np.linspace(top, 0.3 * low, 17)
    path = np.concatenate(
        [up, down, np.linspace(0.3 * low, top, 11), np.linspace(top, 3 * low, 29)]
    )
    radius, step = searched_path(SHAPES[shape], control, path)
    contact = adhere(Springs(SHAPES[shape], 1.0), W, LoadPath(control, path))
    np.testing.assert_allclose(contact.contact_radius, radius, atol=2 * step, rtol=0)
    apart = (radius == 0) & (control == "force")
    np.testing.assert_array_equal(np.isnan([contact.force, contact.penetration]), [apart, apart])


def test_a_shelf_is_crossed_in_a_jump_both_ways():
    """Two stable radii at one load: the contact leaves each at its own fold, and loses energy."""
    path = np.concatenate([np.linspace(0, 0.3, 31), np.linspace(0.3, -0.5, 81)])
    contact = adhere(Springs(SHELF, 1.0), W, LoadPath("penetration", path))
    kinds = [event.kind for event in contact.events]
    assert kinds == ["snap_in", "jump", "jump", "pull_off"]
    outwards, inwards = contact.events[1:3]
    assert outwards.after.contact_radius > outwards.before.contact_radius
    assert inwards.after.contact_radius < inwards.before.contact_radius
    assert outwards.before.penetration > inwards.before.penetration
    assert all(event.dissipated > 0 for event in contact.events)


@pytest.mark.parametrize("shape", ["sphere", "shelf", "table"])
def test_the_work_of_the_force_is_stored_or_lost_in_jumps(shape):
    """U - pi w a^2 and what jumps lost change by int F dd, on a stable branch and around a cycle.

    Trapezoids between 4000 depths per way err where a jump falls between two depths, by the jump in
    force times the step.
    """
    cycle = np.concatenate([np.linspace(0, 0.2, 4000), np.linspace(0.2, -0.5, 4000)])
    for path, tolerance in ((np.linspace(0.1, 0.05, 3000), 1e-5), (cycle, 2e-3)):
        contact = adhere(Springs(SHAPES[shape], 1.0), W, LoadPath("penetration", path))
        free = contact.elastic_energy - np.pi * W * contact.contact_radius**2
        kept = free + contact.dissipated
        work = np.trapezoid(contact.force, path)
        assert kept[-1] - kept[0] == pytest.approx(work, rel=tolerance)
    assert contact.contact_radius[-1] == 0


@given(
    shape=st.sampled_from(sorted(SHAPES)),
    control=st.sampled_from(["force", "penetration"]),
    loads=st.lists(st.integers(-60, 30).map(lambda i: i / 100), min_size=1, max_size=8),
    springs=st.integers(3, 50),
    offset=OFFSETS,
)
@settings(deadline=None, max_examples=30)
def test_jumps_lose_energy_and_states_obey_the_rule(shape, control, loads, springs, offset):
    """Any path: losses are positive, and an edge that is not sharp is stretched by l(a)."""
    profile = SHAPES[shape]
    contact = adhere(
        Springs(profile, 1.0, per_radius=springs, offset=offset), W, LoadPath(control, loads)
    )
    # a fold that a rounding error opens loses a rounding error
    assert all(event.dissipated >= -1e-12 for event in contact.events)
    a = contact.contact_radius
    assert np.isfinite(contact.penetration[(a > 0) | (control == "penetration")]).all()
    free = (a > 0) & (a < profile.edge)
    if free.any():
        depth, _ = equilibrium(profile, 1.0, W, a[free])
        # the coarsest lines, 3 springs, hold the sphere and the quartic to some per cent of l(a)
        scale = np.sqrt(2 * np.pi * W * a[free]) + np.abs(depth)
        assert np.all(np.abs(contact.penetration[free] - depth) < 0.05 * scale)


def test_nothing_acts_across_a_gap():
    contact = adhere(Springs(sphere(1.0), 1.0), W, LoadPath("penetration", [-0.2, -0.01]))
    assert not contact.force.any()
    assert contact.events == ()
