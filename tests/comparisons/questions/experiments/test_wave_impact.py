"""Radiated waves: Lamb's integrals by two paths, and impacts with them."""

import math

import pytest
from scipy.integrate import quad

from comparisons.questions.experiments.wave_impact import rayleigh_share, wave_impact
from reference.dynamics.collision import HERTZ_DURATION, weak_loss


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
