"""Work in its own process: every way it can end, and that nothing of it stays behind."""

import os
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np
import psutil
import pytest

from comparisons.isolation import child, parent

# Functions that only the isolated process imports.
WORK = """
import os, signal, subprocess, sys, time
import numpy as np

def echo(*values):
    print("standard output is nobody's")
    return {str(k): value for k, value in enumerate(values)}

def threads():
    from threadpoolctl import threadpool_info
    np.ones((64, 64)) @ np.ones((64, 64))
    return {"threads": max(pool["num_threads"] for pool in threadpool_info())}

def raises():
    raise ArithmeticError("stalled at 1e-3")

def eats(size):
    kept = []
    while True:
        kept.append(np.ones(size // 8))
        time.sleep(0.01)

def allocates(size):
    return {"a": np.ones(size // 8)}

def objects():
    return {"a": np.array([object()])}

def writes(name):
    open(name, "w").close()
    return {"files": os.listdir(), "folder": os.getcwd()}

def leaves(path):
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    with open(path, "w") as file:
        file.write(str(child.pid))
    time.sleep(600)

def detaches(path):
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            with open(path + ".part", "w") as file:
                file.write(str(os.getpid()))
            os.replace(path + ".part", path)
            time.sleep(600)
        os._exit(0)
    while not os.path.exists(path):
        time.sleep(0.01)
    return {"answer": 1}

def interrupts(path):
    with open(path, "w") as file:
        file.write(str(os.getpid()))
    os.kill(os.getppid(), signal.SIGINT)
    for k in range(10**9):
        open(os.path.join(sys.argv[1], str(k % 10**4)), "w").close()

counted = []

def counts():
    counted.append(1)
    return {"calls": len(counted), "pid": os.getpid()}

def holds(size):
    counted.append(np.ones(size // 8))
    time.sleep(0.2)
    return {"calls": len(counted), "pid": os.getpid()}

def dies():
    print("lost the licence", file=sys.stderr)
    os.abort()
"""


@pytest.fixture
def strange(tmp_path, monkeypatch):
    """Write the functions where the isolated process, and nobody else, imports them."""
    (tmp_path / "strange_work.py").write_text(WORK)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    return "strange_work:"


def gone(pid: int, within: float = 5.0) -> bool:
    """Whether a process ends soon; a zombie that nobody has waited for is gone, too."""
    deadline = time.monotonic() + within
    while True:
        try:
            if psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
        except psutil.NoSuchProcess:
            return True
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)


def test_arrays_and_numbers_return_bit_for_bit(strange):
    field = np.linspace(0, 1, 12).reshape(3, 4) / 3
    contact = field > 0.1
    outcome = parent.run(strange + "echo", field, contact, 1 / 3, "text", [1, None], seconds=60)
    assert outcome.ok, outcome.reason
    assert outcome.reason == ""
    assert outcome.answer["0"].tobytes() == field.tobytes()
    assert (outcome.answer["1"] == contact).all()
    assert [outcome.answer[k] for k in "234"] == [1 / 3, "text", [1, None]]


def test_work_has_one_thread(strange):
    assert parent.run(strange + "threads", seconds=60).answer == {"threads": 1}


@pytest.mark.parametrize(
    ("work", "arguments", "limits", "ended", "words"),
    [
        ("raises", (), {}, child.RAISED, "ArithmeticError: stalled at 1e-3"),
        ("nowhere", (), {}, child.RAISED, "nowhere"),
        ("dies", (), {}, parent.KILLED, "SIGABRT: lost the licence"),
        ("eats", (10**7,), {"memory": 4e8}, parent.OUT_OF_MEMORY, "more memory than 0.4 GB"),
        ("allocates", (10**13,), {"memory": 4e8}, parent.OUT_OF_MEMORY, "allocation"),
        ("objects", (), {}, parent.MALFORMED, "arrays of objects: a"),
        ("echo", (np.array([1.0, np.nan]),), {}, parent.MALFORMED, "not finite: 0"),
        ("echo", (1.0, [2.0, {"a": float("inf")}]), {}, parent.MALFORMED, "not finite: 1"),
        ("builtins:int", (), {}, parent.MALFORMED, "expected a dict"),
        ("os:_exit", (0,), {}, parent.MALFORMED, "without an answer"),
        ("os:_exit", (7,), {}, parent.KILLED, "exit code 7"),
        ("sys:exit", (3,), {}, parent.KILLED, "exit code 3"),
    ],
)
def test_every_failure_has_its_reason(strange, work, arguments, limits, ended, words):
    name = work if ":" in work else strange + work
    outcome = parent.run(name, *arguments, **({"seconds": 60} | limits))
    assert outcome.ended == ended, outcome
    assert words in outcome.reason
    assert outcome.answer == {}
    assert not outcome.ok


def test_nan_passes_where_the_caller_expects_it(strange):
    value = np.array([1.0, np.nan])
    outcome = parent.run(strange + "echo", value, seconds=60, finite=False)
    np.testing.assert_array_equal(outcome.answer["0"], value)


@pytest.mark.slow
def test_hung_work_and_its_children_are_ended_at_the_limit(strange, tmp_path):
    note = tmp_path / "pid"
    outcome = parent.run(strange + "leaves", str(note), seconds=3)
    assert outcome.ended == parent.HUNG
    assert "within 3 s" in outcome.reason
    # One look and a farewell beyond the limit, with room for a busy machine.
    assert outcome.seconds < 3 + 5
    assert gone(int(note.read_text()))


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork")
def test_what_detached_itself_does_not_outlive_its_work(strange, tmp_path):
    """Forked twice, in a session of its own: nobody's child, in nobody's group."""
    note = tmp_path / "pid"
    assert parent.run(strange + "detaches", str(note), seconds=30).ok
    assert gone(int(note.read_text()))


@pytest.mark.slow
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL, signal.SIGTERM])
def test_no_orphan_when_the_caller_is_interrupted_or_killed(tmp_path, how):
    (tmp_path / "sleeper.py").write_text(
        "import os, time\n"
        "def sleep(path):\n"
        "    open(path + '.part', 'w').write(str(os.getpid()))\n"
        "    os.replace(path + '.part', path)\n"
        "    time.sleep(600)\n"
    )
    note = tmp_path / "pid"
    program = f"from comparisons.isolation.parent import run; run('sleeper:sleep', {str(note)!r})"
    paths = os.pathsep.join([str(tmp_path), *(p for p in sys.path if p)])
    caller = subprocess.Popen(
        [sys.executable, "-c", program],
        env=os.environ | {"PYTHONPATH": paths},
        stderr=subprocess.DEVNULL,
    )
    try:
        deadline = time.monotonic() + 30
        while not note.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        caller.send_signal(how)
        caller.wait(10)
        assert gone(int(note.read_text()))
    finally:
        caller.kill()


@pytest.mark.usefixtures("interruptible")
def test_a_process_that_interrupts_us_ends_before_its_folder_goes(strange, tmp_path, monkeypatch):
    """It writes there all the time, and the next ctrl-C comes while it is being ended."""
    kill, held = os.killpg, tmp_path / "temporary"
    held.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(held))

    def interrupted_kill(group, how):
        os.kill(os.getpid(), signal.SIGINT)
        kill(group, how)

    monkeypatch.setattr(os, "killpg", interrupted_kill)
    note = tmp_path / "pid"
    with pytest.raises(KeyboardInterrupt):
        parent.run(strange + "interrupts", str(note), seconds=60)
    assert gone(int(note.read_text()), within=0)
    assert list(held.iterdir()) == []


@pytest.fixture
def called(strange):
    """Return a caller of one kept process, which ends with the test."""
    yield lambda work, *arguments, **limits: parent.run(
        strange + work, *arguments, **({"seconds": 60, "reuse": "test"} | limits)
    )
    parent._end_waiting()


@pytest.mark.slow
def test_a_kept_process_answers_again_and_ends_when_told(called):
    """Python and the packages are started once, not for every resolution."""
    first, second = called("counts").answer, called("counts").answer
    assert (first["calls"], second["calls"]) == (1, 2)
    assert first["pid"] == second["pid"]
    assert called("counts", reuse="").answer["calls"] == 1
    parent._end_waiting()
    assert gone(first["pid"], within=0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("work", "ended"),
    [("raises", child.RAISED), ("dies", parent.KILLED), ("objects", parent.MALFORMED)],
)
def test_a_process_that_has_failed_is_not_asked_again(called, work, ended):
    before = called("counts").answer["pid"]
    assert called(work).ended == ended
    assert gone(before, within=0)
    assert called("counts").answer["calls"] == 1


@pytest.mark.slow
def test_memory_that_earlier_calls_hold_is_not_held_against_a_later_one(called):
    """Twice 0.35 GB under a limit of 0.6 GB: the second has a process of its own."""
    answers = [called("holds", 350_000_000, memory=6e8).answer for _ in range(2)]
    assert [answer["calls"] for answer in answers] == [1, 1]
    assert answers[0]["pid"] != answers[1]["pid"]


def test_wrong_calls_are_refused_at_once():
    with pytest.raises(ValueError, match=r"module:function.*seconds.*-1"):
        parent.run("no function", seconds=-1)


def test_work_starts_in_an_empty_folder_of_its_own(strange, tmp_path, monkeypatch):
    """What it writes by a bare name does not land among the caller's files, and goes with it."""
    (tmp_path / "caller").mkdir()
    monkeypatch.chdir(tmp_path / "caller")
    answer = parent.run(strange + "writes", "left.txt", seconds=60).answer
    assert answer["files"] == ["left.txt"]
    assert os.listdir() == []
    assert not os.path.exists(answer["folder"])
