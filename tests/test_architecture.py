"""The walls of the house: who may import whom, and that the house is ours."""

import tomllib
from pathlib import Path

import pytest

from comparisons.facts.methods import BUILT_IN, LAWS, METHODS, THEORIES
from comparisons.methods.registry import SOLVERS, load
from comparisons.scene.options import MethodOptions
from roughline import __main__ as start

ROOT = Path(__file__).parents[1]
PACKAGES = ("reduced", "reference", "comparisons", "reports", "roughline")


HEAVY = {"markdown_it", "numba", "pandas", "plotly", "pyamg", "pyvista", "scipy", "skfem"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "what", ["--help", "list", "list scenes", "list claims", "list methods", "problems"]
)
def test_nothing_heavy_is_imported_for_a_list(python, what):
    """Numba, SciPy and scikit-fem take seconds to import; a list or a help text needs none."""
    code = "import sys; from roughline.commands.app import run_command; "
    code += f"run_command({what.split()!r})"
    done = python("-c", f"{code}; print(*sys.modules, file=sys.stderr)")
    assert done.returncode == 0
    assert "roughline.commands.app" in done.stderr.split()
    assert not HEAVY & set(done.stderr.split())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("what", "without"),
    [
        ("reports.pages.study", {"skfem", "comparisons.methods.registry"}),
        ("reports.pages.hard_cases", {"skfem", "comparisons.methods.registry"}),
        ("comparisons.questions.hard_cases.case", HEAVY),
        ("reference.rolling.roll", {"skfem", "reference.fem"}),
    ],
)
def test_nothing_is_imported_for_what_is_only_read_or_does_not_use_it(python, what, without):
    """A page is written from records, without solvers; rolling on a half-space needs no mesh."""
    done = python("-c", f"import sys, {what}; print(*sys.modules)")
    assert done.returncode == 0, done.stderr
    loaded = set(done.stdout.split())
    assert what in loaded
    assert not without & loaded


def test_every_method_has_a_row_of_facts_solvers_and_options():
    """The facts stand apart from the solvers, so that listing them imports none."""
    plain = {name for name in BUILT_IN if any(not maker.physics for maker in SOLVERS[name])}
    assert plain == set(BUILT_IN) == {maker.name for name in BUILT_IN for maker in SOLVERS[name]}
    assert list(MethodOptions.model_fields) == list(BUILT_IN)
    load()  # lists, which import no solver, name all that there are
    assert {n for n, row in METHODS.items() if not row.user_made} == {*BUILT_IN, *THEORIES, *LAWS}


def test_our_own_packages_are_no_foreigners():
    assert start.foreign_packages() == []
    assert tuple(name for name in PACKAGES if name != "roughline") == start.PACKAGES


@pytest.mark.parametrize("layout", ["package", "module", "namespace"])
def test_a_foreign_package_of_our_name_is_named_with_both_places(python, tmp_path, layout):
    """As in a folder with somebody's reference/ in it, from where the program is started.

    A folder without __init__.py is shadowed by a regular package anywhere later on the path, so
    there nothing is wrong, and nothing must be said.
    """
    if layout == "module":
        (tmp_path / "reference.py").write_text("raise RuntimeError('imported')\n")
        where = tmp_path
    else:
        where = tmp_path / "reference"
        where.mkdir()
        if layout == "package":
            (where / "__init__.py").write_text("raise RuntimeError('imported')\n")
    done = python("-m", "roughline", "list", "methods", cwd=tmp_path)
    if layout == "namespace":
        assert done.returncode == 0
        return
    assert done.returncode == 2
    assert "shadowed" in done.stderr
    assert f"reference: {where} shadows roughline's own {ROOT / 'reference'}" in done.stderr
    assert "Traceback" not in done.stderr
    assert "reduced:" not in done.stderr


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setattr(start, "PACKAGES", ("reduced", "no_such_room"))
    (line,) = start.foreign_packages()
    assert line == f"no_such_room: not found; roughline's own is {ROOT / 'no_such_room'}"


def test_an_installed_package_has_all_its_files():
    """Tables, templates and sheets beside the code are named in pyproject.toml."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    patterns = settings["tool"]["setuptools"]["package-data"]
    forgotten = [
        path.relative_to(ROOT).as_posix()
        for package, shipped in patterns.items()
        for path in (ROOT / package).rglob("*")
        if path.is_file() and path.suffix != ".py" and "__pycache__" not in path.parts
        if not any(path in (ROOT / package).glob(pattern) for pattern in shipped)
    ]
    assert forgotten == []
    assert all((ROOT / package / "py.typed").exists() for package in PACKAGES)


@pytest.mark.slow
def test_what_a_first_installation_leaves_behind_hides_no_package(python, tmp_path):
    """The README's second command in the folder of the first: folders of compiled code remain."""
    for package in ("reduced", "reference/halfspace", "comparisons"):
        (tmp_path / package / "__pycache__").mkdir(parents=True)
    code = "import reference.halfspace.kernels, reduced, comparisons"
    done = python("-P", "-c", code, cwd=tmp_path, PYTHONPATH=str(tmp_path))
    assert done.returncode == 0, done.stderr
