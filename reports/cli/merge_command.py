"""The command ``roughline merge``: combine runs from several machines."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from reports.cli.arguments import Verbose
from reports.cli.method_files import NO_METHOD_FILES, MethodFiles

FINE, LOST = 0, 1


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
    from comparisons.questions.merging_ensembles import are_ensembles, merge_ensembles
    from comparisons.results.folder import held
    from comparisons.results.store import load_study
    from reports.cli import terminal
    from reports.pages.study import write_report

    method_files.load()
    command = shlex.join(["roughline", *sys.argv[1:]])
    if are_ensembles(runs):
        ensemble = merge_ensembles(runs, out, command)
        terminal.print_ensemble(ensemble, out)
        return LOST if ensemble.record.missing else FINE
    with held(out):
        study = merged(runs, out, command, files)
        record = load_study(out)
        write_report(record, out / "report.html", pictures=pictures)
    lost = study.lost()
    terminal.print_study(record, lost, verbose=verbose)
    return LOST if lost else FINE
