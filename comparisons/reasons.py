"""Why something has no answer, as one line that a reader takes in."""

from __future__ import annotations

import re

_NUMBER = r"[-+]?(?:\d[\d.]*(?:e[-+]?\d+)?|nan|inf)"
# Lists as Python or NumPy write them, with commas or without; rows of a matrix one by one.
_LONG_LIST = re.compile(rf"\[\s*({_NUMBER})((?:[,\s]+(?:{_NUMBER}|\.\.\.)){{4,}})[,\s]*\]", re.I)


def one_line(text: str) -> str:
    r"""Return a message on one line, its lists of more than four numbers by their ends.

    Examples
    --------
    >>> one_line("not array([0.   , 0.125, 0.25 , 0.375, 0.5  ,\n       0.625]) (in _checked)")
    'not array([0., ..., 0.625] (6 numbers)) (in _checked)'
    >>> one_line("expected [1, 2, 3]")
    'expected [1, 2, 3]'
    """

    def ends(match: re.Match[str]) -> str:
        numbers = re.split(r"[,\s]+", match[2].strip(", \n"))
        count = "" if "..." in numbers else f" ({len(numbers) + 1} numbers)"
        return f"[{match[1]}, ..., {numbers[-1]}]{count}"

    return _LONG_LIST.sub(ends, " ".join(text.split()))
