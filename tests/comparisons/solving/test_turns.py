"""Compilation in turn: what one process compiles, the others wait for."""

import importlib
import sys
import threading

import pytest
from numba import config
from numba.core.dispatcher import Dispatcher

from comparisons.solving import execution as turns
from comparisons.solving.execution import compile_in_turn
from comparisons.solving.shared import alone

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
