"""Lee-Radok, Ting by quadrature, the half-space in time, impact, materials: each against others."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from reduced.loads import LoadPath
from reduced.memory.in_time import impact as impact_on_springs
from reduced.memory.in_time import indent_in_time
from reduced.memory.materials import prony
from reduced.memory.row import RelaxingSprings
from reduced.profiles.equivalents import paraboloid
from reference import closed_form
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator
from reference.loads import History
from reference.viscoelastic import creep, impact, indentation, press_in_time
from reference.viscoelastic.materials import GeneralisedMaxwell

SOLID = GeneralisedMaxwell(1.0, [3.0, 2.0], [0.3, 5.0])
SOLID_SPRINGS = prony(1.0, [3.0, 2.0], [0.3, 5.0])
ZENER = GeneralisedMaxwell.standard(1.0, 3.0, 0.5)
HISTORY = np.array([0.0, 1.0, 2.0, 2.4, 2.5])
DEPTHS = np.array([0.0, 1.0, 1.0, 0.65, 0.5]) * 0.01
BALL = closed_form.paraboloid(1.0, 1.0)


def on_springs(times, depths, profile=None, **line):
    """Indent springs of the same solid by a ball of radius one, or another profile."""
    springs = RelaxingSprings(profile or paraboloid(1.0), SOLID_SPRINGS, **line)
    return indent_in_time(springs, times, LoadPath("penetration", depths))


def test_ramp_is_radok_by_adaptive_quadrature():
    """F = (16/3) sqrt R int G(t - s) d[(v s)^1.5], with s = w^2 so that nothing is singular."""
    speed, t = 0.01, 0.8
    contact = indentation(BALL, 1.0, SOLID, History("penetration", [0.0, 1.0], [0.0, speed]), [t])

    def integrand(w):
        return float(SOLID.relaxation(t - w * w)) * 1.5 * speed**1.5 * w * 2 * w

    exact = 16 / 3 * quad(integrand, 0, np.sqrt(t), epsabs=0, epsrel=1e-13)[0]
    assert contact.force[0] == pytest.approx(exact, rel=1e-12)
    assert contact.error[0] < 1e-11 * exact
    assert contact.contact_radius[0] == pytest.approx(np.sqrt(speed * t), rel=1e-14)


def test_a_jump_and_a_retreat():
    """Relaxation after a jump, then a retreat: Ting's integral with a jump against 320 springs."""
    t, depth = np.array([0.0, 1.0, 1.1, 1.16]), np.array([1.0, 1.0, 0.8, 0.65]) * 0.01
    exact = indentation(BALL, 1.0, SOLID, History("penetration", t, depth), t)
    held = 16 / 3 * 0.01**1.5 * SOLID.relaxation(t[:2])
    np.testing.assert_allclose(exact.force[:2], held, rtol=1e-13)
    result = on_springs(t, depth, per_radius=320)
    np.testing.assert_allclose(result.force, exact.force, rtol=1e-6)
    np.testing.assert_allclose(result.contact_radius, exact.contact_radius, rtol=1e-6)


def test_ting_refuses_a_retreat_that_the_surface_overtakes():
    """A retreat that slows down: on springs the contact grows again, Ting's theory has to stop."""
    slower = np.array([0.0, 1.0, 1.0, 0.65, 0.6]) * 0.01
    t = np.array([0.0, 1.0, 2.0, 2.4, 2.6])
    with pytest.raises(ValueError, match="grows again"):
        indentation(BALL, 1.0, SOLID, History("penetration", t, slower), t)
    result = on_springs(t, slower)
    assert result.contact_radius[4] > result.contact_radius[3]


def cells(n, reach):
    """Square grid of n x n cells over |x|, |y| < reach, and the squared radius of its cells."""
    dx = 2 * reach / n
    x = (np.arange(n) - n / 2 + 0.5) * dx
    return FreeOperator((n, n), (dx, dx), 3.0), x[:, None] ** 2 + x**2


def test_punch_creeps_as_its_material_does():
    """Force linear in time on a fixed contact: d(t)/d_elastic = int J* dF/F, exact at any step."""
    operator, square = cells(12, 0.12)
    gap = np.where(square <= 0.1**2, 0.0, np.inf)
    t = np.array([0.0, 0.7, 2.0, 9.0])
    force = np.array([1.0, 1.0, 2.5, 0.4])
    steps = list(press_in_time(operator, gap, ZENER, History("force", t, force)))
    depths = np.array([step.penetration for step in steps])
    elastic = list(
        press_in_time(operator, gap, GeneralisedMaxwell(1.0), History("force", t[:1], [1.0]))
    )
    slopes = np.diff(force) / np.diff(t)
    for depth, end in zip(depths, t, strict=True):
        strain = float(ZENER.creep(end)) * force[0]
        for begin, stop, slope in zip(t[:-1], t[1:], slopes, strict=True):
            if begin < end:
                strain += (
                    slope * quad(lambda s, end=end: float(ZENER.creep(end - s)), begin, stop)[0]
                )
        # the contact problems' tolerance is 1e-9
        assert depth / elastic[0].penetration == pytest.approx(strain, rel=1e-7)


def ball_force(n, steps, depth=DEPTHS, history=HISTORY, material=SOLID):
    """Force at the kinks of the history from n x n cells and steps per piece."""
    operator, square = cells(n, 0.115)
    t = np.concatenate(
        [[0.0]] + [np.linspace(*ends, steps + 1)[1:] for ends in itertools.pairwise(history)]
    )
    contact = press_in_time(
        operator, square / 2, material, History("penetration", t, np.interp(t, history, depth))
    )
    return np.array([step.force for step in contact])[steps::steps]


@pytest.mark.slow
def test_half_space_in_time_converges_to_ting():
    """Paraboloid through unloading: grid and step refined together, factor two each.

    The grid's error of a Hertz force falls about as dx^1.5 to dx^2, the step's as dt^2; the bar
    (the last difference) holds the truth at every kink.
    """
    exact = indentation(
        BALL, 1.0, SOLID, History("penetration", HISTORY, DEPTHS), HISTORY[1:]
    ).force
    runs = np.array([ball_force(n, k) for n, k in ((16, 8), (32, 16), (64, 32))])
    errors = np.abs(runs - exact) / exact.max()
    assert (errors[-1] < 1e-4).all()
    assert errors[-1].max() < errors[0].max() / 4
    assert (np.abs(runs[-1] - exact) <= np.abs(runs[-1] - runs[-2])).all()


def test_half_space_against_a_dashpot():
    """Kelvin-Voigt on the way in, pressure singular at the edge: 0.25 % at 21 cells per radius."""
    damped = GeneralisedMaxwell.kelvin_voigt(1.0, 0.3)
    operator, square = cells(48, 0.115)
    t = np.linspace(0, 1, 41)
    entries = list(press_in_time(operator, square / 2, damped, History("penetration", t, 0.01 * t)))
    at = np.array([step.time for step in entries[18:]])
    exact = indentation(BALL, 1.0, damped, History("penetration", [0, 1], [0, 0.01]), at)
    np.testing.assert_allclose([step.force for step in entries[18:]], exact.force, rtol=2.5e-3)


@pytest.mark.parametrize("material", [SOLID, GeneralisedMaxwell.kelvin_voigt(1.0, 0.3)])
def test_a_force_may_rise_from_nothing(material):
    """At first touch nothing is pressed; then Lee and Radok's depth, 1 % at 14 cells per radius."""
    operator, square = cells(32, 0.115)
    t = np.linspace(0, 1, 17)
    force = 0.01 * t
    entries = list(press_in_time(operator, square / 2, material, History("force", t, force)))
    if not material.viscosity:
        assert (entries[0].penetration, entries[0].force, entries[0].violation) == (0.0, 0.0, 0.0)
        assert not entries[0].pressure.any()
    exact = creep(
        BALL, 1.0, material, History("force", t, force), [step.time for step in entries[4:]]
    )
    depths = [step.penetration for step in entries[4:]]
    np.testing.assert_allclose(depths, exact.penetration, rtol=0.01)


def test_a_force_ends_nowhere_but_at_its_start():
    operator, square = cells(8, 0.115)
    history = History("force", [0, 1, 2], [0.0, 1.0, 0.0])
    with pytest.raises(ValueError, match="the first may be 0"):
        press_in_time(operator, square / 2, SOLID, history)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("material", "springs"),
    [
        (GeneralisedMaxwell.standard(0.25, 0.25, 0.01), prony(0.25, [0.25], [0.01])),
        (GeneralisedMaxwell(0.0, (0.25,), (0.05,)), prony(0.0, [0.25], [0.05])),
        (GeneralisedMaxwell.kelvin_voigt(0.25, 0.0005), prony(0.25, viscosity=0.0005)),
    ],
    ids=["standard", "maxwell", "kelvin_voigt"],
)
def test_impact_on_springs_is_that_of_lee_radok_and_ting(material, springs):
    """Restitution, duration, depth and force of a ball by an initial value problem."""
    exact = impact(BALL, 1.0, material, 1e-6, 1e-2)
    assert exact.error < 1e-6
    rebound = impact_on_springs(RelaxingSprings(paraboloid(1.0), springs), 1e-6, 1e-2, steps=400)
    # second order in 400 steps; with a dashpot d ~ t puts its kink t^(1/2) into the first steps
    assert rebound.restitution == pytest.approx(exact.restitution, abs=2e-5)
    assert rebound.duration == pytest.approx(exact.duration, rel=2e-5)
    assert rebound.penetration.max() == pytest.approx(exact.penetration, rel=2e-5)
    assert rebound.force.max() == pytest.approx(exact.force, rel=2e-4)


def test_a_mass_that_would_bury_the_ball_is_not_stopped():
    """100 kg at 20 m/s on rubber of 0.5 to 7.5 MPa: beyond 14 R no digit tells a from R."""
    material = GeneralisedMaxwell(5e5, (7e6,), (1e-3,))
    with pytest.raises(ConvergenceError, match="not stopped: 14 radii"):
        impact(closed_form.sphere(0.02, 2e6), 2e6, material, 100.0, 20.0)


POSITIVE = st.floats(1e-3, 1e3)
ARMS = st.lists(st.tuples(POSITIVE, POSITIVE), max_size=6)
MAYBE = st.one_of(st.just(0.0), POSITIVE)


def test_creep_of_a_dashpot_and_two_arms_is_that_of_its_differential_equations():
    """States are the strains of the dashpots; constant stress 1, integrated to 1e-10."""
    material = GeneralisedMaxwell(0.7, [2.0, 5.0], [0.3, 20.0], viscosity=0.4)
    G, tau = np.array([2.0, 5.0]), np.array([0.3, 20.0])

    def rates(_, state):
        strain, arms = state[0], state[1:]
        stress = 0.7 * strain + G @ (strain - arms)
        return np.array([(1 - stress) / 0.4, *((strain - arms) / tau)])

    t = np.array([0.1, 1.0, 30.0])
    result = solve_ivp(rates, (0, 30), np.zeros(3), "Radau", t, rtol=1e-10, atol=1e-13).y[0]
    np.testing.assert_allclose(material.creep(t), result, rtol=1e-8)


@given(equilibrium=MAYBE, arms=ARMS, viscosity=MAYBE)
def test_two_materials_written_apart_agree(equilibrium, arms, viscosity):
    """Relaxation, complex modulus and creep of the same springs and dashpots."""
    if not (equilibrium or arms or viscosity):
        return
    moduli, times = zip(*arms, strict=True) if arms else ((), ())
    here = prony(equilibrium, moduli, times, viscosity=viscosity)
    there = GeneralisedMaxwell(equilibrium, moduli, times, viscosity)
    t = np.geomspace(1e-4, 1e4, 9)
    np.testing.assert_allclose(there.relaxation(t), here.relaxation(t), rtol=1e-12, atol=0)
    w = np.concatenate([-t, t])
    np.testing.assert_allclose(there.dynamic_modulus(w), here.complex_modulus(w), rtol=1e-12)
    np.testing.assert_allclose(there.creep(t), here.creep().compliance(t), rtol=1e-9)
