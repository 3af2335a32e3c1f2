"""Scenes with [wear]: what is refused in words, and that methods which share no code agree."""

import numpy as np
import pytest

from comparisons.geometry.prepare import prepare
from comparisons.scene.scene import load_scene

SLIDING, FRETTING, ROUGH = "worn-ball", "fretting-ball", "worn-rough"


@pytest.mark.parametrize("changes", [{}, {"loading": {"penetration": "1 um"}}])
def test_grids_hold_the_worn_contact(curves, changes):
    """The estimate that sizes grids is above what springs find in the end."""
    scene = load_scene(SLIDING, changes)
    geometry, _ = prepare(scene)
    worn = curves(scene, "reduced", 10)
    assert worn["penetration"].max() <= geometry.penetration * (1 + 1e-9)
    assert worn["equivalent_radius"].max() < geometry.reach[0]


@pytest.mark.parametrize(
    ("name", "changes"),
    [(SLIDING, {"wear.sliding_distance": [0.01]}), (FRETTING, {"wear.cycles": [5e3]})],
)
def test_springs_agree_with_cells(curves, name, changes):
    """Both are exact in the limit: 20 springs and 6 cells per radius leave 5 %."""
    scene = load_scene(name, changes)
    springs, cells = curves(scene, "reduced", 20), curves(scene, "bem_fft", 6)
    for quantity in ("penetration", "force", "worn_volume"):
        np.testing.assert_allclose(springs[quantity], cells[quantity], rtol=0.05)


def test_rough_surface_runs_in(curves):
    """Area grows, the highest peaks go first, and cells lose what Archard says."""
    scene = load_scene(
        ROUGH, {"surface.points": 32, "surface.realisations": 1, "surface.short_cutoff": "0.25 um"}
    )
    cells, lines = curves(scene, "bem_fft", 32), curves(scene, "reduced", 32)
    for solved in (cells, lines):
        assert (np.diff(solved["contact_area"]) > 0).all()
        assert (np.diff(solved["wear_depth"]) > 0).all()
    distance = np.array([1e-3, 5e-3, 20e-3])
    np.testing.assert_allclose(cells["worn_volume"], 1e-14 * cells["force"] * distance, rtol=1e-9)
