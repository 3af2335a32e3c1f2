"""Viscoelastic indentation on springs: closed forms, exactness in time, rates, recovery."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from reduced.loads import Load, LoadPath
from reduced.memory.in_time import graded_times, harmonic_stiffness, indent_in_time
from reduced.memory.materials import kelvin_voigt, prony, standard_solid
from reduced.memory.row import RelaxingSprings
from reduced.profiles.equivalents import (
    cone,
    cylinder,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
)
from reduced.springs.indent import indent
from reduced.springs.line import Springs

BALL = paraboloid(2.0)
SOLID = prony(1.0, [3.0, 2.0], [0.3, 5.0])
FLUID = prony(0.0, [1.0], [0.7])
ROUNDING = 1e-12


def elastic(d):
    """Hertz with E* = 1, R = 2."""
    return 4 / 3 * np.sqrt(2.0) * d**1.5


def pressed(springs, times, depths):
    return indent_in_time(springs, times, LoadPath("penetration", depths))


def loaded(springs, times, forces):
    return indent_in_time(springs, times, LoadPath("force", forces))


@pytest.mark.parametrize("springs", [3, 17, 40])
def test_relaxation_after_a_jump(springs):
    """F = (16/3) sqrt(R) G(t) d^1.5 (Lee & Radok 1960): any springs, any steps."""
    t = np.array([0.0, 0.1, 0.11, 3.0, 50.0])
    indentation = pressed(RelaxingSprings(BALL, SOLID, per_radius=springs), t, np.full(5, 0.01))
    np.testing.assert_allclose(
        indentation.force, 4 * SOLID.relaxation(t) * elastic(0.01), rtol=ROUNDING
    )
    np.testing.assert_allclose(indentation.contact_radius, np.sqrt(2 * 0.01), rtol=ROUNDING)


@pytest.mark.parametrize(
    "profile", [BALL, cone(0.3), cylinder(0.2)], ids=["paraboloid", "cone", "punch"]
)
@pytest.mark.parametrize("steps", [1, 7])
def test_kelvin_voigt_in_and_out_at_constant_speed(profile, steps):
    """In: F = E* (A + tau A' v). Out: springs leave at d - g = v tau, so F = E* A(d - v tau).

    tau = eta/G, A the elastic force for E* = 1. The force per length is linear in the height at all
    times, which the cells hold exactly; so does the contact's edge.
    """
    speed, tau = 0.05, 0.04
    t = np.unique(
        np.concatenate([np.linspace(0, 0.2, steps + 1), np.linspace(0.2, 0.3, steps + 1)])
    )
    d = speed * (0.2 - np.abs(t - 0.2))
    indentation = pressed(
        RelaxingSprings(profile, kelvin_voigt(0.25, 0.25 * tau), per_radius=23), t, d
    )
    coming = slice(1, steps + 1)
    there = indent(Springs(profile, 1.0), Load("penetration", d[coming]))
    np.testing.assert_allclose(
        indentation.force[coming], there.force + tau * speed * there.stiffness, rtol=ROUNDING
    )
    left = indent(Springs(profile, 1.0), Load("penetration", d[:steps:-1] - speed * tau))
    np.testing.assert_allclose(indentation.force[:steps:-1], left.force, rtol=ROUNDING)
    np.testing.assert_allclose(
        indentation.contact_radius[:steps:-1], left.contact_radius, rtol=ROUNDING
    )


def test_time_steps_leave_no_error():
    """Ramp, rest, retreat, rest: the same digits with one step per piece or a hundred."""
    knots, depths = np.array([0.0, 1.0, 2.0, 2.6, 3.0]), np.array([0.0, 1.0, 1.0, 0.7, 0.7]) * 0.01
    few = pressed(RelaxingSprings(BALL, SOLID), knots, depths)
    fine = np.unique(np.concatenate([knots, np.linspace(0, 3, 301)]))
    many = pressed(RelaxingSprings(BALL, SOLID), fine, np.interp(fine, knots, depths))
    at = np.searchsorted(fine, knots)
    np.testing.assert_allclose(many.force[at], few.force, rtol=1e-11)
    np.testing.assert_allclose(many.contact_radius[at], few.contact_radius, rtol=1e-11)


@pytest.mark.parametrize(
    "profile",
    [BALL, cone(0.3), cylinder(0.2), sphere(2.0), power_law(4, 3.0), rounded_punch(0.05, 2.0)],
    ids=lambda profile: profile.name,
)
def test_elastic_material_is_the_elastic_contact(profile):
    """A spring alone: `foundation.indent` with E* = 4 G, to what the cells leave (exact: 1e-12)."""
    d = np.array([0.002, 0.005, 0.009, 0.006])
    indentation = pressed(RelaxingSprings(profile, prony(0.25)), np.arange(4.0), d)
    expected = indent(Springs(profile, 1.0), Load("penetration", np.sort(d)))
    exact = profile.name in ("paraboloid", "cone", "cylinder")
    # elsewhere the cell's parabola: fourth order in cells of a/40, less at tips and kinks
    tolerance = ROUNDING if exact else 2e-5
    order = np.argsort(d)
    np.testing.assert_allclose(indentation.force[order], expected.force, rtol=tolerance)
    np.testing.assert_allclose(
        indentation.contact_radius[order], expected.contact_radius, rtol=10 * tolerance
    )


def equal_times(t_end, n):
    return np.linspace(0, t_end, n + 1)


@pytest.mark.parametrize(
    ("material", "times", "fewest", "per_radius", "finest"),
    [
        (SOLID, equal_times, 4, 640, 7e-5),
        (FLUID, equal_times, 4, 640, 7e-5),
        (kelvin_voigt(1.0, 0.5), graded_times, 10, 20, 5e-5),  # a dashpot: d ~ t^(2/3) at first
    ],
    ids=["solid", "fluid", "dashpot"],
)
def test_creep_after_a_jump_of_force_is_of_second_order(
    material, times, fewest, per_radius, finest
):
    """A(d(t)) = J*(t) F (Lee & Radok): error falls as dt^2 until the springs' own is reached."""
    force, steps = 0.02, fewest * np.array([1, 2, 4, 8])
    exact = (0.75 / np.sqrt(2) * force * material.scaled(4).creep().compliance(2.0)) ** (2 / 3)
    springs = RelaxingSprings(BALL, material, per_radius=per_radius)
    courses = [loaded(springs, times(2.0, n), np.full(n + 1, force)) for n in steps]
    errors = [abs(course.penetration[-1] / exact - 1) for course in courses]
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.9
    assert errors[-1] < finest


def test_force_and_depth_control_are_inverse():
    t = np.linspace(0, 3, 31)
    force = 0.02 * np.interp(t, [0, 1, 2, 3], [0.0, 1.0, 1.0, 0.2])
    there = loaded(RelaxingSprings(BALL, SOLID), t, force)
    back = pressed(RelaxingSprings(BALL, SOLID, spacing=there.spacing), t, there.penetration)
    np.testing.assert_allclose(back.force[1:], force[1:], rtol=1e-11)
    np.testing.assert_allclose(back.contact_radius, there.contact_radius, rtol=1e-11)


def test_imprint_recovers_and_is_touched_again_where_it_is():
    """Flat punch, held until relaxed, taken off at once: u = d (1 - G_inf/G_0) exp(-t/lambda).

    lambda = tau G_0/G_inf. The punch coming back finds the surface at the root of d(t) = u(t), and
    its force from then on is that of the springs' arms, integrated here on their own.
    """
    material = standard_solid(1.0, 3.0, relaxation_time=0.5)
    d, wait = 0.01, 60.0
    back = [0.002, 0.008]  # depths at wait + 1 and wait + 3
    t = np.array([0.0, wait, wait, wait + 1.0, wait + 3.0])
    path = np.array([d, d, -d, back[0], back[1]])
    indentation = pressed(RelaxingSprings(cylinder(0.3), material), t, path)
    assert indentation.force[2] == indentation.force[3] == 0

    def surface(time):
        return d * 0.75 * np.exp(-(time - wait) / 2.0)

    def body(time):
        return np.interp(time, t[3:], path[3:])

    touch = brentq(lambda time: body(time) - surface(time), wait + 1, wait + 3, xtol=1e-14)
    rate, u = 0.003, surface(touch)
    arm = -1.0 * u  # at zero force the arm balances G_inf u
    length = wait + 3 - touch
    arm = arm * np.exp(-length / 0.5) + 3 * 0.5 * rate * -np.expm1(-length / 0.5)
    expected = 4 * 2 * 0.3 * (1.0 * back[1] + arm)
    assert indentation.force[4] == pytest.approx(expected, rel=1e-11)


def test_a_fluid_keeps_its_imprint():
    """Maxwell: what has flowed does not come back, so the body meets it where it was left."""
    material = prony(0.0, [1.0], [0.5])
    t = np.array([0.0, 0.5, 0.5, 9.0, 9.0])
    depth = 0.01
    left = depth * -np.expm1(-1.0)  # viscous part of the strain after one relaxation time
    path = np.array([depth, depth, 0.0, 0.0, left + 1e-3])
    indentation = pressed(RelaxingSprings(cylinder(0.3), material), t, path)
    assert indentation.force[3] == 0
    assert indentation.force[4] == pytest.approx(4 * 2 * 0.3 * 1e-3, rel=1e-11)


MATERIALS = st.sampled_from([SOLID, FLUID, prony(0.0, [1.0, 2.0], [0.1, 3.0]), prony(1.0)])


@settings(max_examples=40)
@given(
    material=MATERIALS,
    depths=st.lists(st.floats(-0.1, 1.0), min_size=1, max_size=6),
    profile=st.sampled_from([BALL, cone(0.3), cylinder(0.2), power_law(4, 3.0)]),
)
def test_springs_never_pull_and_never_give_energy(material, depths, profile):
    """Any history that ends clear of the surface: F >= 0, and the cycle takes work."""
    deepest = max(depths)
    if deepest < 1e-6:
        return
    knots = 0.01 * np.array([0.0, *(np.array(depths) / deepest).clip(-0.1), -0.1])
    t = np.linspace(0, knots.size - 1, 50 * (knots.size - 1) + 1)
    path = np.interp(t, np.arange(knots.size), knots)
    indentation = pressed(RelaxingSprings(profile, material, per_radius=10), t, path)
    assert (indentation.force >= 0).all()
    reach = float(profile.contact_radius(knots.max()))
    assert (indentation.contact_radius <= reach * (1 + 1e-9)).all()
    work = np.sum((indentation.force[1:] + indentation.force[:-1]) / 2 * np.diff(path))
    # trapezoids in fifty steps a piece and ten springs: one part in a thousand of the largest
    assert work >= -2e-3 * indentation.force.max() * knots.max()


@given(
    units=st.tuples(*3 * [st.floats(1e-9, 1e9)]),
    ulps=st.lists(st.integers(-2, 2), min_size=22, max_size=22),
)
@settings(max_examples=10)
def test_units_and_rounding_move_nothing(units, ulps):
    """Lengths, times and moduli in other units, depths rounded otherwise: the same contact.

    A spring stands at the rim of the largest contact, where the body rests for seven steps.
    """
    metre, second, pascal = units
    t = np.linspace(0.0, 4.0, 22)
    d = np.interp(t, [0.0, 1.0, 2.4, 3.0, 4.0], [0.0, 0.01, 0.01, 0.006, 0.008])
    here = pressed(RelaxingSprings(BALL, SOLID), t, d)
    material = prony(pascal, [3.0 * pascal, 2.0 * pascal], [0.3 * second, 5.0 * second])
    rounded = d * metre * (1 + np.finfo(float).eps * np.array(ulps))
    there = pressed(RelaxingSprings(paraboloid(2.0 * metre), material), t * second, rounded)
    np.testing.assert_allclose(there.force, here.force * pascal * metre**2, rtol=1e-11)
    np.testing.assert_allclose(there.contact_radius, here.contact_radius * metre, rtol=1e-11)


def test_harmonic_stiffness_is_what_the_springs_answer():
    """Flat punch, small oscillation about a rest: amplitude and phase of (19.30), 2 a E*(w).

    The punch has come to rest long before; the transient of the oscillation has died out after
    fifty of the longest relaxation times. Linear pieces of the sine, 200 a period: error 4e-4.
    """
    material, w, radius, d = standard_solid(1.0, 3.0, relaxation_time=0.5), 3.0, 0.2, 0.01
    per_period, periods = 200, 16
    t = np.arange(per_period * periods + 1) * (2 * np.pi / w / per_period)
    path = d + 0.1 * d * np.sin(w * t)
    indentation = pressed(RelaxingSprings(cylinder(radius), material), t, path)
    last = slice(-per_period, None)
    basis = np.column_stack([np.ones(per_period), np.sin(w * t[last]), np.cos(w * t[last])])
    _, real, imaginary = np.linalg.lstsq(basis, indentation.force[last])[0] / (0.1 * d)
    expected = harmonic_stiffness(material, radius, w)
    assert real + 1j * imaginary == pytest.approx(complex(expected), rel=5e-4)


def test_nodal_springs_are_the_printed_sum():
    """F = 4 dx sum G(t) (d - g_i) over whole springs; contact radius a count of them."""
    indentation = pressed(
        RelaxingSprings(BALL, SOLID, edges="nodal", per_radius=7), [0.0, 1.0], [0.01, 0.01]
    )
    dx = indentation.spacing
    x = dx * (np.arange(20) + 0.5)
    inside = x[x**2 / 2 < 0.01]
    total = 2 * dx * 4 * np.sum(0.01 - inside**2 / 2)
    np.testing.assert_allclose(
        indentation.force, total * SOLID.relaxation([0.0, 1.0]), rtol=ROUNDING
    )
    np.testing.assert_allclose(indentation.contact_radius, dx * inside.size)
