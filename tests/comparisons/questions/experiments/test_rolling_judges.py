"""What judges rolling in single experiments: strips and cylinders."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from comparisons.questions.experiments.rolling import CreepCoefficients, creep_coefficients
from comparisons.questions.experiments.rolling_cylinders import (
    Carter,
    PlaneElements,
    PlaneSurface,
    RubberCylinder,
    hertz,
    moving_compliance,
)
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.loads import Load
from reference.rolling.creep_theories import on_grid
from reference.rolling.roll import Upstream, steady
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.rubber import slide_on_rubber
from reference.viscoelastic.travelling import TravellingPlane


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


@pytest.mark.slow
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


def carter_on_a_grid(cells, traction):
    cylinder = Carter(1.0, 100.0, 0.3)
    side = 1.0 / cells
    x = (np.arange(-cells, cells + 1) + 0.5) * side
    compliance = Compliance.of(1.0, 0.5)
    # a^2 = 4 F R/(pi E*)
    force = np.pi * compliance.effective_modulus / (4 * 100.0)
    pressure = hertz(x, 1.0, force)[:, None]
    flow = Upstream(PlaneSurface(x.size, side, compliance), pressure.shape)
    creep = np.zeros((2, x.size, 1))
    creep[0] = cylinder.creep(traction)
    answer = steady(flow, 0.3 * pressure, creep)
    return answer, answer.traction[0].sum() / (0.3 * pressure.sum()), x, cylinder


@pytest.mark.parametrize("inertia", [0.0, 0.3])
def test_elements_far_from_a_load_are_the_half_space_softer_where_it_moves(inertia):
    """From 8 to 20 cells away; antiplane, by Lorentz's contraction, 1/sqrt(1 - rho V^2/G)."""
    grid = 64, 0.05, Compliance.of(1.0, 0.25)
    cells = PlaneSurface(*grid).shear_coefficients()[:2, [8, 14, 20], 0]
    elements = PlaneElements(*grid, 0.25, inertia).shear_coefficients()[:2, [8, 14, 20], 0]
    softer = np.array([[moving_compliance(0.25, inertia)], [1 / np.sqrt(1 - inertia)]])
    assert_allclose(np.diff(elements), softer * np.diff(cells), rtol=1e-3)


@pytest.mark.parametrize("traction", [0.2, 0.5, 0.9])
def test_cylinder_is_carters(traction):
    answer, there, x, cylinder = carter_on_a_grid(160, traction)
    assert abs(there / traction - 1) < 0.01
    stick = np.flatnonzero((np.abs(x) < 1) & ~answer.sliding[:, 0])
    # in one piece, from the leading edge
    assert stick.size == np.ptp(stick) + 1
    creep = cylinder.creep(traction)
    assert_allclose(stick.size / 320, cylinder.stick_share(creep), atol=0.01)
    exact = 0.3 * hertz(0.0, 1.0, np.pi * 4 / 400) * cylinder.shear(x, creep)
    assert np.abs(answer.traction[0, :, 0] - exact).mean() < 0.01 * exact.max()


def test_creep_of_a_traction_is_the_inverse_and_none_is_beyond_full_slip():
    """To rounding, up to the full creep mu a/R, of either sign."""
    cylinder, tractions = Carter(1.0, 100.0, 0.3), np.array([-1.0, -0.3, 0.0, 1e-12, 0.99, 1.0])
    creeps = cylinder.creep(tractions)
    assert_allclose(cylinder.traction(creeps), tractions, rtol=1e-12)
    assert creeps[-1] == cylinder.full_creep


def test_plane_rolling_is_of_first_order_in_the_cells():
    errors = [carter_on_a_grid(n, 0.5)[1] / 0.5 - 1 for n in (20, 40, 80)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(orders - 1) < 0.25).all()


@pytest.mark.parametrize("way", [0.3, 1.0, 10.0, 100.0])
def test_cylinder_rolls_on_rubber_as_hunters(way):
    """Closed form of a standard solid; 24 cells, of second order, err by 1e-4 and less."""
    cylinder = RubberCylinder(1.0, 100.0, way, 0.25, 11.0)
    x = cylinder.middle + (np.arange(72)[:, None] + 0.5) / 24 - 1.5
    contact = slide_on_rubber(
        TravellingPlane(72, 1 / 24, GeneralisedMaxwell.standard(0.25, 2.5, 1 / 11), way),
        x**2 / 200,
        Load("force", cylinder.force),
        slope=x / 100,
    )
    assert_allclose(contact.friction_coefficient, cylinder.resistance, rtol=3e-4)
    assert_allclose(contact.contact_area, 2, rtol=1e-12)  # whole cells


def test_cylinder_on_kelvin_and_voigts_solid():
    """Its pressure fades towards the trailing edge, where cells of no weight are in or out."""
    cylinder = RubberCylinder(1.0, 100.0, 0.3, 0.25, np.inf)
    x = cylinder.middle + (np.arange(72)[:, None] + 0.5) / 24 - 1.5
    strips = TravellingPlane(72, 1 / 24, GeneralisedMaxwell.kelvin_voigt(0.25, 0.25), 0.3)
    contact = slide_on_rubber(strips, x**2 / 200, Load("force", cylinder.force), slope=x / 100)
    assert_allclose(contact.friction_coefficient, cylinder.resistance, rtol=1e-3)
