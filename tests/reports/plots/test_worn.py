"""Worn profiles: a curve for the unworn body and for each step, near the contact."""

from __future__ import annotations

import numpy as np
import pytest

from reports.plots import worn


@pytest.fixture
def shapes(monkeypatch):
    """Return a parabola that is cut flat twice, as the only field of a scene."""
    x = np.linspace(-1e-3, 1e-3, 41)
    unworn = x**2 / 2e-2
    fields = {
        "worn_r": x,
        "worn_shapes": np.array([unworn, np.maximum(unworn, 1e-6), np.maximum(unworn, 4e-6)]),
    }
    monkeypatch.setattr(worn, "finest_fields", lambda scene, *names: ("bem_fft", 16, fields))
    monkeypatch.setattr(worn, "_labels", lambda *told: ["1 mm", "2 mm"])
    return fields


def test_every_step_has_its_curve_near_the_contact(shapes):
    (figure,) = worn.worn_profiles(None)
    assert [series.look.label for series in figure.series] == ["unworn", "1 mm", "2 mm"]
    before, _, last = figure.series
    assert last.y.min() == 4e-6
    assert before.y.max() <= 1.5 * 4e-6
    assert before.x.size < shapes["worn_r"].size
    assert "N = 16" in figure.caption


def test_what_is_broken_or_not_worn_is_not_drawn(shapes):
    shapes["worn_shapes"] = shapes["worn_shapes"][:1]
    assert worn.worn_profiles(None) == []
    shapes["worn_shapes"] = np.array([np.ones(3), np.ones(3)])
    assert worn.worn_profiles(None) == []
