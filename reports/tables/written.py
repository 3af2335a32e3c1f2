"""Tables in files: LaTeX with booktabs rules, and Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from reports.tables.notation import markdown, tex
from reports.tables.table import Table


def latex(table: Table, label: str) -> str:
    """Return the table in LaTeX, with its title as the caption."""
    lines = [
        "% needs \\usepackage{booktabs} and \\usepackage{textcomp}",
        r"\begin{table}",
        rf"  \caption{{{tex(table.title)}}}",
        rf"  \label{{tab:{label}}}",
        rf"  \begin{{tabular}}{{@{{}}{alignment(table)}@{{}}}}",
        r"    \toprule",
        f"    {_row(_heads(table), tex)}",
        r"    \midrule",
        *(f"    {_row((cell.text for cell in row), tex)}" for row in table.rows),
        r"    \bottomrule",
        r"  \end{tabular}",
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def in_markdown(table: Table) -> str:
    """Return the table in Markdown, below its title."""
    rules = ["---" if kind == "l" else "--:" for kind in alignment(table)]
    lines = [
        *([markdown(table.title)] if table.title else []),
        "",
        _bars(map(markdown, _heads(table))),
        _bars(rules),
        *(_bars(markdown(cell.text) for cell in row) for row in table.rows),
    ]
    return "\n".join(lines) + "\n"


def alignment(table: Table) -> str:
    """Return "l" for each text column and "r" for each numeric column."""
    columns = range(len(table.heads))
    numbers = [any(row[place].kind == "number" for row in table.rows) for place in columns]
    return "".join("r" if is_numeric else "l" for is_numeric in numbers)


def _heads(table: Table) -> list[str]:
    return [head.short or head.text for head in table.heads]


def _row(cells: Iterable[str], escaped: Callable[[str], str]) -> str:
    return " & ".join(escaped(cell) for cell in cells) + r" \\"


def _bars(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"
