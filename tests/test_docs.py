"""What the pages show must work, and the site that is built of them."""

import ast
import pkgutil
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from comparisons.methods.registry import add_class
from comparisons.questions.claims.claim import load_claims
from comparisons.questions.claims.record import STORED, load_claims_record
from comparisons.scene.scene import builtin_folder, load_scene, parse_scene
from comparisons.solving.execution import execute
from comparisons.solving.planning import plan_scene
from comparisons.tasks.task import Task

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_scenes_on_the_pages_are_valid(page):
    """Whole scenes (those with a name) are read; fragments are not scenes."""
    for text in blocks(page, "toml"):
        if text.startswith("name"):
            assert parse_scene(text, page.name, ROOT).name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_between_the_pages_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_tables_of_a_page_are_those_of_a_script_that_it_names(page):
    """A table between markers is written by a script, and so is one that `NAME` calls for."""
    text = page.read_text(encoding="utf-8")
    scripts = [ROOT / path for path in re.findall(r"docs/examples/\w+\.py", text)]
    known = "".join(path.read_text(encoding="utf-8") for path in scripts)
    named = re.findall(r"\b[Tt]ables?\s+((?:`[a-z-]+`(?:,?\s+and\s+|,\s+)?)+)", text)
    names = re.findall(r"<!-- table: (.*?) -->", text)
    names += re.findall(r"`(.*?)`", " ".join(named))
    assert [name for name in names if f'"{name}"' not in known] == []


PACKAGES = ("reduced", "reference", "comparisons", "reports", "roughline")
FOLDERS = "|".join((*PACKAGES, "tests", "docs"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_paths_and_modules_that_a_page_names_are_there(page):
    """Paths (with patterns), files of ours by their bare name, modules with what is in them."""
    named = {
        name
        for text in re.findall(r"`([^`\n]+)`", page.read_text("utf-8"))
        for name in text.split()
    }
    paths = {name for name in named if re.match(rf"({FOLDERS})/", name)}
    missing = {name for name in paths if not any(ROOT.glob(name.rstrip("/")))}
    files = {name for name in named if re.fullmatch(r"[a-z_]+\.py", name)}
    missing |= {name for name in files - YOURS if not any(ours(name))}
    modules = {name for name in named if re.match(rf"({'|'.join(PACKAGES)})\.\w", name)}
    missing |= {name for name in modules if not there(re.match(r"[\w.]+", name)[0])}
    assert not missing


# Files that a reader writes, named on the pages.
YOURS = {"method.py", "mine.py"}


def ours(name: str):
    """Return the files of the packages, the tests and the examples that have this name."""
    return (path for folder in FOLDERS.split("|") for path in (ROOT / folder).rglob(name))


def there(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    try:
        pkgutil.resolve_name(name)
    except (ImportError, AttributeError):
        return False
    return True


def test_every_room_is_on_the_map_of_the_code_and_no_other():
    """Each folder of modules has its line; what a line points to is defined in that file."""
    page = (ROOT / "docs" / "reading.md").read_text(encoding="utf-8")
    rooms = {
        f"{path.parent.relative_to(ROOT).as_posix()}/"
        for package in PACKAGES
        for path in (ROOT / package).rglob("__init__.py")
    }
    headings = set(re.findall(r"^### `([a-z]+/)`", page, re.MULTILINE))
    listed = set(re.findall(r"^\| `([a-z_/]+/)` \|", page, re.MULTILINE)) | headings
    beside = {room for room in listed if room.partition("/")[0] not in PACKAGES}
    assert listed - beside == rooms
    assert "tests/" in beside
    assert all((ROOT / room).is_dir() for room in beside)
    pointers = re.findall(r"`([\w/]+\.(?:py|js))`: `(\w+)`", page)
    assert len(pointers) > 10
    for path, name in pointers:
        text = (ROOT / path).read_text(encoding="utf-8")
        assert re.search(rf"\b(def|class|function|const) {name}\b", text), f"{path}: {name}"


def test_the_way_of_a_scene_names_what_its_files_define_and_its_example_runs():
    page = ROOT / "docs" / "reading.md"
    row = r"^\| \d+ \| `([\w/]+\.py)` \| (.*?) \|"
    files = re.findall(row, page.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(files) > 9
    length = 0
    for path, named in files:
        defined = {
            node.name: node.end_lineno - node.lineno
            for node in ast.parse((ROOT / path).read_text(encoding="utf-8")).body
            if isinstance(node, ast.FunctionDef | ast.ClassDef)
        }
        names = re.findall(r"`(\w+)`", named)
        assert set(names) <= set(defined), path
        length += sum(defined[name] for name in names)
    assert length < 700
    run: dict = {}
    exec(*blocks(page, "python"), run)
    assert run["judged"](run["error"], run["uncertainty"], 0.01).word == "within"


def test_the_verdicts_on_the_pages_are_those_of_the_stored_run(script):
    tables = script("claims_table")
    record = load_claims_record(tables.STORED)
    for path in tables.PAGES:
        page = path.read_text(encoding="utf-8")
        assert tables.BLOCK.search(page), path
        assert tables.written(page, record) == page, f"{path}: run docs/examples/claims_table.py"


@pytest.mark.parametrize(
    ("sentence", "fault"),
    [
        # 0.01 +- 0.05 is no error, and the range of 10 % stands behind one of 1 %
        ("Off by {rough-penetration.least} at the least.", "may be zero"),
        (
            "Within 1 % to {hard-coating-thin-1.high}, and up to {coating-effective-modulus.high}.",
            "a range at 10",
        ),
    ],
)
def test_sentences_to_quote_do_not_read_as_more_than_the_claims_say(script, sentence, fault):
    tables = script("claims_table")
    by_id = {claim.id: claim for claim in load_claims_record(tables.STORED).claims}
    with pytest.raises(ValueError, match=fault):
        tables._with_numbers(sentence, by_id)


def test_a_record_put_together_took_what_all_its_claims_took(script):
    tables = script("claims_table")
    stored = load_claims_record(tables.STORED)
    brief = stored.model_copy(update={"seconds": 1.0})
    again = tables.put_together([brief])
    assert again.seconds == pytest.approx(sum(claim.seconds for claim in stored.claims))


def test_the_stored_run_is_about_the_claims_as_their_files_state_them():
    """Full runs only, of the very statements, with the verdicts that the files expect."""
    files = {claim.id: claim for claim in load_claims()}
    assert all(claim.expected for claim in files.values())
    for told in load_claims_record(STORED).claims:
        claim = files[told.id]
        stated = ("text", "equation", "reading", "tolerance", "refuted_by", "theorem")
        assert {key: getattr(told, key) for key in stated} == claim.model_dump(include=set(stated))
        assert (told.effort, told.verdict, told.what) == ("full", claim.expected, claim.what)
        assert told.expected == claim.expected


def test_the_function_of_the_page_is_the_shipped_example():
    (function, *_) = blocks(ROOT / "docs" / "adding-a-method.md", "python")
    assert function == (ROOT / "docs" / "examples" / "winkler.py").read_text(encoding="utf-8")


@pytest.mark.usefixtures("methods_restored")
def test_the_class_of_the_page_runs_as_printed():
    """A disc as wide as the overlap of a paraboloid: F = 2 E* sqrt(2 R d) d."""
    page: dict = {}
    *shown, _ = blocks(ROOT / "docs" / "adding-a-method.md", "python")  # the last: a user's test
    for code in shown:
        exec(code, page)
    add_class(page["Disc"])
    (plan, *_) = plan_scene(load_scene("paraboloid"))
    solution = execute(Task(plan.scene, plan.geometry, plan.loads, "disc", 40, ("force",)))
    assert solution.converged.all(), solution.reasons
    d, radius = plan.loads.values, plan.scene.indenter.radius
    exact = 2 * plan.scene.effective_modulus * np.sqrt(2 * radius * d) * d
    np.testing.assert_allclose(solution.quantities["force"][0], exact, rtol=1e-12)


def test_the_shipped_map_is_the_one_its_script_makes(script):
    """The stand-in for a measured map is synthetic; its script tells exactly how."""
    shipped = np.genfromtxt(builtin_folder() / "measured-map.csv", delimiter=",")
    # Two decimals are written; another FFT build may round the last one differently.
    np.testing.assert_allclose(shipped, script("stand_in_map").ground_surface(), atol=0.011)


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
