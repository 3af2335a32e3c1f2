"""Forces on pairs and arrays of flat punches."""

import numpy as np
import pytest

from comparisons.questions.experiments.bodies import array_force, pair_force


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


def test_arrays_and_pairs_agree_where_they_meet():
    """Four punches at the corners: three neighbours as point forces, by hand."""
    point = 2 / (np.pi * 10.0)
    assert array_force(10.0, 2) == pytest.approx(1 / (1 + point * (2 + 1 / np.sqrt(2))), rel=1e-12)
