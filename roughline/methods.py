"""Methods: what is built in, and yours beside them."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from comparisons.methods import METHODS, Method
from comparisons.methods.user.external import ExternalMethod, add_methods
from comparisons.methods.user.session import add_to_session
from reports.tables import lists
from reports.tables.frames import frame


def list_methods() -> pd.DataFrame:
    """Return all methods: title, and whether they solve a line or the 3-D contact.

    Examples
    --------
    >>> list_methods().loc["reduced", "solves"]
    'a line'
    """
    return frame(lists.methods()).set_index("name")


def add_method(method: Method | str | Path) -> list[str]:
    """Add a method of yours, to be judged like the built-in ones; return the names added.

    Parameters
    ----------
    method : Method, str or Path
        What the decorator `method` made of a function, or an object of a class derived from
        ``comparisons.methods.Method``: known in this process only. Or a Python file with methods:
        each call then runs in a process of its own with limits on time and memory, and worker
        processes of a `Study` know it, too.

    Raises
    ------
    InputError
        If the file is no method, or the name is taken by a method of roughline's own.

    Notes
    -----
    A method from outside never becomes the truth, whatever its dimension.
    """
    if isinstance(method, Method):
        return [add_to_session(method)]
    add_methods([method])
    source = f"file:{Path(method).resolve()}"
    outside = [each for each in METHODS.values() if isinstance(each, ExternalMethod)]
    return [each.name for each in outside if each.origin.source == source]
