"""A share of the fuzz run in every test run; the whole one is ``python tests/fuzzing/fuzz.py``."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def run(cases: int, tmp_path: Path) -> subprocess.CompletedProcess[str]:
    """Fuzz in a process of its own: it takes over signals and measures its memory."""
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    script = ROOT / "tests" / "fuzzing" / "fuzz.py"
    return subprocess.run(
        [sys.executable, str(script), "--cases", str(cases), "--seed", "7"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=environment,
    )


@pytest.mark.slow
def test_mutated_input_ends_in_an_answer_or_one_clear_error(tmp_path):
    done = run(20, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "0 faults" in done.stdout


@pytest.mark.slow
def test_more_mutated_input_ends_in_an_answer_or_one_clear_error(tmp_path):
    done = run(1000, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "0 faults" in done.stdout
