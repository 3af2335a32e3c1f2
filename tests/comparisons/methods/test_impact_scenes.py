"""Impacts, friction and rubber as scenes: methods against closed forms, and a page's tables."""

import re
from pathlib import Path

import numpy as np
import pytest

from comparisons.questions.experiments import coulomb
from comparisons.questions.experiments.coulomb import march
from comparisons.questions.single import solve_scene
from comparisons.questions.study import solved_in_memory
from comparisons.results.recording import record_scene
from comparisons.scene.scene import SceneError, load_scene, make_scene
from comparisons.solving.planning import plan_scene
from reduced.motion.blocks import Blocks, integrate
from reduced.motion.course import Stepping
from reports.tables.written import markdown_rows


def impact(**changes):
    """Return a ball that strikes at 1 cm/s and at 1 m/s, or otherwise."""
    return load_scene("impact-ball", changes or {"dynamics.velocity": ["1 cm/s", "1 m/s"]})


def solved(method, resolution=None, **changes):
    solution = solve_scene(impact(**changes), method, resolution)
    assert solution.converged, solution.reasons
    return solution


@pytest.mark.parametrize(
    ("method", "resolution", "tolerance"),
    # measured: springs round-off; grids 2.5e-4 at 64 cells, 2e-3 at 20; elements 1e-4 at 2
    [("reduced", 20, 1e-10), ("bem_fft", 32, 2e-3), ("bem_dense", 10, 1e-2), ("fem", 2, 1e-3)],
)
def test_every_method_strikes_as_hertz_did(method, resolution, tolerance):
    """Duration, depth and force at two velocities a factor of 100 apart."""
    true = solved("closed_form").columns()
    result = solved(method, resolution).columns()
    for name in ("contact_duration", "penetration", "force"):
        np.testing.assert_allclose(result[name], true[name], rtol=tolerance)
    np.testing.assert_array_equal(result["restitution"], 1.0)


@pytest.mark.slow
def test_the_bar_of_a_load_curve_holds_its_error():
    """A sphere to half its radius is no power law: the ladder's own bar covers what it errs."""
    scene = {
        "indenter": {"shape": "sphere", "radius": "1 um"},
        "dynamics": {"mass": "1e-12 kg", "velocity": ["10 m/s", "100 m/s"]},
        "half_space": {"effective_modulus": "100 GPa"},
    }
    true = solved("closed_form", **scene).columns()["contact_duration"]
    solution = solved("fem", 4, **scene)
    error = np.abs(solution.columns()["contact_duration"] / true - 1)
    # the mesh of four elements adds its own 1e-4
    assert (error <= solution.solution.truncation + 1e-4).all()


def test_a_force_that_goes_on_pushing_lays_the_springs_out_anew():
    """A force in the rhythm of the contact drives the mass deeper than its first swing."""
    period = 4.2e-5
    times = np.arange(0, 8) * period / 2
    scene = {
        "dynamics": {"mass": "10 g", "velocity": 0},
        "loading": {"time": times.tolist(), "force": [200, 900] * 4, "substeps": 8},
    }
    true = solved("closed_form", **scene).columns()["penetration"]
    result = solved("reduced", 40, **scene).columns()
    largest = np.abs(true).max()
    np.testing.assert_allclose(result["penetration"], true, atol=2e-4 * largest)
    np.testing.assert_array_equal(result["force"][:2], [200, 287.5])  # on the mass, as prescribed


def test_the_plan_says_how_each_method_strikes(planned):
    methods = planned(impact())
    modelled = {name: method.modelled for name, method in methods.items() if method.supported}
    assert "by its energy" in modelled["reduced"]
    assert "along its load curve" in modelled["bem_fft"]
    assert set(modelled) >= {"closed_form", "reduced", "bem_dense", "bem_fft", "fem"}


def test_an_impact_whose_energy_underflows_is_refused():
    """A femtometre per second of 1e-290 kg: the square of the speed alone is 1e-30."""
    dynamics = {"mass": 1e-290, "velocity": [1e-20, 1.0]}
    with pytest.raises(SceneError, match="kinetic energy"):
        plan_scene(impact(dynamics=dynamics))


ROOT = Path(__file__).resolve().parents[3]


def block_of(name, page):
    page = (ROOT / "docs" / page).read_text(encoding="utf-8")
    (block,) = re.findall(f"<!-- table: {name} -->\n(.*?)\n<!-- end -->", page, re.DOTALL)
    return block


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "page"), [("stopping", "friction.md"), ("backbone", "rubber-and-impact.md")]
)
def test_the_tables_of_a_page_are_those_of_the_script(script, name, page):
    """Those without times or scatter are made anew and compared; the tests below are their law."""
    number = r"[-+]?\d+\.\d+(?:e[-+]\d+)?"
    block = block_of(name, page)
    anew = markdown_rows(script("friction_and_impact_tables").TABLES[name]())
    assert re.sub(number, "#", anew) == re.sub(number, "#", block)
    shown, result = ([float(x) for x in re.findall(number, t)] for t in (block, anew))
    np.testing.assert_allclose(shown, result, rtol=2e-3)


def test_implicit_euler_becomes_the_step_of_moreau_and_jean():
    """Three coupled blocks on a belt, v0 = 1e-13 of the speeds: the same numbers to 1e-6.

    The difference where a block just comes to rest goes as sqrt(v0).
    """
    K = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    data = {"stiffness": K, "belt": 0.1, "load": [0.1, 0.0, -0.2], "damping": 0.05}
    args = ([1.0, 2.0, 1.0], [0.3, 0.5, 0.2])
    soft = integrate(Blocks(*args, **data), 1e-13, Stepping(0.01, 1000))
    hard = march(coulomb.Blocks(*args, **data), step=0.01, steps=1000, theta=1.0)
    np.testing.assert_allclose(soft.position, hard.position, atol=1e-6)


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


@pytest.mark.slow
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
