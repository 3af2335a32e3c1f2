"""Creep coefficients from strips, beside Kalker's table and square cells."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from comparisons.questions.experiments.rolling import CreepCoefficients, creep_coefficients
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.rolling.creep_theories import on_grid


@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_strips_have_the_limit_of_square_cells(ratio):
    """Square cells, of first order and with steps along the outline, are within 0.7 % on 22.

    Of spin, whose lever is the outline's, C23 within 1.5 % and C33 within 4 % on 11.
    """
    compliance = Compliance.of(1.0, 0.5)
    counts = np.array([6, 8, 11])
    values = [
        on_grid(lambda s, h: NormalAndTangential(s, (h, h), compliance), ratio, int(count))
        for count in counts
    ]
    line = np.polyfit(1 / counts, np.array(values), 1)[1]
    errors = np.abs(line / creep_coefficients(0.5, ratio, (5, 6, 8)).limit - 1)
    assert (errors < [0.01, 0.01, 0.015, 0.04]).all()


def test_creep_coefficients_converge_faster_than_the_cells_shrink():
    """Of an order between the 3/2 of the ends of strips and 2; the bar of coarse grids holds.

    C33 has reached its limit, from either side, to 0.6 % before.
    """
    coarse, fine = (creep_coefficients(0.25, 2.0, grids) for grids in ([4, 5, 6], [8, 9, 12]))
    errors = [study.values[0] - fine.limit for study in (coarse, fine)]
    assert (np.log2(errors[0][:3] / errors[1][:3]) > 1.5).all()
    assert (np.abs(coarse.limit - fine.limit) < coarse.uncertainty).all()
    assert (fine.uncertainty < [3e-3, 3e-3, 3e-2, 3e-3] * fine.limit).all()


def test_grids_that_agree_on_a_line_have_no_uncertainty_but_the_last_step():
    values = np.array([[5.0, 1.0]]) + np.array([[1.0, -1.0]]) / np.array([[8.0], [16], [32]]) ** 2
    study = CreepCoefficients.of((8, 16, 32), values)
    assert_allclose(study.limit, [5.0, 1.0], rtol=1e-12)
    assert_allclose(study.uncertainty, 1 / 32**2, rtol=1e-9)
