"""Viscoelastic histories and impacts as scenes: springs, hereditary integrals and grids agree."""

from pathlib import Path

import numpy as np
import pytest

from comparisons.questions.study import solved_in_memory
from comparisons.results.scene_record import record_scene
from comparisons.scene.scene import load_scene, make_scene
from comparisons.solving.planning import plan_scene

RUBBER = {"model": "prony", "shear_moduli": [0.5e6, 1e6, 2e6], "relaxation_times": [1.0, 0.01]}


def planned(loading, methods=("closed_form", "reduced")):
    compare = {"methods": list(methods), "resolutions": [8, 16, 32]}
    changes = {"viscoelastic": RUBBER, "loading": loading, "compare": compare}
    (plan,) = plan_scene(load_scene("rubber-ball", changes))
    return plan


def reasons(plan):
    return {method.method: method.reason for method in plan.methods if not method.supported}


def test_a_body_that_is_let_go_answers_while_a_force_holds_it():
    """At zero force any depth above the surface will do; all before is that of a longer hold."""
    hold, let_go = (
        solved_in_memory(planned({"time": [0.0, 1.0, 1.01, 3.0], "force": forces}), "quick")[1]
        for forces in ([0.2] * 4, [0.2, 0.2, 0.0, 0.0])
    )
    for key, solution in let_go.items():
        assert solution.converged[0].tolist() == [True, True, False, False]
        assert solution.undetermined[0].tolist() == [False, False, True, True]
        assert solution.answered.all()
        assert not solution.no_equilibrium.any()
        assert "prescribe it to let the body go" in solution.reasons[0, 2]
        depth, held = (s.quantities["penetration"][0, :2] for s in (solution, hold[key]))
        # a shorter history has finer steps, and the coarsest springs err by some 0.4 %
        assert depth == pytest.approx(held, rel=1e-12 if key[0] == "closed_form" else 5e-3)


@pytest.mark.parametrize(("depth", "word"), [(2e-4, "within"), (np.nan, "not resolved")])
def test_any_depth_is_right_once_the_body_is_let_go(depth, word):
    """Of a method that gives one the others say nothing; one that fails there has no answer."""
    plan = planned({"time": [0.0, 1.0, 2.0], "force": [0.2, 0.2, 0.0]})
    solved = solved_in_memory(plan, "quick")[1]
    for (method, _), solution in solved.items():
        if method == "reduced":
            solution.undetermined[0, 2] = False
            solution.put((0, 2), {"penetration": depth})
            solution.converged[0, 2] = np.isfinite(depth)
    verdicts = record_scene(plan, solved).verdicts
    words = {v.resolution: v.word for v in verdicts if v.quantity == "penetration"}
    assert words[max(words)] == word


def test_a_rough_surface_relaxes_on_the_grid():
    """A periodic patch under a constant force creeps: its depth and its area grow."""
    surface = {
        "kind": "self_affine",
        "hurst": 0.8,
        "size": 1e-3,
        "points": 32,
        "rms_slope": 0.1,
        "periodic": True,
    }
    loading = {"time": [0.0, 0.1, 1.0, 10.0], "force": [0.02] * 4}
    data = {"name": "rough", "surface": surface, "viscoelastic": RUBBER, "loading": loading}
    (plan,) = plan_scene(make_scene(data, "rough.toml", Path()))
    kept = {name: part for (name, n), part in solved_in_memory(plan, "quick")[1].items() if n == 32}
    assert "for sliding only" in reasons(plan)["reduced"]
    solution = kept["bem_fft"]
    assert solution.converged.all()
    assert (np.diff(solution.quantities["penetration"][0]) > 0).all()
    area = solution.quantities["contact_area_raw"][0]
    assert area[-1] > 1.3 * area[0]
    assert solution.violation.max() < 1e-6


@pytest.mark.parametrize("name", ["rubber-ball", "rubber-again", "rubber-creep", "impact-rubber"])
def test_built_in_scenes_are_planned_for_at_least_two_methods(name):
    (plan,) = plan_scene(load_scene(name))
    assert sum(method.supported for method in plan.methods) >= 2
