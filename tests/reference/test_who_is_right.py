"""The table "Who is right?" follows from its script; skipped without the numbers of others.

ROUGHLINE_OTHERS names the folder that `docs/examples/who_is_right.py` reads.
"""

import os
import runpy
import tomllib
from pathlib import Path

import numpy as np
import pytest

from comparisons.questions.claims.claim import load_claims
from reference.closed_form import rounded_punch

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "docs" / "examples" / "who_is_right.py"
PAGE = (ROOT / "docs" / "other-codes.md").read_text(encoding="utf-8")
FOLDER = os.environ.get("ROUGHLINE_OTHERS")
needs_numbers = pytest.mark.skipif(not FOLDER, reason="ROUGHLINE_OTHERS names no folder")


@pytest.fixture(scope="module")
def script():
    return runpy.run_path(str(SCRIPT))


@pytest.fixture(scope="module")
def known():
    return tomllib.loads(SCRIPT.with_suffix(".toml").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_half_a_ball_in_a_small_contact_is_hertzs(script):
    """At a/R = 0.01; that the body ends is worth a share of a/R."""
    radius, modulus, depth = 50.0, 20e3, 0.005
    found = script["half_disc"](8, radius, (modulus, 0.3), depth, around=True)
    plane, strain = modulus / (1 - 0.3**2), np.sqrt(depth / radius)
    assert found["pressure"] == pytest.approx(2 / np.pi * plane * strain, rel=0.005)
    assert found["force"] == pytest.approx(4 / 3 * plane * radius**2 * strain**3, rel=0.01)


@pytest.mark.slow
def test_a_rigid_rounded_punch_on_a_large_block_is_that_on_the_half_space(script):
    """The block's end is worth a share of a/R in depth, which two blocks show, less in pressure."""
    stress, exact = 1.0, rounded_punch(40.0, 10.0, 70e3 / (1 - 0.3**2))
    rigid = {"modulus": 1e10, "stress": stress}
    small, large = (
        script["punch"](4, 0.0, block=(size, size), **rigid) for size in (1500.0, 3000.0)
    )
    depth = 2 * large["displacement"] - small["displacement"]
    assert exact.force(depth) == pytest.approx(stress * np.pi * 50**2, rel=0.001)
    assert large["pressure"] == pytest.approx(float(exact.pressure(0.0, 0.0, depth)), rel=0.001)


def test_large_rotations_cost_no_force(script):
    """What linear elasticity has in excess is all it has, in the plane."""
    line, angle = np.linspace(0, 1, 3), 0.3
    body = script["Section"]((line, line), lambda x, y: (x, y), (1.0, 0.3), {"back": "xy"})
    turn = np.array([[np.cos(angle) - 1, -np.sin(angle)], [np.sin(angle), np.cos(angle) - 1]])
    places, rows = body.basis.doflocs, body.basis.split_indices()
    moved = np.zeros(body.basis.N)
    for row, part in zip(rows, turn, strict=True):
        moved[row] = part @ places[:, row]
    linear = body.stiffness @ moved
    assert body.excess(moved) == pytest.approx(linear, abs=1e-12 * np.abs(linear).max())


def test_places_on_a_quadratic_surface_are_exact(script):
    x, places = np.linspace(0, 2, 5), np.array([0.1, 0.9, 1.7])
    matrix, slope = script["across"](places, x, x**2)
    assert matrix @ x**2 == pytest.approx(places**2)
    assert slope == pytest.approx(2 * places)


def test_every_problem_has_a_source_and_is_on_the_page(known, script):
    unwrapped = " ".join(PAGE.split())
    assert all(line in unwrapped for line in script["provenance"]())
    for problem in known["problems"]:
        assert problem["source"] in known["sources"]
        where = f"\n| {problem['name']} |" if "model" in problem else problem["reason"]
        assert where in PAGE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "model"),
    [("sheet-code-aster-body", ("balls", 4)), ("sheet-nafems-large", ("roller", 0.0))],
)
def test_claims_hold_printed_pressures_against_the_answers(script, name, model):
    (claim,) = load_claims((name,))
    answer, true = script["answers"](*model)["pressure"], claim.true
    assert true.number == pytest.approx(answer.value, rel=5e-5)
    assert true.uncertainty == pytest.approx(answer.bar * answer.value, rel=0.1)


@pytest.mark.slow
@needs_numbers
def test_the_page_follows_from_the_numbers(script):
    _, table, counts = script["report"](Path(FOLDER))
    section = PAGE.partition("## Who is right?")[2].partition("\n### ")[0]
    shown = [line for line in section.splitlines() if line.startswith("| ")]
    assert shown[1:] == table
    assert f"\n{counts}\n" in PAGE


@needs_numbers
def test_numbers_beside_the_problems_are_those_of_the_folder(known):
    """Of MOOSE and LAMMPS, where the folder has them."""
    results = {p["name"]: p["results"] for p in known["problems"] if "results" in p}
    pressures = np.loadtxt(Path(FOLDER, "moose_hertz_cyl_q8_frictionless_pressure.dat"))[:, 1]
    (kinematic, _) = results["MOOSE: largest pressure, kinematic and by penalty"]
    assert kinematic == pressures.max()
    text = Path(FOLDER, "lammps_dem02.yaml.txt").read_text(encoding="utf-8")
    (rebound,) = results["LAMMPS: speed of rebound after 2508 steps"]
    (overlap,) = results["LAMMPS, two balls: overlap after 1508 steps"]
    assert repr(rebound)[:16] in text
    assert f"{overlap:.2f} um" in text
