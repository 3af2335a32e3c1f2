"""Load lists and discrete laws, shared by the solvers."""

from __future__ import annotations

import numpy as np

EDGES = ("sub_cell", "nodal")
"""Contacts that end inside a cell, and the chapter's sums over whole springs."""


def one_load_list(**given: object) -> tuple[str, np.ndarray]:
    """Name and values of the only load list that was given.

    Parameters
    ----------
    **given : array_like or None
        Candidates by name; exactly one is not None.

    Returns
    -------
    tuple of str and ndarray, shape (k,)

    Raises
    ------
    ValueError
        If not exactly one list is given, or it is not 1-D, finite, positive, strictly increasing.

    Examples
    --------
    >>> one_load_list(force=[1, 2], penetration=None)
    ('force', array([1., 2.]))
    """
    chosen = {name: values for name, values in given.items() if values is not None}
    if len(chosen) != 1:
        names = ", ".join(given)
        raise ValueError(f"give exactly one of {names}; got {', '.join(chosen) or 'none'}")
    ((name, values),) = chosen.items()
    loads = np.array(values, dtype=float, ndmin=1)
    if loads.ndim != 1 or loads.size == 0:
        raise ValueError(f"{name} must be a non-empty 1-D list, got shape {loads.shape}")
    increasing = bool(np.all(np.diff(loads) > 0))
    if not (np.all(np.isfinite(loads)) and loads[0] > 0 and increasing):
        raise ValueError(f"{name} must be finite, positive and strictly increasing, got {values!r}")
    return name, loads
