"""Display of results in notebooks: short tables with escaped text.

Colours have their own background, so that they are readable on light and dark pages, and always
accompany a word.
"""

from __future__ import annotations

from markupsafe import Markup

from reports.tables.cells import Table, tone

_OPEN, _NONE = ("#5c5300", "#f6f0c4"), ("#444444", "#e9eaec")
_COLOURS = {
    "within": ("#00624a", "#dff2ea"),
    "outside": ("#9c3a00", "#fde6d8"),
    "not-resolved": _OPEN,
    "partly": _OPEN,
}


def badge(word: str) -> Markup:
    """Return a verdict word in the colour of its tone; other words are grey.

    >>> print(badge("<within>"))
    <span style="color:#444444;background:#e9eaec;...">&lt;within&gt;</span>
    """
    ink, ground = _COLOURS.get(tone(word), _NONE)
    style = f"color:{ink};background:{ground};padding:0 .4em;border-radius:3px;font-weight:600"
    return Markup('<span style="{};white-space:nowrap">{}</span>').format(style, word)


def table(drawn: Table) -> Markup:
    """Return a table with left-aligned text, coloured verdicts and all text escaped."""
    tag = Markup('<t{0} style="text-align:left;padding:.15em .6em">{1}</t{0}>')
    head = Markup("").join(tag.format("h", cell.text) for cell in drawn.heads)
    body = Markup("")
    for row in drawn.rows:
        texts = (Markup(" ").join(map(badge, c.badges)) if c.badges else c.text for c in row)
        cells = Markup("").join(tag.format("d", text) for text in texts)
        body += Markup("<tr>{}</tr>").format(cells)
    return Markup("<table><thead><tr>{}</tr></thead><tbody>{}</tbody></table>").format(head, body)


def block(heading: str, *parts: object) -> str:
    """Return a heading with paragraphs and tables below it."""
    paragraph = Markup('<p style="max-width:75ch;margin:.3em 0">{}</p>')
    body = (part if isinstance(part, Markup) else paragraph.format(part) for part in parts if part)
    start = Markup("<div><p><strong>{}</strong></p>").format(heading)
    return str(start + Markup("").join(body) + Markup("</div>"))


def more(count: int, noun: str) -> str:
    """Return a note on the rows omitted from a short table."""
    return "" if count <= 0 else f"... and {count} more {noun}: .table() has all of them"
