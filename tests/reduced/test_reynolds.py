"""A film on a line of springs: rigid limits by its free width, and what it conserves."""

import numpy as np
import pytest

from reduced.film import RULES, Ball, approach, entrain


def test_a_rigid_ball_is_squeezed_right_with_the_width_for_it():
    """B = 4 sqrt(R h0): h = 6 pi eta R^2 V/F; with another width it is not."""
    exact = 6 * np.pi * 1e-4 * 1e-4 / 0.1
    film = approach(Ball(0.01, 1e13, 1.0, 0.1, "rigid"), 1e-4, 64)
    # cells, by second order
    assert film.film_minimum == pytest.approx(exact, rel=5e-4)
    assert approach(Ball(0.01, 1e10, 1.0, 0.1, "hertz"), 1e-4, 32).film_minimum < 0.7 * exact


@pytest.mark.parametrize("rule", ["rigid", "hertz"])
def test_stiff_springs_are_solved_to_their_round_off(rule):
    """The flow is a small difference there; what is reached is far below the cells' error."""
    for modulus in np.geomspace(1e10, 1e12, 5):
        assert approach(Ball(0.01, modulus, 1.0, 0.1, rule), 1e-4, 16).error < 1e-8


@pytest.mark.parametrize("load", [0.01, 0.02, 0.04])
def test_a_small_ball_is_squeezed_like_a_large_one(load):
    """R is 3.6 to 7.3 reaches of the film: the paraboloid goes on beyond it, as its formula's."""
    exact = 6 * np.pi * 1e-4 * 1e-3 / load
    film = approach(Ball(0.01, 1e13, 1.0, load, "rigid"), 1e-3, 32)
    assert film.film_central == pytest.approx(exact, rel=2e-3)


def test_a_rigid_ball_is_entrained_by_the_line_as_by_its_cylinder():
    """B = 5.33 sqrt(R h0) of half-Sommerfeld; W = 4.895 eta U (R/2)/h0 B fixes h0 of the line."""
    film = entrain(Ball(0.01, 1e16, 1e-3, 0.1, "rigid"), 1.0, 64)
    half = (24 / 5 * np.pi / np.sqrt(2) * 1e-3 * 0.01**1.5 / 0.1) ** 2
    width = 12 / 5 * np.pi / np.sqrt(2) * np.sqrt(0.01 * half)
    line = 4.894968 * 1e-3 * (0.01 / 2) * width / 0.1
    assert film.film_minimum == pytest.approx(line, rel=2e-3)


@pytest.mark.parametrize("rule", RULES)
def test_the_film_carries_the_load_and_thins_with_the_speed(rule):
    """Every rule: the load is met, less speed leaves less film, vapour lies behind."""
    films = [entrain(Ball(0.01, 1e6, 1.0, 0.2, rule), speed, 32) for speed in (1e-1, 1e-2)]
    for film in films:
        assert film.load == pytest.approx(0.2, rel=1e-9)
        assert film.error < 1e-10
        assert (film.thickness > 0).all()
        assert not (film.pressure * film.vapour).any()
        assert film.x[film.vapour > 0].min() > 0
    assert films[1].film_central < films[0].film_central
