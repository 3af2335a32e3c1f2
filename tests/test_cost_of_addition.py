"""What an addition costs: one file. A quantity, a method, a table of physics and a claim, each run.

The files are dropped into a copy of the packages, as a developer would drop them into the tree.
"""

import os
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("reduced", "reference", "comparisons", "reports", "roughline")
SCENE = """
name = "toy"
[half_space]
effective_modulus = "1 MPa"
[indenter]
shape = "paraboloid"
radius = "10 mm"
{table}
[loading]
penetration = ["0.1 mm", "0.2 mm"]
[compare]
quantities = {quantities}
methods = {methods}
"""
QUANTITY = '''
"""The pressure that a contact would have if it were even."""

from comparisons.facts.quantities.rows import Derived, Quantity

ROWS = (
    Quantity(
        "mean_pressure",
        "mean contact pressure",
        "p_m",
        "Pa",
        comparable=True,
        derived=Derived(("force", "contact_area"), lambda k, _: k["force"] / k["contact_area"]),
    ),
)
'''
# Hertz (Johnson 1985, 4.22) with a force that is 2 % too large.
METHOD = '''
"""The method `toy`."""

from comparisons.methods.solver import Solver
from comparisons.tasks.solution import Solution


class Toy(Solver):
    """Hertz, badly remembered."""

    name = "toy"
    title = "toy method"
    dimension = {dimension}
    physics = frozenset({physics})

    def resolutions(self, geometry):
        return (1,)

    def solve(self, task):
        depth, shape = task.loads.values, task.scene.indenter
        force = 1.02 * 4 / 3 * task.scene.effective_modulus * shape.radius**0.5 * depth**1.5
        return Solution.of(task, {{"penetration": depth, "force": force}})
'''
PHYSICS = '''
"""The table [toy_physics]."""

from comparisons.scene.fields import Positive
from comparisons.scene.physics.tables.physics_table import PhysicsTable


class Toy(PhysicsTable):
    """A magnet under the body."""

    key = "toy_physics"
    strength: Positive
'''
CLAIM = """
[claims.toy-claim]
text = "A paraboloid on springs is as stiff as Hertz says."
equation = "toy"
scene = "paraboloid"
quantity = "stiffness"
at = "penetration"
tolerance = 1e-9
expected = "holds"
"""


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """Copy the packages, with what Numba has compiled of them."""
    root = tmp_path_factory.mktemp("tree")
    for package in PACKAGES:
        shutil.copytree(ROOT / package, root / package)
    return root


@contextmanager
def added(tree, path, text):
    """One file more in the tree."""
    file = tree / path
    file.write_text(text)
    try:
        yield
    finally:
        file.unlink()


def roughline(tree, *arguments):
    """Run the command of the tree; return its exit code and what it says."""
    done = subprocess.run(
        [sys.executable, "-m", "roughline", *arguments],
        cwd=tree,
        env=os.environ | {"PYTHONPATH": str(tree), "COLUMNS": "200"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    return done.returncode, done.stdout + done.stderr


def attempt(tree, *, table="", quantities=("force",), methods):
    """Run the scene into the folder `out`; return what the command says."""
    scene = SCENE.format(table=table, quantities=list(quantities), methods=list(methods))
    (tree / "toy.toml").write_text(scene)
    shutil.rmtree(tree / "out", ignore_errors=True)
    return roughline(tree, "run", "toy.toml", "--out", "out")[1]


def run(tree, **parts):
    """Run the scene; return results.csv, measures.csv and the report."""
    said, out = attempt(tree, **parts), tree / "out"
    assert (out / "results.csv").exists(), said
    tables = [pd.read_csv(out / name) for name in ("results.csv", "measures.csv")]
    return *tables, (out / "report.html").read_text("utf-8")


@pytest.mark.slow
def test_a_quantity_is_one_file(tree):
    """Derived, compared and reported: of a Hertzian contact p_m = 4 E* a/(3 pi R)."""
    with added(tree, "comparisons/facts/quantities/toy.py", QUANTITY):
        rows, measures, report = run(
            tree, quantities=["mean_pressure"], methods=["closed_form", "reduced"]
        )
    exact = rows[rows["method"] == "closed_form"]
    radius = np.sqrt(0.01 * exact["penetration"])
    np.testing.assert_allclose(exact["mean_pressure"], 4e6 * radius / (3 * np.pi * 0.01))
    assert np.isfinite(rows[rows["method"] == "reduced"]["error_mean_pressure"]).all()
    assert set(measures["quantity"]) == {"mean_pressure"}
    assert set(measures["verdict"]) == {"within"}
    assert "mean contact pressure" in report


@pytest.mark.slow
def test_a_method_is_one_file(tree):
    """A model under test: it is planned, solved, judged and drawn."""
    text = METHOD.format(dimension=1, physics=set())
    with added(tree, "comparisons/methods/toy.py", text.replace("set()", "")):
        rows, measures, report = run(tree, methods=["closed_form", "toy"])
    np.testing.assert_allclose(rows[rows["method"] == "toy"]["error_force"], 0.02)
    assert set(measures["verdict"]) == {"outside"}
    assert "toy" in report


@pytest.mark.slow
def test_a_table_of_physics_is_one_file_and_each_of_its_solvers_another(tree):
    """Scenes may have it, plans tell it, and methods that do not model it say so."""
    table = "[toy_physics]\nstrength = 2"
    with added(tree, "comparisons/scene/physics/tables/toy_physics.py", PHYSICS):
        said = attempt(tree, table=table, methods=["closed_form", "reduced"])
        assert "closed_form, reduced: does not model [toy_physics]" in said
        solver = METHOD.format(dimension=3, physics={"toy_physics"})
        with added(tree, "comparisons/methods/toy.py", solver):
            rows, _, report = run(tree, table=table, methods=["toy"])
    toy = rows[rows["method"] == "toy"]
    assert np.isfinite(toy["force"]).all()
    assert set(toy["reference"]) == {"toy 1"}
    assert "The reference is the finest solution of toy method" in report
    assert "A magnet under the body: strength = 2" in report


@pytest.mark.slow
def test_a_claim_is_one_file(tree):
    with added(tree, "comparisons/questions/claims/toy-claim.toml", CLAIM):
        code, said = roughline(tree, "claims", "toy-claim", "--out", str(tree / "claims"))
    assert code == 0, said
    assert "toy-claim" in said
    assert "holds" in said
