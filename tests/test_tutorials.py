"""The tutorials run as a reader would run them, and what their prose says is asserted in them."""

import ast
import re
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


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_tells_a_story_and_proves_it(path):
    """A title, prose between short cells, and assertions of what the prose says."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    title, rule = ast.get_docstring(tree).splitlines()[:2]
    assert set(rule) == {"="}
    assert len(rule) == len(title)
    assert any(isinstance(node, ast.Assert) for node in tree.body)
    cells = re.split(r"^# %%$", text, flags=re.MULTILINE)[1:]
    assert len(cells) >= 5
    assert sum(cell.lstrip().startswith("# ") for cell in cells) >= len(cells) - 1
