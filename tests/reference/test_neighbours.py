"""Punches side by side: the point force of the far field, and its corrections."""

import numpy as np
import pytest

from reference.halfspace.punches import array_force, pair_force


@pytest.mark.parametrize("distance", [6.0, 20.0, 60.0])
def test_far_apart_the_other_punch_is_a_point_force(distance):
    """F/F_single = 1/(1 + 2a/(pi s)), corrections of the relative order (a/s)^2."""
    point = 2 / (np.pi * distance)
    interaction = 1 / pair_force(distance, 10) - 1
    assert interaction == pytest.approx(point, rel=1.5 / distance**2)


def test_the_interaction_does_not_need_a_fine_edge():
    """With the radius of its own stiffness the staircase cancels: 0.2 % from 4 to 16 cells."""
    coarse, fine = (1 / pair_force(4.0, cells) - 1 for cells in (4, 16))
    assert coarse == pytest.approx(fine, rel=2e-3)


def test_an_array_tends_to_the_punch_of_its_own_area():
    """Many punches are less stiff than a square punch over all of them, but not by much.

    The square of area A has the stiffness 1.0212 times 2 E* sqrt(A/pi) (theory.md: checked); 900
    punches at three diameters keep 0.7 of it.
    """
    distance, per_side = 6.0, 30
    total = per_side**2 * 2 * array_force(distance, per_side)
    side = per_side * distance
    assert total < 1.0212 * 2 * side / np.sqrt(np.pi)
    assert total > 0.7 * 1.0212 * 2 * side / np.sqrt(np.pi)


def test_arrays_and_pairs_agree_where_they_meet():
    """Four punches at the corners: three neighbours as point forces, by hand."""
    point = 2 / (np.pi * 10.0)
    assert array_force(10.0, 2) == pytest.approx(1 / (1 + point * (2 + 1 / np.sqrt(2))), rel=1e-12)


def test_wrong_arguments_are_all_named():
    with pytest.raises(ValueError, match="distance"):
        pair_force(2.0, 8)
    with pytest.raises(ValueError, match="cells"):
        pair_force(4.0, 1)
    with pytest.raises(ValueError, match=r"distance.*per_side"):
        array_force(1.0, 0)
