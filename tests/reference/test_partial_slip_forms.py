"""Closed forms of partial slip: Cattaneo, Mindlin & Deresiewicz, and what every path must keep."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.closed_form import (
    PartialSlip,
    cone,
    cylinder,
    paraboloid,
    power_law,
    stiffness_ratio,
)

E, MU, RATIO = 1.7, 0.3, 0.8
FORMS = [paraboloid(1.0, E), cone(0.2, E), power_law(4, 0.3, E)]


def test_cattaneo_and_the_unloading_of_mindlin():
    """Cattaneo 1938, Mindlin & Deresiewicz 1953 (Johnson 1985, (7.40), (7.46)).

    u = (3 mu F/(4 a G*)) {2 [1 - (T* - T)/(2 mu F)]^(2/3) - [1 - T*/(mu F)]^(2/3) - 1} on
    unloading from T*, with 4 a G* in place of Johnson's 16 a/((2 - nu)/G): rounding.
    """
    slip = PartialSlip(paraboloid(1.0, E), 0.7, MU, RATIO)
    a, top = np.sqrt(0.7), 0.8
    scale = 3 * slip.limit / (4 * a * RATIO * E)
    shares = np.array([0.8, 0.3, -0.6])
    path = slip.along(shares * slip.limit)
    expected = scale * np.concatenate(
        [
            [1 - (1 - top) ** (2 / 3)],
            2 * (1 - (top - shares[1:]) / 2) ** (2 / 3) - (1 - top) ** (2 / 3) - 1,
        ]
    )
    assert np.allclose(path.tangential_displacement, expected, rtol=1e-12)
    radii = a * np.concatenate([[(1 - top) ** (1 / 3)], (1 - (top - shares[1:]) / 2) ** (1 / 3)])
    assert np.allclose(path.stick_radius, radii, rtol=1e-12)


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
@given(shares=st.lists(st.floats(-0.98, 0.98), min_size=1, max_size=6))
@settings(max_examples=10, deadline=None)
def test_tractions_carry_the_force_within_the_friction(form, shares):
    """The integral of q is F_x (Gauss across root-like kinks: 1e-3) and |q| <= mu p."""
    slip = PartialSlip(form, 0.5, MU, RATIO)
    path = slip.along(np.array(shares) * slip.limit)
    a = float(form.contact_radius(0.5))
    nodes, weights = np.polynomial.legendre.leggauss(400)
    t = (nodes + 1) * np.pi / 4
    r = a * np.sin(t)  # the pressures vanish like roots at the rim
    q = path.traction(r, 0.0)
    force = float(np.sum(weights * np.pi / 4 * 2 * np.pi * r * q * a * np.cos(t)))
    assert force == pytest.approx(path.tangential_force[-1], abs=1e-3 * slip.limit)
    assert (np.abs(q) <= MU * form.pressure(r, 0.0, 0.5) * (1 + 1e-9)).all()


@given(shares=st.lists(st.floats(-1, 1), min_size=2, max_size=10))
@settings(max_examples=50, deadline=None)
def test_points_on_a_monotone_way_leave_no_trace(shares):
    """Stopping half-way changes nothing, and the mirrored path mirrors."""
    slip = PartialSlip(cone(0.2, E), 0.5, MU, RATIO)
    direct = slip.along(np.array(shares) * slip.limit)
    way = np.array(shares)
    half_way = (way[1:] + way[:-1]) / 2
    with_stops = np.append(way[:1], np.column_stack([half_way, way[1:]]).ravel())
    stopped = slip.along(with_stops * slip.limit)
    # where all slides, mu d E*/G*
    unit = slip.friction * slip.penetration / slip.modulus_ratio
    gap = stopped.tangential_displacement[::2] - direct.tangential_displacement
    assert np.abs(gap).max() < 1e-12 * unit
    mirrored = slip.along(-np.array(shares) * slip.limit)
    both = mirrored.tangential_displacement + direct.tangential_displacement
    assert np.abs(both).max() < 1e-12 * unit


def test_ratio_of_ellipses_joins_at_the_circle():
    """Series and elliptic integrals meet, and the two directions share cos^2 and sin^2."""
    for nu in (-0.5, 0.3, 0.5):
        near, circle = stiffness_ratio(1.0, 1 - 6e-6, nu), stiffness_ratio(1.0, 1.0, nu)
        assert near == pytest.approx(circle, rel=1e-5)
        assert circle == pytest.approx(2 * (1 - nu) / (2 - nu), rel=1e-14)
        one, other = stiffness_ratio(3.0, 1.0, nu), stiffness_ratio(1.0, 3.0, nu)
        assert 2 / (1 / one + 1 / other) == pytest.approx(circle, rel=1e-12)


def test_a_flat_punch_sticks_whole():
    slip = PartialSlip(cylinder(2.0, E), 0.1, MU, RATIO)
    path = slip.along([0.4 * slip.limit])
    stiffness = RATIO * 2 * E * 2.0
    assert path.tangential_force / path.tangential_displacement == pytest.approx(stiffness)
