"""The film below a ball: a map that is empty in the cavity, and a section along the flow."""

from __future__ import annotations

import numpy as np
import pytest

from reports.plots import film


@pytest.fixture
def fields(monkeypatch):
    """Return a parabolic film with a cavity behind the middle, as the only field of a scene."""
    x, y = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 11), indexing="ij")
    grid = {
        "pressure_x": x.ravel(),
        "pressure_y": y.ravel(),
        "pressure": np.clip(1 - x**2 - y**2, 0, None).ravel(),
        "film": (1e-6 * (1 + 8 * (x**2 + y**2))).ravel(),
        "vapour": np.where(x > 0.5, 0.75, 0.0).ravel(),
        "pressure_shape": np.array(x.shape),
    }
    monkeypatch.setattr(film, "finest_fields", lambda scene, *names: ("bem_fft", 16, grid))
    return grid


def test_the_cavity_is_empty_on_the_map_and_holds_less_oil_in_the_section(fields):
    on_map, section = film.films(None)
    assert np.array_equal(np.isnan(on_map.map.values), np.reshape(fields["vapour"] > 0, (21, 11)))
    assert on_map.map.highest == pytest.approx(5e-6)
    thickness, oil, pressure = (series.y for series in section.series)
    assert thickness.max() < 5
    assert np.allclose(oil / thickness, np.where(section.series[0].x > 0.5, 0.25, 1.0))
    assert pressure.max() == 1


def test_fields_of_another_shape_are_not_drawn(fields):
    fields["pressure_shape"] = np.array([20, 11])
    assert film.films(None) == []
