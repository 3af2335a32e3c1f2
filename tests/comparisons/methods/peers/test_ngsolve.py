"""The method `ngsolve`: another code's finite elements against closed forms, and its absence."""

from importlib import util
from pathlib import Path

import numpy as np
import pytest

from comparisons.methods.peers import ngsolve
from comparisons.methods.registry import solver_for
from comparisons.scene.scene import make_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

needs_ngsolve = pytest.mark.skipif(
    util.find_spec("ngsolve") is None, reason="NGSolve is in the extra `peers`"
)
SHAPES = {
    "paraboloid": ({"radius": 0.01}, 1e-4),
    "ellipsoid": ({"radius_x": 0.02, "radius_y": 0.005}, 5e-4),
    "cone": ({"slope": 0.05}, 3e-4),
    "cylinder": ({"radius": 0.001}, 1e-2),
}


def scene(shape, **changes):
    tables = {
        "name": "peer",
        "half_space": {"youngs_modulus": 2e9, "poisson_ratio": 0.3},
        "indenter": {"shape": shape, **SHAPES[shape][0]},
        "loading": {"penetration": [1e-7, 1e-5]},
        "compare": {"quantities": ["force", "stiffness", "contact_area"]},
    }
    return make_scene(tables | changes, "test", Path())


@needs_ngsolve
@pytest.mark.slow
@pytest.mark.parametrize("shape", SHAPES)
def test_it_agrees_with_closed_forms(solved, shape):
    """An independent code on each kind of contact edge; sharp ones converge slowly.

    Loads a hundredfold apart. A ball: 1e-4 with two elements of fourth order per radius, of far
    field 1e-5, penalty 1e-5, and the mesh.
    """
    made = scene(shape)
    exact = solved(made, "closed_form", 1).quantities
    solution = solved(made, "ngsolve", 2)
    result = solution.quantities
    assert solution.seconds > 0
    assert solution.unknowns > 1000
    if shape == "paraboloid":
        np.testing.assert_allclose(result["contact_area"], exact["contact_area"], rtol=5e-3)
    np.testing.assert_allclose(result["force"], exact["force"], rtol=SHAPES[shape][1])
    np.testing.assert_allclose(result["stiffness"], exact["stiffness"], rtol=0.015)


@needs_ngsolve
@pytest.mark.slow
def test_force_control_is_the_inverse_of_penetration_control(solved):
    force = solved(scene("paraboloid"), "ngsolve", 2).quantities["force"][0]
    back = solved(scene("paraboloid", loading={"force": force.tolist()}), "ngsolve", 2)
    np.testing.assert_allclose(back.quantities["penetration"][0], [1e-7, 1e-5], rtol=1e-5)


def test_its_absence_is_said(monkeypatch):
    monkeypatch.setattr(ngsolve.util, "find_spec", lambda name: None)
    support = solver_for("ngsolve", scene("paraboloid"))
    assert support.reason == "not installed: pip install 'roughline[peers]'"


@needs_ngsolve
def test_a_limit_of_time_costs_its_own_rows():
    made = scene("paraboloid", methods={"ngsolve": {"seconds": 0.01}})
    (plan,) = plan_scene(made)
    solution = execute(task_of(plan, "ngsolve", 2))
    assert not solution.converged.any()
    assert "no answer within" in solution.reasons[0, 0]
