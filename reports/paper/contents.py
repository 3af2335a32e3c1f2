"""What a folder for a paper holds: an index to read, and LaTeX that includes every figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from comparisons.results.advice import advise
from comparisons.results.finding import methods_of
from comparisons.results.store import StudyRecord
from reports.paper.style import PAGE
from reports.tables.judged import finding_table
from reports.tables.notation import markdown, tex
from reports.tables.written import in_markdown

SHOWN = ("png", "svg")  # formats that Markdown shows in place
WIDE = ("verdicts", "-overview")


@dataclass(frozen=True)
class Entry:
    """A figure of the folder: file name without suffix, the scene ("" for all), its caption."""

    name: str
    scene: str
    caption: str

    @property
    def is_wide(self) -> bool:
        """Whether it is as wide as the page."""
        return self.name.endswith(WIDE)


def index(
    study: StudyRecord, entries: list[Entry], suffixes: Sequence[str], left: list[str]
) -> str:
    """Return the index: the finding, every figure with its caption, the tables, what was left."""
    lines = ["# Figures and tables"]
    lines += [
        in_markdown(finding_table(study.scenes, method)) for method in methods_of(study.scenes)
    ]
    lines += [_shown(entry, suffixes) for entry in entries if not entry.scene]
    lines += ["Tables: [verdicts](verdicts.md), [settings](settings.md); LaTeX beside them.", ""]
    for scene in study.scenes:
        shown = [_shown(entry, suffixes) for entry in entries if entry.scene == scene.name]
        advice = advise(scene)
        lines += [f"## {markdown(scene.name)}", "", markdown(advice.sentence), ""]
        lines += [markdown(advice.single), ""] if advice.single else []
        lines += shown
    lines += [f"`figures.tex` includes every figure with its caption ({PAGE:.0f} mm wide or less)."]
    if left:
        names = ", ".join(f"`{name}`" for name in left)
        lines += ["", f"Not drawn; `--figures` chooses by name or pattern (`*`: all): {names}."]
    return "\n".join(lines) + "\n"


def _shown(entry: Entry, suffixes: Sequence[str]) -> str:
    inline = [suffix for suffix in suffixes if suffix in SHOWN]
    links = ", ".join(f"[{entry.name}.{suffix}]({entry.name}.{suffix})" for suffix in suffixes)
    picture = f"![{entry.name}]({entry.name}.{inline[0]})\n\n" if inline else ""
    return f"{picture}{links}: {markdown(entry.caption)}\n"


def inclusion(entries: Sequence[Entry]) -> str:
    r"""Return LaTeX with a figure environment for each: ``\input{figures}``."""
    lines = ["% needs \\usepackage{graphicx} and \\usepackage{textcomp}"]
    for entry in entries:
        kind, width = ("figure*", "textwidth") if entry.is_wide else ("figure", "columnwidth")
        lines += [
            rf"\begin{{{kind}}}",
            r"  \centering",
            rf"  \includegraphics[width=\{width}]{{{entry.name}}}",
            rf"  \caption{{{tex(entry.caption)}}}",
            rf"  \label{{fig:{entry.name}}}",
            rf"\end{{{kind}}}",
        ]
    return "\n".join(lines) + "\n"
