"""Pictures of the stress below a contact on a grid."""

from __future__ import annotations

import numpy as np
import pytest

from reports.plots import stress_below


def fields() -> dict[str, np.ndarray]:
    """Return a stress that is largest 2 mm below the place (3, 1) mm, on a mesh."""
    x, y, depth = np.arange(7) * 1e-3, np.arange(4) * 1e-3, np.array([0.0, 0.5, 1, 2, 4]) * 1e-3
    z, *across = np.meshgrid(depth, x, y, indexing="ij")
    points = np.stack([*across, z], axis=-1)
    away = np.linalg.norm(points - np.array([3e-3, 1e-3, 2e-3]), axis=-1)
    stress = 1e9 / (1 + away / 1e-3)
    return {
        "mesh_points": points.reshape(-1, 3),
        "mesh_von_mises": stress.ravel(),
        "von_mises_depth": depth,
        "von_mises_highest": stress.max(axis=(1, 2)),
    }


def test_the_section_goes_through_the_largest_stress_and_the_depth_is_told(monkeypatch):
    monkeypatch.setattr(stress_below, "finest_fields", lambda scene, *names: ("fem", 7, fields()))
    section, profile = stress_below.stresses_below(None)
    assert section.map.highest == pytest.approx(1e9)
    assert section.map.y[-1] == 0.0  # the surface at the top
    row = int(np.argmin(np.abs(section.map.y + 2e-3)))
    # down is cut in 119 parts of 3 mm: a point lies within 0.013 mm of the largest stress
    assert section.map.values[3, row] == pytest.approx(1e9, rel=0.02)
    assert "1.00 GPa 2.00 mm below the surface" in " ".join(profile.caption.split())
    (line,) = profile.series
    assert line.x[line.y.argmax()] == pytest.approx(2e-3)


def test_without_stresses_there_is_no_picture(monkeypatch):
    monkeypatch.setattr(stress_below, "finest_fields", lambda scene, *names: None)
    assert stress_below.stresses_below(None) == []
