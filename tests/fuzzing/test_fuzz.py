"""A share of the fuzz run in every test run; the whole one is ``python tests/fuzzing/fuzz.py``."""

from pathlib import Path

import pytest


@pytest.mark.slow
def test_mutated_input_ends_in_an_answer_or_one_clear_error(python, tmp_path):
    """In a process of its own: it takes over signals and measures its memory."""
    script = Path(__file__).with_name("fuzz.py")
    done = python(script, "--cases", 1000, "--seed", 7, cwd=tmp_path, OMP_NUM_THREADS="1")
    assert done.returncode == 0, done.stderr
    assert "0 faults" in done.stdout
