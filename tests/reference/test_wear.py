"""Worn shapes on the half-space: waves, balls, fretting; closed forms of worn bodies."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reference.closed_form import cylinder, paraboloid
from reference.closed_form.worn import FrettingLimit, WornPunch
from reference.halfspace.kernels import FreeOperator, PeriodicOperator
from reference.halfspace.wear import Oscillation, wear
from reference.loads import Load


def ball(per_radius: int, half: float):
    """Return a half-space with so many cells per unit, and a paraboloid of unit radius."""
    n = int(np.ceil(half * per_radius))
    x = (np.arange(2 * n) - n + 0.5) / per_radius
    operator = FreeOperator((2 * n, 2 * n), (1 / per_radius,) * 2, 1.0)
    return operator, (x[:, None] ** 2 + x**2) / 2


def last(*args, **kwargs):
    return list(wear(*args, **kwargs))[-1]


def test_wave_in_full_contact_wears_off_exponentially():
    """K dp/ds + k p = 0 with K = 2/(E* q): exp(-k E* q s/2), to the second order of the steps."""
    n, length = 16, 1.0
    operator = PeriodicOperator((n, n), (length / n,) * 2, 1.0)
    wave = np.cos(2 * np.pi * np.arange(n) / n)[:, None] * np.ones(n)
    state = last(operator, 0.01 * (1 - wave), Load("force", 1.0), 1.0, np.array([0.3]))
    amplitude = np.ptp(state.contact.pressure) / 2
    exact = 0.01 * np.pi * np.exp(-np.pi * 0.3)
    assert_allclose(amplitude, exact, rtol=5e-3)
    assert_allclose(state.volume, 0.3, rtol=1e-9)


def test_volume_is_archards_to_round_off():
    state = last(*ball(6, 1.9), Load("force", 4 / 3), 0.5, np.array([0.4]))
    assert_allclose(state.volume, 0.5 * state.contact.force * 0.4, rtol=1e-12)
    assert_allclose(state.contact.force, 4 / 3, rtol=1e-12)


@pytest.mark.slow
def test_fretting_ends_at_popovs_limit():
    """Cells know a stick circle of four of them to their own width, and the force by 3 %."""
    limit = FrettingLimit(paraboloid(1.0, 1.0), 1.0, 0.5)
    body, gap = ball(6, 1.3)
    state = last(body, gap, Load("penetration", 1.0), 1.0, np.array([3.0]), Oscillation(1.0, 0.5))
    assert_allclose(state.contact.force, limit.force, rtol=0.03)
    radius = np.sqrt(state.sticking.sum() / np.pi) / 6
    assert abs(radius - limit.stick_radius) < 1 / 6
    assert not state.depth[state.sticking].any()


def test_full_slip_leaves_no_stick():
    body, gap = ball(6, 1.3)
    state = last(body, gap, Load("penetration", 1.0), 1.0, np.array([0.1]), Oscillation(1.0, 2.0))
    assert not state.sticking.any()
    # all slips by at least U - (mu E*/G*) d = U (1 - d/lag)
    assert (state.depth[state.contact.mask] > 0).all()


def test_worn_punch_starts_rigid_and_ends_uniform():
    punch = WornPunch(2.0, 3.0, 0.1)
    form = cylinder(2.0, 3.0)
    depth, force, _ = punch.at_penetration(0.01, 1e-2)
    assert_allclose(force, form.force(depth), rtol=3e-3)  # k E* s/b = 1.5e-3
    # mean deflection of a uniform pressure: 16 p b/(3 pi E*) over its own circle
    sunk, _, volume = punch.under_force(1.0, 2e3)
    assert_allclose(volume, 0.1 * 2e3, rtol=1e-12)
    mean = 1 / (np.pi * 4)
    assert_allclose(sunk - 0.1 * mean * 2e3, 16 * mean * 2 / (3 * np.pi * 3), rtol=1e-6)


def test_worn_punch_loses_what_archard_says():
    punch = WornPunch(1.0, 1.0, 1.0)
    s = np.linspace(1e-3, 1.0, 400)
    force = np.array([punch.at_penetration(1.0, float(at))[1] for at in s])
    volume = [punch.at_penetration(1.0, float(at))[2] for at in (s[0], s[-1])]
    assert_allclose(np.diff(volume)[0], np.trapezoid(force, s), rtol=1e-4)
