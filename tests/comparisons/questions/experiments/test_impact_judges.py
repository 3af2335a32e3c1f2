"""What judges motion normal to the surface: vibrations, and waves that an impact radiates."""

import math

import pytest
from scipy.integrate import quad, solve_ivp

from comparisons.questions.experiments.vibrations import (
    contact_resonance,
    deepest_without_flight,
    forced_vibration,
    free_period,
    linear_amplitude,
    power_backbone,
    rayleigh_share,
    wave_impact,
)
from reference.closed_form import paraboloid, power_law
from reference.dynamics.collision import HERTZ_DURATION, weak_loss

BALL = paraboloid(1.0, 1.0)
LOAD = 1 / 6  # d0 = 1/4, k = 1


def test_hertzs_contact_resonance():
    """k^3 = 6 E*^2 R F0 (Johnson 1985, section 4.2)."""
    frequency = contact_resonance(paraboloid(0.02, 1e11), 0.1, 50.0)
    assert (0.1 * frequency**2) ** 3 == pytest.approx(6 * 1e22 * 0.02 * 50, rel=1e-12)


@pytest.mark.parametrize("exponent", [1, 2, 4])
def test_the_backbone_is_that_of_lindstedt(exponent):
    """1 - (q-1)(2q+1)/48 (A/d0)^2; the next order is (A/d0)^4: the rest falls by 16 at A/2."""
    form = power_law(exponent, 0.5, 1.0)
    static = float(form.penetration(0.1))
    w0 = contact_resonance(form, 1.0, 0.1)
    rests = []
    for part in (0.2, 0.1):
        deepest = static * (1 + part)
        ratio = 2 * math.pi / free_period(form, 1.0, 0.1, deepest) / w0
        # the amplitude is half the distance of the turning points
        energy = float(form.energy(deepest)) - 0.1 * deepest
        low = turning(form, 0.1, energy, static)
        amplitude = 0.5 * (deepest - low) / static
        rests.append(abs(ratio - power_backbone(exponent, amplitude)))
    assert rests[0] / rests[1] == pytest.approx(16, rel=0.35)


def turning(form, load, energy, static):
    """Upper turning point, by bisection."""
    low, high = 0.0, static
    for _ in range(100):
        x = 0.5 * (low + high)
        low, high = (x, high) if float(form.energy(x)) - load * x > energy else (low, x)
    return x


def test_contact_is_lost_from_1_842_of_the_static_depth_on():
    """2.5^(2/3) (the depth of a mass let go at first touch); the period is continuous there."""
    limit = deepest_without_flight(BALL, LOAD)
    assert limit / 0.25 == pytest.approx(2.5 ** (2 / 3), rel=1e-13)
    below, above = (free_period(BALL, 1.0, LOAD, limit * (1 + e)) for e in (-1e-10, 1e-10))
    # beyond, the flight grows as the square root of the energy: 2 v/g
    assert above == pytest.approx(below, rel=1e-4)


@pytest.mark.parametrize("deepest", [0.3, 0.45, 0.6, 1.0])
def test_free_periods_with_and_without_flight(deepest):
    """By energy against Runge and Kutta: two periods later the mass is back where it was."""
    period = free_period(BALL, 1.0, LOAD, deepest)
    run = solve_ivp(
        lambda _, y: [y[1], LOAD - float(BALL.force(max(y[0], 0.0)))],
        *((0, 2 * period), [deepest, 0.0]),
        method="DOP853",
        rtol=1e-11,
        atol=1e-13,
        max_step=0.01 * period,
    )
    # a time error e shows in the velocity as F e: both back to 1e-7
    assert abs(run.y[1, -1]) < 1e-6
    assert run.y[0, -1] == pytest.approx(deepest, rel=1e-9)


@pytest.mark.slow
def test_small_forced_vibrations_are_linear_and_larger_ones_soften():
    """P = 1e-3 F0 at resonance with 10 % of critical damping times two: P/(c w0), to (A/d0)^2.

    The mean of the vibration moves by -(A/d0)^2/12 d0: F is convex.
    """
    shift = []
    for share in (0.005, 0.01):
        motion = forced_vibration(
            BALL, 1.0, 0.1, LOAD, share * LOAD, 1.0, periods=40, tolerance=1e-8
        )
        linear = linear_amplitude(1.0, 1.0, 0.1, share * LOAD, 1.0)
        assert motion.amplitude == pytest.approx(linear, rel=(linear / 0.25) ** 2 + 1e-6)
        assert motion.flight == 0
        shift.append(1 - motion.mean / 0.25)
    assert shift[1] / shift[0] == pytest.approx(4, rel=0.02)


def test_two_thirds_of_the_radiated_power_are_rayleigh_waves():
    """67.4 % at nu = 1/4 (Miller and Pursey 1955).

    The share is the pole's residue on the real axis over an integral on the imaginary one: two
    paths around Lamb's integrand, so that a slip in either shows.
    """
    assert rayleigh_share(0.25) == pytest.approx(0.674, abs=0.001)


def body_waves(poisson_ratio):
    """Return what P and S waves radiate, by Lamb's integrand on the real axis.

    For k < g both roots are imaginary, for g < k < 1 one is (Miller and Pursey's P and S waves).
    """
    g2 = (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))

    def power(k: float) -> float:
        a = 1j * math.sqrt(g2 - k * k) if k * k < g2 else math.sqrt(k * k - g2)
        b = 1j * math.sqrt(1 - k * k)
        return abs((k * a / ((2 * k * k - 1) ** 2 - 4 * k * k * a * b)).imag)

    g = math.sqrt(g2)
    return quad(power, 0, g, limit=200)[0] + quad(power, g, 1, limit=200)[0]


@pytest.mark.parametrize("poisson_ratio", [0.25, 0.29, 0.3])
def test_slow_impacts_of_steel_radiate_the_power_of_hertzs_force(poisson_ratio):
    """Radiated share, int beta F'^2 dt / (m v^2/2), all by quadrature and in SI units.

    The radiated power is that of Miller and Pursey's waves on the real axis (body waves' branch
    cuts and the Rayleigh pole), F(t) is Hertz's exact history; nothing of `impact` enters. The
    next order of the loss is e ~ 5e-5 at v/c0 = 1e-7, so 1e-4 holds.
    """
    young, density, radius, slow = 210e9, 7800.0, 0.01, 1e-7
    speed = slow * math.sqrt(young / density)
    mass = density * 4 / 3 * math.pi * radius**3
    modulus = young / (2 * (1 - poisson_ratio**2))
    shear = young / (2 * (1 + poisson_ratio))
    stiffness = 4 / 3 * modulus * math.sqrt(radius)
    depth = (5 * mass * speed**2 / (4 * stiffness)) ** 0.4

    def radiated(x: float) -> float:  # (dF/dt)^2 dt = (F' x')^2 dx/x' at the depth x
        rate = speed * math.sqrt(1 - (x / depth) ** 2.5)
        return (1.5 * stiffness * math.sqrt(x)) ** 2 * rate

    waves = body_waves(poisson_ratio) / (1 - rayleigh_share(poisson_ratio))
    lag = waves / (2 * math.pi * shear * math.sqrt(shear / density))
    lost = 2 * lag * quad(radiated, 0, depth, epsabs=0)[0] / (0.5 * mass * speed**2)
    rebound = wave_impact(slow, poisson_ratio, elastic_sphere=True)
    assert rebound.energy_lost == pytest.approx(lost, rel=1e-4)


def test_the_loss_tends_to_its_first_order_linearly():
    """The relative difference of loss and first order halves with e, to 20 %."""
    rest = []
    for speed in (1e-4, 1e-4 / 2 ** (5 / 3)):
        rebound = wave_impact(speed)
        rest.append(weak_loss(rebound.radiation) / rebound.energy_lost - 1)
    assert rest[0] / rest[1] == pytest.approx(2, rel=0.2)


def test_without_waves_it_is_hertzs_impact():
    """Duration 2.9432 delta/v (Johnson (11.24)); a millionth of the speed of sound loses 0.07 %."""
    assert pytest.approx(2.9432, abs=1e-4) == HERTZ_DURATION
    slow = wave_impact(1e-6)
    assert slow.duration == pytest.approx(1, abs=1e-4)
    assert slow.restitution == pytest.approx(1 - slow.energy_lost / 2, rel=1e-6)
    assert slow.energy_lost < 1e-3


def test_heavy_spheres_radiate_less_of_their_energy():
    """As e = beta F v/delta^2 ~ m v^3/delta^3 and delta ~ (m v^2)^(2/5): e ~ m^(-1/5)."""
    light, heavy = (wave_impact(1e-6, density_ratio=ratio).radiation for ratio in (1.0, 32.0))
    assert light / heavy == pytest.approx(2.0, rel=1e-9)
