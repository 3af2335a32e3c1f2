"""Asperities of particles with bonds that break and heal, dragged over each other."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from comparisons.questions.experiments.asperities import Asperities
from reference.elasticity import von_mises


def test_the_work_of_a_pass_is_stored_damped_or_spent_on_bonds():
    """Steps of first order where velocities are damped: 1 %."""
    drag = Asperities(overlap=0.5, speed=0.2, radius=3.0, height=2.0).drag(0)
    assert_allclose(drag.stored + drag.damped + drag.spent, drag.work, rtol=0.02)
    assert drag.work > drag.spent > 0
    assert drag.broken > 0
    assert_allclose(np.trapezoid(drag.force, drag.way), drag.work, rtol=0.02)


def test_bonds_that_cannot_break_lose_nothing_and_nothing_is_worn():
    """A strain of 0.3 is not reached by tips that barely touch, and free pairs do not heal."""
    drag = Asperities(
        overlap=0.1, energy=0.045, healing=0.9, speed=0.2, radius=3.0, height=2.0
    ).drag(0)
    assert drag.broken == drag.healed == drag.worn == drag.loose == 0
    assert drag.spent == 0


@pytest.mark.slow
def test_a_seed_draws_the_same_pass_again():
    given = Asperities(overlap=0.5, speed=0.3, radius=3.0, height=2.0)
    first, again, other = given.drag(3), given.drag(3), given.drag(4)
    assert np.array_equal(first.force, again.force)
    assert not np.array_equal(first.force, other.force)
    assert von_mises(first.stress).max() > 0
