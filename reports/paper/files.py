"""Figures and tables of a run for a paper, written to a folder, and its report for mail."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from io import BytesIO
from itertools import islice
from pathlib import Path

from PIL import Image

from comparisons.errors import InputError
from comparisons.files import write_named, write_named_text, write_text
from comparisons.results.advice import advise
from comparisons.results.finding import methods_of
from comparisons.results.folder import MAILED
from comparisons.results.record import StudyRecord
from reports.pages.page import render
from reports.paper.figures import (
    FORMATS,
    PAGE,
    VERDICTS_CAPTION,
    PaperFigure,
    file_name,
    overview,
    panels,
    sheet,
    single,
    verdict_figure,
)
from reports.plots.axes import FOOT_NOTE
from reports.plots.errors import sweeps
from reports.tables.card import card
from reports.tables.judged import finding_table, methods_table, printed_verdicts
from reports.tables.scene import printed_settings, values
from reports.tables.written import in_markdown, latex, markdown, tex

CHOSEN = ("verdicts", "*-overview")
SHOWN = ("png", "svg")  # formats that Markdown shows in place
WIDE = ("verdicts", "-overview")


def write_paper(
    study: StudyRecord,
    folder: Path,
    formats: Sequence[str] = ("pdf",),
    *,
    figures: Sequence[str] = CHOSEN,
    each: Callable[[Sequence[Drawable]], Iterable[Drawable]] = iter,
) -> list[Path]:
    """Write chosen figures, the tables in LaTeX and Markdown, and an index; return the files.

    Formats are "pdf", "svg" and "png"; figures are names or patterns of them: "ball-error-force",
    "ball-*", "*". Identical results give identical bytes. `each` may tell of the figures that it
    passes on to be drawn. InputError if a format is unknown, a pattern fits no figure, or no scene
    of the run has results.
    """
    suffixes = [suffix.strip() for suffix in formats]
    if not study.scenes:
        raise InputError(f"{study.directory}: no scene has results; --resume finishes the run")
    drawable = _drawable(study)
    # Formats and names that do not exist are refused all at once.
    problems = []
    unknown = [suffix for suffix in suffixes if suffix not in FORMATS]
    if unknown or not suffixes:
        allowed = ", ".join(FORMATS)
        problems.append(f"--format: expected {allowed}, got {', '.join(unknown) or 'none'}")
    for pattern in figures:
        # A run without results has no figure at all, and what is chosen by default may be missing.
        if pattern not in CHOSEN and not any(fnmatchcase(name, pattern) for name in drawable):
            known = ", ".join(islice(drawable, 8))
            problems.append(f"--figures: no figure {pattern!r}; there are {known}, ...")
    if problems:
        raise InputError("\n".join(problems))
    chosen = [
        drawable[name]
        for name in drawable
        if any(fnmatchcase(name, pattern) for pattern in figures)
    ]
    written: list[Path] = []
    drawn: list[Drawable] = []
    for entry in each(chosen):
        figure = entry.draw()
        if figure is None:
            continue  # nothing was solved or compared
        drawn.append(entry)
        for suffix in suffixes:
            stream = BytesIO()
            figure.savefig(stream, format=suffix)
            stream.seek(0)
            written.append(folder / f"{entry.name}.{suffix}")
            write_named(written[-1], partial(shutil.copyfileobj, stream))
    tables = {"verdicts": {"verdicts": printed_verdicts(study.scenes)}}
    for name, made in (("settings", printed_settings), ("values", values)):
        tables[name] = {file_name(scene.name, name): made(scene) for scene in study.scenes}
    texts = {}
    for name, several in tables.items():
        texts[f"{name}.tex"] = "\n".join(latex(table, label) for label, table in several.items())
        texts[f"{name}.md"] = "\n".join(map(in_markdown, several.values()))
    left = [name for name, entry in drawable.items() if entry not in chosen]
    texts |= {"figures.tex": _inclusion(drawn), "index.md": _index(study, drawn, suffixes, left)}
    for name, text in texts.items():
        written.append(folder / name)
        write_named_text(written[-1], text)
    return written


@dataclass(frozen=True, eq=False)
class Drawable:
    """A figure of the folder: file name without suffix, the scene ("" for all), its caption."""

    name: str
    scene: str
    caption: str
    draw: Callable[[], PaperFigure | None]


def _drawable(study: StudyRecord) -> dict[str, Drawable]:
    """Return every figure by its name, those that are chosen by default first."""
    verdicts = partial(verdict_figure, study.scenes)
    first = [Drawable("verdicts", "", VERDICTS_CAPTION, verdicts)]
    others = []
    for scene in study.scenes:
        title, drawn = scene.title, panels(scene)
        if drawn:
            curves = "load curves, the error of the quantity that decides the verdict over the load"
            shown = f"{curves}, and its" if not scene.of_one_load else "the"
            caption = f"{title}: {shown} largest error against the time for the whole scene. "
            caption += FOOT_NOTE
            name = file_name(scene.name, "overview")
            first.append(Drawable(name, scene.name, caption, partial(overview, scene)))
        for key, panel in drawn.items():
            text, name = f"{title}: {panel.title}. {panel.caption}", file_name(scene.name, key)
            others.append(Drawable(name, scene.name, text, partial(single, panel)))
    return {entry.name: entry for entry in (*first, *others)}


def _index(
    study: StudyRecord, entries: list[Drawable], suffixes: Sequence[str], left: list[str]
) -> str:
    """Return the index: the finding, every figure with its caption, the tables, what was left."""
    lines = ["# Figures and tables"]
    lines += [
        in_markdown(finding_table(study.scenes, method)) for method in methods_of(study.scenes)
    ]
    lines += [_shown(entry, suffixes) for entry in entries if not entry.scene]
    lines += [
        "Tables: [verdicts](verdicts.md), [values](values.md), [settings](settings.md); "
        "LaTeX beside them.",
        "",
    ]
    for scene in study.scenes:
        shown = [_shown(entry, suffixes) for entry in entries if entry.scene == scene.name]
        advice = advise(scene)
        lines += [f"## {markdown(scene.name)}", "", markdown(advice.sentence), ""]
        lines += [markdown(advice.single), ""] if advice.single else []
        lines += ["One load: no curves; its values are in the tables.", ""] * scene.of_one_load
        lines += shown
    lines += [f"`figures.tex` includes every figure with its caption ({PAGE:.0f} mm wide or less)."]
    if left:
        names = ", ".join(f"`{name}`" for name in left)
        lines += ["", f"Not drawn; `--figures` chooses by name or pattern (`*`: all): {names}."]
    return "\n".join(lines) + "\n"


def _shown(entry: Drawable, suffixes: Sequence[str]) -> str:
    inline = [suffix for suffix in suffixes if suffix in SHOWN]
    links = ", ".join(f"[{entry.name}.{suffix}]({entry.name}.{suffix})" for suffix in suffixes)
    picture = f"![{entry.name}]({entry.name}.{inline[0]})\n\n" if inline else ""
    return f"{picture}{links}: {markdown(entry.caption)}\n"


def _inclusion(entries: Sequence[Drawable]) -> str:
    r"""Return LaTeX with a figure environment for each: ``\input{figures}``."""
    lines = ["% needs \\usepackage{graphicx} and \\usepackage{textcomp}"]
    for entry in entries:
        kind, width = (
            ("figure*", "textwidth") if entry.name.endswith(WIDE) else ("figure", "columnwidth")
        )
        lines += [
            rf"\begin{{{kind}}}",
            r"  \centering",
            rf"  \includegraphics[width=\{width}]{{{entry.name}}}",
            rf"  \caption{{{tex(entry.caption)}}}",
            rf"  \label{{fig:{entry.name}}}",
            rf"\end{{{kind}}}",
        ]
    return "\n".join(lines) + "\n"


SWEEP = "sweep of all scenes"
# Of the images together; with many scenes they get fewer colours and pixels.
MOST_BYTES = 600_000
QUALITIES = ((130, 64), (100, 32), (80, 16), (60, 8))  # dots per inch, colours


def write_mailed(record: StudyRecord, directory: Path) -> Path:
    """Write the page beside the report, and return its path."""
    figures = {scene.name: overview(scene) for scene in record.scenes}
    figures[SWEEP] = sheet(sweeps(record.scenes))
    for dots, colours in QUALITIES:
        images = dict.fromkeys(figures, b"")
        for name, figure in figures.items():
            if figure is not None:
                drawn, small = BytesIO(), BytesIO()
                figure.savefig(drawn, format="png", dpi=dots)
                whole = Image.open(drawn).convert("RGB")
                whole.quantize(colours).save(small, "png", optimize=True)
                images[name] = small.getvalue()
        if sum(map(len, images.values())) <= MOST_BYTES:
            break
    path = directory / MAILED
    page = render(
        "static.html.j2",
        {},
        static=True,
        record=record,
        swept=images[SWEEP],
        findings=[finding_table(record.scenes, method) for method in methods_of(record.scenes)],
        scenes=[
            (scene, card(scene), methods_table(scene), images[scene.name])
            for scene in record.scenes
        ],
    )
    write_text(path, page)
    return path
