"""Closed forms of dents and rebounds: limits of the books, and work by quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from reference.elasticity import Material
from reference.loads import LoadPath
from reference.plastic import PlasticMaterial, Walk
from reference.plastic.theories import (
    cavity_pressure,
    johnson_restitution,
    thornton_restitution,
)


@pytest.mark.parametrize("share", [1.5, 10.0, 1e4])
def test_thorntons_rebound_is_the_work_below_a_pressure_that_is_cut_off(share):
    # units of first yield on R = E* = 1: pressure 2 sqrt(d_y)/pi
    yields = 1e-6
    cut = 2 * np.sqrt(yields) / np.pi

    def force(depth: float) -> float:
        """Return Hertz's pressure over the contact, no more than the cut."""
        a = np.sqrt(depth)
        inner = a * np.sqrt(max(0.0, 1 - (yields / depth)))
        rim = quad(lambda r: 4 * r * np.sqrt(max(0.0, depth - r * r)), inner, a)[0]
        return float(np.pi * inner**2 * cut + rim)

    depth = share * yields
    work = quad(force, 0, depth, points=[yields], epsabs=0, limit=200)[0]
    largest = force(depth)
    # the flattened ball has the radius of the same contact: R_p = (4/3) E* a^3/F
    back = 3 / 10 * largest**2 / np.sqrt(depth)
    speed = np.sqrt(work / (8 / 15 * yields**2.5))
    assert_allclose(thornton_restitution(speed), np.sqrt(back / work), rtol=1e-6)


def test_rebounds_have_the_limits_of_their_sources():
    # Thornton 1997: 1.18 (v_y/v)^(1/4); Johnson 1985 (11.49): 3.8 (Y/E*)^(1/2) (W/(Y R^3))^(-1/8)
    assert_allclose(thornton_restitution(1e8) * 1e2, 1.185, rtol=1e-3)
    assert_allclose(johnson_restitution(1e-3, 1e-3), 3.8 * np.sqrt(1e-3) * 1e3**0.125, rtol=0.02)
    assert thornton_restitution(0.1) == 1.0
    with pytest.raises(ValueError, match="speed must be positive"):
        thornton_restitution([1.0, 0.0])


def test_a_cavity_is_between_first_and_full_yield():
    # Johnson 1985, 6.3: about 1.1 Y where Hertz's contact first yields, 3 Y at E a/(Y R) near 40
    assert 1.0 < cavity_pressure(2.3, 0.3) < 1.3
    assert_allclose(cavity_pressure(38.0, 0.5), 3.0, rtol=0.02)


def test_an_elastic_half_space_gives_back_all_work():
    ball = Walk(
        PlasticMaterial(Material(0.91, 0.3), np.inf), lambda r: r**2 / 2, 0.12, per_radius=3
    )
    (moment,) = ball.along(LoadPath("penetration", 0.01))
    # to the place of the edge between the points of its element
    assert_allclose(ball.given_back(moment, steps=3), moment.work, rtol=0.02)
