"""A flat punch on a finite body: limits, rates, and the energy of a point force far away."""

import numpy as np
import pytest

from comparisons.questions.experiments.punched_section import press_section


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


def test_a_free_body_deforms_about_its_centre_of_mass():
    """Koenig: measured from the centre of mass the mean vanishes, and K exceeds m v^2/2."""
    contact = press_section(20.0, 0.3, support="inertia")
    assert abs(contact.mean_displacement[-1]) < 1e-12
    assert contact.mean_square_displacement[-1] > 0
    assert contact.energy[-1] == 1.0
