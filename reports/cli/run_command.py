"""The commands ``roughline run`` and ``roughline report``: scenes solved, compared, reported."""

from __future__ import annotations

import shlex
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from reports.cli.arguments import Flag, Full, Verbose, overrides_of, part_of
from reports.cli.method_files import NO_METHOD_FILES, MethodFiles
from reports.cli.workers import ALONE, Workers
from reports.printable import say

if TYPE_CHECKING:
    from comparisons.solving.plan import Effort, Plan

FINE, LOST = 0, 1
DEFAULT_FOLDER = Path("roughline-results")


def run(  # noqa: PLR0913 (the options on the command line)
    *scenes: str,
    methods: str | None = None,
    tolerance: str | None = None,
    quantities: str | None = None,
    option: tuple[str, ...] = (),
    full: Full = False,
    plan: Flag = False,
    out: Path | None = None,
    overwrite: Flag = False,
    part: str | None = None,
    resume: Flag = False,
    pictures: bool = True,
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
    fields
        "all": those of every setting as VTU files, too, for ParaView; default: what pages show.
    verbose
        Print the verdict on every quantity, and the advice for each scene.
    """
    from comparisons.questions.study import WHOLE, Study
    from comparisons.results.decisions import asked_in_vain
    from comparisons.results.folder import held
    from comparisons.solving.planning import plan_all
    from reports.cli import terminal
    from reports.cli.live import watched

    brought = method_files.load()
    share_of_work = WHOLE if part is None else part_of(part)
    effort: Effort = "full" if full else "quick"
    overrides = overrides_of(methods, option, tolerance, quantities)
    plans = plan_all(scenes or ("quick",), overrides, effort, brought=brought)
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
        paraview=fields == "all",
        resume=resume,
        overwrite=overwrite,
    )
    with held(directory):
        record = watched(study, lambda: _write_page(directory, pictures=False))
        _write_page(directory, pictures)
    lost = study.lost()
    terminal.print_study(record, lost, verbose=verbose)
    return LOST if lost or asked_in_vain(record.scenes) else FINE


def report(directory: Path, *, pictures: bool = True) -> int:
    """Rewrite the report of a results folder.

    Parameters
    ----------
    directory
        A folder written by `roughline run`.
    pictures
        Render 3-D pictures.
    """
    from comparisons.results.folder import held

    with held(directory) if directory.is_dir() else nullcontext():
        say(_write_page(directory, pictures))
    return FINE


def _write_page(directory: Path, pictures: bool) -> Path:
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


def _folder_name(scenes: tuple[str, ...], plans: list[Plan]) -> str:
    from comparisons.scene.suites import SUITES

    if not scenes:
        return "quick"
    if len(scenes) == 1:
        name = scenes[0].lower()
        return name if name in SUITES else plans[0].scene.name
    return "+".join(dict.fromkeys(plan.scene.name for plan in plans))[:100]
