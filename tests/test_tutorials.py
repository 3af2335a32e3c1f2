"""The tutorials run as a reader would run them, and what their prose says is asserted in them."""

from pathlib import Path

import pytest

pytest.importorskip("matplotlib", reason="the extra `paper` is not installed")

ROOT = Path(__file__).resolve().parent.parent
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.py"))


@pytest.mark.slow
@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_runs_from_any_folder(path, python, tmp_path):
    """In a process and a folder of its own; it leaves nothing behind there."""
    (tmp_path / "temporary").mkdir()
    done = python(path, cwd=tmp_path, TMPDIR=str(tmp_path / "temporary"))
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert [item.name for item in tmp_path.iterdir()] == ["temporary"]
