"""Contact codes of others in a process of their own: what is said without them, and their laws."""

import os
import runpy
import sys
from importlib import util
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from comparisons.isolation import parent
from comparisons.methods.peers import live, truths
from comparisons.methods.peers.live import Drake, MuJoCo, Slippy
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refused
from comparisons.scene.scene import make_scene

CODES = {"drake": Drake.code, "mujoco": MuJoCo.code, "slippy": Slippy.code}
LOADS = {
    "drake": {"penetration": [1e-6, 1e-5, 1e-4]},
    "mujoco": {"force": [1.0, 10.0, 100.0]},
    "slippy": {"penetration": [1e-6, 2e-6, 1e-5]},
}
RADIUS = 0.01  # of the fixture's paraboloid


def needs(name):
    try:
        CODES[name].version()
        absent = ""
    except Refused as refused:
        absent = str(refused)
    return pytest.mark.skipif(bool(absent), reason=absent)


def pretend(monkeypatch, tmp_path, name, text):
    """Put a script in the place of a code's, in our interpreter, where the code is said to be."""
    (tmp_path / f"run_{name}.py").write_text(text)
    monkeypatch.setattr(live, "SCRIPTS", tmp_path)
    monkeypatch.setenv(f"ROUGHLINE_PYTHON_{name.upper()}", sys.executable)
    said = {package: tried or "1" for package, tried in CODES[name].releases.items()}
    monkeypatch.setattr(live, "versions_in", lambda python, packages: said)


@pytest.mark.parametrize("name", CODES)
def test_a_missing_interpreter_and_a_missing_package_are_refused_in_words(scene, monkeypatch, name):
    variable = f"ROUGHLINE_PYTHON_{name.upper()}"
    monkeypatch.setenv(variable, "/nowhere/python")
    reason = solver_for(name, scene(loading=LOADS[name])).reason
    assert f"{variable}=/nowhere/python" in reason
    assert "No such file" in reason
    monkeypatch.setattr(live, "versions_in", lambda python, packages: dict.fromkeys(packages, ""))
    refusal = solver_for(name, scene(loading=LOADS[name]))
    assert refusal.missing
    said = f"{name} not installed in {variable}=/nowhere/python: {CODES[name].install}"
    assert refusal.reason == said


@pytest.mark.parametrize(
    ("script", "reason"),
    [
        ("import no_such_package", "No module named 'no_such_package'"),
        ("import os, signal\ndef solve(problem): os.kill(os.getpid(), signal.SIGKILL)", "SIGKILL"),
        ("def solve(problem): return {'force': float('nan')}", "not finite: force"),
        ("def solve(problem): return 1", "expected a dict"),
    ],
)
def test_a_code_that_fails_costs_its_own_rows(solved, scene, monkeypatch, tmp_path, script, reason):
    name = "drake"  # what runs it is the same for all
    pretend(monkeypatch, tmp_path, name, script)
    solution = solved(scene(loading=LOADS[name]), name, lost=True)
    assert not solution.converged.any()
    assert solution.reasons[0, 2].startswith(f"{CODES[name].name}: ")
    assert reason in solution.reasons[0, 2]


def test_another_interpreter_does_not_get_our_import_path(monkeypatch, tmp_path):
    (tmp_path / "ours.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    script = tmp_path / "script.py"
    script.write_text("def solve():\n    import ours")
    outcome = parent.run(f"{script}:solve", seconds=60, python=sys.executable)
    assert "No module named 'ours'" in outcome.reason


def test_units_are_put_back_on_what_a_code_answers(solved, scene, monkeypatch, tmp_path):
    """The script answers Hertz for E* = R = 1, the closed form has the scene's own."""
    hertz = """
import numpy as np
def solve(problem):
    d = np.array(problem["depths"])
    return {"force": 4 / 3 * d**1.5, "contact_area": np.pi * d, "unknowns": 1, "seconds": 0.0,
            "setup_seconds": 0.0}
"""
    pretend(monkeypatch, tmp_path, "drake", hertz)
    made = scene(loading=LOADS["drake"])
    ours, exact = solved(made, "drake").quantities, solved(made, "closed_form").quantities
    for name in ("force", "contact_area"):
        assert_allclose(ours[name], exact[name], rtol=1e-12)


@needs("drake")
def test_hydroelastic_contact_goes_as_the_square_and_is_hertz_at_one_depth(solved, scene):
    """F/Hertz = sqrt(d/d*) (1 - d/3R), its cap twice Hertz's area; 1e-3: 128 chords for circles."""
    made = scene(loading=LOADS["drake"])
    theirs, exact = solved(made, "drake").quantities, solved(made, "closed_form").quantities
    depth = exact["penetration"]
    law = np.sqrt(depth / depth.max()) * (1 - depth / (3 * RADIUS))
    assert_allclose(theirs["force"] / exact["force"], law, rtol=1e-3)
    assert_allclose(theirs["contact_area"] / exact["contact_area"], 2.0, rtol=1.5e-3)


@needs("mujoco")
def test_a_soft_contact_is_linear_and_hertz_at_one_force(solved, scene):
    """1e-4: where the ball counts as at rest."""
    made = scene(loading=LOADS["mujoco"])
    theirs, exact = solved(made, "mujoco").quantities, solved(made, "closed_form").quantities
    force = exact["force"]
    assert_allclose(theirs["force"], force, rtol=1e-4)
    law = (force / force.max()) ** (1 / 3)
    assert_allclose(theirs["penetration"] / exact["penetration"], law, rtol=1e-4)


@needs("mujoco")
def test_a_soft_contact_is_as_stiff_as_its_ball_is_heavy():
    depths = []
    for mass in (1.0, 3.0):
        outcome = parent.run(
            f"{live.SCRIPTS / 'run_mujoco.py'}:solve",
            {"stiffness": 100.0, "mass": mass, "forces": [1.0]},
            python=os.environ.get("ROUGHLINE_PYTHON_MUJOCO", sys.executable),
        )
        depths.append(outcome.answer["penetration"][0])
    assert_allclose(depths[0] / depths[1], 3.0, rtol=1e-4)


@needs("slippy")
def test_boundary_elements_of_others_give_hertz(solved, scene):
    """Cells across a radius: 21; counted whole, they add half a cell to it, 5 % to the area."""
    made = scene(loading=LOADS["slippy"])
    theirs, exact = solved(made, "slippy").quantities, solved(made, "closed_form").quantities
    assert_allclose(theirs["force"], exact["force"], rtol=2e-3)
    assert_allclose(theirs["contact_area"], exact["contact_area"], rtol=0.05)


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


def test_its_absence_is_said(monkeypatch):
    monkeypatch.setattr(truths.util, "find_spec", lambda name: None)
    support = solver_for("ngsolve", scene("paraboloid"))
    assert support.reason == "not installed: pip install 'roughline[peers]'"


@pytest.fixture
def line_contact(monkeypatch):
    examples = Path(__file__).parents[4] / "docs" / "examples"
    monkeypatch.syspath_prepend(examples)
    return runpy.run_path(str(examples / "line_contact.py"))


@pytest.mark.slow
def test_our_line_contact_on_a_block_is_hertzs(line_contact):
    """The end of the block adds a share of (a/40)^2 to the pressure at a given force."""
    ours = line_contact["ours"]()
    assert_allclose(ours.value, 1.0, atol=ours.bar + 40.0**-2)


@pytest.mark.slow
def test_mortar_contact_is_hertzs_at_small_strains_on_fine_elements(line_contact):
    """Four-node elements, 12 in a half-width; 1e-3: three times what 24 change (docs)."""
    try:
        line_contact["KRATOS"].version()
    except Refused as refused:
        pytest.skip(str(refused))
    theirs = line_contact["theirs"](1e-4, 12, line_contact["growth"](12))
    assert_allclose(theirs["pressure"][0], theirs["hertz"], rtol=1e-3)
    assert (theirs["pressure"][13:] == 0).all()
