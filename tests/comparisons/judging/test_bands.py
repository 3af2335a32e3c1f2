"""The one surface of a map among single lines, beside their mean."""

import numpy as np
import pytest

from comparisons.judging.comparison import FEWEST, compare
from comparisons.judging.levels import Levels
from comparisons.judging.verdicts import Verdict
from comparisons.scene.scene import load_scene
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solution

AREA = "contact_area"


@pytest.fixture(scope="module")
def plan():
    changes = {
        "surface.crop": [0, 0, 16, 16],
        "compare": {"quantities": [AREA], "methods": ["reduced", "bem_fft"]},
    }
    return plan_scene(load_scene("measured-map", changes))[0]


def outside(plan, lines, surface, grids=(1.0, 1.0)):
    """Return the load steps at which a surface is outside the band of lines, as it is written."""
    steps = len(plan.loads.values)
    solved = {}
    for n, share in zip((16, 32), grids, strict=True):
        task = task_of(plan, "bem_fft", n)
        solved["bem_fft", n] = Solution.of(task, {AREA: share * np.asarray(surface)})
    task = task_of(plan, "reduced", 16, tuple(range(len(lines))))
    curves = np.asarray(lines)[:, None] * np.ones(steps)
    solved["reduced", 16] = Solution.of(task, {AREA: curves})
    verdicts = compare(plan, solved, {}).verdicts
    (own,) = [v for v in verdicts if (v.method, v.at) == ("reduced", "force")]
    return own.outside_band


def test_a_surface_is_inside_or_outside_the_band_of_single_lines(plan):
    """90 % of 1, 2, .. 100 lie between 5.95 and 95.05; the grids agree, so nothing blurs it."""
    lines = np.arange(1.0, 101.0)
    assert outside(plan, lines, [6.0, 50.0, 50.0, 50.0, 95.0]) == "never"
    assert outside(plan, lines, [5.9, 50.0, 95.1, 96.0, 50.0]) == "1 3 4"


def test_the_bar_of_the_surface_counts_for_it(plan):
    """Its area changed by 10 % from one grid to the next: 98 may be 95."""
    lines, surface = np.arange(1.0, 101.0), [50.0, 50.0, 50.0, 50.0, 98.0]
    assert outside(plan, lines, surface) == "5"
    assert outside(plan, lines, surface, grids=(1.1, 1.0)) == "never"


def test_few_lines_have_no_band(plan):
    assert outside(plan, np.arange(1.0, FEWEST), np.ones(5)) == ""


def test_only_grids_of_cells_err_at_the_contact_line(plan):
    """An area of 1.0 counted as 1.5: cells leave at least 0.4 0.5^1.5 = 14 %, springs nothing."""
    steps = np.ones(len(plan.loads.values))
    for method, least, most in (("bem_fft", 0.14, np.inf), ("reduced", 0.0, 1e-9)):
        solved = {
            (method, n): Solution.of(
                task_of(plan, method, n), {AREA: steps, "contact_area_raw": 1.5 * steps}
            )
            for n in (16, 32, 64)
        }
        bar = Levels.of(solved, method).discretisation(AREA)
        assert (bar >= least).all()
        assert (bar <= most).all()


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ("", ""),
        ("never", "in the lines' band"),
        ("2", "outside the lines' band at load step 2"),
        ("1 4", "outside the lines' band at load steps 1, 4"),
        ("2 3 4 5", "outside the lines' band at load steps 2 to 5"),
    ],
)
def test_a_verdict_says_where_the_surface_lies(steps, words):
    numbers = {"step": 4, "error": 0.2, "uncertainty": 0.01, "low": 0.19, "high": 0.21}
    asked = {"quantity": AREA, "at": "force", "tolerance": 0.05}
    judged = Verdict(word="outside", outside_band=steps, **asked, **numbers)
    assert judged.band == words
    expected = "load step 5, equal force"
    assert judged.where == expected + (f"; the lines' mean, the surface {words}" if words else "")
