"""Commands of every day: a scene file, runs and their reports, tables and figures for a paper."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from comparisons.errors import InputError
from roughline.commands import say, typed
from roughline.commands.arguments import (
    ALONE,
    DEFAULT_FOLDER,
    FAILED,
    FINE,
    NO_METHOD_FILES,
    Changes,
    Flag,
    Full,
    MaybeWhole,
    MethodFiles,
    Share,
    Verbose,
    Workers,
    flags_of,
    overrides_of,
    part_of,
    share,
)

if TYPE_CHECKING:
    from comparisons.results.record import StudyRecord
    from comparisons.solving.plan import Effort, Plan

# Usual seconds of the report when all is solved, and those of each scene: as `Usual` measured.
REPORT, OF_SCENE = 0.8, 0.5


def new(kind: str, file: Path | None = None) -> int:
    """Write a scene file with comments, to be changed into yours.

    Parameters
    ----------
    kind
        What touches: "ball", "punch" (a flat one), "rough" (a self-affine surface) or "map" (a
        measured one); or the name of a built-in scene.
    file
        The file to write; default: KIND.toml in this folder. An existing one stays.
    """
    from comparisons.files import write_named_text
    from comparisons.scene.scene import beginning

    text = beginning(kind)
    path = file or Path(f"{kind}.toml")
    if path.exists():
        raise InputError(f"{path}: exists; choose another name")
    write_named_text(path, text)
    say(f"{path}: change it, then `roughline run {path}`")
    return FINE


def run(  # noqa: PLR0913 (the options on the command line)
    *scenes: str,
    methods: str | None = None,
    tolerance: Share | None = None,
    quantities: str | None = None,
    loads: str | None = None,
    option: tuple[str, ...] = (),
    changes: Changes = (),
    full: Full = False,
    prove: Flag = False,
    sensitivity: Flag = False,
    plan: Flag = False,
    out: Path | None = None,
    overwrite: Flag = False,
    part: str | None = None,
    resume: Flag = False,
    pictures: bool = True,
    static: Flag = False,
    fields: Literal["shown", "all"] = "shown",
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
    tolerance
        Acceptable relative error, such as 5% or 0.05; default: that of each scene.
    quantities
        Comma-separated quantities to compare; default: those of each scene.
    loads
        CONTROL=VALUE,VALUE,... in place of the loads of each scene, such as "force=1 N,10 N,50 N".
    option
        METHOD.KEY=VALUE, an option of a method; may be repeated.
    changes
        KEY=VALUE in place of a key of each scene, such as surface.hurst=0.7; may be repeated.
    full
        Refine the reference to a fifth of the tolerance, on as many surfaces as that needs;
        --quick: no refinement, fewer surfaces.
    prove
        Enclose the reference by theorems also where that takes longer than the solves: rough
        surfaces (the documentation's page on error bars).
    sensitivity
        Solve measured maps also with other trends and cut-offs, and their quarters alone.
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
    static
        Beside the report, write report-static.html for mail: no scripts, below 1 MB (needs
        matplotlib: roughline[paper]).
    fields
        "all": those of every setting as VTU files, too, for ParaView; default: what pages show.
    verbose
        Print the verdict on every quantity, and the advice for each scene.
    """
    from comparisons.methods.user.external import brought
    from comparisons.questions.campaign import WHOLE
    from comparisons.questions.study import Study
    from comparisons.results.folder import MAILED, held
    from comparisons.results.record import asked_in_vain
    from comparisons.solving.planning import plan_all
    from roughline.commands import terminal
    from roughline.commands.progress import watched

    if static:  # without matplotlib that is told before anything is solved
        import_module("reports.paper.files")
    method_files.load()
    share_of_work = WHOLE if part is None else part_of(part)
    effort: Effort = "full" if full else "quick"
    overrides = overrides_of(methods, option, tolerance, quantities, loads, changes)
    overrides |= {"compare.proved": "if_any"} if prove else {}
    sources = scenes or ("quick",)
    plans = plan_all(
        sources, overrides, effort, flags_of(changes), brought(), sensitivity=sensitivity
    )
    if plan:
        terminal.print_plans(plans)
        return FINE
    directory = out or DEFAULT_FOLDER / _folder_name(scenes, plans)
    study = Study(
        plans,
        directory,
        command=typed(),
        effort=effort,
        executor=workers.executor(),
        part=share_of_work,
        paraview=fields == "all",
        resume=resume,
        overwrite=overwrite,
    )

    def write_page(record: StudyRecord) -> None:
        whole = not record.interrupted
        _write_study(record, pictures and whole, static and whole)

    with held(directory):
        record = watched(study, write_page, REPORT + OF_SCENE * len(plans))
    lost = study.lost()
    terminal.print_study(record, lost, verbose=verbose)
    if static:
        say(directory / MAILED)
    return FAILED if lost or asked_in_vain(record.scenes) else FINE


def report(directory: Path, *, pictures: bool = True, static: Flag = False) -> int:
    """Rewrite the report of a results folder.

    Parameters
    ----------
    directory
        A folder written by `roughline run`.
    pictures
        Render 3-D pictures.
    static
        Beside it, write report-static.html for mail (see `roughline run`).
    """
    from comparisons.files import write_text
    from comparisons.questions.claims import record as claims
    from comparisons.questions.hard_cases import case as hard_cases
    from comparisons.results.folder import MAILED, PAGE, RECORDS, held
    from comparisons.results.store import STUDY, load_study

    page = directory / PAGE
    with held(directory) if directory.is_dir() else nullcontext():
        name = next((name for name in RECORDS if (directory / name).exists()), STUDY)
        if static and name in (claims.RECORD, hard_cases.RECORD):
            raise InputError(f"--static: expected results of `roughline run`, got {name}")
        if name == claims.RECORD:
            from reports.pages.claims import claims_page

            write_text(page, claims_page(claims.load_claims_record(directory)))
        elif name == hard_cases.RECORD:
            from reports.pages.hard_cases import hard_cases_page

            write_text(page, hard_cases_page(hard_cases.load_record(directory)))
        else:
            _write_study(load_study(directory), pictures, static)
    say(page)
    if static:
        say(directory / MAILED)
    return FINE


def _write_study(record: StudyRecord, pictures: bool, static: bool) -> None:
    from comparisons.results.folder import PAGE
    from reports.pages.study import write_report

    write_report(record, record.directory / PAGE, pictures=pictures)
    if static:
        from reports.paper.files import write_mailed

        write_mailed(record, record.directory)


def _folder_name(scenes: tuple[str, ...], plans: list[Plan]) -> str:
    from comparisons.scene.scene import SUITES, member

    if not scenes:
        return "quick"
    if len(scenes) == 1:
        name = scenes[0].lower()
        first = plans[0].scene
        if name in SUITES:
            return name
        for value in first.sweep.values():
            return first.name.removesuffix(member("", value))
        return first.name
    return "+".join(dict.fromkeys(plan.scene.name for plan in plans))[:100]


def solve(
    scene: str,
    *,
    method: str,
    resolution: MaybeWhole = None,
    option: tuple[str, ...] = (),
    json: Flag = False,
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
    from roughline.commands import terminal

    method_files.load()
    if json and csv is not None:
        raise InputError("--json and --csv: expected at most one")
    if csv is not None and csv == vtu:
        raise InputError(f"--csv and --vtu: expected two files, got {csv} twice")
    for target in (csv, vtu):
        if target and target.exists() and Path(scene).exists() and target.samefile(scene):
            raise InputError(f"{target}: expected a file other than the scene itself")
    options = tuple(
        setting if "." in setting.partition("=")[0] else f"{method}.{setting}" for setting in option
    )
    overrides = overrides_of(method, options)
    result = solve_scene(
        scene, method, resolution, overrides, with_fields=vtu is not None, threads=threads
    )
    if vtu is not None:
        result.to_vtu(vtu)
    if json:
        print(result.to_json())
    elif csv is not None:
        result.to_csv(csv)
    else:
        terminal.print_solution(result)
    for note in result.plan.doubts:
        say(note, sys.stderr)
    if result.reasons:
        say("\n".join(result.reasons), sys.stderr)
    return FINE if result.converged else FAILED


def compare(
    before: Path,
    after: Path,
    *,
    tolerance: Share = "1e-5",
    slower: float = 1.5,
    out: Path | None = None,
    overwrite: Flag = False,
    static: Flag = False,
) -> int:
    """Compare two results folders: changes in value, error and time. Returns 1 if answers moved.

    Parameters
    ----------
    before, after
        Folders written by `roughline run`.
    tolerance
        Smallest relative change of a quantity that counts, e.g. 1e-5 or 1%.
    slower
        Smallest ratio of times that is told; between different machines, times are shown only.
    out
        Folder for comparison.html; default roughline-results/comparison-BEFORE-AFTER.
    overwrite
        Replace a comparison.html in it.
    static
        Beside it, write comparison-static.html for mail: no plots, no scripts.
    """
    from comparisons.files import write_text
    from comparisons.results.folder import held
    from reports.pages.runs import comparison_page
    from roughline.commands import terminal
    from roughline.studies import compare_runs

    runs = f"{before.resolve().name}-{after.resolve().name}"
    out = out or DEFAULT_FOLDER / f"comparison-{runs}"
    page = out / "comparison.html"
    if page.exists() and not overwrite:
        told = "use --overwrite to replace it, or --out for another folder"
        raise InputError(f"{page} exists already: {told}")
    record = compare_runs(before, after, tolerance=share(tolerance), slower=slower).record
    command = typed()
    with held(out):
        write_text(page, comparison_page(record, command))
        if static:
            mailed = page.with_name("comparison-static.html")
            write_text(mailed, comparison_page(record, command, static=True))
    terminal.print_run_comparison(record, page)
    return FAILED if record.failed or not record.compared else FINE


def paper(
    run: Path,
    *,
    out: Path,
    format: str = "pdf",  # noqa: A002
    figures: str = "verdicts,*-overview",
) -> int:
    """Write figures and tables of a run for a paper: matplotlib, LaTeX, Markdown, and an index.

    Parameters
    ----------
    run
        A folder written by `roughline run`.
    out
        Folder for the files, created if missing; files of the same names are replaced.
    format
        Comma-separated formats of the figures: pdf, svg, png.
    figures
        Comma-separated names of figures, or patterns: `ball-*`, `*-error-force`, `*` for all.
        Default: the figure of all verdicts, and one of each scene. The index lists the others.
    """
    from comparisons.results.folder import held
    from comparisons.results.store import load_study
    from roughline.commands.progress import drawing

    study = load_study(run)
    from reports.paper.files import write_paper

    chosen = [name.strip() for name in figures.split(",")]
    with held(out):
        written = write_paper(study, out, format.split(","), figures=chosen, each=drawing)
    say(f"{len(written)} files; {out / 'index.md'}")
    return FINE


def advise(
    scene: str,
    *,
    tolerance: Share | None = None,
    quantities: str | None = None,
    changes: Changes = (),
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
    changes
        KEY=VALUE in place of a key of the scene, such as surface.hurst=0.7; may be repeated.
    known
        Only say what was measured nearest to the scene; solve nothing.
    full
        Solve as many surfaces and grids as `run --full`; --quick: as many as `run`.
    json
        Print one JSON object.
    """
    from comparisons.methods.user.external import brought
    from comparisons.solving.planning import plan_all
    from roughline.commands import advising

    method_files.load()
    overrides = overrides_of(tolerance=tolerance, quantities=quantities, changes=changes)
    effort: Effort = "full" if full else "quick"
    plans = plan_all([scene], overrides, effort, flags_of(changes), brought())
    if not known:
        return advising.advise_all(plans, effort, json)
    return advising.print_known(plans, json)


def list_(catalogue: str | None = None, *, method_files: MethodFiles = NO_METHOD_FILES) -> int:
    """List the built-in scenes, methods, claims or hard cases.

    Parameters
    ----------
    catalogue
        "scenes", "methods", "claims" or "hard-cases"; default: the number of each.
    """
    from comparisons.reasons import near
    from reports.tables.lists import CATALOGUES
    from roughline.commands.terminal import Terminal

    if catalogue is not None and catalogue not in CATALOGUES:
        expected = f"list: expected one of {', '.join(CATALOGUES)}, got {catalogue!r}"
        raise InputError(expected + near(catalogue, CATALOGUES))
    method_files.load()
    if catalogue is not None:
        Terminal().show(CATALOGUES[catalogue](), unfolded=catalogue == "hard-cases")
        return FINE
    for name, listed in CATALOGUES.items():
        say(f"{len(listed().rows):5} {name.replace('-', ' '):<11} roughline list {name}")
    return FINE
