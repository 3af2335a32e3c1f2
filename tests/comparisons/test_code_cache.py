"""Compiled code has a place, also in a package that nobody may write to and without a home."""

import ast
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


@pytest.mark.slow
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
    assert (answer, Path(place).parents[1]) == ("42", folder)
    assert list(Path(place).glob("*.nbi"))
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.fixture
def homeless(tmp_path, monkeypatch):
    """Stand where only the temporary folder can be written to."""
    temporary = tmp_path / f"roughline-{os.getuid()}"
    monkeypatch.setattr(code_cache, "_may_write", lambda folder: False)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.delenv(code_cache.VARIABLE, raising=False)
    return temporary


def chosen() -> Path:
    code_cache.choose_folder()
    return Path(os.environ[code_cache.VARIABLE])


@pytest.fixture(autouse=True)
def _numba_stays(monkeypatch):
    monkeypatch.setenv(code_cache.VARIABLE, os.environ.get(code_cache.VARIABLE, ""))
    numba = sys.modules.get("numba")
    if numba is not None:
        monkeypatch.setattr(numba.config, "CACHE_DIR", numba.config.CACHE_DIR)


def test_the_next_process_finds_what_the_first_has_compiled(homeless):
    first = chosen()
    del os.environ[code_cache.VARIABLE]
    assert first == chosen()
    assert first.parent == homeless


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
    assert folder.parent not in (homeless, theirs)
    assert stat.S_IMODE(folder.parent.lstat().st_mode) == 0o700


def test_a_folder_of_the_users_own_choice_holds_ours(monkeypatch, tmp_path):
    """Also where a process of other sources has chosen before; unused code goes."""
    monkeypatch.setenv(code_cache.VARIABLE, str(tmp_path))
    folder = chosen()
    assert folder.parent == tmp_path
    old = folder.rename(tmp_path / f"{code_cache.NAME}old")
    os.utime(old, (0, 0))
    monkeypatch.setenv(code_cache.VARIABLE, str(old))
    assert chosen() == folder
    assert list(tmp_path.iterdir()) == [folder]


def test_other_sources_have_another_folder(tmp_path, monkeypatch):
    """Numba looks at the file of a function only: a changed callee would give the old number."""
    monkeypatch.setattr(code_cache, "HOME", tmp_path)
    monkeypatch.setenv(code_cache.VARIABLE, str(tmp_path / "cache"))
    (tmp_path / "reduced").mkdir()
    callee = tmp_path / "reduced" / "callee.py"
    callee.write_text("from numba import njit\n")
    first = chosen()
    (tmp_path / "reduced" / "plain.py").write_text("import numpy\n")
    assert chosen() == first
    callee.write_text("from numba import njit  # edited\n")
    assert chosen() != first


def test_compiled_functions_use_nothing_of_files_that_the_digest_leaves_out():
    """Numba freezes constants: one from a file that does not name numba would stay as it was."""
    sources = {
        path.relative_to(code_cache.HOME).with_suffix("").as_posix().replace("/", "."): path
        for package in code_cache.COMPILED
        for path in (code_cache.HOME / package).rglob("*.py")
    }
    counted = {name for name, path in sources.items() if b"numba" in path.read_bytes()}
    wrong = []
    for name in counted:
        tree = ast.parse(sources[name].read_text(encoding="utf-8"))
        foreign = {
            alias.asname or alias.name: node.module
            for node in tree.body
            if isinstance(node, ast.ImportFrom) and node.module in sources.keys() - counted
            for alias in node.names
        }
        for function in ast.walk(tree):
            if isinstance(function, ast.FunctionDef) and any(
                "jit" in ast.unparse(decorator) for decorator in function.decorator_list
            ):
                body = ast.Module(body=function.body, type_ignores=[])
                used = {node.id for node in ast.walk(body) if isinstance(node, ast.Name)}
                wrong += [f"{name}.{function.name}: {n}" for n in used & foreign.keys()]
    assert not wrong, "say in the file of these constants that numba compiles them"
