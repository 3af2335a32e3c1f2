"""The tables to take away."""

import pickle
from unittest.mock import Mock

import numpy as np
import pandas as pd

import roughline
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.results.exports import MEASURES, TO_TAKE

HERTZ = {
    "name": "ball",
    "half_space": {"effective_modulus": 1e9},
    "indenter": {"shape": "paraboloid", "radius": 1e-3},
    "loading": {"penetration": {"values": [1e-6, 4e-6]}},
}


def test_a_row_is_a_load_and_a_column_a_method_and_quantity_in_si_units(tmp_path):
    """F = (4/3) E* R^(1/2) d^(3/2), A = pi R d."""
    methods = ["reduced", "closed_form"]
    found = roughline.Study(HERTZ, tmp_path / "out", methods=methods).run()
    table = pd.read_csv(tmp_path / "out" / TO_TAKE)
    (comparison,) = found
    pd.testing.assert_frame_equal(table.drop(columns="scene"), comparison.curves())
    assert list(table)[:5] == [
        *("scene", "step", "penetration / m"),
        *("closed_form:force / N", "closed_form:contact_area / m2"),
    ]
    depth = table["penetration / m"].to_numpy()
    assert depth.tolist() == [1e-6, 4e-6]
    # Springs to a radius: 40, of second order; the closed form is exact to round-off.
    for method, tolerance in (("closed_form", 1e-12), ("reduced", 1e-4)):
        force, area = (table[f"{method}:{n}"] for n in ("force / N", "contact_area / m2"))
        np.testing.assert_allclose(force, 4 / 3 * 1e9 * 1e-3**0.5 * depth**1.5, rtol=tolerance)
        np.testing.assert_allclose(area, np.pi * 1e-3 * depth, rtol=tolerance)
    # What was derived does not keep a record from another process.
    again = pickle.loads(pickle.dumps(comparison.record))
    pd.testing.assert_frame_equal(again.rows.frame(), comparison.record.rows.frame())


def test_a_method_without_an_answer_has_its_reason_beside_its_verdict(tmp_path, monkeypatch):
    monkeypatch.setattr(ReducedProfile, "solve", Mock(side_effect=ValueError("no springs")))
    roughline.Study(HERTZ, tmp_path / "out", methods=["reduced", "closed_form"]).run()
    table = pd.read_csv(tmp_path / "out" / MEASURES, keep_default_na=False)
    (reason,) = set(table.loc[table["method"] == "reduced", "reason"])
    assert "no springs" in reason
