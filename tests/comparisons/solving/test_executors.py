"""Who does the work changes nothing: lost processes, memory, order, threads.

Functions inside tests travel to the processes by value, so these need not import the tests.
"""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from itertools import combinations

import psutil
import pytest
from joblib.externals.loky import process_executor

from comparisons.solving import processes
from comparisons.solving.jobs import Job, JobKind, SerialExecutor, executor_for
from comparisons.solving.processes import ProcessExecutor

GB = 1e9


def collected(executor, jobs):
    executor.add(jobs)
    return {done.job.key: done for done in executor.finished()}


def interval():
    def work(seconds):
        start = time.time()
        time.sleep(seconds)
        return start, time.time()

    return work


def test_a_second_process_compiles_another_method_meanwhile():
    """Of a method that is used for the first time, one job at a time; then in the usual order."""
    executor = ProcessExecutor(2)
    first, *others = (Job(f"{m}{k}", pow, kind=JobKind(method=m)) for m in "ab" for k in range(2))
    executor._running[Future()] = first
    executor._waiting.extend(others)
    assert executor._next(GB).key == "b0"
    executor._used.add("a")
    executor._from_the_end = False
    assert executor._next(GB).key == "a1"
    executor._used.clear()
    assert executor._next(GB).key == "b1"  # nothing else is left


def overlap(one, other):
    return one[0] < other[1] and other[0] < one[1]


@pytest.mark.slow
@pytest.mark.parametrize("make", [SerialExecutor, lambda: ProcessExecutor(2)])
def test_jobs_may_come_while_others_finish(make):
    """As the refinement of one scene comes while the solves of others go on."""
    executor = make()
    executor.add([Job("0", pow, (2, 0))])
    values = []
    for done in executor.finished():
        values.append(done.value)
        if len(values) < 5:
            executor.add([Job(str(len(values)), pow, (2, len(values)))])
    assert values == [1, 2, 4, 8, 16]


def test_loky_still_has_the_limit_that_is_set():
    """A private name: without it processes would be replaced again for 0.3 GB that they keep."""
    assert isinstance(process_executor._MAX_MEMORY_LEAK_SIZE, int)


def test_work_begins_when_it_is_given(tmp_path):
    """Not only when somebody asks for what is finished: planning the rest takes seconds."""
    begun = tmp_path / "begun"
    executor = ProcessExecutor(2)
    executor.add([Job("begun", begun.touch)])
    deadline = time.time() + 60
    while not begun.exists() and time.time() < deadline:
        time.sleep(0.02)
    assert begun.exists()
    assert [done.job.key for done in executor.finished()] == ["begun"]


def test_half_of_the_jobs_are_the_last_ones(monkeypatch):
    """Neighbours share compiled code: two processes do not begin with the same."""
    executor = ProcessExecutor(2)
    given = []

    class Pool:
        def submit(self, timed, work, arguments):
            given.append(arguments[0])
            return Future()

    monkeypatch.setattr(processes, "_processes", lambda workers: Pool())
    executor.add(Job(str(k), pow, (k, 2)) for k in range(9))
    assert given == [0, 8, 1, 7]


@pytest.mark.slow
def test_a_killed_process_is_tried_again(tmp_path):
    """SIGKILL twice, an answer the third time; beside it others that are hit by the lost pool."""

    def work():
        tried = len(list(tmp_path.iterdir()))
        if tried < 2:
            (tmp_path / str(tried)).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return tried

    jobs = [Job("killed", work), *(Job(str(k), pow, (k, 1)) for k in range(9))]
    collection = collected(ProcessExecutor(2), jobs)
    assert collection["killed"].value == 2
    assert [collection[str(k)].value for k in range(9)] == list(range(9))
    assert not any(done.lost for done in collection.values())


@pytest.mark.slow
def test_who_is_killed_every_time_is_lost_and_the_others_are_not(tmp_path):
    """Two culprits: slow jobs that share a pool with them again and again must not be lost."""
    culprits = [Job(f"culprit {k}", signal.raise_signal, (signal.SIGKILL,)) for k in range(2)]
    slow = [Job(str(k), time.sleep, (0.3,)) for k in range(4)]
    collection = collected(
        ProcessExecutor(2), [slow[0], culprits[0], *slow[1:3], culprits[1], slow[3]]
    )
    for culprit in culprits:
        reason = collection[culprit.key].lost
        assert reason.startswith("its process was killed 3 times (SIGKILL)")
        assert "lack of memory" in reason
    assert not any(collection[str(k)].lost for k in range(4))


@pytest.mark.slow
def test_an_exception_of_the_work_is_raised_and_the_next_run_works():
    executor = ProcessExecutor(2)
    executor.add([Job("wrong", divmod, (1, 0)), Job("right", pow, (2, 2))])
    with pytest.raises(ZeroDivisionError):
        list(executor.finished())
    assert collected(ProcessExecutor(2), [Job("again", pow, (3, 2))])["again"].value == 9


@pytest.mark.slow
def test_what_does_not_fit_side_by_side_runs_one_after_the_other(tmp_path):
    """Three jobs of 6 GB where 10 may be handed out; small ones pass beside a large one."""

    def large(name):  # goes on when a small one has passed
        start = time.time()
        while not (tmp_path / "passed").exists() and time.time() < start + 60:
            time.sleep(0.02)
        return start, time.time(), (tmp_path / "passed").exists()

    def small(name):
        (tmp_path / "passed").touch()

    jobs = [
        *(Job(f"large {k}", large, (k,), 6 * GB) for k in range(3)),
        *(Job(f"small {k}", small, (k,), 0.1 * GB) for k in range(3)),
    ]
    collection = collected(ProcessExecutor(2, memory=10 * GB), jobs)
    times = [collection[f"large {k}"].value for k in range(3)]
    assert not any(overlap(one, other) for one, other in combinations(times, 2))
    assert all(passed for *_, passed in times)


def test_what_is_larger_than_the_machine_runs_alone():
    """The estimate may be wrong; if it is right, the job is killed alone and nobody with it."""
    jobs = [Job("a", interval(), (0.2,), 0.1 * GB), Job("huge", interval(), (0.2,), 99 * GB)]
    jobs.append(Job("b", interval(), (0.2,), 0.1 * GB))
    collection = collected(ProcessExecutor(2, memory=10 * GB), jobs)
    times = {key: done.value for key, done in collection.items()}
    assert not any(overlap(times["huge"], times[key]) for key in ("a", "b"))


def test_processes_have_one_thread_each():
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
    collection = collected(ProcessExecutor(2), [Job(name, os.getenv, (name,)) for name in names])
    assert {done.value for done in collection.values()} == {"1"}


@pytest.mark.slow
def test_processes_end_when_the_work_is_left_in_the_middle():
    """An interrupt must not leave processes that burn on."""
    executor = ProcessExecutor(2)
    executor.add([Job("quick", os.getpid), Job("a", time.sleep, (60,)), Job("b", os.getpid)])
    work = executor.finished()
    pid = next(work).value
    work.close()
    deadline = time.time() + 10
    while psutil.pid_exists(pid) and time.time() < deadline:
        time.sleep(0.05)
    assert not psutil.pid_exists(pid)


def test_processes_clear_up_for_one_that_was_killed(tmp_path, monkeypatch):
    """Its folder of shared results goes; it can do so no more itself."""
    common = tmp_path / "shared"
    common.mkdir()
    (common / "result").touch()
    ended = []
    monkeypatch.setattr(os, "_exit", ended.append)
    processes._follow(os.getppid() + 1, str(common))
    assert ended == [1]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")
def test_an_interrupt_right_after_work_was_given_leaves_no_error_behind(monkeypatch):
    """Processes wait for work here, and the thread that hands it to them has not looked yet."""
    collected(ProcessExecutor(2), [Job("first", pow, (2, 2))])

    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(processes, "wait", interrupted)
    executor = ProcessExecutor(2)
    executor.add(Job(str(k), pow, (k, 2)) for k in range(2))
    with pytest.raises(KeyboardInterrupt):
        list(executor.finished())


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no masks of signals")
def test_control_c_in_a_terminal_ends_nothing_but_the_process_that_hands_out_the_work():
    """Others would answer with tracebacks of their own; they end with it.

    In a fresh interpreter: multiprocessing's tracker of resources, which lifts the mask where it
    starts, may run here already.
    """
    program = """
import signal
from comparisons.solving.jobs import Job
from comparisons.solving.processes import ProcessExecutor
executor = ProcessExecutor(2)
executor.add([Job("pressed", signal.raise_signal, (signal.SIGINT,))])
print([done.lost for done in executor.finished()])
print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ()))
"""
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert told.stdout.split() == ["['']", "False"], told.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.usefixtures("interruptible")
def test_a_job_that_is_handed_over_when_a_ctrl_c_comes_is_known_to_be_under_way(monkeypatch):
    """Else nobody would end it."""

    class Pool:
        def submit(self, *_):
            signal.raise_signal(signal.SIGINT)
            return Future()

    executor, job = ProcessExecutor(1), Job("one", pow)
    monkeypatch.setattr(processes, "_processes", lambda workers: Pool())
    with pytest.raises(KeyboardInterrupt):
        executor.add([job])
    assert list(executor._running.values()) == [job]


def test_one_worker_needs_no_other_process():
    assert isinstance(executor_for(1), SerialExecutor)
    assert executor_for(3).workers == 3
