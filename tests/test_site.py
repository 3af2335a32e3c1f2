"""The documentation site: complete, built without a warning, readable without a network."""

import re
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
METHODS = ("reduced-model", "half-space", "finite-elements")


def test_every_page_is_on_the_way_from_the_index():
    """Sphinx would warn; this tells without building."""
    told = (DOCS / "index.md").read_text(encoding="utf-8")
    for page in DOCS.glob("*.md"):
        listed = page.name == "index.md" or re.search(rf"^{page.stem}$", told, re.MULTILINE)
        assert listed, f"{page.name}: add {page.stem} to a toctree of docs/index.md"


@pytest.mark.parametrize("method", METHODS)
def test_the_page_of_a_method_has_equations_validity_failures_and_sources(method):
    text = (DOCS / f"{method}.md").read_text(encoding="utf-8")
    headings = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert {"Equations", "Validity", "Known failures", "Sources"} <= set(headings)
    failures = text.split("## Known failures")[1].split("## Sources")[0]
    assert failures.count("\n- ") >= 4
    assert "$$" in text


@pytest.mark.slow
def test_the_site_builds_without_a_warning_and_without_a_network(python, tmp_path):
    """In a copy, so that the gallery's pages are not written into the repository."""
    pytest.importorskip("sphinx", reason="the extra `docs` is not installed")
    source, out = tmp_path / "docs", tmp_path / "site"
    shutil.copytree(DOCS, source, ignore=shutil.ignore_patterns("_build", "gallery"))
    words = ("-m", "sphinx", "-W", "--keep-going", "-q", source, out)
    done = python(*words, ROUGHLINE_ROOT=str(ROOT))
    assert done.returncode == 0, done.stderr
    for page in ("index", "python", "claims", *METHODS):
        assert (out / f"{page}.html").exists()
    for name in ("check_a_claim", "my_measured_surface", "choose_a_method"):
        page = (out / "gallery" / f"{name}.html").read_text(encoding="utf-8")
        assert "data:image/png;base64," in page  # a plot
        assert "</span></td>" in page  # a table with verdicts
    for path in out.rglob("*.html"):
        loaded = r'<(?:script|img|link rel="stylesheet")[^>]*(?:src|href)="(?:https?:)?//'
        assert not re.search(loaded, path.read_text(encoding="utf-8")), path
    assert "<math" in (out / "reduced-model.html").read_text(encoding="utf-8")
    assert "load_scene" in (out / "python.html").read_text(encoding="utf-8")
