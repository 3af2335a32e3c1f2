"""Fixtures that tests of several rooms share."""

import importlib.util
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from comparisons.facts.methods import METHODS
from comparisons.methods.registry import SOLVERS, load
from comparisons.methods.user.external import VARIABLE
from comparisons.results.store import load_study
from comparisons.solving import execution

# Solvers of all physics at once: tests that put others in their place put them back.
load()


@pytest.fixture(autouse=True)
def _width(monkeypatch):
    """Print as wide as a terminal is by default, wherever the tests themselves run."""
    monkeypatch.setenv("COLUMNS", "80")


@pytest.fixture(autouse=True, scope="session")
def _solve_once():
    """Solve once what a study solves three times for the median of its times: no test reads them.

    tests/comparisons/solving/test_execution.py does, and sets its own number.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(execution, "REPEATS", 1)
        yield


@pytest.fixture(scope="session")
def python():
    """Run Python on our packages in a process of its own; more of its environment may be given."""
    ours = {"PYTHONPATH": str(Path(__file__).parents[1])}

    def run(*arguments, cwd=None, timeout=1800, **environment):
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            cwd=cwd,
            env=os.environ | ours | environment,
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )

    return run


@pytest.fixture
def methods_restored(monkeypatch):
    known, solvers = dict(METHODS), dict(SOLVERS)
    monkeypatch.setenv(VARIABLE, "[]")
    yield
    for table, before in ((METHODS, known), (SOLVERS, solvers)):
        table.clear()
        table.update(before)


@pytest.fixture
def interruptible():
    """Let a ctrl-C reach the programs that a test starts, wherever the tests themselves run.

    A job in the background of a shell, as on some build servers, ignores SIGINT, and a program
    inherits that from the one that starts it; a handler is not inherited.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def script():
    def load_script(name):
        path = Path(__file__).parents[1] / "docs" / "examples" / f"{name}.py"
        spec = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return load_script


@pytest.fixture(scope="session")
def quick_suite():
    """Return the scenes of the folder that ROUGHLINE_QUICK names, where `.ci/run` solved them."""
    made = os.environ.get("ROUGHLINE_QUICK")
    return {scene.name: scene for scene in load_study(made).scenes} if made else {}
