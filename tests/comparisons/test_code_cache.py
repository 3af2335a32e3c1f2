"""Compiled code has a place, also in a package that nobody may write to and without a home."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from comparisons import code_cache

pytestmark = pytest.mark.skipif(os.name != "posix", reason="owners and permissions of POSIX")

SOURCE = """
import comparisons
from numba import njit

@njit(cache=True)
def twice(x):
    return 2 * x

print(twice(21), twice.stats.cache_path)
"""


def test_code_is_cached_for_an_installed_package_and_a_user_without_a_home(tmp_path):
    """Numba alone refuses to define the function: "no locator available".

    A file in place of a folder cannot be written into by root either.
    """
    for package in code_cache.COMPILED:
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").write_text("")
        (tmp_path / package / "__pycache__").write_text("")
    (tmp_path / "reduced" / "double.py").write_text(SOURCE)
    own = Path(code_cache.__file__).parent
    (tmp_path / "comparisons").mkdir()
    for name in ("__init__.py", "code_cache.py"):
        shutil.copy(own / name, tmp_path / "comparisons")
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    paths = [str(tmp_path), *(path for path in sys.path if path)]
    homeless = {"HOME": os.devnull, "TMPDIR": str(temporary), "PYTHONPATH": os.pathsep.join(paths)}
    settled = (code_cache.VARIABLE, "XDG_CACHE_HOME")
    kept = {name: value for name, value in os.environ.items() if name not in settled}
    done = subprocess.run(
        [sys.executable, "-m", "reduced.double"],
        cwd=tmp_path,
        env=kept | homeless,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    folder = temporary / f"roughline-{os.getuid()}"
    answer, place = done.stdout.split()
    assert (answer, Path(place).parent) == ("42", folder)
    assert list(Path(place).glob("*.nbi"))
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.fixture
def homeless(tmp_path, monkeypatch):
    """Stand where only the temporary folder can be written to."""
    monkeypatch.setattr(code_cache, "_may_write", lambda folder: False)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.delenv(code_cache.VARIABLE, raising=False)
    numba = sys.modules.get("numba")
    if numba is not None:
        monkeypatch.setattr(numba.config, "CACHE_DIR", numba.config.CACHE_DIR)
    yield tmp_path / f"roughline-{os.getuid()}"
    os.environ.pop(code_cache.VARIABLE, None)


def chosen() -> Path:
    code_cache.choose_folder()
    return Path(os.environ[code_cache.VARIABLE])


def test_the_next_process_finds_what_the_first_has_compiled(homeless):
    first = chosen()
    del os.environ[code_cache.VARIABLE]
    assert first == chosen() == homeless


@pytest.mark.parametrize("trap", ["link", "writable by others", "file"])
def test_code_is_never_read_from_a_folder_that_others_may_write_to(homeless, trap, tmp_path):
    """Everybody may put something of that name into the temporary folder, and wait."""
    theirs = tmp_path / "theirs"
    theirs.mkdir()
    if trap == "link":
        homeless.symlink_to(theirs)
    elif trap == "file":
        homeless.write_text("")
    else:
        homeless.mkdir()
        homeless.chmod(0o777)
    folder = chosen()
    assert folder not in (homeless, theirs)
    assert stat.S_IMODE(folder.lstat().st_mode) == 0o700


def test_a_folder_of_the_users_own_choice_is_left_alone(monkeypatch, tmp_path):
    monkeypatch.setattr(code_cache, "_beside_the_sources", lambda: False)
    monkeypatch.setenv("HOME", os.devnull)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv(code_cache.VARIABLE, str(tmp_path / "mine"))
    assert chosen() == tmp_path / "mine"


def test_where_numba_has_a_place_nothing_is_set(monkeypatch, tmp_path):
    """Other libraries' compiled code would move as well."""
    monkeypatch.delenv(code_cache.VARIABLE, raising=False)
    monkeypatch.setattr(code_cache, "_beside_the_sources", lambda: False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "not-made-yet"))
    code_cache.choose_folder()
    assert code_cache.VARIABLE not in os.environ


def test_compiled_code_goes_with_what_it_calls(tmp_path, monkeypatch):
    """Numba looks at the file of a function only: a changed callee would give the old number."""
    monkeypatch.setattr(code_cache, "HOME", tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    room = tmp_path / "reduced" / "rough"
    cache = room / "__pycache__"
    cache.mkdir(parents=True)
    (room / "callee.py").write_text("def half(x): ...\n")
    (room / "between.py").write_text("from reduced.rough.callee import half\n")
    (room / "caller.py").write_text("from reduced.rough import (\n    between,\n)\n")
    (room / "apart.py").write_text("import numpy\n")
    for module in ("caller", "apart", "gone"):
        for ending in ("nbi", "1.nbc"):
            (cache / f"{module}.f-1.py311.{ending}").touch()
    made = (cache / "caller.f-1.py311.nbi").stat().st_mtime
    for source in room.glob("*.py"):
        os.utime(source, (made - 10, made - 10))
    code_cache.remove_outdated()
    assert len(list(cache.iterdir())) == 6
    os.utime(room / "callee.py", (made + 10, made + 10))
    code_cache.remove_outdated()
    assert {path.name.partition(".")[0] for path in cache.iterdir()} == {"apart"}
