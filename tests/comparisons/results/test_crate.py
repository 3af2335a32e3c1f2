"""Results folders describe themselves to archives: RO-Crate and CodeMeta."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

from comparisons.questions.study import Study
from comparisons.results.crate import codemeta, describe, relist
from comparisons.results.folder import CODEMETA, CRATE, PAGE
from comparisons.solving.planning import plan_all

ROOT = Path(__file__).parents[3]
CONE = {"compare.methods": ["closed_form"], "compare.quantities": ["force"]}


def crate(folder):
    """Return the entities of a crate by their ids."""
    document = json.loads((folder / CRATE).read_text(encoding="utf-8"))
    return {item["@id"]: item for item in document["@graph"]}


def test_a_run_leaves_a_crate_that_lists_every_file_of_it(tmp_path):
    """As RO-Crate 1.1 asks: itself, the root with its parts, each part a file that exists."""
    out = tmp_path / "run"
    Study(plan_all(("cone",), CONE, "quick"), out, command="roughline run cone").run()
    items = crate(out)
    assert items[CRATE]["about"] == {"@id": "./"}
    assert items[CRATE]["conformsTo"]["@id"].endswith("/ro/crate/1.1")
    parts = {part["@id"] for part in items["./"]["hasPart"]}
    there = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    assert parts == there - {CRATE}
    for name in parts:
        assert int(items[name]["contentSize"]) == (out / name).stat().st_size
    assert {"name", "description", "datePublished", "license"} <= items["./"].keys()
    run = items["#run"]
    assert (run["name"], run["instrument"]) == ("roughline run cone", {"@id": CODEMETA})


def test_a_page_that_is_written_later_is_listed_too(tmp_path):
    describe(tmp_path, "2026-01-01", "roughline run")
    before = crate(tmp_path)
    (tmp_path / PAGE).write_text("page")
    relist(tmp_path)
    after = crate(tmp_path)
    assert after.keys() - before.keys() == {PAGE}
    assert after["#run"] == before["#run"]


def test_a_description_that_is_not_ours_is_left_alone(tmp_path):
    """Folders come from strangers: damaged and foreign ones cost nothing and are not replaced."""
    relist(tmp_path)
    assert list(tmp_path.iterdir()) == []
    foreign = '{"@graph": [{"@id": "./", "@type": "Dataset"}]}'
    for text in (foreign, "[" * 10_000, '{"@graph": [1]}', "{}", '{"@graph": [{"@type": []}]}'):
        (tmp_path / CRATE).write_text(text)
        relist(tmp_path)
        assert (tmp_path / CRATE).read_text() == text


def test_the_program_is_described_as_its_package_and_citation_do():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    described = codemeta()
    assert described["version"] == project["version"]
    assert described["license"].endswith(f"/{project['license']}")
    assert described["description"] == project["description"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"version: {project['version']}\n" in citation
    assert f"license: {project['license']}\n" in citation
