"""The command line ``roughline``, also available as ``python -m reports``.

Heavy packages are imported inside the commands, so that help and error messages appear at once.
"""

from __future__ import annotations

import io
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from cyclopts import App, CycloptsError, Group, Parameter

from reports.cli.arguments import Flag, Full, overrides_of
from reports.cli.calibrate_command import calibrate
from reports.cli.claims_command import claims
from reports.cli.compare_command import compare
from reports.cli.ensemble_command import ensemble
from reports.cli.hard_cases_command import hard_cases
from reports.cli.merge_command import merge
from reports.cli.method_files import NO_METHOD_FILES, MethodFiles
from reports.cli.new_command import new
from reports.cli.paper_command import paper
from reports.cli.problems_command import leaderboard, problems, submit
from reports.cli.run_command import report, run
from reports.cli.shadowed import foreign_packages
from reports.cli.solve_command import solve
from reports.printable import say

if TYPE_CHECKING:
    from comparisons.solving.plan import Effort

FINE, LOST, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 3
RESUMABLE = ("run", "claims", "ensemble")  # commands with --resume


def _version() -> str:
    from comparisons.machine import own_version

    return own_version()


app = App(
    name="roughline",
    help="Is the fast contact model accurate? Compare it with 3-D solvers on the same scene.",
    version=_version,
    version_flags=["--version"],
    help_format="plaintext",
    suppress_keyboard_interrupt=False,  # our own exit code says that --resume will go on
    default_parameter=Parameter(negative_iterable=(), show_default=False),
)
EVERYDAY, SHARED, VALIDATION = (
    Group(name, sort_key=place)
    for place, name in enumerate(
        ("Everyday", "Problems for all methods, and many surfaces", "For validation")
    )
)
for _group, _commands in {
    EVERYDAY: (new, run, solve, report, compare, paper),
    SHARED: (problems, submit, leaderboard, ensemble, merge),
    VALIDATION: (claims, calibrate, hard_cases),
}.items():
    for _command in _commands:
        app.command(_command, group=_group)


def run_command(arguments: list[str]) -> int:
    """Run a command and report every expected error as one clear message.

    Returns
    -------
    int
        Exit code: 0 success, 1 a solve failed, 2 invalid input, 3 interrupted.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A console that cannot show a narrow space or a micro sign shows a question mark.
            stream.reconfigure(errors="replace")
    shadows = foreign_packages()
    if shadows:
        return _complain("roughline's packages are shadowed by others:", shadows)
    from comparisons.errors import InputError, LostWorkError

    try:
        result = app(arguments, exit_on_error=False, print_error=True, result_action="return_value")
    except CycloptsError:
        return WRONG_INPUT
    except InputError as error:
        return _complain(str(error), [])
    except LostWorkError as error:
        return _interrupted(str(error), arguments)
    except KeyboardInterrupt:
        return _interrupted("interrupted", arguments)
    except BrokenPipeError:
        # The reader went away (roughline ... | head): nothing is left to say.
        sys.stderr.close()
        return FINE
    except OSError as error:
        return _complain(f"cannot read or write: {error}", [])
    return result if isinstance(result, int) else FINE


def _complain(heading: str, lines: list[str]) -> int:
    say("\n  ".join([heading, *lines]), sys.stderr)
    return WRONG_INPUT


def _interrupted(reason: str, arguments: list[str]) -> int:
    resumes = bool(arguments) and arguments[0] in RESUMABLE
    hint = "; finished solves are kept, continue with --resume" if resumes else ""
    say(f"{reason}{hint}", sys.stderr)
    return INTERRUPTED


@app.command(name="list", group=EVERYDAY)
def list_(catalogue: str | None = None, *, method_files: MethodFiles = NO_METHOD_FILES) -> int:
    """List the built-in scenes, methods, claims or hard cases.

    Parameters
    ----------
    catalogue
        "scenes", "methods", "claims" or "hard-cases"; default: the number of each.
    """
    from comparisons.errors import InputError
    from reports.cli import terminal

    lists = {
        "scenes": terminal.print_scenes,
        "methods": terminal.print_methods,
        "claims": terminal.print_claim_list,
        "hard-cases": terminal.print_hard_case_list,
    }
    if catalogue is None:
        method_files.load()
        terminal.print_lists()
        return FINE
    if catalogue not in lists:
        raise InputError(f"list: expected one of {', '.join(lists)}, got {catalogue!r}")
    method_files.load()
    lists[catalogue]()
    return FINE


@app.command(group=VALIDATION)
def bench(benchmark: str | None = None, *, json: Path | None = None) -> int:
    """Measure the speed of the solvers against yardsticks timed in the same run.

    Parameters
    ----------
    benchmark
        "reduced", "bem" or "fem"; default: all.
    json
        Write the rows to this file, as a list of {name, seconds, yardstick, yardstick_seconds,
        ratio, target, met}.
    """
    import json as json_format

    from comparisons.errors import InputError
    from comparisons.files import write_named_text
    from comparisons.questions.benchmarks import BENCHMARKS
    from reports.cli import terminal

    if benchmark is not None and benchmark not in BENCHMARKS:
        raise InputError(f"bench: expected one of {', '.join(BENCHMARKS)}, got {benchmark!r}")
    names = list(BENCHMARKS) if benchmark is None else [benchmark]
    timings = {name: BENCHMARKS[name]() for name in names}
    terminal.print_benchmarks(timings)
    if json is not None:
        rows = [measurement.row() for rows in timings.values() for measurement in rows]
        write_named_text(json, json_format.dumps(rows, indent=1) + "\n")
    return FINE


@app.command(group=EVERYDAY)
def advise(
    scene: str,
    *,
    tolerance: str | None = None,
    quantities: str | None = None,
    known: Flag = False,
    full: Full = False,
    json: Flag = False,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Find the cheapest method and resolution that meet a tolerance, error bar included.

    First it says what claims have measured nearest to the scene; then it solves the scene.

    Parameters
    ----------
    scene
        A scene file or the name of a built-in scene.
    tolerance
        Acceptable relative error, such as 5% or 0.05; default: the scene's tolerance.
    quantities
        Comma-separated quantities that must meet it; default: those that the scene compares.
    known
        Only say what was measured nearest to the scene; solve nothing.
    full
        Solve as many surfaces and grids as `run --full`; --quick: as many as `run`.
    json
        Print one JSON object.
    """
    from comparisons.solving.planning import plan_all
    from reports.cli import advising

    brought = method_files.load()
    overrides = overrides_of(tolerance=tolerance, quantities=quantities)
    effort: Effort = "full" if full else "quick"
    plans = plan_all([scene], overrides, effort, "--tolerance, --quantities", brought)
    if not known:
        return advising.advise_all(plans, effort, json)
    again = shlex.join(["roughline", *(word for word in sys.argv[1:] if word != "--known")])
    return advising.print_known(plans, json, again)


@app.command(group=VALIDATION)
def check(
    *scenes: str,
    method: str = "reduced",
    baseline: Path | None = None,
    update: Flag = False,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Check for drift against a baseline, and attribute it to the model, reference or machine.

    Parameters
    ----------
    scenes
        Scene files or built-in scenes; default: all single contacts and a rough surface.
    method
        The method to check.
    baseline
        The stored curves; default: roughline-baseline.json in this folder, else the packaged one.
    update
        Show the drift, then store the new curves, by default in roughline-baseline.json.
    """
    from comparisons.questions.regression import CHECK_SCENES, PACKAGED
    from comparisons.questions.regression.check import check_against, update_baseline
    from reports.cli import terminal
    from reports.cli.live import watching

    method_files.load()
    stored_baseline = Path("roughline-baseline.json")
    stored = baseline or (stored_baseline if stored_baseline.exists() or update else PACKAGED)
    with watching() as watch:
        act = update_baseline if update else check_against
        findings = act(stored, method, scenes or CHECK_SCENES, watch=watch)
    terminal.print_findings(findings, stored)
    return LOST if any(finding.drifted for finding in findings) and not update else FINE


for _name in app:
    if not _name.startswith("-"):
        # What renders Markdown takes as long to import as all the rest: not for the first help.
        app[_name].help_format = "markdown"
