"""Films below rough balls: the linear wave, the smooth limit, mass, symmetry."""

from dataclasses import replace

import numpy as np
import pytest

from reference.errors import ConvergenceError
from reference.lubrication import formulas
from reference.lubrication.point import Ball, entrain, self_affine, waviness

SOFT = Ball(radius=0.01, effective_modulus=1e6, viscosity=1.0, load=0.2)
LONG = 1e-3


@pytest.mark.slow
def test_a_small_wave_under_a_film_has_the_amplitude_of_the_linear_theory():
    """The change of h over A: 1/(1 + 24 i eta U/(E* q^2 h^3)) in the middle."""
    wave = waviness(1e-8, LONG / 2)
    up, down = (
        entrain(replace(SOFT, waves=replace(wave, phases=np.array([phase]))), 1e-2, 16)
        for phase in (0.0, np.pi)
    )
    film = (up.film_central + down.film_central) / 2
    x, q = up.x, 4 * np.pi / LONG
    near = np.abs(x) < LONG / 4
    j = up.y.size // 2
    change = (up.thickness - down.thickness)[near, j] / 2e-8
    basis = np.array([np.cos(q * x[near]), np.sin(q * x[near]), np.ones(near.sum()), x[near]]).T
    cosine, sine, *_ = np.linalg.lstsq(basis, change, rcond=None)[0]
    linear = formulas.wave_amplitude(q, 1e6, 1.0, 1e-2, film)
    # a middle that is flat over two wavelengths only, 16 cells per l
    assert complex(-cosine, sine) == pytest.approx(linear, abs=0.05)
    assert abs(linear) < 0.87  # not the wave as it is


@pytest.mark.slow
def test_the_film_of_a_ball_hardly_rough_is_the_smooth_one_and_keeps_its_mass():
    """Of second order in the waves but for the middle itself; mass in every cell to 1e-10."""
    smooth = entrain(SOFT, 1e-2, 10)
    for rms in (1e-12, 2e-7):
        waves = self_affine(rms, 0.8, 2e-3, 1e-3, seed=1)
        film = entrain(replace(SOFT, waves=waves), 1e-2, 10)
        assert film.error < 1e-10
        assert film.load == pytest.approx(SOFT.load, rel=1e-9)
        assert film.film_central == pytest.approx(smooth.film_central, abs=3 * rms + 1e-12)
        assert film.film_minimum == pytest.approx(smooth.film_minimum, abs=3 * rms + 1e-12)


def test_half_of_an_even_film_is_the_whole():
    """A wave along the flow is even in y; the same cells without the mirror give the same film."""
    even = waviness(5e-7, LONG, "along")
    odd = replace(even, along=np.array([1e-9 / LONG]))
    films = [entrain(replace(SOFT, waves=waves), 1e-2, 8) for waves in (even, odd)]
    assert even.even
    assert not odd.even
    assert films[0].film_minimum == pytest.approx(films[1].film_minimum, rel=1e-6)
    assert films[0].thickness.shape == films[1].thickness.shape


def test_heights_have_the_rms_that_is_asked_for_and_waves_need_cells():
    """The mean square of many points; six cells per wave."""
    waves = self_affine(3e-7, 0.8, 2e-3, 2.5e-4, seed=2)
    x = np.linspace(0, 2e-3, 64, endpoint=False)
    assert np.sqrt((waves.at(x, x) ** 2).mean()) == pytest.approx(3e-7, rel=1e-9)
    with pytest.raises(ValueError, match="need 6 cells"):
        entrain(replace(SOFT, waves=waves), 1e-2, 16)


def test_the_shortest_wave_is_there_in_every_unit():
    """75e-6 over 25e-6 is 2.9999999999999996."""
    one = self_affine(1.0, 0.8, 75.0, 25.0, seed=1)
    other = self_affine(1e-6, 0.8, 75e-6, 25e-6, seed=1)
    assert other.shortest == pytest.approx(25e-6)
    np.testing.assert_allclose(other.heights / 1e-6, one.heights, rtol=1e-12)


def test_crests_higher_than_any_film_are_a_lost_film_never_nan():
    high = replace(SOFT, waves=waviness(1e-3, LONG))
    with pytest.raises(ConvergenceError, match="too thin for its cells") as caught:
        entrain(high, 1e-2, 8)
    assert np.isfinite(caught.value.history).all()
