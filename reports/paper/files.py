"""Figures and tables of a run for a paper, written to a folder."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import BytesIO
from pathlib import Path

from comparisons.errors import InputError
from comparisons.files import write_named, write_named_text
from comparisons.results.store import StudyRecord
from reports.paper.figures import file_name, panels, single
from reports.paper.figures import overview as overview_of
from reports.paper.style import FORMATS, PaperFigure
from reports.tables.judged import printed_verdicts
from reports.tables.scene import printed_settings
from reports.tables.table import Table
from reports.tables.written import in_markdown, latex


def write_paper(
    study: StudyRecord, folder: Path, formats: Sequence[str] = ("pdf",), *, overview: bool = True
) -> list[Path]:
    """Write the figures of every scene, and the tables in LaTeX and Markdown.

    Parameters
    ----------
    study : StudyRecord
    folder : Path
    formats : sequence of str
        Among "pdf", "svg" and "png".
    overview : bool
        Also write a page-wide figure of each scene.

    Returns
    -------
    list of Path
        The files written; identical results give identical bytes.

    Raises
    ------
    InputError
        If a format is unknown, or no scene of the run has results.
    """
    suffixes = [suffix.strip() for suffix in formats]
    unknown = [suffix for suffix in suffixes if suffix not in FORMATS]
    if unknown or not suffixes:
        allowed = ", ".join(FORMATS)
        raise InputError(f"--format: expected {allowed}, got {', '.join(unknown) or 'none'}")
    if not study.scenes:
        raise InputError(f"{study.directory}: no scene has results; --resume finishes the run")
    written = []
    for name, figure in _figures(study, overview=overview):
        for suffix in suffixes:
            path = folder / f"{name}.{suffix}"
            _save(figure, path, suffix)
            written.append(path)
    for name, table in _tables(study):
        for suffix, text in (("tex", latex(table, name)), ("md", in_markdown(table))):
            path = folder / f"{name}.{suffix}"
            write_named_text(path, text)
            written.append(path)
    return written


def _figures(study: StudyRecord, *, overview: bool) -> Iterator[tuple[str, PaperFigure]]:
    for scene in study.scenes:
        for name, panel in panels(scene).items():
            yield file_name(scene.name, name), single(panel)
        figure = overview_of(scene) if overview else None
        if figure is not None:
            yield file_name(scene.name, "overview"), figure


def _tables(study: StudyRecord) -> Iterator[tuple[str, Table]]:
    yield "verdicts", printed_verdicts(study.scenes)
    for scene in study.scenes:
        yield file_name(scene.name, "settings"), printed_settings(scene)


def _save(figure: PaperFigure, path: Path, suffix: str) -> None:
    stream = BytesIO()
    figure.savefig(stream, format=suffix)
    write_named(path, lambda target: target.write(stream.getvalue()))
