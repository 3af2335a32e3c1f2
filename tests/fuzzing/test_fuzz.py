"""A share of the fuzz run in every test run; the whole one is ``python tests/fuzzing/fuzz.py``."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_mutated_input_ends_in_an_answer_or_one_clear_error(tmp_path):
    """In a process of its own: it takes over signals and measures its memory."""
    done = subprocess.run(
        [sys.executable, str(ROOT / "tests/fuzzing/fuzz.py"), "--cases", "1000", "--seed", "7"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stderr
    assert "0 faults" in done.stdout
