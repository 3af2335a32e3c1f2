"""Figures and tables of a run for a paper, written to a folder."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fnmatch import fnmatchcase
from functools import partial
from io import BytesIO
from itertools import islice
from pathlib import Path

from comparisons.errors import InputError
from comparisons.files import write_named, write_named_text
from comparisons.results.store import SceneRecord, StudyRecord
from reports.paper.contents import Entry, inclusion, index
from reports.paper.figures import file_name, overview, panels, single, verdict_figure
from reports.paper.style import FORMATS, PaperFigure
from reports.plots.figure import Figure
from reports.plots.verdict_map import CAPTION as VERDICT_CAPTION
from reports.tables.judged import printed_verdicts
from reports.tables.scene import printed_settings
from reports.tables.table import Table
from reports.tables.written import in_markdown, latex

CHOSEN = ("verdicts", "*-overview")
Draw = Callable[[], PaperFigure | None]
Advance = Callable[[int, int, str], object]


def write_paper(
    study: StudyRecord,
    folder: Path,
    formats: Sequence[str] = ("pdf",),
    *,
    figures: Sequence[str] = CHOSEN,
    advance: Advance = lambda done, total, name: None,
) -> list[Path]:
    """Write chosen figures, the tables in LaTeX and Markdown, and an index of all.

    Parameters
    ----------
    study : StudyRecord
    folder : Path
    formats : sequence of str
        Among "pdf", "svg" and "png".
    figures : sequence of str
        Names of figures, or patterns of them: "ball-error-force", "ball-*", "*".
    advance : callable, optional
        Called with (figures drawn, figures in all, name of the next one).

    Returns
    -------
    list of Path
        The files written; identical results give identical bytes.

    Raises
    ------
    InputError
        If a format is unknown, a pattern fits no figure, or no scene of the run has results.
    """
    suffixes = [suffix.strip() for suffix in formats]
    if not study.scenes:
        raise InputError(f"{study.directory}: no scene has results; --resume finishes the run")
    drawable = _drawable(study)
    _check(suffixes, figures, drawable)
    chosen = {
        name: drawable[name]
        for name in drawable
        if any(fnmatchcase(name, pattern) for pattern in figures)
    }
    written: list[Path] = []
    entries: list[Entry] = []
    for done, (name, (scene, caption, draw)) in enumerate(chosen.items()):
        advance(done, len(chosen), name)
        figure = draw()
        if figure is None:
            continue  # nothing was solved or compared
        entries.append(Entry(name, scene, caption))
        for suffix in suffixes:
            written.append(folder / f"{name}.{suffix}")
            _save(figure, written[-1], suffix)
    advance(len(chosen), len(chosen), "tables")
    left = [name for name in drawable if name not in chosen]
    for name, text in {
        **_tables(study),
        "figures.tex": inclusion(entries),
        "index.md": index(study, entries, suffixes, left),
    }.items():
        written.append(folder / name)
        write_named_text(written[-1], text)
    return written


def _check(suffixes: Sequence[str], patterns: Sequence[str], drawable: Iterable[str]) -> None:
    """Refuse formats and names of figures that do not exist, all at once."""
    problems = []
    unknown = [suffix for suffix in suffixes if suffix not in FORMATS]
    if unknown or not suffixes:
        allowed = ", ".join(FORMATS)
        problems.append(f"--format: expected {allowed}, got {', '.join(unknown) or 'none'}")
    for pattern in patterns:
        # A run without results has no figure at all, and what is chosen by default may be missing.
        if pattern not in CHOSEN and not any(fnmatchcase(name, pattern) for name in drawable):
            known = ", ".join(islice(drawable, 8))
            problems.append(f"--figures: no figure {pattern!r}; there are {known}, ...")
    if problems:
        raise InputError("\n".join(problems))


def _drawable(study: StudyRecord) -> dict[str, tuple[str, str, Draw]]:
    """Return name -> (scene, caption, what draws it) of every figure, the chosen ones first."""
    drawable: dict[str, tuple[str, str, Draw]] = {
        "verdicts": ("", VERDICT_CAPTION, partial(verdict_figure, study.scenes))
    }
    every: dict[str, tuple[str, str, Draw]] = {}
    for scene in study.scenes:
        drawn = panels(scene)
        if drawn:
            name = file_name(scene.name, "overview")
            drawable[name] = (scene.name, _overview_caption(scene), partial(overview, scene))
        for name, panel in drawn.items():
            text = f"{scene.title or scene.name}: {panel.title}. {panel.caption}"
            every[file_name(scene.name, name)] = (scene.name, text, _single(panel))
    return drawable | every


def _single(panel: Figure) -> Draw:
    return lambda: single(panel)


def _overview_caption(scene: SceneRecord) -> str:
    return (
        f"{scene.title or scene.name}: load curves, the error of the quantity that decides the "
        "verdict over the load, and its largest error against the time for the whole scene."
    )


def _tables(study: StudyRecord) -> dict[str, str]:
    """Return file -> text of the tables: all verdicts, and all settings with a table per scene."""
    verdicts = printed_verdicts(study.scenes)
    settings: dict[str, Table] = {
        file_name(scene.name, "settings"): printed_settings(scene) for scene in study.scenes
    }
    return {
        "verdicts.tex": latex(verdicts, "verdicts"),
        "verdicts.md": in_markdown(verdicts),
        "settings.tex": "\n".join(latex(table, name) for name, table in settings.items()),
        "settings.md": "\n".join(map(in_markdown, settings.values())),
    }


def _save(figure: PaperFigure, path: Path, suffix: str) -> None:
    stream = BytesIO()
    figure.savefig(stream, format=suffix)
    write_named(path, lambda target: target.write(stream.getvalue()))
