"""The command ``roughline paper``: figures and tables of a run, ready to be printed."""

from __future__ import annotations

from pathlib import Path

from reports.printable import say

FINE = 0


def paper(run: Path, *, out: Path, format: str = "pdf", overview: bool = True) -> int:  # noqa: A002
    """Write figures and tables of a run for a paper: matplotlib, LaTeX and Markdown.

    Parameters
    ----------
    run
        A folder that `roughline run` has written.
    out
        Folder for the files; made if it is not there, files of the same names are replaced.
    format
        Formats of the figures, separated by commas: pdf, svg, png.
    overview
        Also one figure per scene with all plots across the page.
    """
    from comparisons.errors import InputError
    from comparisons.results.store import load_study

    study = load_study(run)
    if out.exists() and not out.is_dir():
        raise InputError(f"{out}: expected a folder for the figures, got a file")
    from reports.paper.files import write_paper

    written = write_paper(study, out, format.split(","), overview=overview)
    say(f"{len(written)} files in {out}")
    return FINE
