"""Built-in and user-supplied methods."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from comparisons.methods.registry import add_class
from comparisons.methods.solver import Solver
from comparisons.methods.user.external import add_methods, names_in
from reports.tables import lists
from reports.tables.written import frame


def list_methods() -> pd.DataFrame:
    """Return all methods with their titles, and whether they solve a line or the 3-D contact.

    Examples
    --------
    >>> list_methods().loc["reduced", "solves"]
    'a line'
    """
    return frame(lists.methods()).set_index("name")


def add_method(method: type[Solver[Any]] | str | Path) -> list[str]:
    """Add your own method, to be tested like the built-in ones; return the names added.

    Parameters
    ----------
    method : class, str or Path
        The result of the decorator `method`, or a class derived from
        ``comparisons.methods.Solver``, known in this process only. Or a Python file with methods:
        each call then runs in a separate process with limits on time and memory, and is also
        available to the worker processes of a `Study`.

    Raises
    ------
    InputError
        If the file or class does not define a method, or a built-in method has the same name.

    Notes
    -----
    A user-supplied method never serves as the reference, whatever its dimension.
    """
    if not isinstance(method, (str, Path)):
        return [add_class(method)]
    add_methods([method])
    return names_in(method)
