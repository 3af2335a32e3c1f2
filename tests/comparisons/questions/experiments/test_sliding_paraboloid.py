"""A paraboloid that slides on rubber, on three grids."""

import pytest
from numpy.testing import assert_allclose

from comparisons.questions.experiments.viscoelastic import GridStudy, paraboloid
from reference.loads import Load
from reference.viscoelastic.materials import GeneralisedMaxwell

ZENER = GeneralisedMaxwell.standard(0.25, 2.5, 0.1)


@pytest.mark.slow
def test_paraboloid_is_known_to_half_a_per_cent():
    """The bar of three grids holds a fourth, twice as fine as the finest, and is below 0.5 %."""
    studies = (paraboloid(1.0, ZENER, 0.3, Load("penetration", 0.01), n) for n in (48, 96))
    for coarse, fine in zip(*studies, strict=True):
        assert abs(coarse.estimate - fine.estimate) < coarse.uncertainty
        assert fine.uncertainty < 0.005 * fine.estimate


def test_three_grids_that_converge_are_extrapolated():
    """Values 1 + h^p with p = 1, 2: the estimate is 1; with p = 4 the order is capped at 2."""
    for order in (1, 2):
        study = GridStudy.of([1 + h**order for h in (0.4, 0.2, 0.1)])
        assert_allclose(study.estimate, 1.0, rtol=1e-12)
    study = GridStudy.of([1 + h**4 for h in (0.4, 0.2, 0.1)])
    assert abs(study.estimate - 1) < study.uncertainty
