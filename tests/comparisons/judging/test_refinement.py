"""Full effort: the truth is refined until it is known well enough, or it is said why not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import psutil
import pytest

from comparisons.facts.methods import growth
from comparisons.judging.refinement import BUDGET, refinements
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solution

SQUARE = {"shape": "square_punch", "side": 1e-3}


def refined(plan, solved, solve, budget=BUDGET):
    """Return the plan with all refinements, each solved as it is asked for."""
    steps = refinements(plan, solved, budget)
    while True:
        try:
            solve(next(steps))
        except StopIteration as end:
            return end.value


@pytest.fixture
def refine(scene):
    """Refine a plan whose FFT solver has an error of C/N in force, at a cost of N^2 seconds."""

    def run(
        *, error=1.0, tolerance=0.05, seconds=1e-6, lost_from=10**9, budget=BUDGET, listed=None
    ):
        compared = {"tolerance": tolerance, "methods": ["bem_fft"]} | (listed or {})
        (plan,) = plan_scene(scene(indenter=SQUARE, compare=compared))
        start = (8, 16)
        chosen = [
            replace(m, resolutions=start) if m.method == "bem_fft" else m for m in plan.methods
        ]
        plan = replace(plan, methods=tuple(chosen))
        store = {}

        def solve(item):
            for method in item.methods:
                for n in method.resolutions:
                    store.setdefault((method.method, n), solution(item, n))

        def solution(item, n):
            depth = item.loads.values[None, :]
            result = Solution.empty(task_of(plan, "bem_fft", n))
            result.seconds = seconds * n**2
            if n < lost_from:
                result.quantities = {"penetration": depth, "force": depth * (1 + error / n)}
                result.converged[:] = True
                result.violation[:] = 0.0
            return result

        solve(plan)
        done = refined(plan, lambda _: dict(store), solve, budget)
        (planned,) = [item for item in done.methods if item.method == "bem_fft"]
        return planned.resolutions, done.notes

    return run


def test_the_truth_is_refined_until_its_bar_is_a_fifth_of_the_tolerance(refine):
    """Error 1/N at first order of a punch with corners: the bar is 1.25/N (3/N on two grids).

    Wanted is 0.05/5 = 1/100: N = 16 has 3/16, N = 32 has 1.25/32, N = 64 1.25/64, and N = 128 the
    first below a hundredth.
    """
    resolutions, notes = refine()
    assert resolutions == (8, 16, 32, 64, 128)
    assert notes == ()


def test_a_truth_that_is_known_well_enough_is_left_as_it_is(refine):
    assert refine(error=1e-4) == ((8, 16), ())
    assert refine(tolerance=0.5) == ((8, 16, 32), ())  # 2/17 on two grids, wanted 0.1


def test_what_ends_a_refinement_is_named(refine, monkeypatch):
    resolutions, (note,) = refine(tolerance=1e-4, seconds=0.5)
    # 0.5 s N^2 and 4.7 times that for the next: at N = 16 already 602 s.
    assert resolutions == (8, 16)
    assert "ends at N = 16, the next would take about 602 s, more than the budget" in note
    resolutions, (note,) = refine(tolerance=1e-4, lost_from=64)
    assert resolutions == (8, 16, 32, 64)
    assert "bem_fft found no answer at N = 64" in note
    memory = SimpleNamespace(available=2.5e8, total=2.5e8)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: memory)
    resolutions, (note,) = refine(tolerance=1e-6)
    assert resolutions[-1] < 1024
    assert f"ends at N = {resolutions[-1]}, needs about" in note


def test_growth_of_work_is_that_of_the_method(refine):
    """With a budget just above 4.7 times the last solve it goes on, just below it ends."""
    last = growth("bem_fft") * 16**2
    assert refine(tolerance=1e-3, seconds=1.0, budget=1.01 * last)[0] == (8, 16, 32)
    assert refine(tolerance=1e-3, seconds=1.0, budget=0.99 * last)[0] == (8, 16)


def test_a_scene_with_a_closed_form_needs_no_refinement(scene):
    (plan,) = plan_scene(scene(compare={"methods": ["closed_form"]}))
    exact = Solution.empty(task_of(plan, "closed_form", 1))
    exact.quantities = {"force": np.ones((1, 3)), "penetration": plan.loads.values[None, :]}
    exact.converged[:] = True
    never = pytest.fail
    assert refined(plan, lambda _: {("closed_form", 1): exact}, never) is plan
    assert refined(plan, lambda _: {}, never) is plan


def test_listed_resolutions_are_not_refined_beyond(refine):
    resolutions, (note,) = refine(listed={"resolutions": [8, 16]})
    assert resolutions == (8, 16)
    assert "the resolutions that the scene lists" in note


def test_a_second_candidate_follows_the_truth_on_one_rough_surface(rough):
    """Both are asked for every finer grid, elements up to 512 points a side, to be compared."""
    methods = {"methods": ["bem_fft", "fem"], "tolerance": 1e-4}
    (plan,) = plan_scene(rough(points=64, short_cutoff=None, compare=methods))
    store = {}

    def solve(item):
        for task in item.tasks:
            result = Solution.empty(task)
            error = 1 + (1 if task.method == "bem_fft" else 2) / task.resolution
            result.quantities = {name: np.full((1, 2), error) for name in plan.compared}
            result.quantities["force"] = plan.loads.values[None, :]
            result.converged[:], result.seconds = True, 1e-3
            store[task.method, task.resolution] = result

    solve(plan)
    done = refined(plan, lambda _: dict(store), solve)
    grids = {item.method: item.resolutions for item in done.methods if item.supported}
    assert grids["fem"] == (64, 128, 256, 512)
    assert grids["bem_fft"][:4] == (64, 128, 256, 512)
    assert len(grids["bem_fft"]) > 4
