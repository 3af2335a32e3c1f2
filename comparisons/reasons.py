"""Why something has no answer, as one line that a reader takes in."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from typing import Any

import numpy as np

# First word of notes that ask the reader to check something.
CHECK = "check the "
STEEP = f"{CHECK}slopes"  # too steep for every method: that they agree says nothing
# Of notes on a premise of all methods that a scene strains.
STRAINED, THICKENED = "small strains: ", "constant viscosity: "
UNJUDGED = "not computed by the reference"  # first words of why a quantity has no error
_NUMBER = r"[-+]?(?:\d[\d.]*(?:e[-+]?\d+)?|nan|inf)"
# Lists as Python or NumPy write them, with commas or without; rows of a matrix one by one.
_LONG_LIST = re.compile(rf"\[\s*({_NUMBER})((?:[,\s]+(?:{_NUMBER}|\.\.\.)){{4,}})[,\s]*\]", re.I)


# Words of everyday that are far from ours in letters.
_MEANT = {"ball": ("sphere", "paraboloid"), "diameter": ("radius",)}


def near(name: str, known: Iterable[str]) -> str:
    """Return the end of a message on a name that nobody knows: what was meant, perhaps.

    >>> near("parabolid", ["paraboloid", "cone"]), near("ball", ["rolling-ball", "cone"])
    ('; did you mean paraboloid?', '; did you mean rolling-ball?')
    >>> near("diameter", ["radius", "shape"]), near("nothere", ["sphere", "cone"])
    ('; did you mean radius, half of it?', '')
    """
    names = {entry.lower(): entry for entry in known}
    wanted = name.lower()
    close = [entry for entry in _MEANT.get(wanted, ()) if entry in names]
    close += difflib.get_close_matches(wanted, names, n=3, cutoff=0.7)
    close += [entry for entry in names if len(wanted) > 2 and wanted in entry]
    meant = [names[entry] for entry in dict.fromkeys(close)][:3]
    of_it = ", half of it" if wanted == "diameter" and meant else ""
    return f"; did you mean {' or '.join(meant)}{of_it}?" if meant else ""


def in_kind(value: Any) -> str:
    """Return what a value is, for a message that expected something else.

    >>> in_kind(np.ones((3, 4))), in_kind(np.ones(7) * 1j), in_kind(None)
    ('an array of shape (3, 4)', 'an array of shape (7,) of complex128', 'None')
    >>> in_kind([1.0, 2.0]), in_kind({}), in_kind(1j), in_kind("abc")
    ('a list of 2', 'an empty dict', 'a complex', 'a str')
    """
    if isinstance(value, np.ndarray):
        odd = "" if value.dtype.kind in "biuf" else f" of {value.dtype}"
        return f"an array of shape {value.shape}{odd}"
    if value is None:
        return "None"
    kind = type(value).__name__
    if isinstance(value, (list, tuple, dict)):
        return f"a {kind} of {len(value)}" if value else f"an empty {kind}"
    return f"a {kind}"


def one_line(text: str) -> str:
    r"""Return a message on one line, its lists of more than four numbers by their ends.

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
