"""What several jobs need is computed once, and compiled in turn."""

import errno
import importlib
import os
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from numba import config
from numba.core.dispatcher import Dispatcher

from comparisons.solving import execution as turns
from comparisons.solving.execution import compile_in_turn
from comparisons.solving.jobs import Job
from comparisons.solving.processes import ProcessExecutor
from comparisons.solving.shared import VARIABLE, _plain, alone, busy, folder, shared


@pytest.fixture
def counted(tmp_path, monkeypatch):
    """Return a shared function and the list of the arguments it was computed for."""
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    calls = []

    def square(number):
        calls.append(number)
        return number**2

    return shared(maxsize=4)(square), calls


def test_a_result_is_computed_once_and_read_by_a_process_that_has_not_got_it(counted):
    square, calls = counted
    assert [square(3), square(3)] == [9, 9]
    square.cache_clear()  # as another process, which has only the folder
    assert square(3) == 9
    assert calls == [3]


def test_without_a_folder_each_process_computes_its_own(counted, monkeypatch):
    square, calls = counted
    monkeypatch.delenv(VARIABLE)
    assert square(3) == 9
    square.cache_clear()
    assert square(3) == 9
    assert calls == [3, 3]


def test_numbers_that_are_equal_to_the_last_digit_are_one_result(counted):
    square, calls = counted
    close = 3.0 + 2**-51
    assert [square(close), square(3.0), square(0.3)] == [close**2, 9, 0.09]
    square.cache_clear()
    assert square(np.float64(0.3)) == 0.09
    assert calls == [close, 3.0, 0.3]
    assert _plain(np.float32(0.3)) != 0.3  # in single precision another one


def test_a_list_comes_in_its_order(counted):
    square, calls = counted
    assert square.over((n,) for n in (3, 1, 3, 2)) == [9, 1, 9, 4]
    assert sorted(calls) == [1, 2, 3]


def test_a_list_longer_than_the_memory_is_computed_once(monkeypatch):
    """Four results, of which two stay in memory, where there is no folder to read them from."""
    monkeypatch.delenv(VARIABLE, raising=False)
    calls = []
    known = shared(maxsize=2)(lambda number: calls.append(number) or number)
    assert known.over((n,) for n in (0, 1, 2, 3, 0)) == [0, 1, 2, 3, 0]
    assert calls == [0, 1, 2, 3]


def test_a_full_disk_loses_no_result(counted, monkeypatch, tmp_path):
    square, calls = counted

    def full(path, _):
        path.write_text("a part")
        raise OSError(errno.ENOSPC, "no space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        assert square(3) == 9
    assert [path.suffix for path in tmp_path.iterdir()] == [".lock"]
    square.cache_clear()
    assert square(3) == 9
    assert calls == [3, 3]


def test_a_disk_too_full_for_a_lock_loses_no_result(counted, monkeypatch):
    square, calls = counted

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "no space left on device")

    monkeypatch.setattr(Path, "open", full)
    assert square.over([(3,), (2,)]) == [9, 4]
    assert calls == [3, 2]


def test_where_the_system_has_no_locks_each_computes_its_own(counted, monkeypatch, tmp_path):
    """As on some network file systems."""
    fcntl = pytest.importorskip("fcntl")

    def no_locks(*_):
        raise OSError(errno.ENOLCK, "no locks available")

    monkeypatch.setattr(fcntl, "flock", no_locks)
    assert not busy(tmp_path / "any.lock")
    assert counted[0].over([(3,)]) == [9]


@pytest.mark.slow
def test_two_processes_share_the_work_on_a_list(tmp_path):
    """Both ask for the same ten results: each is computed by one of them, and both have part."""

    def both(numbers):  # a process that is started has the packages, not this module
        from comparisons.solving.shared import shared

        def work_on(number, path):
            """Compute slowly, and leave a trace of who did it."""
            time.sleep(0.2)
            with (path / f"{number}").open("a") as trace:
                trace.write(f"{os.getpid()}\n")
            return number**2

        known = shared(maxsize=16)(work_on)
        return known.over((n, tmp_path) for n in numbers)

    executor = ProcessExecutor(2)
    executor.add([Job(str(k), both, (range(10),)) for k in range(2)])
    results = list(executor.finished())
    assert [done.lost for done in results] == ["", ""]
    answers = [done.value for done in results]
    assert answers == [[n**2 for n in range(10)]] * 2
    workers = [(tmp_path / str(n)).read_text().split() for n in range(10)]
    assert all(len(who) == 1 for who in workers)
    assert len({who for (who,) in workers}) == 2


@pytest.mark.usefixtures("counted")
def test_an_exception_is_no_result():
    tries = []

    def fails(number):
        tries.append(number)
        if len(tries) == 1:
            raise ArithmeticError
        return number

    known = shared()(fails)
    with pytest.raises(ArithmeticError):
        known(1)
    assert known(1) == 1


@pytest.mark.usefixtures("counted")
@pytest.mark.parametrize(
    "result",
    [
        0.1 + 0.2,
        float("inf"),
        (1, "a", None, True),
        {("free", 2): np.arange(3.0), "b": [np.ones((2, 2), bool), (0.1,)]},
    ],
)
def test_plain_results_come_back_digit_for_digit(result):
    known = shared()(lambda: result)
    known()
    known.cache_clear()
    again = known()
    assert type(again) is type(result)
    np.testing.assert_equal(again, result)


def test_the_folder_is_there_and_only_ours():
    assert os.stat(folder()).st_mode & 0o077 == 0


SOURCE = """
from numba import njit

@njit(cache=True)
def fall(n):
    return n if n <= 0 else fall(n - 1)
"""


@pytest.fixture
def fall(tmp_path, monkeypatch):
    """Return a function that calls itself, compiled in turn, with the folder of the locks."""
    monkeypatch.setattr(Dispatcher, "compile", Dispatcher.compile)
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "code"))
    locks = tmp_path / "locks"
    locks.mkdir()
    compile_in_turn(locks)
    source = tmp_path / "falling.py"
    source.write_text(SOURCE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "falling", raising=False)
    return importlib.import_module("falling").fall, locks


def test_a_function_waits_until_no_other_process_compiles_it(fall):
    """A lock that is opened anew keeps others out also within one process."""
    function, locks = fall
    assert function(3) == 0
    (lock,) = locks.iterdir()
    answers = []
    with alone(lock):
        thread = threading.Thread(target=lambda: answers.append(function(2.5)))
        thread.start()
        thread.join(0.2)
        assert not answers
    thread.join(60)
    assert answers == [-0.5]
    assert len(function.signatures) == 2


def test_a_process_that_is_stopped_while_it_compiles_is_not_waited_for_without_end(
    fall, monkeypatch
):
    """Its lock is held on; the function is compiled beside it."""
    function, locks = fall
    assert function(3) == 0
    (lock,) = locks.iterdir()
    monkeypatch.setattr(turns, "_PATIENCE", 0.1)
    with alone(lock):
        assert function(2.5) == -0.5


def test_without_a_folder_for_locks_functions_are_compiled_all_the_same(fall):
    function, locks = fall
    locks.rmdir()
    assert function(3) == 0
