"""The fixture for other people's suites: writes baselines, passes what stayed, names what moved."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SUITE = """
from winkler import winkler


def test_my_model(roughline_check):
    roughline_check(winkler, "winkler.json", scenes=["paraboloid"])
"""


def pytest_run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a suite as its owner would, with roughline importable but not its tests' settings."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "comparisons.pytest_plugin"]
    # Installed, roughline registers the plugin itself; naming it twice is an error.
    command += ["-p", "no:roughline", "--rootdir", str(folder), *arguments]
    paths = f"{ROOT}:{folder}"
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=folder,
        check=False,
        env={**os.environ, "PYTHONPATH": paths},
    )


@pytest.mark.slow
def test_a_model_is_regression_tested_in_its_owners_suite(tmp_path):
    """Missing baseline, baseline written, unchanged, and a model that is 1 % stiffer."""
    shutil.copy(ROOT / "docs" / "examples" / "winkler.py", tmp_path)
    (tmp_path / "test_mine.py").write_text(SUITE)
    missing = pytest_run(tmp_path)
    assert missing.returncode == 1
    assert "--roughline-update writes baselines" in missing.stdout
    assert pytest_run(tmp_path, "--roughline-update").returncode == 0
    assert pytest_run(tmp_path).returncode == 0
    model = tmp_path / "winkler.py"
    text = model.read_text()
    assert "* overlap.sum()" in text
    model.write_text(text.replace("* overlap.sum()", "* 1.01 * overlap.sum()"))
    moved = pytest_run(tmp_path)
    assert moved.returncode == 1
    assert "paraboloid: Winkler foundation moved: force by +1.0" in moved.stdout
