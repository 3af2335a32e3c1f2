"""The command ``roughline paper``: print-ready figures and tables of a run."""

from __future__ import annotations

from pathlib import Path

from reports.printable import say

FINE = 0


def paper(run: Path, *, out: Path, format: str = "pdf", overview: bool = True) -> int:  # noqa: A002
    """Write the figures and tables of a run for a paper: matplotlib, LaTeX and Markdown.

    Parameters
    ----------
    run
        A folder written by `roughline run`.
    out
        Folder for the files, created if missing; files of the same names are replaced.
    format
        Comma-separated formats of the figures: pdf, svg, png.
    overview
        Also draw one page-wide figure per scene with all its plots.
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
