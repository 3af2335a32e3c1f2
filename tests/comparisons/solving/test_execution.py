"""One task executed and archived: honest clock, contained failures, nothing lost on disk."""

import math
import warnings
from typing import ClassVar

import numpy as np
import psutil
import pytest

from comparisons.errors import ResultsError
from comparisons.files import write_arrays
from comparisons.methods.normal.closed_form import unit_rings
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.registry import SOLVERS, solver_for
from comparisons.methods.solver import Solver
from comparisons.scene.scene import load_scene
from comparisons.solving import execution, processes
from comparisons.solving.execution import execute
from comparisons.solving.jobs import Done, SerialExecutor
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks import solution as tasks_solution
from comparisons.tasks.solution import Solution, load_solution, save_solution
from comparisons.tasks.steps import Row, Step, solve_rows
from reference.errors import ConvergenceError

SCALARS = ("unknowns", "seconds", "setup_seconds", "compile_seconds", "memory")


@pytest.fixture
def task(scene):
    def make(method="reduced", resolution=10, **tables):
        return task_of(plan_scene(scene(**tables))[0], method, resolution)

    return make


@pytest.fixture
def replace(monkeypatch):
    """Put another solve in the place of a method's own, for this test."""

    def put(name, solve):
        class Replaced(type(solver_for(name, load_scene("paraboloid")))):
            def solve(self, task):
                return solve(super().solve, task)

            def warm_up(self, task):
                """Nothing to compile."""

        monkeypatch.setitem(SOLVERS, name, (Replaced,))

    return put


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (RuntimeError("the matrix is singular"), "RuntimeError: the matrix is singular (in fail)"),
        (ZeroDivisionError(), "ZeroDivisionError in fail"),
        (MemoryError("no room"), "MemoryError: no room (in fail)"),
        (
            ValueError(f"force, not {np.arange(40.0)!r}"),
            "ValueError: force, not array([0., ..., 39.] (40 numbers)) (in fail)",
        ),
    ],
)
def test_a_method_that_raises_costs_its_own_rows(task, replace, error, reason):
    def fail(solve, task):
        raise error

    replace("reduced", fail)
    solution = execute(task())
    assert solution.converged.shape == (1, 3)
    assert not solution.converged.any()
    assert set(solution.reasons) == {(0, 0), (0, 1), (0, 2)}
    assert set(solution.reasons.values()) == {reason}


def test_a_method_that_cannot_even_warm_up_costs_its_own_rows(task, monkeypatch):
    class Cold(ReducedProfile):
        def warm_up(self, task):
            raise OSError("no compiler")

    monkeypatch.setitem(SOLVERS, "reduced", (Cold,))
    monkeypatch.setattr(execution, "_compiled", {})
    assert "no compiler" in execute(task()).reasons[0, 0]


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (math.nan, "force came out as nan"),
        (math.inf, "force came out as inf"),
        (0.0, "force came out as 0.0 in a contact: below the smallest number (underflow)"),
    ],
)
def test_a_step_that_is_no_number_has_no_answer(task, replace, wrong, told):
    """Only that step, with all its quantities; a force of zero on a contact is underflow."""

    def spoil(solve, task):
        solution = solve(task)
        solution.quantities["force"][0, 1] = wrong
        return solution

    replace("reduced", spoil)
    solution = execute(task())
    assert solution.converged.tolist() == [[True, False, True]]
    assert solution.reasons == {(0, 1): told}
    assert np.isnan(solution.quantities["contact_area"]).tolist() == [[False, True, False]]


def test_quantities_of_the_wrong_shape_are_a_failure_of_the_method(task, replace):
    def spoil(solve, task):
        solution = solve(task)
        solution.quantities["force"] = np.ones((2, 3))
        return solution

    replace("reduced", spoil)
    solution = execute(task())
    assert not solution.converged.any()
    assert "force: expected 3 numbers, got an array of shape (2, 3)" in solution.reasons[0, 0]


def test_what_fails_beside_a_solve_is_no_load_without_an_answer(task):
    """A picture that fails is a defect to see; a solver that ends early loses the load it is at."""
    planned = task()
    solution = solve_rows(
        planned, [Row(lambda loads: iter([Step({"force": 1.0})] * (len(loads) - 1)))]
    )
    assert solution.converged.tolist() == [[True, True, False]]
    assert solution.reasons == {(0, 2): "the solver ended before this load"}

    def picture():
        raise ConvergenceError("picture failed", [])

    steps = [Step({"force": 1.0}), Step({"force": 2.0}), Step({"force": 3.0}, fields=picture)]
    with pytest.raises(ConvergenceError, match="picture failed"):
        solve_rows(planned, [Row(lambda loads: iter(steps))])


@pytest.mark.parametrize("in_a_class_body", [False, True])
def test_a_keyboard_interrupt_is_no_failure_of_the_method(task, replace, in_a_class_body):
    """Python up to 3.11 makes a RuntimeError of one that meets a `__set_name__`."""

    def stop(solve, task):
        if in_a_class_body:
            raise RuntimeError from KeyboardInterrupt()
        raise KeyboardInterrupt

    replace("reduced", stop)
    with pytest.raises(KeyboardInterrupt):
        execute(task())


@pytest.fixture
def clock(monkeypatch):
    class Clock:
        now = 0.0

        def perf_counter(self):
            return self.now

        def advance(self, seconds):
            self.now += seconds

    made = Clock()
    for module in (execution, tasks_solution):
        monkeypatch.setattr(module, "time", made)
    monkeypatch.setattr(execution, "_compiled", {})
    monkeypatch.setattr(execution, "REPEATS", 3)  # as outside the tests
    return made


def timed_solver(clock, durations):
    """Return a reduced model that takes a second to compile, and then these times."""
    pauses = iter(durations)

    class Timed(ReducedProfile):
        def warm_up(self, task):
            clock.advance(1.0)

        def solve(self, task):
            solution = super().solve(task)
            pause = next(pauses)
            with solution.setup():
                clock.advance(0.75 * pause)
            clock.advance(0.25 * pause)
            return solution

    return (Timed,)


def test_time_is_the_median_of_three_and_compilation_is_apart(task, monkeypatch, clock):
    monkeypatch.setitem(SOLVERS, "reduced", timed_solver(clock, [0.0625, 0.015625, 0.03125] * 2))
    solution = execute(task())
    assert solution.seconds == 0.03125
    assert solution.setup_seconds == 0.0234375
    assert solution.compile_seconds == 1.0
    assert execute(task()).compile_seconds == 0  # once per process


def test_the_first_solve_of_a_closed_form_finds_no_radii(task):
    """They take fifty times as long as the solve, and are found before the clock starts."""
    made = task("closed_form", 1, compare={"quantities": ["force", "pressure"]})
    solver = solver_for("closed_form", made.scene)
    unit_rings.cache_clear()
    solver.warm_up(made)
    before = unit_rings.cache_info()
    solver.solve(made)
    after = unit_rings.cache_info()
    assert after.hits > before.hits
    assert after.misses == before.misses


@pytest.mark.parametrize(("durations", "median"), [([2.0], 2.0), ([0.09375, 0.0625], 0.078125)])
def test_solves_are_repeated_for_a_tenth_of_a_second(task, monkeypatch, clock, durations, median):
    """A longer list would be a StopIteration here, that is, a failure."""
    monkeypatch.setitem(SOLVERS, "reduced", timed_solver(clock, durations))
    solution = execute(task())
    assert solution.converged.all()
    assert solution.seconds == median


def test_peak_memory_is_that_of_the_solve(task, replace):
    """64 MB taken and given back during the solve; 10 % for what the system rounds."""

    def greedy(solve, task):
        np.ones(2**23).sum()
        return solve(task)

    replace("reduced", greedy)
    memory = execute(task()).memory
    if math.isnan(memory):
        pytest.skip("the system does not say how much memory a process took at most")
    assert 2**26 * 0.9 < memory < 2**26 * 1.5


def test_fields_of_the_body_are_computed_after_the_clock(task, monkeypatch, clock):
    class Pictured(ReducedProfile):
        def solve(self, task):
            solution = super().solve(task)

            def body():
                clock.advance(10.0)
                return {"mesh_points": np.zeros((1, 3))}

            clock.advance(1.0)
            solution.body_fields = body
            return solution

    monkeypatch.setitem(SOLVERS, "reduced", (Pictured,))
    solution = execute(task())
    assert "mesh_points" in solution.fields
    assert solution.seconds == 1.0


def test_a_solution_comes_back_from_its_file(rough, tmp_path):
    (plan,) = plan_scene(rough(realisations=2, compare={"quantities": ["force", "pressure"]}))
    solution = execute(task_of(plan, "bem_fft", 16, (0, 1)))
    solution.fail((1, 0), "planted \u2013 reason")
    save_solution(tmp_path / "s.npz", solution)
    again = load_solution(tmp_path / "s.npz")
    assert set(again.quantities) == set(solution.quantities)
    for name, values in solution.quantities.items():
        np.testing.assert_array_equal(again.quantities[name], values)
    for name in ("converged", "iterations", "violation"):
        np.testing.assert_array_equal(getattr(again, name), getattr(solution, name))
    assert again.reasons == {(1, 0): "planted \u2013 reason"}
    for name in SCALARS:
        assert getattr(again, name) == getattr(solution, name)
    assert set(again.fields) == set(solution.fields)
    for name, values in solution.fields.items():
        np.testing.assert_array_equal(again.fields[name], values)


def test_unknown_numbers_come_back_as_unknown(task, tmp_path):
    solution = Solution.empty(task())
    solution.fail((0, 0), "lost")
    save_solution(tmp_path / "s.npz", solution)
    again = load_solution(tmp_path / "s.npz")
    assert math.isnan(again.seconds)
    assert math.isnan(again.memory)
    assert again.quantities == {}


@pytest.mark.parametrize(
    "arrays",
    [
        {"a": np.zeros(3)},
        {"solution.json": np.array("[]")},
        {"solution.json": np.array("{")},
        {"solution.json": np.array("{}")},
    ],
)
def test_files_that_hold_no_solution_are_refused(tmp_path, arrays):
    write_arrays(tmp_path / "s.npz", arrays)
    with pytest.raises(ResultsError, match="not the arrays of a solved task"):
        load_solution(tmp_path / "s.npz")


def test_blocks_join_in_order_with_their_times_added(rough):
    """One block of three against blocks of one and two: the same numbers, reasons moved along."""
    (plan,) = plan_scene(rough(realisations=3))
    together = execute(task_of(plan, "reduced", 64, (0, 1, 2)))
    parts = [execute(task_of(plan, "reduced", 64, block)) for block in ((0,), (1, 2))]
    parts[1].fail((1, 0), "planted")
    parts[0].memory, parts[1].memory = 3.0, 5.0
    whole = Solution.concat(parts, axis=0)
    for name, values in together.quantities.items():
        np.testing.assert_array_equal(whole.quantities[name], values)
    assert whole.reasons == {(2, 0): "planted"}
    assert whole.seconds == parts[0].seconds + parts[1].seconds
    assert whole.memory == 5.0
    np.testing.assert_array_equal(whole.fields["line_height"], together.fields["line_height"])


def test_a_lost_block_joins_as_lost(rough):
    (plan,) = plan_scene(rough(realisations=2))
    good = execute(task_of(plan, "reduced", 64, (0,)))
    without = Solution.lost(task_of(plan, "reduced", 64, (1,)), "no luck")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        whole = Solution.concat([good, without], axis=0)
    assert whole.converged.tolist() == [[True, True], [False, False]]
    assert np.isnan(whole.quantities["force"][1]).all()
    assert whole.reasons == {(1, 0): "no luck", (1, 1): "no luck"}


def test_a_method_says_what_it_must(task):
    """The contract that a new method overrides."""
    made = task()
    bare = Solver(made.scene)
    assert bare.resolutions(made.geometry) == (1,)  # nothing is discretised
    with pytest.raises(NotImplementedError):
        bare.steps(made, made.loads.values)
    assert bare.memory(made) == 0
    assert bare.refusal(made) == ""


@pytest.fixture
def cold(task, monkeypatch, tmp_path):
    """Return planned tasks of four kinds, none of which is marked as compiled."""
    made = [task(*setting) for setting in (("closed_form", 1), ("bem_fft", 16), ("bem_dense", 5))]
    kinds = [*made, task("reduced"), task("bem_fft", 32)]
    monkeypatch.setattr(execution, "_mark", lambda task: tmp_path / task.method)
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    return kinds


@pytest.mark.slow
def test_two_processes_compile_every_kind_once_and_are_gone_when_solves_begin(cold, tmp_path):
    """Nothing works beside the solves that are timed; a second run finds all done."""
    before = set(psutil.Process().children(recursive=True))
    done = list(execution.compile_ahead(cold))
    methods = sorted(outcome.job.kind.method for outcome in done)
    assert methods == ["bem_dense", "bem_fft", "closed_form", "reduced"]
    assert all(outcome.compile_seconds == outcome.seconds > 0 for outcome in done)
    (finest,) = (outcome.job for outcome in done if outcome.job.kind.method == "bem_fft")
    assert finest.kind.resolution == 16  # the first that a run solves
    after = set(psutil.Process().children(recursive=True)) - before
    assert not [process for process in after if "popen_loky" in " ".join(process.cmdline())]
    assert sorted(path.name for path in tmp_path.glob("*[!k]")) == methods
    assert list(execution.compile_ahead(cold)) == []


class Recording(SerialExecutor):
    """Keeps the keys of its jobs, and loses the last."""

    keys: ClassVar[list[str]] = []

    def __init__(self, workers):
        super().__init__()

    def finished(self):
        self.keys[:] = [job.kind.method for job in self._waiting]
        for job in list(self._waiting)[:-1]:
            yield Done(job, {}, 2.0)
        yield Done(self._waiting[-1], lost="killed")

    def end(self, *, idle=False):
        """End no process."""


def test_rough_lines_are_compiled_first_and_what_was_lost_is_left(cold, monkeypatch, tmp_path):
    monkeypatch.setattr(processes, "ProcessExecutor", Recording)
    assert len(list(execution.compile_ahead(cold))) == 3
    assert Recording.keys[0] == "reduced"
    assert not (tmp_path / Recording.keys[-1]).exists()


def test_where_no_process_can_be_started_each_kind_is_compiled_in_its_turn(cold, monkeypatch):
    def refused(workers):
        raise OSError("no semaphores")

    monkeypatch.setattr(processes, "ProcessExecutor", refused)
    assert list(execution.compile_ahead(cold)) == []


@pytest.mark.parametrize(("kinds", "cores"), [(3, 2), (5, 1)])
def test_a_small_run_or_a_single_core_has_no_second_process(cold, monkeypatch, kinds, cores):
    monkeypatch.setattr(processes, "ProcessExecutor", None)
    monkeypatch.setattr("os.cpu_count", lambda: cores)
    assert list(execution.compile_ahead(cold[:kinds])) == []


# Prints what Numba compiles or loads, of our own, after a warm-up: that of a coarser grid does.
AFTER_WARM_UP = """
from dataclasses import replace
from functools import partial
from numba.core.dispatcher import Dispatcher
from comparisons.methods.normal import proved
from comparisons.methods.registry import planned_solver
from comparisons.scene.scene import load_scene
from comparisons.solving.planning import plan_scene
from comparisons.tasks.task import Task

plan = plan_scene(load_scene({scene!r}, {changes!r}))[0]
late, compile_now = [], Dispatcher.compile
if {method!r} == "proof":
    warm_up = partial(proved.warm_up, plan.scene.rough, plan.geometry.periodic)
    run = partial(proved.enclosures, plan.scene, plan.geometry, plan.loads)
else:
    task = Task(plan.scene, plan.geometry, plan.loads, {method!r}, {resolution}, plan.compared)
    solver = planned_solver(task)
    warm_up = partial(solver.warm_up, replace(task, resolution={resolution} // 2))
    run = partial(solver.solve, task)

def watched(self, signature):
    late.append(self.py_func.__name__)
    return compile_now(self, signature)

warm_up()
Dispatcher.compile = watched
run()
print("late:", *late)
"""
ROUGH = {"surface.points": 128, "surface.realisations": 1}
FEW = {"surface.points": 8, "surface.realisations": 1, "surface.short_cutoff": "0.5 um"}
FEW |= {"loading": {"penetration": ["10 nm"]}}
PERIOD = FEW | {"surface.points": 16}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "changes", "method", "resolution"),
    [
        ("rough-periodic", ROUGH, "bem_fft", 128),
        ("rough-free", ROUGH, "bem_fft", 128),
        ("rough-periodic", ROUGH, "fem", 128),
        ("square-punch", {}, "proof", 64),
        ("rough-free", FEW, "proof", 8),
        ("rough-periodic", PERIOD, "proof", 16),
    ],
)
def test_no_timing_of_a_solve_or_a_proof_contains_a_compiler(
    python, scene, changes, method, resolution
):
    code = AFTER_WARM_UP.format(scene=scene, changes=changes, method=method, resolution=resolution)
    done = python("-c", code)
    assert done.stdout.split() == ["late:"], done.stderr
