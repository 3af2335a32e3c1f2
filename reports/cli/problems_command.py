"""The commands ``roughline problems``, ``submit`` and ``leaderboard``."""

from __future__ import annotations

import json
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.printable import say

if TYPE_CHECKING:
    from comparisons.questions.problems.sheet import Sheet

FINE, OUTSIDE = 0, 1


def problems(problem: str | None = None, *, out: Path | None = None) -> int:
    """List the numbered problems, or print the sheet of one.

    Parameters
    ----------
    problem
        Its number: RL-001. Default: list all.
    out
        Also write the scene, the heights of a rough surface, and an entry to be filled in.
    """
    from comparisons.errors import InputError
    from comparisons.questions.problems.sheet import builtin_sheets, sheet_of
    from reports.cli.terminal import print_table
    from reports.tables.problems import problem_list, sheet_table, sheet_text

    if problem is None:
        if out is not None:
            raise InputError("--out: expected a problem whose files are to be written")
        print_table(problem_list(builtin_sheets().values()))
        return FINE
    sheet = sheet_of(problem)
    say(sheet_text(sheet))
    print_table(sheet_table(sheet))
    if out is not None:
        from comparisons.results.folder import held

        with held(out):
            paths = write_problem(sheet, out)
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
    from comparisons.questions.problems.board import ENTRIES, judge_entry, reference_of
    from comparisons.questions.problems.entry import read_entry
    from comparisons.questions.problems.sheet import sheet_of
    from comparisons.results.folder import held
    from reports.cli.terminal import print_table
    from reports.tables.problems import judged_table, judged_text

    entry = read_entry(file)
    sheet = sheet_of(entry.problem)
    judged = judge_entry(entry, sheet, reference_of(sheet))
    print_table(judged_table(judged, sheet))
    say(judged_text(judged, sheet))
    if leaderboard is not None:
        with held(leaderboard):
            # Named by the hash of what it states: the same entry again changes nothing.
            path = leaderboard / ENTRIES / f"{entry.problem.lower()}-{entry.digest[:16]}.json"
            write_text(path, entry.text)
            say(path)
            _write_page(leaderboard)
    return FINE if judged.verdicts[judged.worst].word == WITHIN else OUTSIDE


def leaderboard(directory: Path) -> int:
    """Write the page of all entries of a folder: the same bytes for the same entries.

    Exits with code 1 if a file of the folder is no entry to a problem as it stands now.

    Parameters
    ----------
    directory
        Folder with entries/*.json, as `roughline submit FILE --leaderboard DIR` fills it.
    """
    from comparisons.results.folder import held

    with held(directory) if directory.is_dir() else nullcontext():
        return OUTSIDE if _write_page(directory) else FINE


def _write_page(directory: Path) -> list[str]:
    """Write the page of a folder, and return why some of its files are not judged."""
    from comparisons.files import write_text
    from comparisons.questions.problems.board import boards_of
    from comparisons.results.folder import PAGE
    from reports.pages.leaderboard import leaderboard_page

    boards, refused = boards_of(directory)
    write_text(directory / PAGE, leaderboard_page(boards, refused))
    for problem in refused:
        say(f"not judged: {problem}")
    say(directory / PAGE)
    return refused


def write_problem(sheet: Sheet, folder: Path) -> list[Path]:
    """Write the files of a sheet for other people's solvers and return their paths."""
    import numpy as np

    from comparisons.files import write_atomically, write_text
    from comparisons.geometry.prepare import RoughGeometry, prepare

    geometry, loads = prepare(sheet.scene)
    steps = len(loads.values)
    paths = [folder / "scene.toml", folder / "entry.json"]
    write_text(paths[0], sheet.scene.text)
    write_text(paths[1], json.dumps(blank_entry(sheet, steps), indent=1) + "\n")
    if isinstance(geometry, RoughGeometry):
        heights = geometry.heights(0, geometry.points[0])
        paths.append(folder / "heights.csv")
        write_atomically(paths[-1], lambda s: np.savetxt(s, heights, delimiter=",", fmt="%.17g"))
    return paths


def blank_entry(sheet: Sheet, steps: int) -> dict[str, Any]:
    """Return an entry without values: every place is to be filled in, or stays null."""
    from comparisons.questions.problems.entry import BLANK_SOLVER

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
