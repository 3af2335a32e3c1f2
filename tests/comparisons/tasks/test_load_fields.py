"""The pressure at earlier load steps, against the closed form at that step's own depth."""

import numpy as np
import pytest

from comparisons.results.record import field_problems
from comparisons.tasks.shown_loads import MOST_STEPS, at_step, shown, shown_steps, stored_steps


@pytest.fixture
def pressed(scene, solved):
    def press(method, *depths):
        asked = {"loading": {"penetration": depths}, "compare": {"quantities": ["pressure"]}}
        made = scene(half_space={"effective_modulus": 1e9}, **asked)
        return solved(made, method, {"closed_form": 1, "fem": 2}.get(method, 10))

    return press


@pytest.mark.parametrize("method", ["closed_form", "reduced", "bem_fft", "bem_dense", "fem"])
def test_every_method_stores_hertz_pressure_at_every_load(pressed, method):
    """p0 = 2 E* a/(pi R), a = sqrt(R d): each step's peak within the grid's own error (10 %)."""
    solution = pressed(method, 2e-6, 4e-6, 8e-6)
    assert stored_steps(solution.fields) == [0, 1]
    for step, depth in enumerate((2e-6, 4e-6)):
        fields = at_step(solution.fields, step)
        a = np.sqrt(0.01 * depth)
        peak = 2 * 1e9 * a / (np.pi * 0.01)
        assert np.max(fields["pressure"]) == pytest.approx(peak, rel=0.1)
        touching = np.hypot(fields["pressure_x"], fields["pressure_y"])[fields["pressure"] > 0]
        assert touching.max() == pytest.approx(a, rel=0.25)
    assert field_problems(solution.fields) == []


def test_loads_over_decades_are_stored_from_grids_of_their_own(pressed):
    """Contact radii a factor of 100 apart are solved on different grids; each keeps its own."""
    fields = at_step(pressed("bem_fft", 1e-9, 1e-6, 1e-5).fields, 0)
    a = np.sqrt(0.01 * 1e-9)
    assert np.abs(fields["pressure_x"]).max() < 2 * a
    assert np.max(fields["pressure"]) == pytest.approx(2e9 * a / (np.pi * 0.01), rel=0.1)


def test_at_most_eight_steps_are_shown_and_always_the_last():
    for count in range(1, 40):
        steps = shown_steps(count)
        assert len(steps) == len(set(steps)) == min(count, MOST_STEPS)
        assert steps[-1] == count - 1


def test_a_torn_step_is_told(pressed):
    torn = pressed("closed_form", 2e-6, 4e-6).fields | {"step.0.pressure": np.ones(3)}
    assert any(field_problem.startswith("step 0") for field_problem in field_problems(torn))


def test_pages_get_coarse_colours_on_an_offset_and_earlier_pressures_in_single_precision():
    """Heights of 100 nm on 1 mm keep their shape: half a step of the range, and float32."""
    heights = 1e-3 + 1e-7 * np.linspace(0, 1, 500) ** 2
    pressure = 1e9 * np.linspace(0, 1, 500, dtype=np.float32)
    fields = shown({"heights": heights, "step.0.pressure": pressure})
    rounding = 2e-7 * 1e-3 / 2
    np.testing.assert_allclose(fields["heights"], heights, rtol=0, atol=1e-7 / 8192 + rounding)
    assert len(np.unique(fields["heights"])) > 300
    np.testing.assert_array_equal(fields["step.0.pressure"], pressure)
