"""Pictures of what yields: sections below an indenter, dents of rough surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from reports.plots import dent


@pytest.fixture
def shown(monkeypatch):
    """Return what makes the figures of given fields."""

    def draw(method: str, fields: dict[str, np.ndarray] | None):
        def stored(scene, *names):
            return (method, 4, fields) if fields and set(names) <= fields.keys() else None

        monkeypatch.setattr(dent, "finest_fields", stored)
        return dent.dents(None)

    return draw


def section() -> dict[str, np.ndarray]:
    """Return a body that has yielded to a depth of 1 mm, and sunk by 1 um at most."""
    r, z = (axis.ravel() for axis in np.meshgrid(*2 * [np.linspace(0, 4e-3, 41)], indexing="ij"))
    distance, surface = np.hypot(r, z), np.linspace(0, 1e-2, 21)
    return {
        "section_r": r,
        "section_z": z,
        "section_plastic_strain": np.maximum(0.0, 0.01 * (1 - distance / 1e-3)),
        "section_von_mises": 1e8 / (1 + distance / 1e-3),
        "surface_r": surface,
        "surface_depth": 1e-6 * np.exp(-surface / 1e-3),
    }


def test_a_section_has_the_surface_at_the_top_and_the_axis_on_the_left(shown):
    zone, stress, surface = shown("fem", section())
    for figure, highest in ((zone, 0.01), (stress, 1e8)):
        drawn = figure.map
        assert drawn.values[0, -1] == pytest.approx(highest)  # at r = z = 0
        assert drawn.y[-1] == 0.0
        assert drawn.y[0] < 0
        assert np.isfinite(drawn.values).all()
    assert (zone.map.values >= 0).all()
    (line,) = surface.series
    assert line.y.min() == pytest.approx(-1e-6)


def test_dents_of_a_rough_surface_are_a_map_over_it(shown):
    depth = np.zeros((4, 6))
    depth[1, 2] = 3e-9
    (figure,) = shown("bem_fft", {"dent": depth, "size": np.array([4e-6, 6e-6])})
    assert figure.map.values.shape == (4, 6)
    assert figure.map.highest == 3e-9
    np.testing.assert_allclose(figure.map.x, (np.arange(4) + 0.5) * 1e-6)


def test_what_has_not_yielded_has_no_picture(shown):
    assert shown("fem", None) == []
    elastic = section()
    elastic["section_plastic_strain"] *= 0
    assert shown("fem", elastic) == []
