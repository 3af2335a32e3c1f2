"""Flow through rough plane gaps: stripes and spots in closed form, second order, ways through."""

import numpy as np
import pytest

from comparisons.questions.experiments.plane_flow import (
    effective_medium_factor,
    plane_flow,
    second_order_factors,
)


def wave(points):
    return np.cos(2 * np.pi * (np.arange(points) + 0.5) / points)


def rough(points, seed=0):
    """Return a gap of random cells, a fifth of them closed."""
    rng = np.random.default_rng(seed)
    gap = 0.2 + rng.random((points, points + 1))
    gap[rng.random(gap.shape) < 0.2] = 0.0
    return gap


def test_stripes_across_the_flow_are_in_series():
    """1/<h^-3> and <h^-2>/<h^-3> of h = 1 + a cos, exact for means over a whole period."""
    a = 0.5
    across = plane_flow(np.repeat((1 + a * wave(64))[:, None], 3, axis=1))
    cubes, squares = (1 + a**2 / 2) / (1 - a**2) ** 2.5, 1 / (1 - a**2) ** 1.5
    assert across.pressure_factor == pytest.approx(1 / cubes, rel=1e-12)
    assert across.shear_factor == pytest.approx(squares / cubes, rel=1e-12)


def test_stripes_along_the_flow_are_side_by_side():
    """<h^3> = 1 + 3 a^2/2, and sliding draws the mean gap along."""
    a = 0.5
    along = plane_flow(np.repeat((1 + a * wave(64))[None, :], 3, axis=0))
    assert along.pressure_factor == pytest.approx(1 + 1.5 * a**2, rel=1e-12)
    assert along.shear_factor == pytest.approx(1.0, rel=1e-12)


def test_what_two_crossed_waves_take_is_the_second_order_up_to_the_fourth():
    """Isotropic, and no odd order: errors fall by 16 as heights are halved."""
    crossed = wave(64)[:, None] + wave(64)[None, :]  # of rms one
    errors = []
    for roughness in (0.2, 0.1):
        flow = plane_flow(1 + roughness * crossed)
        stated = second_order_factors(roughness)
        errors.append((flow.pressure_factor - stated[0], flow.shear_factor - stated[1]))
    # cells change the second order by (2 pi/64)^2/12 = 8e-4 of itself: 3 % of what is left
    assert np.divide(*errors) == pytest.approx(16, rel=0.06)


def test_round_spots_of_contact_let_through_what_rayleigh_found():
    """A square array of closed discs in an even gap (1892); staircases are of first order."""
    errors = []
    for points in (32, 128):
        x = (np.arange(points) + 0.5) / points - 0.5
        gap = np.where(np.hypot(x[:, None], x) < np.sqrt(0.3 / np.pi), 0.0, 1.0)
        closed = 1 - gap.mean()
        through = plane_flow(gap).pressure_factor * gap.mean() ** 3
        errors.append(abs(through - 1 + 2 * closed / (1 + closed - 0.305827 * closed**4)))
    assert errors[1] < 0.01
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.2)


def test_every_section_passes_the_same_oil_and_no_cell_keeps_any():
    flow = plane_flow(rough(24))
    sections = flow.flow.sum(axis=1)
    assert sections == pytest.approx(sections[0], rel=1e-10)
    assert flow.imbalance < 1e-12


def test_sliding_draws_along_what_its_own_equation_says():
    """The factor of reciprocity against the pressure of sliding itself, by dense matrices."""
    gap = np.maximum(rough(6, seed=3), 0.3)
    n, m = gap.shape
    index = np.arange(n * m).reshape(n, m)
    matrix, right, faces = np.zeros((n * m, n * m)), np.zeros(n * m), []
    for axis in (0, 1):
        after = np.roll(index, -1, axis)
        for i, j in zip(index.ravel(), after.ravel(), strict=True):
            h, k = gap.flat[i], gap.flat[j]
            through = 2 / (h**-3 + k**-3)
            drawn = (h**-2 + k**-2) / (h**-3 + k**-3) if axis == 0 else 0.0
            for cell, sign in ((i, 1), (j, -1)):
                matrix[cell, i] += sign * through
                matrix[cell, j] -= sign * through
                right[cell] -= sign * drawn
            faces.append((axis, i, j, through, drawn))
    pressure = np.linalg.lstsq(matrix, right, rcond=None)[0]
    flow = [k * (pressure[i] - pressure[j]) + u for axis, i, j, k, u in faces if axis == 0]
    assert plane_flow(gap).shear_factor == pytest.approx(np.mean(flow) / gap.mean(), rel=1e-10)


def test_no_oil_passes_where_contact_closes_every_way():
    """A wall; a wall with a door; a winding stripe that needs two periods across for one along."""
    wall = np.ones((12, 8))
    wall[5] = 0.0
    closed = plane_flow(wall)
    assert not closed.open
    assert closed.pressure_factor == closed.shear_factor == 0.0
    wall[5, 3] = 1.0
    assert plane_flow(wall).open
    i, j = np.indices((12, 24))
    stripe = np.where((2 * i - j) % 24 < 4, 1.0, 0.0)
    winding = plane_flow(stripe)
    assert winding.open
    assert winding.pressure_factor > 0
    # along x it closes upon itself; across a wall of its own there is no way
    stripe[0] = 0.0
    assert not plane_flow(stripe).open


def test_a_narrow_door_lets_through_the_cube_of_its_gap():
    """Pools before and behind hold no pressure; half a cell of the door's width to either side.

    A door of 1e-3 falls short of the limit by 3e-5. The mean flow of a door of 1e-6 would be
    2000 times too large: 1e-18 of what flows through a cell of a pool, whose rounding is 1e-16.
    """
    door = np.ones((12, 12))
    door[5] = 0.0
    factors = []
    for gap in (1e-3, 1e-6):
        door[5, 3] = gap
        factors.append(plane_flow(door).pressure_factor / gap**3)
    assert factors[1] == pytest.approx(factors[0], rel=1e-4)


def test_pockets_of_oil_change_nothing():
    """A pocket inside a spot of contact, and the flow around it: equal but for the mean gap."""
    spot = np.ones((16, 16))
    spot[4:11, 4:11] = 0.0
    pocket = spot.copy()
    pocket[6:9, 6:9] = 2.0
    flows = [plane_flow(gap).flow for gap in (spot, pocket)]
    np.testing.assert_allclose(flows[1], flows[0], atol=1e-12)


def test_flow_is_the_same_in_every_unit():
    gap = rough(12)
    here, there = plane_flow(gap), plane_flow(1e-9 * gap)
    assert there.pressure_factor == pytest.approx(here.pressure_factor, rel=1e-12)
    np.testing.assert_allclose(there.flow * 1e27, here.flow, atol=1e-12)


def test_an_effective_medium_lies_between_series_and_parallel_and_closes_at_half():
    """And is exact where it must be: two gaps, half each, are their geometric mean (Dykhne)."""
    assert effective_medium_factor([1.0, 3.0]) == pytest.approx(27**0.5 / 8, rel=1e-9)
    gaps = 0.1 + np.random.default_rng(0).random(1000)
    mean = gaps.mean() ** 3
    medium = effective_medium_factor(gaps)
    assert 1 / (gaps**-3).mean() / mean < medium < (gaps**3).mean() / mean
    assert effective_medium_factor([0.0, 0.0, 1.0]) == 0.0
    # one part in five closed of an even gap: 1 - 2 f
    assert effective_medium_factor([0, 1, 1, 1, 1]) * 0.8**3 == pytest.approx(0.6)


@pytest.mark.filterwarnings("error")
def test_a_gap_that_vanishes_is_closed():
    """Its cube is below the smallest number: h^-3 overflows."""
    gap = np.ones((4, 4))
    gap[1, 2] = 1e-120
    spot = np.where(gap < 1, 0.0, gap)
    assert plane_flow(gap).pressure_factor == plane_flow(spot).pressure_factor
    assert effective_medium_factor([1e-120, 1e-120, 1.0]) == 0.0
