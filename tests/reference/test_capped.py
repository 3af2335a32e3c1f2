"""Half-space with a capped pressure: elastic limit, full yield, memory, energy, what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from reference.contact.press import press, sweep
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.halfspace.areas import located_area
from reference.loads import Load, LoadPath
from reference.plastic.capped import along
from reference.surfaces import SelfAffine, self_affine

N, RADIUS, DEPTH = 48, 200.0, 1.0
X = np.arange(N) - N / 2 + 0.5
BALL = (X[:, None] ** 2 + X**2) / (2 * RADIUS)
FREE = FreeOperator((N, N), (1.0, 1.0), 1.0)
PEAK = 2 / np.pi * np.sqrt(DEPTH / RADIUS)  # of Hertz's pressure at that depth


def ball(hardness: float):
    """Return a half-space and a ball over it, units of cells and E*, and the hardness."""
    return FREE, BALL, hardness


def pressed(body, gap, hardness: float, *depths: float, control: str = "penetration"):
    path = LoadPath(control, np.array(depths))
    return list(along(body, gap, hardness, path, tolerance=1e-9))


# of unit period, the shortest wave 12 cells long
WAVES = SelfAffine(power=3.0, rms_height=5e-3, short_cutoff=0.25)
HEIGHTS = self_affine(N, 1.0, WAVES, seed=5, realisation=0)
ROUGH = PeriodicOperator((N, N), (1 / N, 1 / N), 1.0), HEIGHTS.max() - HEIGHTS


def test_a_body_that_is_hard_enough_is_elastic_to_the_last_digit():
    loads = np.array([1e-4, 1e-3])
    elastic = list(sweep(*ROUGH, Load("force", loads)))
    enough = 1.001 * elastic[-1].pressure.max()
    for hardness in (np.inf, enough):
        (first, last) = along(*ROUGH, hardness, LoadPath("force", loads))
        assert first.dissipated == last.dissipated == last.residual_depth == 0.0
        assert first.plastic_share == 0.0
        assert_array_equal(first.contact.pressure, elastic[0].pressure)
        assert_allclose(last.contact.pressure, elastic[1].pressure, atol=1e-7 * enough)


def test_in_full_yield_the_force_is_the_hardness_times_the_area():
    # PEAK/H = 90; a rigid-plastic body touches where shape and plane overlap, pi 2 R d
    (dent,) = pressed(*ball(PEAK / 90), DEPTH)
    area = located_area(dent.contact, PEAK / 90)
    assert_allclose(dent.contact.force, PEAK / 90 * area, rtol=5e-3)
    assert_allclose(area, 2 * np.pi * RADIUS * DEPTH, rtol=0.02)
    assert dent.plastic_share > 0.99


@pytest.mark.parametrize("hardness", [3e-4, 3e-3])
def test_no_mean_pressure_is_above_the_hardness(hardness):
    # a rim that yields is no elastic one: its located line lies up to half a per cent too far in
    (dent,) = pressed(*ROUGH, hardness, 0.003)
    least = dent.contact.force / hardness
    assert least * (1 - 1e-12) <= located_area(dent.contact, hardness) < 1.001 * least


@pytest.mark.parametrize(("body", "gap", "hardness"), [ball(PEAK / 2), (*ROUGH, 0.02)])
def test_unloading_is_elastic_on_what_is_left_and_reloading_finds_the_state_again(
    body, gap, hardness
):
    depth = DEPTH if body is FREE else 0.006
    down, half, away, again = pressed(body, gap, hardness, depth, 0.9 * depth, 0.0, depth)
    assert down.plastic_share > 0.2
    assert_array_equal(half.sunk, down.sunk)
    assert half.contact.force < 0.9 * down.contact.force
    assert away.contact.force == 0.0
    assert 0 < down.residual_depth < depth
    assert_allclose(again.contact.force, down.contact.force, rtol=1e-6)
    # elastic contact with the dented surface by the other solver, above its first touch
    if body is FREE:
        other = press(FREE, gap + down.sunk, Load("penetration", 0.9 * depth), by="pivot")
        assert_allclose(half.contact.force, other.force, rtol=1e-6)


@pytest.mark.slow
def test_work_is_elastic_energy_and_dissipation():
    # the trapezoidal rule over 80 steps down and 40 up
    path = DEPTH * np.append(np.linspace(0, 1, 81)[1:], np.linspace(1, 0, 41)[1:])
    dents = pressed(*ball(PEAK / 3), *path)
    last, away = dents[79], dents[-1]
    assert_allclose(last.elastic + last.dissipated, last.work, rtol=3e-4)
    assert 0.2 < last.dissipated / last.work < 1
    assert (np.diff([dent.dissipated for dent in dents[:80]]) >= 0).all()
    # unloaded, all that is left of the work has been dissipated
    assert_allclose(away.dissipated, away.work, rtol=2e-3)


@pytest.mark.parametrize(("body", "gap", "hardness"), [ball(PEAK / 2), (*ROUGH, 0.01)])
def test_forces_and_penetrations_are_one_curve(body, gap, hardness):
    depths = np.array([0.3, 1.0]) * (DEPTH if body is FREE else 0.005)
    forces = [dent.contact.force for dent in pressed(body, gap, hardness, *depths)]
    by_force = pressed(body, gap, hardness, *forces, control="force")
    assert_allclose([dent.contact.penetration for dent in by_force], depths, rtol=1e-6)


def test_what_the_hardness_cannot_carry_is_refused():
    with pytest.raises(ConvergenceError, match="hardness carries less"):
        pressed(*ROUGH, 0.01, 0.011, control="force")
    with pytest.raises(ValueError, match="nothing holds"):
        pressed(*ROUGH, 0.01, -1.0, control="force")
    with pytest.raises(ValueError, match="hardness must be positive"):
        pressed(FREE, BALL, 0.0, 1.0)
    with pytest.raises(ValueError, match="elastic"):
        press(FREE, BALL, Load("penetration", 0.001), cap=1.0, by="pivot")
