"""Numbers with error bars in print notation, in Unicode and LaTeX.

The bar is rounded to two significant digits, the value to the same place: (1.23 ± 0.14) %.
"""

from __future__ import annotations

import math
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


def error_with_bar(error: object, bar: object) -> str:
    """Return a relative error with the 95 % half-width of its bar.

    Examples
    --------
    >>> error_with_bar(-0.21457, 0.00013), error_with_bar(0.0123, 0.0142)
    ('(−21.457 ± 0.013)\u202f%', '(1.2 ± 1.4)\u202f%')
    >>> error_with_bar(3e-5, 4e-6), error_with_bar(0.94, 0.18)
    ('(30.0 ± 4.0)\u202fppm', '(94 ± 18)\u202f%')
    >>> error_with_bar(-0.2146, 1e-12), error_with_bar(0.02, None), error_with_bar(1e-15, 1e-12)
    ('−21.5\u202f%', '2.00\u202f% (bar unknown)', '< 10⁻⁹')
    """
    if not fmt.finite(error):
        return fmt.MISSING
    value = float(error)
    if not fmt.finite(bar):
        return f"{fmt.relative(value, 3)} (bar unknown)"
    half = abs(float(bar))
    largest = max(abs(value), half)
    if largest < fmt.ROUND_OFF:
        return "< 10⁻⁹"
    if half < 1e-4 * abs(value):
        return fmt.relative(value, 3)  # the bar is far below what three digits show
    factor, unit = _unit(largest)
    decimals = max(0, 1 - _exponent(half * factor))
    texts = [f"{number * factor:.{decimals}f}".replace("-", fmt.MINUS) for number in (value, half)]
    return f"({texts[0]} ± {texts[1]}){unit}"


def _unit(largest: float) -> tuple[float, str]:
    """Return factor and unit: per cent, ppm, or a power of ten for smaller values."""
    if largest >= 1e-4:
        return 100.0, f"{THIN}%"
    if largest >= 1e-8:
        return 1e6, f"{THIN}ppm"
    return 1e9, "×10⁻⁹"


def _exponent(value: float) -> int:
    """Return the power of ten of the leading digit, after rounding to two digits."""
    return int(f"{value:.1e}".partition("e")[2]) if value > 0 and math.isfinite(value) else 0


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
