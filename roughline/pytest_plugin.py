"""A pytest fixture: somebody else's reduced model, regression-tested in their own suite.

Installing roughline installs it (entry point ``pytest11``), in every test run of the same
environment. Imports happen where the fixture is used: others do not pay for them, and may have
packages of their own that are called ``comparisons`` or ``reports``, as ours are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from comparisons.methods import Solver

UPDATE = "--roughline-update"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that renews baselines instead of comparing with them."""
    group = parser.getgroup("roughline")
    group.addoption(UPDATE, action="store_true", help="renew the baselines of roughline_check")


@pytest.fixture
def roughline_check(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Return a function that compares a method with a baseline file, and fails on drift.

    ``roughline_check(method, baseline, scenes=("paraboloid",), tolerance=1e-9)``

    - method: a method of yours (docs/adding-a-method.md), or the name of a built-in one;
    - baseline: path of the JSON file, relative to the test's file; ``--roughline-update`` writes
      it;
    - scenes: built-in names or scene files; default: those of ``roughline check``;
    - tolerance: relative change of the method's curves that is no drift.

    Times are not judged here: tests run on machines that do other things.
    """

    def check(
        method: str | type[Solver],
        baseline: str | Path,
        scenes: Iterable[str] | None = None,
        tolerance: float | None = None,
    ) -> None:
        shadows = _shadows()
        if shadows:
            message = "\n".join(["roughline's packages are shadowed by others:", *shadows])
            pytest.fail(message, pytrace=False)
        from comparisons.errors import InputError
        from comparisons.questions.regression import CHECK_SCENES
        from comparisons.questions.regression.check import check_against, update_baseline
        from comparisons.questions.regression.findings import MODEL_TOLERANCE, SPEED

        path = request.path.parent / baseline
        name, scenes = _registered(method), scenes or CHECK_SCENES
        allowed = MODEL_TOLERANCE if tolerance is None else tolerance
        if request.config.getoption(UPDATE):
            update_baseline(path, name, scenes, tolerance=allowed)
            return
        try:
            findings = check_against(path, name, scenes, tolerance=allowed)
        except InputError as error:
            pytest.fail(f"{error}\n(pytest {UPDATE} writes baselines)", pytrace=False)
        drifted = [f for f in findings if f.drifted and f.subject != SPEED]
        if drifted:
            message = "\n".join(f"{drift.scene}: {drift.text}" for drift in drifted)
            pytest.fail(f"against {path}:\n{message}", pytrace=False)

    return check


def _shadows() -> list[str]:
    """Return a line for each package of ours that is somebody else's in this test run."""
    try:
        from reports.cli.shadowed import foreign_packages
    except ImportError as error:
        return [f"reports: {error}"]
    return foreign_packages()


def _registered(method: str | type[Solver]) -> str:
    """Make a class known by its name for the rest of the session."""
    if isinstance(method, str):
        return method
    from comparisons.methods.registry import add_class

    return add_class(method)
