"""A flat punch on a finite body: limits, rates, and the energy of a point force far away."""

import numpy as np
import pytest

from reference import closed_form
from reference.fem.section import press_section


@pytest.mark.slow
def test_the_half_ball_tends_to_the_half_space_as_its_inverse_radius():
    """k/(2 E* a) - 1 = c a/R: constant c to 2 % between R/a = 100 and 1000 (mesh error 2e-5)."""
    excess = [
        (press_section(radius, 0.3, elements=16).stiffness / 2 - 1) * radius
        for radius in (100.0, 1000.0)
    ]
    assert excess[0] == pytest.approx(excess[1], rel=0.02)
    assert 1.0 < excess[0] < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["axisymmetric", "plane"])
@pytest.mark.parametrize("support", ["fixed", "inertia"])
def test_the_stiffness_converges_with_the_fourth_power_of_the_elements(kind, support):
    """Order of three meshes; the root singularity of the edge would leave first order at best."""
    values = [
        press_section(20.0, 0.3, kind=kind, support=support, elements=n).stiffness
        for n in (4, 8, 16)
    ]
    order = np.log2(abs(values[0] - values[1]) / abs(values[1] - values[2]))
    assert order > 3


@pytest.mark.parametrize(
    "poisson_ratio", [0.3, *(pytest.param(nu, marks=pytest.mark.slow) for nu in (0.0, 0.45))]
)
def test_in_plane_strain_the_compliance_grows_by_two_over_pi_per_e_fold(poisson_ratio):
    """Flamant's field: d = (2 F/(pi E*)) ln R + const, whatever nu; corrections O((a/R)^2)."""
    low, high = (
        1 / press_section(radius, poisson_ratio, kind="plane", elements=16).stiffness
        for radius in (100.0, 1e4)
    )
    assert (high - low) / np.log(100) == pytest.approx(2 / np.pi, rel=2e-4)


@pytest.mark.slow
@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3])
def test_the_energy_far_away_is_that_of_a_point_force(poisson_ratio):
    """Beyond rho = 20 a of a body of 1e4 a, share of U = F d/2, to (a/rho)^2 = 0.25 %."""
    rho = 20.0
    contact = press_section(1e4, poisson_ratio, radii=(rho,), elements=16)
    # E* a d^2 is the unit of energy, E* a d of force
    outside = closed_form.boussinesq_energy(1.0, rho, 1.0, poisson_ratio) * contact.stiffness**2
    assert 1 - contact.energy[0] == pytest.approx(outside / (contact.stiffness / 2), rel=0.005)


@pytest.mark.parametrize("poisson_ratio", [pytest.param(0.1, marks=pytest.mark.slow), 0.3])
def test_the_mean_displacement_is_that_of_the_chapters_estimate_with_its_coefficient(poisson_ratio):
    """2 <u>/d = (7 - 6 nu)/(2 pi (1 - nu)) D/R in a half-ball of the half-space, as R grows.

    By integrating Boussinesq's u_z over the half-ball; corrections are O((a/R)^2) and the radius of
    the body around, 1e-3.
    """
    radius = 50.0
    contact = press_section(1e5, poisson_ratio, radii=(radius,), elements=16)
    exact = (7 - 6 * poisson_ratio) / (2 * np.pi * (1 - poisson_ratio))
    assert 2 * contact.mean_displacement[0] * radius / 2 == pytest.approx(exact, rel=2e-3)


def test_a_free_body_deforms_about_its_centre_of_mass():
    """Koenig: measured from the centre of mass the mean vanishes, and K exceeds m v^2/2."""
    contact = press_section(20.0, 0.3, support="inertia")
    assert abs(contact.mean_displacement[-1]) < 1e-12
    assert contact.mean_square_displacement[-1] > 0
    assert contact.energy[-1] == 1.0
