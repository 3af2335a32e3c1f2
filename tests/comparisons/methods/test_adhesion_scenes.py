"""Adhesion in scenes: springs, closed forms and grids along one path, with their refusals."""

from pathlib import Path

import numpy as np
import pytest

from comparisons.formatting import unpadded
from comparisons.questions.study import solved_in_memory
from comparisons.reasons import one_line
from comparisons.results.recording import record_scene
from comparisons.scene.scene import load_scene, make_scene
from comparisons.solving.planning import plan_scene

QUANTITIES = ("force", "penetration", "contact_area", "pull_off_force")


def ball(loading, unit=1.0, **adhesion):
    """Return a ball that adheres, its lengths times a unit."""
    tables = {
        "name": "ball",
        "half_space": {"effective_modulus": 2e6},
        "indenter": {"shape": "paraboloid", "radius": 0.01 * unit},
        "adhesion": {"work": 0.05 * unit} | adhesion,
    }
    return make_scene(tables | {"loading": loading}, "ball.toml", Path())


BY_DEPTH = {"penetration": ["-1 um", "1 um", "8 um", "0 um", "-2 um", "-5 um"]}
BY_FORCE = {"force": ["0 mN", "5 mN", "-1 mN", "-4 mN", "1 mN"]}


@pytest.mark.parametrize("loading", [BY_DEPTH, BY_FORCE])
@pytest.mark.parametrize(
    ("method", "resolution", "tolerance"),
    # detachment calibrated to the mesh: 25 % of the largest value at 8 cells per radius
    [("reduced", 12, 1e-10), pytest.param("bem_fft", 8, 0.25, marks=pytest.mark.slow)],
)
def test_a_path_is_that_of_the_closed_form(curves, loading, method, resolution, tolerance):
    """Contact, loss and contact again, for a paraboloid that the springs hold exactly."""
    scene = ball(loading)
    result, exact = curves(scene, method, resolution), curves(scene, "closed_form", 1)
    for name in QUANTITIES:
        scale = np.nanmax(np.abs(exact[name]))
        np.testing.assert_allclose(result[name], exact[name], atol=tolerance * scale, rtol=0)
    np.testing.assert_array_equal(result["contact_area"] > 0, exact["contact_area"] > 0)
    assert exact["pull_off_force"][0] == pytest.approx(1.5 * np.pi * 0.05 * 0.01, rel=1e-12)
    assert not (exact["contact_area"] > 0).all()


RANGE = {"range": "4 um"}


@pytest.mark.parametrize(
    ("method", "resolution", "more"),
    [
        *(("closed_form", 1, {}), ("reduced", 10, {}), ("bem_fft", 6, {})),
        pytest.param("bem_fft", 8, RANGE, marks=pytest.mark.slow),
    ],
)
def test_a_pull_on_a_body_that_is_apart_has_no_equilibrium(solved, method, resolution, more):
    """Before first touch, and from pull-off (2.36 mN, 36 % more on 6 cells) to the next touch."""
    path = {"force": ["-0.1 mN", "0 mN", "-1 mN", "-4 mN", "-1 mN", "1 mN"]}
    solution = solved(ball(path, **more), method, resolution)
    held = np.array([False, True, True, False, False, True])
    np.testing.assert_array_equal(solution.converged[0], held)
    for values in solution.quantities.values():
        np.testing.assert_array_equal(np.isfinite(values[0]), held)
    force = solution.quantities["force"][0, held]
    np.testing.assert_allclose(force, [0, -1e-3, 1e-3], atol=1e-15)
    (reason,) = set(solution.reasons.values())
    assert reason.startswith("no equilibrium: ")
    lost_at = -solution.quantities["pull_off_force"][0, 1]
    assert reason.endswith(one_line(f"lets go at {unpadded(lost_at, 'N')}"))
    assert solution.answered.all()


@pytest.mark.parametrize(
    ("answer", "reason", "word", "told"),
    [
        (None, "", "within", ""),
        ({}, "ValueError: my own bug", "not resolved", "no answer"),
        ({}, "no equilibrium: of the automata after 9 steps", "not resolved", "no answer"),
        ({"penetration": -1e-6}, "", "outside", "an answer where no equilibrium exists"),
    ],
)
def test_where_no_equilibrium_exists_to_say_so_is_right_and_to_crash_or_to_cling_is_not(
    answer, reason, word, told
):
    forces = {"loading": {"force": [0.0, -1e-3, -4e-3, 1e-3]}}
    asked = {"compare.methods": ["closed_form", "reduced"], "compare.quantities": ["penetration"]}
    (plan, *_) = plan_scene(load_scene("adhesive-ball", forces | asked))
    plan, solved = solved_in_memory(plan, "quick")
    for (method, _), solution in solved.items():
        if method == "reduced" and answer is not None:
            solution.reasons = {(0, 2): reason} if reason else {}
            solution.put((0, 2), answer)
            solution.no_equilibrium[0, 2] = False
            solution.converged[0, 2] = not reason
    (verdict,) = record_scene(plan, solved).verdicts_on("reduced")
    assert (verdict.word, verdict.reason) == (word, told and f"{told} at 1 of 4 steps")


@pytest.mark.slow
def test_a_range_is_maugis_tension_and_has_a_hysteresis(curves):
    """Lambda = 0.95: pull-off within 1.5 % of Maugis, contact kept below the depth of snap-in."""
    scene = load_scene("adhesive-ball-range")
    grid, exact, springs = (
        curves(scene, method, cells)
        for method, cells in (("bem_fft", 12), ("closed_form", 1), ("reduced", 12))
    )
    assert grid["pull_off_force"][0] == pytest.approx(exact["pull_off_force"][0], rel=0.015)
    (plan, *_) = plan_scene(scene)
    depth, half = plan.loads.values, int(np.argmax(plan.loads.values))
    for touching in (grid["contact_area"] > 0, exact["contact_area"] > 0):
        assert depth[:half][touching[:half]].min() > depth[half:][touching[half:]].min()
    assert springs["pull_off_force"][0] < exact["pull_off_force"][0]


@pytest.mark.parametrize("unit", [1e-12, 1e-9, 1e-6, 1e-3, 1e3, 1e6])
def test_first_touch_is_met_in_any_unit_of_length(curves, unit):
    """A path in steps passes zero depth exactly: a ball in touch adheres, one below it does not."""
    depths = [-6e-6 * unit, 2e-6 * unit, -6e-6 * unit]
    solution = curves(ball({"penetration": depths, "substeps": 4}, unit), "closed_form", 1)
    touch, area = 3, np.pi * (2 * np.pi * 0.05 * 0.01**2 / 2e6) ** (2 / 3)  # a^2/R = stretch
    assert solution["penetration"][touch] == 0.0
    assert solution["contact_area"][touch - 1] == 0.0
    assert solution["contact_area"][touch] / unit**2 == pytest.approx(area, rel=1e-12)
