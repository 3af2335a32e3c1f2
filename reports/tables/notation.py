"""Texts of the report in LaTeX and Markdown."""

from __future__ import annotations

import re

from comparisons import formatting as fmt

THIN = fmt.THIN
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
    THIN: r"\,",
    "\u00a0": "~",
    "\N{PLUS-MINUS SIGN}": r"$\pm$",
    "\N{MINUS SIGN}": r"$-$",
    "\N{MULTIPLICATION SIGN}": r"$\times$",
    "\N{SQUARE ROOT}": r"$\surd$",
    "µ": r"\textmu{}",
    "π": r"$\pi$",
    "–": "--",
}
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_POWER = re.compile("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")


def tex(text: str) -> str:
    r"""Return report text as LaTeX: special characters escaped, numbers in math mode.

    Examples
    --------
    >>> print(tex("(−1.2 ± 0.1)\u202f%"), tex("3×10⁻⁹"), tex("a_b & c\\d"))
    ($-$1.2 $\pm$ 0.1)\,\% 3$\times$10$^{-9}$ a\_b \& c\textbackslash{}d
    """
    pieces, end = [], 0
    for power in _POWER.finditer(text):
        pieces += [_escaped(text[end : power.start()]), _power(power[0])]
        end = power.end()
    return "".join([*pieces, _escaped(text[end:])])


def _escaped(text: str) -> str:
    printable = "".join(c if c.isprintable() or c in _SPECIAL else " " for c in text)
    return "".join(_SPECIAL.get(c, c) for c in printable)


def _power(text: str) -> str:
    return f"$^{{{text.translate(_SUPERSCRIPTS)}}}$"


def markdown(text: str) -> str:
    r"""Return text as a cell of a Markdown table, with all markup escaped.

    Examples
    --------
    >>> markdown("a|b <i> *c*")
    'a\\|b &lt;i&gt; \\*c\\*'
    """
    line = " ".join(text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").split(" "))
    return re.sub(
        r"([\\|*_`\[\]])",
        r"\\\1",
        "".join(c if c.isprintable() or c == THIN else " " for c in line),
    )
