"""Scenes with a [counter_body]: compliances add, and finite elements mesh both bodies."""

from pathlib import Path

import numpy as np
import pytest

from comparisons.scene.scene import make_scene, parse_scene
from comparisons.solving.planning import plan_scene

TABLES = {
    "name": "two-bodies",
    "half_space": {"youngs_modulus": 2e9, "poisson_ratio": 0.3},
    "counter_body": {"youngs_modulus": 1e9, "poisson_ratio": 0.2},
    "indenter": {"shape": "paraboloid", "radius": 0.01},
    "loading": {"penetration": [1e-7, 1e-5]},
    "compare": {"quantities": ["force", "contact_area", "pressure"]},
}
COMBINED = 1 / ((1 - 0.3**2) / 2e9 + (1 - 0.2**2) / 1e9)
HERTZ = 4 / 3 * COMBINED * np.sqrt(0.01) * np.array([1e-7, 1e-5]) ** 1.5


def scene(**changes):
    return make_scene(TABLES | changes, "test", Path())


def test_compliances_of_two_half_spaces_add():
    """Johnson 1985, eq. (4.5); the canonical text keeps both bodies."""
    made = scene()
    assert made.effective_modulus == pytest.approx(COMBINED, rel=1e-14)
    assert parse_scene(made.text, "test", Path()) == made
    (plan,) = plan_scene(made)
    assert "both bodies are elastic: their compliances 1/E* add" in plan.notes


@pytest.mark.slow
@pytest.mark.parametrize(("coupling", "tolerance"), [("mortar", 1e-3), ("node_to_surface", 5e-3)])
def test_finite_elements_find_the_sum_by_meshing_both_bodies(solved, coupling, tolerance):
    """The addition is a result here, not an input: at loads a thousandfold apart.

    The same digits at both loads, because each scales the grids to its contact.
    """
    solution = solved(scene(methods={"fem": {"coupling": coupling}}), "fem", 3, with_body=True)
    error = solution.quantities["force"][0] / HERTZ - 1
    assert np.abs(error).max() < tolerance
    assert error[0] == pytest.approx(error[1], rel=1e-6)
    fields = solution.fields
    total = (fields["pressure"] * fields["pressure_weight"]).sum()
    assert total == pytest.approx(solution.quantities["force"][0, -1], rel=1e-12)
    assert fields["mesh_von_mises"].max() > 0


def test_one_body_with_both_compliances_is_the_other_way(solved, planned):
    made = scene(methods={"fem": {"coupling": "effective_modulus"}})
    assert "both bodies" not in planned(made)["fem"].modelled
    assert "a quarter of both bodies" in planned(scene())["fem"].modelled
    force = solved(made, "fem", 3).quantities["force"][0]
    np.testing.assert_allclose(force, HERTZ, rtol=1e-3)
