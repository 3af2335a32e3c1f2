"""The command ``roughline paper``: print-ready figures and tables of a run."""

from __future__ import annotations

from pathlib import Path

from reports.printable import say

FINE = 0


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
        Comma-separated names of figures, or patterns: "ball-*", "*-error-force", "*" for all.
        Default: the figure of all verdicts, and one of each scene. The index lists the others.
    """
    from comparisons.results.folder import held
    from comparisons.results.store import load_study
    from reports.cli.live import counting

    study = load_study(run)
    from reports.paper.files import write_paper

    chosen = [name.strip() for name in figures.split(",")]
    with held(out), counting("drawn") as advance:
        written = write_paper(study, out, format.split(","), figures=chosen, advance=advance)
    say(f"{len(written)} files; {out / 'index.md'}")
    return FINE
