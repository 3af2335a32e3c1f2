"""The documentation site: complete, built without a warning, readable without a network."""

import re
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
METHODS = ("reduced-model", "half-space", "finite-elements")


@pytest.mark.slow
def test_the_site_builds_without_a_warning_and_without_a_network(python, tmp_path):
    """In a copy, so that the gallery's pages are not written into the repository."""
    pytest.importorskip("sphinx", reason="the extra `docs` is not installed")
    source, out = tmp_path / "docs", tmp_path / "site"
    shutil.copytree(DOCS, source, ignore=shutil.ignore_patterns("_build", "gallery"))
    words = ("-m", "sphinx", "-W", "--keep-going", "-q", source, out)
    done = python(*words, ROUGHLINE_ROOT=str(ROOT))
    assert done.returncode == 0, done.stderr
    for page in ("index", "claims", *METHODS):
        assert (out / f"{page}.html").exists()
    for name in ("check_a_claim", "my_measured_surface", "choose_a_method"):
        page = (out / "gallery" / f"{name}.html").read_text(encoding="utf-8")
        assert "data:image/png;base64," in page  # a plot
        assert "</span></td>" in page  # a table with verdicts
    for path in out.rglob("*.html"):
        loaded = r'<(?:script|img|link rel="stylesheet")[^>]*(?:src|href)="(?:https?:)?//'
        assert not re.search(loaded, path.read_text(encoding="utf-8")), path
    assert "<math" in (out / "reduced-model.html").read_text(encoding="utf-8")
    assert "load_scene" in (out / "getting-started.html").read_text(encoding="utf-8")
