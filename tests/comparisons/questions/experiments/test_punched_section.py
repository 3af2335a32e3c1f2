"""A flat punch on a finite body: limits, rates, and the energy of a point force far away."""

import numpy as np
import pytest

from comparisons.questions.experiments.punched_section import press_section
from reference import closed_form


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


def test_in_plane_strain_the_compliance_grows_by_two_over_pi_per_e_fold():
    """Flamant's field: d = (2 F/(pi E*)) ln R + const, whatever nu; corrections O((a/R)^2)."""
    low, high = (
        1 / press_section(radius, 0.3, kind="plane", elements=16).stiffness
        for radius in (100.0, 1e4)
    )
    assert (high - low) / np.log(100) == pytest.approx(2 / np.pi, rel=2e-4)


def test_mean_displacement_and_energy_far_away_are_those_of_a_point_force():
    """2 <u>/d = (7 - 6 nu)/(2 pi (1 - nu)) D/R, by integrating Boussinesq's u_z over a half-ball.

    Corrections are O((a/R)^2) and the radius of the body around: 1e-3 at R = 50 a, of the energy
    beyond 20 a 0.25 %.
    """
    nu, inner, outer = 0.3, 20.0, 50.0
    contact = press_section(1e5, nu, radii=(inner, outer), elements=16)
    exact = (7 - 6 * nu) / (2 * np.pi * (1 - nu))
    assert 2 * contact.mean_displacement[1] * outer / 2 == pytest.approx(exact, rel=2e-3)
    # E* a d^2 is the unit of energy, E* a d of force
    energy = closed_form.boussinesq_energy(1.0, inner, 1.0, nu) * contact.stiffness**2
    assert 1 - contact.energy[0] == pytest.approx(energy / (contact.stiffness / 2), rel=0.005)


def test_a_free_body_deforms_about_its_centre_of_mass():
    """Koenig: measured from the centre of mass the mean vanishes, and K exceeds m v^2/2."""
    contact = press_section(20.0, 0.3, support="inertia")
    assert abs(contact.mean_displacement[-1]) < 1e-12
    assert contact.mean_square_displacement[-1] > 0
    assert contact.energy[-1] == 1.0
