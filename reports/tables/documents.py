"""Generated tables in the documentation: Markdown between markers, rewritten by scripts."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from pathlib import Path

Rows = Sequence[Sequence[str]]


def markdown(rows: Rows) -> str:
    """Return rows, the header first, as a Markdown table; cells are already Markdown.

    >>> print(markdown([["N", "error"], ["4", "1 %"]]))
    | N | error |
    |---|---|
    | 4 | 1 % |
    """
    head, *body = (f"| {' | '.join(row)} |" for row in rows)
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
        block = re.compile(f"(<!-- table: {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        table = markdown(make())
        if block.search(text):
            text = block.sub(partial(_with_table, table), text)
        else:
            sys.stdout.write(f"{name}\n\n{table}\n\n")
    page.write_text(text, encoding="utf-8")


def _with_table(table: str, markers: re.Match[str]) -> str:
    return f"{markers[1]}{table}\n{markers[2]}"
