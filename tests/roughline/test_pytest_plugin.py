"""The fixture for other people's suites: writes baselines, passes what stayed, names what moved."""

import shutil
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SUITE = """
from winkler import winkler


def test_my_model(roughline_check):
    roughline_check(winkler, "baseline", scenes=["paraboloid"])
"""


@pytest.mark.slow
def test_a_model_is_regression_tested_in_its_owners_suite(python, tmp_path):
    """Missing baseline, baseline written, unchanged, and a model that is 1 % stiffer."""

    def suite(*arguments):
        """Run the suite as its owner would, without the settings of our tests."""
        # Installed, roughline registers the plugin itself; naming it twice is an error.
        command = ("-m", "pytest", "-q", "-p", "roughline.pytest_plugin", "-p", "no:roughline")
        paths = f"{ROOT}:{tmp_path}"
        return python(*command, "--rootdir", tmp_path, *arguments, cwd=tmp_path, PYTHONPATH=paths)

    shutil.copy(ROOT / "docs" / "examples" / "winkler.py", tmp_path)
    (tmp_path / "test_mine.py").write_text(SUITE)
    missing = suite()
    assert missing.returncode == 1
    assert "--roughline-update writes baselines" in missing.stdout
    assert suite("--roughline-update").returncode == 0
    assert suite().returncode == 0
    model = tmp_path / "winkler.py"
    text = model.read_text()
    assert "* overlap.sum()" in text
    model.write_text(text.replace("* overlap.sum()", "* 1.01 * overlap.sum()"))
    moved = suite()
    assert moved.returncode == 1
    assert "paraboloid: Winkler foundation moved: force by +1.0" in moved.stdout


@pytest.fixture
def installed(python, tmp_path):
    """Return a runner of a suite in an environment that has roughline installed.

    The entry point is the one that pyproject.toml declares.
    """
    entries = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
    info = tmp_path / "site" / "roughline-0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: roughline\nVersion: 0\n")
    lines = [f"{name} = {value}" for name, value in entries["pytest11"].items()]
    (info / "entry_points.txt").write_text("\n".join(["[pytest11]", *lines, ""]))

    def run(suite: str):
        project = tmp_path / "project"
        for package in ("comparisons", "reports", "reduced", "reference"):
            (project / package).mkdir(parents=True)
            (project / package / "__init__.py").write_text("OWN = True\n")
        (project / "test_own.py").write_text(suite)
        words = ("-m", "pytest", "-q", "--rootdir", project, project)
        return python(*words, cwd=tmp_path, PYTHONPATH=f"{info.parent}:{ROOT}")

    return run


@pytest.mark.slow
def test_a_project_may_have_packages_of_our_names(installed):
    done = installed(
        "from comparisons import OWN\n"
        "from reduced import OWN\nfrom reference import OWN\nfrom reports import OWN\n"
        "def test_own(request):\n"
        "    assert OWN\n"
        "    assert request.config.pluginmanager.has_plugin('roughline')\n"
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_the_fixture_says_which_packages_are_in_its_way(installed):
    """There it cannot work: the model's own packages are not to be had."""
    done = installed(
        "import comparisons\n"
        "def test_model(roughline_check):\n"
        "    roughline_check('reduced', 'baseline', scenes=['cone'])\n"
    )
    assert done.returncode == 1
    assert "roughline's packages are shadowed by others" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr
