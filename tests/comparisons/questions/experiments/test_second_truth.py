"""Elements and half-space on one surface; von Mises stress below a rough contact."""

from __future__ import annotations

import numpy as np
import pytest

from comparisons.questions.experiments import EXPERIMENTS
from comparisons.questions.experiments.boundary_elements import QUANTITIES, two_truths
from comparisons.questions.experiments.rough_ensemble import Surface
from comparisons.questions.experiments.yielding import largest_mises
from reference.fem import Material


@pytest.mark.parametrize("element", ["splines", "quadratic"])
def test_elements_and_half_space_agree_inside_both_bars(element):
    """A wave in both directions, four cells to it on the coarsest grid, free."""
    maps = []
    for n in (8, 16, 32):
        x = np.cos(2 * np.pi * (np.arange(n) + 0.5) / n)
        maps.append(0.1 * (x[:, None] + x))
    case = two_truths(maps, (1.0, 1.0), Material(0.91, 0.3), 0.02, periodic=False, element=element)
    for quantity in QUANTITIES:
        assert abs(case.difference(quantity)) < case.bar(quantity)
    assert case.pressure < min(case.pressure_changes)


def test_rough_contacts_yield_below_their_surface():
    """The largest stress lies below the surface, and is of the size of Hertz's 0.62 p0."""
    stresses, depths = largest_mises(Surface(16, shortest=4.0, periodic=True), 0.02, 0.3, 2, 2)
    assert np.all(depths > 0.01)
    assert np.all((stresses > 0.2) & (stresses < 1.0))


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("second-truth", {"quantity": "force"}), ("rough-first-yield", {"rule": "none"})],
)
def test_unknown_choices_are_refused_in_words(name, wrong):
    with pytest.raises(ValueError, match=r"must be .*of"):
        EXPERIMENTS[name].measure(None, "quick", **wrong)


def test_waves_of_elements_are_known_better_the_longer_they_are():
    """h^4 with 27 nodes."""
    errors = [abs(EXPERIMENTS["element-waves"].measure(n, "quick").error) for n in (4.0, 8.0)]
    assert 8 < errors[0] / errors[1] < 32
