"""Tests run on one thread, as solves do: small matrices are slower on two, and noisy.

The whole suite is shared among the cores, a process on each; what is picked out runs in one.
"""

import os

import pytest
from _pytest.doctest import DoctestModule
from hypothesis import settings

# Sphinx's, and scripts that tests/test_tutorials.py runs as a whole: nothing to import here.
collect_ignore = [f"docs/{name}" for name in ("conf.py", "site", "tutorials", "gallery", "_build")]

# Before NumPy is imported, and inherited by the programs that tests start.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# No deadline: the first example of a test may have to compile. The same examples in every run, so
# that a change is to blame for what it breaks; `.ci/nightly` takes 100 of them, and
# `pytest --hypothesis-profile=search` looks further.
settings.register_profile("roughline", deadline=None, derandomize=True, max_examples=40)
settings.register_profile("nightly", settings.get_profile("roughline"), max_examples=100)
settings.register_profile("search", deadline=None, max_examples=1000)
settings.load_profile("roughline")

MOST_WORKERS = 8  # each collects all tests and may hold a gigabyte


def pytest_xdist_auto_num_workers(config) -> int:
    """Return 0, which is no worker, for tests that somebody picks out to look at them.

    Starting workers takes longer than most single tests, and hides what is printed.
    """
    option = config.option
    named = config.args_source is config.ArgsSource.ARGS
    if named or option.keyword or option.capture == "no" or getattr(option, "lf", False):
        return 0
    free = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return min(free, MOST_WORKERS) if free and free > 1 else 0


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path):
    """Look for examples only where there are some: each worker would import all modules first."""
    collectors = yield
    if ">>>" in file_path.read_text(encoding="utf-8", errors="ignore"):
        return collectors
    return [kind for kind in collectors if not isinstance(kind, DoctestModule)]


def pytest_configure(config) -> None:
    """Let workers share one cache of compiled code."""
    if hasattr(config, "workerinput") and os.name == "posix":
        _save_compiled_code_in_turn()


def _save_compiled_code_in_turn() -> None:
    """Lock the index of Numba's cache while code is added to it.

    Numba numbers the files of a function by what its index holds: of two processes that save two
    types of arguments at once, one would later run the code of the other.
    """
    import fcntl

    from numba.core.caching import IndexDataCacheFile

    save = IndexDataCacheFile.save

    def save_alone(self, key, data):
        with open(self._index_path + ".lock", "wb") as stream:
            fcntl.flock(stream, fcntl.LOCK_EX)
            save(self, key, data)

    IndexDataCacheFile.save = save_alone
