"""Cylinders that roll with friction (Carter) and on rubber (Hunter): closed forms and cells."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from comparisons.questions.experiments.plane_rollers import (
    PlaneElements,
    PlaneSurface,
    hertz,
    moving_compliance,
)
from comparisons.questions.experiments.rolling_cylinders import Carter, RubberCylinder
from reference.halfspace.traction import Compliance
from reference.loads import Load
from reference.rolling.roll import Upstream, steady
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.rubber import slide_on_rubber
from reference.viscoelastic.travelling import TravellingPlane


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
