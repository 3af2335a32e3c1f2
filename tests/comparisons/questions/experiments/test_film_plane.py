"""Flow through rough planes: the experiments, on few cells."""

import numpy as np
import pytest

from comparisons.errors import InputError
from comparisons.questions.experiments import EXPERIMENTS, films
from comparisons.questions.experiments.rough_ensemble import Surface

COARSE = {"points": 32, "roll_off": 1.0, "realisations": 6}


@pytest.mark.parametrize("quantity", ["pressure", "shear"])
def test_what_slight_roughness_takes_is_its_second_order(quantity):
    """At 2 % of the gap the fourth order is 1e-3 of the second: less than cells and scatter."""
    told = EXPERIMENTS["film-plane-open"].measure(0.02, "quick", quantity=quantity, **COARSE)
    assert abs(told.error) < told.uncertainty < 0.5


def test_an_effective_medium_lets_more_through_than_spots_of_contact_do():
    """Necks between spots, which it does not know, close first."""
    told = EXPERIMENTS["film-plane-pressed"].measure(0.05, "quick", **COARSE)
    assert told.details["stated"] > told.details["true"] > 0
    assert 0 < told.details["contact area"] < 0.3


def test_lines_all_in_contact_let_nothing_through():
    lines = films._lines(Surface.of(32, 0.8, 1.0, 8.0, periodic=True), 1.0)
    assert not np.any(lines["flow"])


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("film-plane-open", {"statement": "patir_cheng", "quantity": "shear"}),
        ("film-plane-pressed", {"statement": "patir_cheng", "quantity": "flow"}),
    ],
)
def test_formulas_are_not_asked_for_what_they_do_not_say(name, wrong):
    with pytest.raises(InputError, match=r"pressure, not of shear|the factor, not of the flow"):
        EXPERIMENTS[name].measure(0.1, "quick", **wrong)
