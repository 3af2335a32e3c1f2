"""The fixture for other people's suites: writes baselines, passes what stayed, names what moved."""

import re
import shutil
import tomllib
from pathlib import Path

import pytest

from roughline.__main__ import PACKAGES

ROOT = Path(__file__).resolve().parents[2]
SUITE = """
import pytest
from stiffened import stiffened
from winkler import winkler


@pytest.mark.parametrize("baseline", ["kept", "lost"])
def test_my_model(roughline_check, baseline):
    roughline_check(winkler, baseline, scenes=["paraboloid"])


def test_my_other_model(roughline_check):
    roughline_check(stiffened, "other", scenes=["paraboloid"])
"""


@pytest.mark.slow
def test_a_model_is_regression_tested_in_its_owners_suite(python, tmp_path):
    """Baselines written, unchanged, lost, and a model that has become 1 % stiffer."""

    def suite(*arguments):
        """Run the suite as its owner would, without the settings of our tests."""
        # Installed, roughline registers the plugin itself; naming it twice is an error.
        command = ("-m", "pytest", "-q", "-p", "roughline.pytest_plugin", "-p", "no:roughline")
        paths = f"{ROOT}:{tmp_path}"
        return python(*command, "--rootdir", tmp_path, *arguments, cwd=tmp_path, PYTHONPATH=paths)

    text = (ROOT / "docs" / "examples" / "winkler.py").read_text()
    assert "* overlap.sum()" in text
    other = re.sub(r"winkler\b", "stiffened", text)
    (tmp_path / "winkler.py").write_text(text)
    (tmp_path / "stiffened.py").write_text(other)
    (tmp_path / "test_mine.py").write_text(SUITE)
    assert suite("--roughline-update").returncode == 0
    shutil.rmtree(tmp_path / "lost")
    (tmp_path / "stiffened.py").write_text(other.replace("* overlap", "* 1.01 * overlap"))
    done = suite("-rA")
    assert done.returncode == 1
    assert "PASSED test_mine.py::test_my_model[kept]" in done.stdout
    assert "FAILED test_mine.py::test_my_model[lost]" in done.stdout
    assert "--roughline-update writes baselines" in done.stdout
    assert "paraboloid: Winkler foundation moved: force by +1.0" in done.stdout


@pytest.mark.slow
def test_a_project_may_have_packages_of_our_names(python, tmp_path):
    """There the fixture cannot work, and says so: the model's own packages are not to be had.

    roughline is installed: its entry point is the one that pyproject.toml declares.
    """
    entries = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
    info = tmp_path / "site" / "roughline-0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: roughline\nVersion: 0\n")
    lines = [f"{name} = {value}" for name, value in entries["pytest11"].items()]
    (info / "entry_points.txt").write_text("\n".join(["[pytest11]", *lines, ""]))
    project = tmp_path / "project"
    for package in PACKAGES:
        (project / package).mkdir(parents=True)
        (project / package / "__init__.py").write_text("OWN = True\n")
    imports = "".join(f"from {package} import OWN\n" for package in PACKAGES)
    (project / "test_own.py").write_text(
        f"{imports}"
        "def test_own(request):\n"
        "    assert OWN\n"
        "    assert request.config.pluginmanager.has_plugin('roughline')\n"
        "def test_model(roughline_check):\n"
        "    roughline_check('reduced', 'baseline', scenes=['cone'])\n"
    )
    words = ("-m", "pytest", "-q", "-rA", "--rootdir", project, project)
    done = python(*words, cwd=tmp_path, PYTHONPATH=f"{info.parent}:{ROOT}")
    said = done.stdout + done.stderr
    assert "PASSED project/test_own.py::test_own" in said, said
    assert "FAILED project/test_own.py::test_model" in said
    assert "roughline's packages are shadowed by others" in said
    assert "Traceback" not in said
