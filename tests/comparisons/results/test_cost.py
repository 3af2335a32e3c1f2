"""A time and the error beside it are of the same thing: one surface, or the mean over all."""

import numpy as np
import pytest

from comparisons.results.advice import advise
from comparisons.results.scene_record import record_scene
from comparisons.scene.scene import load_scene
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solution

LINES = 101


@pytest.fixture
def record(rough):
    """Surfaces of area 1 in 1 s each at 16, 2 s at 32, 4 s of fem; lines of area 1.2 to 1.8."""
    (plan,) = plan_scene(rough(realisations=30, loading={"force": [1e-6]}))

    def solution(method, resolution, areas, seconds):
        task = task_of(plan, method, resolution, tuple(range(len(areas))))
        curves = {"force": np.full((len(areas), 1), 1e-6), "contact_area": areas[:, None]}
        found = Solution.of(task, curves)
        found.seconds, found.setup_seconds = seconds * len(areas), 0.25 * seconds * len(areas)
        return found

    solved = {
        ("bem_fft", 16): solution("bem_fft", 16, np.ones(30), 1.0),
        ("bem_fft", 32): solution("bem_fft", 32, np.ones(5), 2.0),
        ("fem", 16): solution("fem", 16, np.ones(3), 4.0),
        ("reduced", 16): solution("reduced", 16, np.linspace(1.2, 1.8, LINES), 1e-3),
    }
    return record_scene(plan, solved)


def test_the_time_of_a_mean_is_that_of_all_solves_it_stands_on(record):
    """A mean on a fine grid stands on the coarse ones; one of elements on those of the grid."""
    whole = {key: record.cost(*key) for key in (("bem_fft", 32), ("fem", 16), ("reduced", 16))}
    assert whole["bem_fft", 32].seconds == pytest.approx(30 + 5 * 2)
    assert whole["bem_fft", 32].setup_seconds == pytest.approx(0.25 * 40)
    assert whole["fem", 16].seconds == pytest.approx(30 + 3 * 4)
    assert whole["reduced", 16].seconds == pytest.approx(LINES * 1e-3)
    assert whole["bem_fft", 32].single_seconds == pytest.approx(2.0)
    assert whole["bem_fft", 32].solves == "30 + 5 surfaces"
    assert whole["fem", 16].solves == "3 surfaces beside those of FFT BEM"
    # every solve of the scene once
    assert record.spent == pytest.approx(30 + 5 * 2 + 3 * 4 + LINES * 1e-3)


def test_the_time_of_one_line_stands_beside_the_errors_of_single_lines(record):
    """The mean errs by 50 %; of lines from +20 to +80 %, 90 % lie between +23 and +77 %."""
    (line,) = [s for s in advise(record).settings if (s.method, s.resolution) == ("reduced", 16)]
    (verdict,) = [v for v in line.verdicts if v.quantity == "contact_area"]
    assert verdict.error == pytest.approx(0.5)
    assert verdict.single == "+23 to +77\u202f%"
    assert (verdict.single_low, verdict.single_high) == pytest.approx((0.23, 0.77))
    assert "takes 1.0\u202fms" in advise(record).single
    assert "contact area +23 to +77\u202f%." in advise(record).single


def test_a_method_that_is_compared_with_itself_is_marked(record):
    marks = {(s.method, s.resolution): s.brief for s in advise(record).settings}
    assert marks["bem_fft", 16].startswith("FFT BEM* ")
    assert not marks["bem_fft", 32].startswith("FFT BEM* ")  # the truth
    assert "FFT BEM 30\u202fs (N = 16, 30 surfaces, same method as the reference)" in (
        advise(record).sentence
    )


def test_elements_that_repeat_from_cell_to_cell_have_a_name_of_their_own(record):
    """They cost as much as boundary elements; a block of elements ten times as much."""
    (block,) = plan_scene(load_scene("paraboloid", {"compare.methods": ["fem", "bem_fft"]}))
    titles = {planned.method: planned.title for planned in block.methods}
    assert titles["fem"] == ""  # the usual one, FEM
    assert record.title_of("fem") == "FFT FEM"
    assert "FFT FEM 42\u202fs" in advise(record).sentence
