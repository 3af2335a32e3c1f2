"""Problems for all methods, with their leaderboard; very many surfaces, and merged folders."""

from __future__ import annotations

import json
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from comparisons.errors import InputError, ResultsError
from roughline.commands import say, typed
from roughline.commands.arguments import (
    ALONE,
    DEFAULT_FOLDER,
    FAILED,
    FINE,
    NO_METHOD_FILES,
    Flag,
    MaybeWhole,
    MethodFiles,
    Verbose,
    Workers,
    overrides_of,
    part_of,
)

if TYPE_CHECKING:
    from comparisons.questions.problem_sheets import Sheet


ENTRY = "entry.json"  # to be filled in


def problems(problem: str | None = None, *, out: Path | None = None) -> int:
    """List the numbered problems, or print the sheet of one.

    Parameters
    ----------
    problem
        Its number: RL-001. Default: list all.
    out
        Also write the scene, the heights of a rough surface, and an entry to be filled in.
    """
    from comparisons.questions.problem_sheets import builtin_sheets, sheet_of
    from reports.tables.problems import problem_list, sheet_table, sheet_text
    from roughline.commands.terminal import Terminal

    console = Terminal()
    if problem is None:
        if out is not None:
            raise InputError("--out: expected a problem whose files are to be written")
        console.show(problem_list(builtin_sheets().values()))
        return FINE
    sheet = sheet_of(problem)
    say(sheet_text(sheet))
    console.show(sheet_table(sheet))
    if out is None:
        return FINE
    import numpy as np

    from comparisons.files import write_atomically, write_text
    from comparisons.geometry.prepare import RoughGeometry, prepare
    from comparisons.results.folder import held

    paths = [out / "scene.toml", out / ENTRY]
    if paths[1].exists():
        raise InputError(f"{paths[1]}: exists; choose another folder")
    with held(out):
        geometry, loads = prepare(sheet.scene)
        write_text(paths[0], sheet.scene.text)
        blank = blank_entry(sheet, len(loads.values))
        write_text(paths[1], json.dumps(blank, indent=1) + "\n")
        if isinstance(geometry, RoughGeometry):
            heights = geometry.heights(0, geometry.points[0])
            paths.append(out / "heights.csv")
            save = partial(np.savetxt, X=heights, delimiter=",", fmt="%.17g")
            write_atomically(paths[-1], save)
    say("\n".join(map(str, paths)))
    return FINE


def submit(file: Path, *, leaderboard: Path | None = None) -> int:
    """Judge a result file against its problem sheet; nothing of it is run.

    Exits with code 1 if a quantity is outside the sheet's tolerance, or missing.

    Parameters
    ----------
    file
        JSON, as `roughline problems RL-001 --out DIR` writes it to be filled in.
    leaderboard
        Store the entry in this folder, too, and write its page.
    """
    from comparisons.files import write_text
    from comparisons.judging.verdicts import WITHIN
    from comparisons.questions.problem_sheets import (
        ENTRIES,
        judge_entry,
        read_entry,
        reference_of,
        sheet_of,
    )
    from comparisons.results.folder import held
    from reports.tables.problems import judged_table, judged_text
    from roughline.commands.terminal import Terminal

    entry = read_entry(file)
    sheet = sheet_of(entry.problem)
    judged = judge_entry(entry, sheet, reference_of(sheet))
    Terminal().show(judged_table(judged, sheet))
    say(judged_text(judged, sheet))
    if leaderboard is not None:
        with held(leaderboard):
            # Named by the hash of what it states: the same entry again changes nothing.
            path = leaderboard / ENTRIES / f"{entry.problem.lower()}-{entry.digest[:16]}.json"
            write_text(path, entry.text)
            say(path)
            _write_page(leaderboard, leaderboard)
    return FINE if judged.verdicts[judged.worst].word == WITHIN else FAILED


def leaderboard(directory: Path, *, out: Path | None = None) -> int:
    """Write the page of all entries of a folder: the same bytes for the same entries.

    Exits with code 1 if a file of the folder is no entry to a problem as it stands now.

    Parameters
    ----------
    directory
        Folder with entries/*.json, as `roughline submit FILE --leaderboard DIR` fills it.
    out
        Folder for the page, report.html; default: that of the entries.
    """
    from comparisons.results.folder import held

    with held(directory) if directory.is_dir() else nullcontext():
        return FAILED if _write_page(directory, out or directory) else FINE


def _write_page(directory: Path, out: Path) -> list[str]:
    """Write the page of a folder's entries, and return why some of its files are not judged."""
    from comparisons.files import write_text
    from comparisons.questions.problem_sheets import boards_of
    from comparisons.results.folder import PAGE, RECORDS, held
    from reports.pages.leaderboard import leaderboard_page

    boards, refused = boards_of(directory)
    with held(out):
        if foreign := [name for name in RECORDS if (out / name).exists()]:
            raise ResultsError(
                f"{out} has {', '.join(foreign)} of another command: choose another --out"
            )
        write_text(out / PAGE, leaderboard_page(boards, refused))
    for problem in refused:
        say(f"not judged: {problem}")
    say(out / PAGE)
    return refused


def blank_entry(sheet: Sheet, steps: int) -> dict[str, Any]:
    """Return an entry without values: every place is to be filled in, or stays null."""
    from comparisons.questions.problem_sheets import BLANK_SOLVER

    return {
        "problem": sheet.id,
        "version": sheet.version,
        "solver": BLANK_SOLVER,
        "author": "",
        "machine": "",
        "notes": "",
        "threads": 1,
        "unknowns": None,
        "seconds": None,
        "values": {name: [None] * steps for name in sheet.quantities},
    }


def ensemble(
    scene: str,
    *,
    surfaces: MaybeWhole = None,
    methods: str = "bem_fft",
    option: tuple[str, ...] = (),
    out: Path | None = None,
    overwrite: Flag = False,
    part: str | None = None,
    resume: Flag = False,
    workers: Workers = ALONE,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Solve very many surfaces of a scene; write their curves as Parquet files, and statistics.

    Parameters
    ----------
    scene
        A scene file or built-in scene with a random surface.
    surfaces
        Number of surfaces; default: `realisations` of the scene.
    methods
        Comma-separated list of methods, at the resolutions of the scene's [compare], by default the
        surface's own points.
    option
        METHOD.KEY=VALUE, an option of a method; may be repeated.
    out
        Folder for the results; default roughline-results/NAME-ensemble.
    overwrite
        Replace existing results.
    part
        K/N: solve only the Kth of N equal ranges of the surfaces, for `roughline merge`.
    resume
        Continue an interrupted run, or one with fewer surfaces.
    """
    from comparisons.questions.campaign import WHOLE
    from comparisons.questions.ensemble import Ensemble
    from comparisons.scene.scene import load_scene
    from roughline.commands import terminal
    from roughline.commands.progress import watched

    method_files.load()
    overrides = overrides_of(methods, option)
    if surfaces is not None:
        overrides["surface.realisations"] = surfaces
    loaded = load_scene(scene, overrides)
    campaign = Ensemble(
        loaded,
        out or DEFAULT_FOLDER / f"{loaded.name}-ensemble",
        part=WHOLE if part is None else part_of(part),
        command=typed(),
        effort="full",
        executor=workers.executor(),
        resume=resume,
        overwrite=overwrite,
    )
    result = watched(campaign, lambda _: None)
    terminal.print_ensemble(result, campaign.directory)
    lost = sum(setting.lost for setting in result.record.settings)
    return FAILED if lost or result.record.missing else FINE


def merge(
    *runs: Path,
    out: Path,
    files: Path = Path(),
    pictures: bool = True,
    verbose: Verbose = False,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Merge results folders: parts of one study or ensemble, or different methods and scenes.

    The runs must come from this version of roughline and the package versions installed here.

    Parameters
    ----------
    runs
        Folders written by `roughline run` or `roughline ensemble`, with or without `--part K/N`.
    out
        A new folder for the merged results and their report.
    files
        Folder of the maps and meshes that the scenes refer to; default: the current folder.
    pictures
        Render 3-D pictures for the report.
    verbose
        Print the verdict on every quantity, and the advice for each scene.
    """
    from comparisons.questions.merging import merge as merged
    from comparisons.questions.merging import merge_ensembles
    from comparisons.results.ensemble_folder import RECORD
    from comparisons.results.folder import PAGE, held
    from comparisons.results.store import load_study
    from reports.pages.study import write_report
    from roughline.commands import terminal

    method_files.load()
    command = typed()
    if any((run / RECORD).exists() for run in runs):
        ensemble = merge_ensembles(runs, out, command)
        terminal.print_ensemble(ensemble, out)
        return FAILED if ensemble.record.missing else FINE
    with held(out):
        study = merged(runs, out, command, files)
        record = load_study(out)
        write_report(record, out / PAGE, pictures=pictures)
    lost = study.lost()
    terminal.print_study(record, lost, verbose=verbose)
    return FAILED if lost else FINE
