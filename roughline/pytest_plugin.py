"""A pytest fixture for regression tests of a user's own reduced model.

Installing roughline registers it (entry point ``pytest11``) for every test run of the environment.
Packages are imported only where the fixture is used, so that other test runs pay no cost and may
have their own packages called ``comparisons`` or ``reports``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from roughline.__main__ import SHADOWED, foreign_packages

if TYPE_CHECKING:
    from comparisons.methods import Solver

UPDATE = "--roughline-update"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that rewrites baselines instead of comparing with them."""
    group = parser.getgroup("roughline")
    group.addoption(UPDATE, action="store_true", help="renew the baselines of roughline_check")


@pytest.fixture
def roughline_check(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Return a function that compares a method with a baseline, a stored run, and fails on drift.

    ``roughline_check(method, baseline, scenes=("paraboloid",), tolerance=1e-9)``

    - method: your own method (the documentation has a page on it), or a built-in one's name;
    - baseline: path of the folder, relative to the test's file; ``--roughline-update`` writes
      it;
    - scenes: built-in names or scene files; default: those of ``roughline check``;
    - tolerance: largest relative change of the method's curves that is not a drift.

    Times are not judged, because test machines are often busy.
    """

    def check(
        method: str | type[Solver],
        baseline: str | Path,
        scenes: Iterable[str] | None = None,
        tolerance: float | None = None,
    ) -> None:
        shadows = foreign_packages()
        if shadows:
            message = "\n".join([SHADOWED, *shadows])
            pytest.fail(message, pytrace=False)
        from comparisons.errors import InputError
        from comparisons.methods.registry import add_class
        from comparisons.questions.check import CHECK_SCENES, MODEL_TOLERANCE, check_against

        path = request.path.parent / baseline
        scenes = scenes or CHECK_SCENES
        # A class is known by its name for the rest of the session.
        name = method if isinstance(method, str) else add_class(method)
        allowed = MODEL_TOLERANCE if tolerance is None else tolerance
        if request.config.getoption(UPDATE):
            check_against(path, name, scenes, tolerance=allowed, update=True)
            return
        try:
            findings = check_against(path, name, scenes, tolerance=allowed)
        except InputError as error:
            pytest.fail(f"{error}\n(pytest {UPDATE} writes baselines)", pytrace=False)
        drifted = [f for f in findings if f.drifted]
        if drifted:
            message = "\n".join(f"{drift.scene}: {drift.text}" for drift in drifted)
            pytest.fail(f"against {path}:\n{message}", pytrace=False)

    return check
