"""Maps of stick and slip: cells of the contact, a frame for every creep of the slider."""

from __future__ import annotations

import numpy as np
import pytest

from reports.plots import interactive, slip
from reports.plots.load_slider import SliderSteps


@pytest.fixture
def stored(monkeypatch):
    """Return the fields of a contact of 2 x 3 cells on a grid of 4 x 5, at two creeps."""
    x, y = np.meshgrid(np.arange(4.0) * 1e-3, np.arange(5.0) * 1e-3, indexing="ij")
    inside = np.zeros((4, 5))
    inside[1:3, 1:4] = 1.0
    fields = {
        "pressure_x": x.ravel(),
        "pressure_y": y.ravel(),
        "pressure": inside.ravel(),
        "pressure_shape": np.array(inside.shape),
        "friction_used": np.where(inside > 0, 1.0, np.nan).ravel(),
        "traction_x": 0.3 * inside.ravel(),
        "traction_y": 0.0 * inside.ravel(),
        "step.0.friction_used": np.where(inside > 0, 0.5, np.nan).ravel(),
        "step.0.traction_x": 0.1 * inside.ravel(),
    }
    monkeypatch.setattr(slip, "finest_fields", lambda scene, *names: ("bem_fft", 4, fields))
    monkeypatch.setattr(slip, "slider_steps", lambda scene: SliderSteps((0, 1), ("a", "b")))
    return fields


def test_a_frame_for_every_creep_on_one_scale(stored):
    used, traction = slip.slips(None)
    assert (used.key, traction.key) == ("slip-map", "traction-x")
    (before,) = used.earlier
    assert before.map.values.shape == used.map.values.shape == (2, 3)
    assert (before.map.values == 0.5).all()
    assert (used.map.values == 1.0).all()
    assert before.map.highest == used.map.highest == 1.0
    assert "1 where it slips" in used.caption
    heads = [interactive.spec(f)["data"][0]["colorbar"]["title"]["text"] for f in (used, traction)]
    assert [str(head) for head in heads] == ["|q|/(µp)", "q / mPa"]


def test_tractions_follow_the_slider(stored):
    _, traction = slip.slips(None)
    assert (traction.earlier[0].map.values == 0.1).all()
    assert traction.map.highest == 0.3


def test_without_tractions_there_is_no_map(monkeypatch):
    monkeypatch.setattr(slip, "finest_fields", lambda scene, *names: None)
    assert slip.slips(None) == []
