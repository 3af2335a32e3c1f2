"""Tables for papers: verdicts of all scenes, and cost and errors of every setting of one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from comparisons import formatting as fmt
from comparisons.judging.truth import OTHER_AXIS
from comparisons.judging.verdicts import NO_RESULT
from comparisons.results import selection
from comparisons.results.advice import advise
from comparisons.results.decisions import Verdict, equal_at, verdicts
from comparisons.results.store import SceneRecord, StudyRecord
from reports.paper.notation import error_with_bar, file_name, markdown, tex
from reports.plots.style import look


@dataclass(frozen=True)
class PaperTable:
    """A table as texts: `kinds` says "l" for words and "r" for numbers."""

    label: str
    caption: str
    heads: tuple[str, ...]
    kinds: str
    rows: tuple[tuple[str, ...], ...]

    def latex(self) -> str:
        """Return the table in LaTeX, with the rules of booktabs."""
        lines = [
            "% needs \\usepackage{booktabs} and \\usepackage{textcomp}",
            r"\begin{table}",
            rf"  \caption{{{tex(self.caption)}}}",
            rf"  \label{{tab:{self.label}}}",
            rf"  \begin{{tabular}}{{@{{}}{self.kinds}@{{}}}}",
            r"    \toprule",
            f"    {_row(self.heads, tex)}",
            r"    \midrule",
            *(f"    {_row(row, tex)}" for row in self.rows),
            r"    \bottomrule",
            r"  \end{tabular}",
            r"\end{table}",
        ]
        return "\n".join(lines) + "\n"

    def markdown(self) -> str:
        """Return the table in Markdown."""
        rules = ["---" if kind == "l" else "--:" for kind in self.kinds]
        lines = [
            markdown(self.caption),
            "",
            _bars([markdown(each) for each in self.heads]),
            _bars(rules),
            *(_bars([markdown(cell) for cell in row]) for row in self.rows),
        ]
        return "\n".join(lines) + "\n"


def _row(cells: Sequence[str], escaped: Callable[[str], str]) -> str:
    return " & ".join(escaped(cell) for cell in cells) + r" \\"


def _bars(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def verdict_table(study: StudyRecord) -> PaperTable:
    """Return the reduced model's verdicts, and the cheapest setting that is sure to be within."""
    rows: list[tuple[str, ...]] = []
    for scene in study.scenes:
        found = verdicts(scene)
        cheapest = advise(scene).cheapest
        best = "" if cheapest is None else cheapest.text
        for index, each in enumerate(found):
            sides = (scene.name, best) if index == 0 else ("", "")
            rows.append((sides[0], *_judged(each), sides[1]))
    caption = (
        "Largest relative error of the reduced model over all load steps at the prescribed load "
        "(what is prescribed itself: at the other), with the 95 % half-width of its bar; verdict "
        "at the tolerance asked for; the cheapest setting that was run and is sure to be within "
        "it, with its measured time."
    )
    heads = ("scene", "quantity", "error", "verdict", "cheapest")
    return PaperTable("verdicts", caption, heads, "llrll", tuple(rows))


def _judged(verdict: Verdict) -> tuple[str, str, str]:
    words = fmt.quantity(verdict.quantity).words
    if verdict.word == NO_RESULT:
        return words, fmt.MISSING, NO_RESULT
    error = error_with_bar(verdict.error, verdict.uncertainty)
    return words, error, f"{verdict.word} {fmt.tolerance(verdict.tolerance)}"


def setting_table(scene: SceneRecord) -> PaperTable:
    """Return cost and largest errors of every method and resolution of a scene."""
    asked = selection.compared_measures(scene)["quantity"]
    names = [str(name) for name in dict.fromkeys(asked)]
    rows = [
        (
            look(method).label,
            fmt.count(level),
            fmt.count(_first(scene, method, level, "unknowns")),
            fmt.duration(_first(scene, method, level, "seconds")),
            *(_error(scene, method, level, name) for name in names),
        )
        for method in selection.methods(scene)
        for level in selection.resolutions(scene, method)
    ]
    return PaperTable(
        file_name(scene.name, "settings"),
        f"{scene.title}: largest relative errors over all load steps{_held(scene)}, with the 95 % "
        "half-widths of their bars, and the cost of each setting on one thread. "
        f"{scene.reference.get('text', 'There is no reference.')}",
        ("method", "N", "unknowns", "time", *(fmt.quantity(name).words for name in names)),
        "lrrr" + "r" * len(names),
        tuple(rows),
    )


def _held(scene: SceneRecord) -> str:
    """Return at which equal loads the quantities of a table are compared."""
    held = f" at equal {fmt.quantity(scene.along).words}"
    if scene.along not in OTHER_AXIS or scene.along not in scene.quantities:
        return held
    other = fmt.quantity(OTHER_AXIS[scene.along]).words
    return f"{held} ({fmt.quantity(scene.along).words} itself at equal {other})"


def _first(scene: SceneRecord, method: str, level: float, name: str) -> float:
    values = selection.column(selection.curve(scene, method, level), name)
    known = values[np.isfinite(values)]
    return float(known[0]) if len(known) else float("nan")


def _error(scene: SceneRecord, method: str, level: float, name: str) -> str:
    if selection.is_reference(scene, method, level):
        return "truth"
    table = selection.compared_measures(scene, method)
    table = table[selection.column(table, "resolution") == level]
    table = table[table["quantity"] == name]
    at = np.array(selection.words(table, "at"))
    main = at == equal_at(scene, name)
    row = table[main] if main.any() else table
    if not len(row):
        return fmt.MISSING
    return error_with_bar(*(selection.column(row, key)[0] for key in ("maximum", "uncertainty")))
