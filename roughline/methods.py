"""Methods: what is built in, and yours beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from comparisons.methods.registry import add_class
from comparisons.methods.solver import Solver
from comparisons.methods.user.external import add_methods, user_methods
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


def add_method(method: type[Solver[Any]] | str | Path) -> list[str]:
    """Add a method of yours, to be judged like the built-in ones; return the names added.

    Parameters
    ----------
    method : class, str or Path
        What the decorator `method` made of a function, or a class derived from
        ``comparisons.methods.Solver``: known in this process only. Or a Python file with methods:
        each call then runs in a process of its own with limits on time and memory, and worker
        processes of a `Study` know it, too.

    Raises
    ------
    InputError
        If the file or the class is no method, or the name is taken by a method of roughline's own.

    Notes
    -----
    A method from outside never becomes the truth, whatever its dimension.
    """
    if not isinstance(method, (str, Path)):
        return [add_class(method)]
    add_methods([method])
    source = f"file:{Path(method).resolve()}"
    return [method.name for method in user_methods() if method.origin.source == source]
