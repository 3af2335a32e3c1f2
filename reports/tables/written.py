"""Tables written: data frames, LaTeX with booktabs rules, Markdown, and on a terminal with rich.

Tables that scripts generate stand in the pages of the documentation between markers.
"""

from __future__ import annotations

import re
import shutil
import sys
import textwrap
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from rich import table as rich
from rich.console import Console

from comparisons import formatting as fmt
from reports.tables.cells import Table

if TYPE_CHECKING:
    import pandas as pd

Rows = Sequence[Sequence[str]]
_SPECIAL = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "_": r"\_",
    "%": r"\%",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    fmt.THIN: r"\,",
    "\u00a0": "~",
    "\N{PLUS-MINUS SIGN}": r"$\pm$",
    "\N{MINUS SIGN}": r"$-$",
    "\N{MULTIPLICATION SIGN}": r"$\times$",
    "\N{SQUARE ROOT}": r"$\surd$",
    "µ": r"\textmu{}",
    "π": r"$\pi$",
    "σ": r"$\sigma$",
    "τ": r"$\tau$",
    "ū": r"$\bar{u}$",
    "₀": "$_0$",
    "–": "--",
}
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
# Powers, magnitudes, and symbols with an index, which LaTeX sets in math mode.
_MATH = re.compile(r"([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)|\|(\w)\||(?<!\w)([A-Za-zστ])_([A-Za-z0-9τ]+)(?!\w)")
_HEAD = 12  # characters of a line of a head


def frame(table: Table) -> pd.DataFrame:
    """Return a data frame of sort keys, a row per table row; numbers stay numeric."""
    import pandas as pd  # a list on a terminal does without

    columns = [head.csv or head.text for head in table.heads]
    rows = [[cell.key if cell.key != "" else cell.text for cell in row] for row in table.rows]
    return pd.DataFrame(rows, columns=columns)


def latex(table: Table, label: str) -> str:
    """Return the table in LaTeX, with its title as the caption, as wide as a page at most."""
    columns = alignment(table)
    heads = (
        rf"\begin{{tabular}}[b]{{@{{}}{side}@{{}}}}{_stacked(text)}\end{{tabular}}"
        for side, text in zip(columns, _heads(table), strict=True)
    )
    lines = [
        "% needs \\usepackage{booktabs}, \\usepackage{graphicx} and \\usepackage{textcomp}",
        r"\begin{table*}",
        r"  \centering\footnotesize",
        rf"  \caption{{{tex(table.title)}}}",
        rf"  \label{{tab:{label}}}",
        r"  \resizebox{\ifdim\width>\textwidth\textwidth\else\width\fi}{!}{%",
        rf"  \begin{{tabular}}{{@{{}}{columns}@{{}}}}",
        r"    \toprule",
        f"    {' & '.join(heads)} \\\\",
        r"    \midrule",
        *(f"    {' & '.join(tex(cell.text) for cell in row)} \\\\" for row in table.rows),
        r"    \bottomrule",
        r"  \end{tabular}}",
        r"\end{table*}",
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


def _stacked(head: str) -> str:
    """Return the lines of a head in LaTeX; a unit stays with its symbol."""
    words = head.replace(" / ", "\u00a0/\u00a0")
    return r"\\".join(map(tex, textwrap.wrap(words, _HEAD, break_long_words=False)))


def _heads(table: Table) -> list[str]:
    return [head.short or head.text for head in table.heads]


def _bars(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"


def tex(text: str) -> str:
    r"""Return report text as LaTeX: special characters escaped, numbers in math mode.

    >>> print(tex("(−1.2 ± 0.1)\u202f%"), tex("3×10⁻⁹"), tex("bem_fft & c\\d"))
    ($-$1.2 $\pm$ 0.1)\,\% 3$\times$10$^{-9}$ bem\_fft \& c\textbackslash{}d
    >>> print(tex("|e| of σ_v / GPa"))
    $|e|$ of $\sigma_{\mathrm{v}}$ / GPa
    """
    pieces, end = [], 0
    for math in _MATH.finditer(text):
        power, size, symbol, index = math.groups()
        if power:
            formula = f"^{{{power.translate(_SUPERSCRIPTS)}}}"
        elif size:
            formula = f"|{size}|"
        else:
            formula = rf"{symbol}_{{\mathrm{{{index}}}}}".replace("σ", r"\sigma")
            formula = formula.replace("τ", r"\tau")
        pieces += [_escaped(text[end : math.start()]), f"${formula}$"]
        end = math.end()
    return "".join([*pieces, _escaped(text[end:])])


def _escaped(text: str) -> str:
    printable = "".join(c if c.isprintable() or c in _SPECIAL else " " for c in text)
    return "".join(_SPECIAL.get(c, c) for c in printable)


def markdown(text: str) -> str:
    r"""Return text as a cell of a Markdown table, with all markup escaped.

    >>> markdown("a|b <i> *c*")
    'a\\|b &lt;i&gt; \\*c\\*'
    """
    line = " ".join(text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").split(" "))
    return re.sub(
        r"([\\|*_`\[\]])",
        r"\\\1",
        "".join(c if c.isprintable() or c == fmt.THIN else " " for c in line),
    )


def markdown_rows(rows: Rows) -> str:
    """Return rows, the header first, as a Markdown table; cells are already Markdown.

    >>> print(markdown_rows([["N", "error"], ["4", "1 %"]]))
    | N | error |
    |---|---|
    | 4 | 1 % |
    """
    head, *body = map(_bars, rows)
    return "\n".join([head, "|" + "---|" * len(rows[0]), *body])


def rewrite(
    page: Path, tables: Mapping[str, Callable[[], Rows]], names: Collection[str] = ()
) -> None:
    """Rewrite tables of a page between their markers, and print those that it does not show.

    All tables, or only those with these names.
    """
    text = page.read_text(encoding="utf-8")
    for name, make in tables.items():
        if names and name not in names:
            continue
        table = markdown_rows(make())
        before, marker, after = text.partition(f"<!-- table: {name} -->\n")
        if marker:
            text = f"{before}{marker}{table}\n{after[after.index('<!-- end -->') :]}"
        else:
            sys.stdout.write(f"{name}\n\n{table}\n\n")
    page.write_text(text, encoding="utf-8")


SHORT = 22  # characters: cells that are not folded, so that long texts give way and no word breaks
LONG_SHARE = 20  # columns left for each column of longer cells


def drawn(table: Table, *, unfolded: bool = False, tight: bool = False) -> rich.Table:
    """Return a table without rules; long cells are wrapped, the first column unless `unfolded`.

    Columns of short cells keep their width, where the terminal has room for them all: the texts
    beside them wrap, between words. A `tight` table has one space between columns. The console that
    prints it has no markup.
    """
    result = rich.Table(
        title=table.title, title_justify="left", box=None, pad_edge=False, collapse_padding=tight
    )
    # which columns are not folded: those of short cells, if all of them have room
    widths = [
        max(len(head.text), *(len(row[place].text) for row in table.rows))
        for place, head in enumerate(table.heads)
        if table.rows
    ] or [0] * len(table.heads)
    short = [width <= SHORT for width in widths]
    needed = sum(w if fits else LONG_SHARE for w, fits in zip(widths, short, strict=True))
    room = shutil.get_terminal_size().columns - (1 if tight else 2) * (len(widths) - 1)
    kept = short if needed <= room else [False] * len(widths)
    for head, keep in zip(table.heads, kept, strict=True):
        result.add_column(head.text, overflow="fold", no_wrap=keep)
    if unfolded:
        result.columns[0].no_wrap = True
    for place, row in enumerate(table.rows):
        style = "bold" if place in table.strong else None
        result.add_row(*(cell.text for cell in row), style=style)
    return result


def plain(table: Table) -> str:
    """Return a table as text."""
    console = Console(width=100, file=StringIO(), emoji=False, markup=False, color_system=None)
    with console.capture() as told:
        console.print(drawn(table, tight=True))
    return told.get().rstrip()
