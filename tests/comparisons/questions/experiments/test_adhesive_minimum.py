"""Adhesion of rough surfaces by least energy, against Newton's method and Derjaguin."""

import numpy as np
import pytest

from comparisons.questions.experiments.adhesive_minimum import Adhesive
from reference.contact.press import press
from reference.halfspace import PeriodicOperator
from reference.halfspace.cohesive import CohesiveProblem, exponential
from reference.loads import Load
from reference.surfaces import SelfAffine, self_affine


def rough_patch() -> tuple[PeriodicOperator, np.ndarray]:
    """Return a periodic rough patch of 32 x 32 cells, with rms slope, side and E* of one."""
    spectrum = SelfAffine(power=3.6, rms_slope=1.0, long_cutoff=0.5, short_cutoff=1 / 8)
    heights = self_affine(32, 1.0, spectrum, seed=1, realisation=0)
    return PeriodicOperator((32, 32), (1 / 32, 1 / 32), 1.0), heights.max() - heights


def test_least_energy_is_the_equilibrium_of_newtons_method():
    """Two algorithms, one state: Newton's pressures at the depth of the least energy's gaps."""
    operator, gap = rough_patch()
    law = exponential(2e-4, 0.015)
    plain = press(operator, gap, Load("force", 0.02))
    least = Adhesive(operator, gap, law).at_force(0.02, plain.gap)
    newton = CohesiveProblem(operator, gap, law).at_penetration(gap.mean() - least.mean_gap)
    assert newton.force == pytest.approx(least.force, rel=1e-5)
    assert np.abs(newton.gap - least.gap).max() < 1e-4 * law.reach
    # adhesion draws more cells into contact
    assert newton.mask.sum() > plain.mask.sum()


def test_weak_adhesion_takes_what_the_surface_energy_loses_with_the_gap():
    """Derjaguin: the energy of an equilibrium is stationary, so that dF = d<phi>/d<h> at once."""
    operator, gap = rough_patch()
    law = exponential(3e-5, 0.015)
    low, middle, high = (press(operator, gap, Load("force", load)) for load in (0.021, 0.02, 0.019))
    weak = Adhesive(operator, gap, law).at_mean_gap(middle.mean_gap, middle.gap, 0.02)
    lost = law.energy(low.gap).mean() - law.energy(high.gap).mean()
    # central differences over loads 5 % apart, in which cells enter one by one
    assert 0.02 - weak.force == pytest.approx(lost / (high.mean_gap - low.mean_gap), rel=0.03)
    # ... and not what the tension across these gaps would take, for gaps at the rims open less
    across = np.mean(law.tension(middle.gap) * ~middle.mask)
    assert across > 1.2 * (0.02 - weak.force)
