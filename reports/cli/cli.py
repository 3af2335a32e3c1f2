"""The command line ``roughline``, also available as ``python -m reports``.

Heavy packages are imported inside the commands, so that help and error messages appear at once.
"""

from __future__ import annotations

import io
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, CycloptsError, Parameter

from reports.cli.arguments import MaybeWhole, Verbose, part_of, share
from reports.cli.calibrate_command import calibrate
from reports.cli.claims_command import claims
from reports.cli.compare_command import compare
from reports.cli.hard_cases_command import hard_cases
from reports.cli.merge_command import merge
from reports.cli.method_files import NO_METHOD_FILES, MethodFiles
from reports.cli.paper_command import paper
from reports.cli.problems_command import leaderboard, problems, submit
from reports.cli.shadowed import foreign_packages
from reports.cli.workers import ALONE, Workers
from reports.printable import say

if TYPE_CHECKING:
    from comparisons.solving.plan import Effort, Plan

FINE, LOST, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 3
DEFAULT_FOLDER = Path("roughline-results")
RESUMABLE = ("run", "claims")  # commands with --resume

app = App(
    name="roughline",
    help="Is the fast contact model accurate? Compare it with 3-D solvers on the same scene.",
    version_flags=["--version"],
    help_format="plaintext",
    suppress_keyboard_interrupt=False,  # our own exit code says that --resume will go on
)
app.command(claims)
app.command(calibrate)
app.command(hard_cases)
app.command(compare)
app.command(paper)
app.command(merge)
app.command(problems)
app.command(submit)
app.command(leaderboard)


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


@app.command
def run(
    *scenes: str,
    methods: str | None = None,
    option: tuple[str, ...] = (),
    full: Annotated[bool, Parameter(name="--full", negative="--quick")] = False,
    plan: Annotated[bool, Parameter(negative=())] = False,
    out: Path | None = None,
    overwrite: Annotated[bool, Parameter(negative=())] = False,
    part: str | None = None,
    resume: Annotated[bool, Parameter(negative=())] = False,
    pictures: bool = True,
    verbose: Verbose = False,
    workers: Workers = ALONE,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Solve scenes with all methods, compare them, and write a report.

    Parameters
    ----------
    scenes
        Scene files, names of built-in scenes, or suites (quick, single, rough, physics);
        default: quick.
    methods
        Comma-separated list of methods to use; default: all.
    option
        METHOD.KEY=VALUE, an option of a method; may be repeated.
    full
        Refine the reference to a fifth of the tolerance, on as many surfaces as that needs;
        --quick: no refinement, fewer surfaces.
    plan
        Print what would be modelled, what is left out and why, without solving.
    out
        Folder for the results; default roughline-results/NAME.
    overwrite
        Replace existing results.
    part
        K/N: solve only part K of N, for `roughline merge`.
    resume
        Continue an interrupted run.
    pictures
        Render 3-D pictures for the report.
    verbose
        Print the verdict on every quantity, and the advice for each scene.
    """
    from comparisons.questions.study import WHOLE, Study
    from comparisons.results.decisions import asked_in_vain
    from comparisons.solving.planning import plan_all
    from reports.cli import terminal
    from reports.cli.live import watched

    method_files.load()
    share_of_work = WHOLE if part is None else part_of(part)
    effort: Effort = "full" if full else "quick"
    plans = plan_all(scenes or ("quick",), _overrides(methods, option), effort)
    if plan:
        terminal.print_plans(plans)
        return FINE
    directory = out or DEFAULT_FOLDER / _folder_name(scenes, plans)
    study = Study(
        plans,
        directory,
        command=shlex.join(["roughline", *sys.argv[1:]]),
        effort=effort,
        executor=workers.executor(),
        part=share_of_work,
        resume=resume,
        overwrite=overwrite,
    )
    record = watched(study, lambda: _write_report(directory, pictures=False))
    _write_report(directory, pictures)
    lost = study.lost()
    terminal.print_study(record, lost, verbose=verbose)
    return LOST if lost or asked_in_vain(record.scenes) else FINE


@app.command
def solve(
    scene: str,
    *,
    method: str,
    resolution: MaybeWhole = None,
    option: tuple[str, ...] = (),
    json: Annotated[bool, Parameter(negative=())] = False,
    csv: Path | None = None,
    vtu: Path | None = None,
    threads: int = 1,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Solve one scene with one method.

    Parameters
    ----------
    scene
        A scene file or the name of a built-in scene.
    method
        The method, one of those in `roughline list methods`.
    resolution
        Springs, cells or elements per contact radius; for rough surfaces, points per side.
    option
        KEY=VALUE, an option of the method; may be repeated.
    json
        Print one JSON object.
    csv
        Write the load steps to this CSV file.
    vtu
        Write the fields at the last load to this VTU file, for ParaView.
    threads
        Threads that share large grids of the half-space (from 512 x 512); digits do not change.
    """
    from comparisons.questions.single import solve_scene
    from reports.cli import terminal

    method_files.load()
    if json and csv is not None:
        return _complain("--json and --csv: expected at most one", [])
    for target in (csv, vtu):
        if (
            target is not None
            and Path(scene).exists()
            and target.exists()
            and target.samefile(scene)
        ):
            return _complain(f"{target}: expected a file other than the scene itself", [])
    options = tuple(
        setting if "." in setting.partition("=")[0] else f"{method}.{setting}" for setting in option
    )
    overrides = _overrides(method, options)
    result = solve_scene(
        scene, method, resolution, overrides, with_fields=vtu is not None, threads=threads
    )
    if vtu is not None:
        result.write_vtu(vtu)
    if json:
        print(result.to_json())
    elif csv is not None:
        result.write_csv(csv)
    else:
        terminal.print_solution(result)
    if not result.converged:
        say("\n".join(result.reasons), sys.stderr)
    return FINE if result.converged else LOST


@app.command(name="list")
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


@app.command
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


@app.command
def advise(
    scene: str,
    *,
    tolerance: str | None = None,
    quantities: str | None = None,
    known: Annotated[bool, Parameter(negative=())] = False,
    full: Annotated[bool, Parameter(name="--full", negative="--quick")] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
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
    from comparisons.scene.scene import load_scene
    from comparisons.solving.planning import plan_scene, refuse_unsolvable
    from reports.cli import advising

    method_files.load()
    overrides: dict[str, Any] = {}
    if tolerance is not None:
        overrides["compare.tolerance"] = share(tolerance)
    if quantities is not None:
        overrides["compare.quantities"] = [quantity.strip() for quantity in quantities.split(",")]
    effort: Effort = "full" if full else "quick"
    plans = plan_scene(load_scene(scene, overrides), effort)
    refuse_unsolvable(plans)
    return advising.print_known(plans, json) if known else advising.advise_all(plans, effort, json)


@app.command
def check(
    *scenes: str,
    method: str = "reduced",
    baseline: Path | None = None,
    update: Annotated[bool, Parameter(negative=())] = False,
    junit: Path | None = None,
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
    junit
        Write the findings to this file as JUnit XML, for continuous integration.
    """
    from comparisons.questions.regression import CHECK_SCENES, PACKAGED
    from comparisons.questions.regression.check import check_against, update_baseline
    from comparisons.questions.regression.junit import write_junit
    from reports.cli import terminal
    from reports.cli.live import watching

    method_files.load()
    stored_baseline = Path("roughline-baseline.json")
    stored = baseline or (stored_baseline if stored_baseline.exists() or update else PACKAGED)
    with watching() as watch:
        act = update_baseline if update else check_against
        findings = act(stored, method, scenes or CHECK_SCENES, watch=watch)
    terminal.print_findings(findings, stored)
    if junit is not None:
        write_junit(junit, findings)
    return LOST if any(finding.drifted for finding in findings) and not update else FINE


@app.command
def report(directory: Path, *, pictures: bool = True) -> int:
    """Rewrite the report of a results folder.

    Parameters
    ----------
    directory
        A folder written by `roughline run`.
    pictures
        Render 3-D pictures.
    """
    say(_write_report(directory, pictures))
    return FINE


def _write_report(directory: Path, pictures: bool) -> Path:
    from comparisons.questions.claims.record import RECORD, load_claims_record
    from comparisons.questions.hard_cases import record as hard
    from comparisons.results.store import STUDY, load_study
    from reports.pages.claims import write_claims_report
    from reports.pages.hard_cases import write_hard_cases_report
    from reports.pages.study import write_report

    path = directory / "report.html"
    if not (directory / STUDY).exists() and (directory / RECORD).exists():
        write_claims_report(load_claims_record(directory), path)
        return path
    if not (directory / STUDY).exists() and (directory / hard.RECORD).exists():
        write_hard_cases_report(hard.load_record(directory), path)
        return path
    write_report(load_study(directory), path, pictures=pictures)
    return path


def _overrides(methods: str | None, options: tuple[str, ...]) -> dict[str, Any]:
    """Turn --methods and --option into keys of the scene, to be validated with it."""
    import tomllib

    from comparisons.errors import InputError

    overrides: dict[str, Any] = {}
    if methods is not None:
        overrides["compare.methods"] = [method.strip() for method in methods.split(",")]
    for text in options:
        key, equals, value = text.partition("=")
        if not equals or key.count(".") != 1:
            raise InputError(f"--option: expected METHOD.KEY=VALUE, got {text!r}")
        try:
            parsed = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            parsed = value
        overrides[f"methods.{key}"] = parsed
    return overrides


def _folder_name(scenes: tuple[str, ...], plans: list[Plan]) -> str:
    from comparisons.scene.suites import SUITES

    if not scenes:
        return "quick"
    if len(scenes) == 1:
        return scenes[0] if scenes[0] in SUITES else plans[0].scene.name
    return "+".join(dict.fromkeys(plan.scene.name for plan in plans))[:100]


for _name in app:
    if not _name.startswith("-"):
        # What renders Markdown takes as long to import as all the rest: not for the first help.
        app[_name].help_format = "markdown"
