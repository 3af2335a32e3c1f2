"""Rows of quantities: what scenes, comparisons and reports read out of them."""

from types import SimpleNamespace

import numpy as np
import pytest

from comparisons.facts.quantities import (
    COMPARABLE,
    DEFAULT,
    DISTRIBUTIONS,
    FIELDS,
    QUANTITIES,
    derived,
    quantity,
)

SCENE = SimpleNamespace(effective_modulus=2.0)


def all_of(known, *, is_round):
    curves = {name: np.array(values, dtype=float) for name, values in known.items()}
    return curves | dict(derived(curves, SCENE, is_round=is_round))


def test_an_area_tells_the_radius_of_a_circle_and_the_radius_its_area():
    """A = pi r^2, whichever is missing; with holes counted as contact the raw area is the same."""
    from_area = all_of({"contact_area": [np.pi, 4 * np.pi]}, is_round=True)
    from_radius = all_of({"equivalent_radius": [1.0, 2.0]}, is_round=True)
    for curves in (from_area, from_radius):
        assert curves["equivalent_radius"] == pytest.approx([1.0, 2.0])
        assert curves["contact_area_raw"] == pytest.approx([np.pi, 4 * np.pi])
        assert curves["contact_radius"] == pytest.approx([1.0, 2.0])


def test_a_contact_that_is_no_circle_has_an_equivalent_radius_only():
    curves = all_of({"contact_area": [np.pi]}, is_round=False)
    assert not np.shares_memory(curves["contact_area"], curves["contact_area_raw"])  # of lost steps
    # a grid counts its cells: its raw area is not the corrected one
    counted = all_of({"contact_area": [1.0], "contact_area_raw": [1.1]}, is_round=False)
    assert counted["contact_area_raw"] == pytest.approx([1.1])
    assert all_of({"stiffness": [3.0]}, is_round=True)["contact_length_stiffness"] == [1.5]
    assert "contact_radius" not in curves
    assert curves["equivalent_radius"] == pytest.approx([1.0])


def test_a_row_may_be_asked_for_compared_and_written_on_an_axis():
    assert set(DEFAULT) <= set(COMPARABLE) <= set(QUANTITIES)
    assert set(FIELDS) & set(COMPARABLE) == {"pressure", *DISTRIBUTIONS}
    assert quantity("force").title("mN") == "force F / mN"
    assert quantity("angle_of_repose").title("") == "angle of repose"


def test_what_a_quantity_follows_from_and_is_compared_at_is_a_quantity():
    rules = [row.derived for row in QUANTITIES.values() if row.derived is not None]
    named = {name for rule in rules for name in rule.of}
    named |= {row.counterpart for row in QUANTITIES.values() if row.counterpart}
    assert named <= set(QUANTITIES)
