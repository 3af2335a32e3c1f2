"""Graded mesh lines: cells that grow from one end, or are refined towards one."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray


def growing_lines(start: float, end: float, first: float, growth: float) -> NDArray[np.float64]:
    """Return lines from `start` to `end`, with a first cell near `first`, growing by `growth`.

    >>> growing_lines(0.0, 7.0, 1.0, 2.0)
    array([0., 1., 3., 7.])
    """
    count = max(1, round(np.log1p((end - start) * (growth - 1.0) / first) / np.log(growth)))
    lines = np.concatenate([[0.0], np.cumsum(growth ** np.arange(count))])
    return start + (end - start) * lines / lines[-1]


def edge_lines(reach: float, count: int, exponent: float) -> NDArray[np.float64]:
    """Return lines from 0 to `reach` with cells refined towards 0 and growing beyond 1.

    The cell size at t is proportional to ``t^exponent (1 + t)^(1 - exponent)``: the first power
    suits a field with a root or a singularity at 0, the second a field that decays with 1 + t.

    >>> np.round(edge_lines(3.0, 4, 0.5), 3)
    array([0.   , 0.112, 0.5  , 1.337, 3.   ])
    """
    # t = reach s^(1/(1 - exponent)) makes the integral of 1/size smooth
    s = np.linspace(0.0, 1.0, 4001)
    t = reach * s ** (1.0 / (1.0 - exponent))
    number = scipy.integrate.cumulative_simpson((1.0 + t) ** (exponent - 1.0), x=s, initial=0.0)
    place = np.interp(np.linspace(0.0, number[-1], count + 1), number, s)
    return reach * place ** (1.0 / (1.0 - exponent))


def graded_lines(start: float, end: float, count: int, exponent: float) -> NDArray[np.float64]:
    """Return lines from `start` to `end`, refined towards `end`.

    The distance to `end` is proportional to ``(j/count)^(1/(1 - exponent))``; exponent 0 is
    uniform.
    """
    return end - (end - start) * np.linspace(1.0, 0.0, count + 1) ** (1.0 / (1.0 - exponent))


def power_lines(cells: int, exponent: float, end: float) -> NDArray[np.float64]:
    """Return lines from 0 to `end` at t^exponent (1 + t)^2 with t = j/cells, but for a factor.

    >>> power_lines(2, 1.0, 4.0).round(3).tolist()
    [0.0, 1.125, 4.0]
    """
    t = np.arange(64 * cells) / cells
    grown = t**exponent * (1 + t) ** 2
    last = int(np.searchsorted(grown, end))
    return grown[: last + 1] * (end / grown[last])


def contact_lines(
    smallest: float, largest: float, per_radius: int, fine: float, *, growth: float, outer: float
) -> NDArray[np.float64]:
    """Return lines from 0 to `outer` times the largest of several contact radii.

    Cells have 1/per_radius of the smallest contact radius up to that, then of their own distance up
    to `fine` times the largest one, and grow by a factor from there.

    >>> contact_lines(1.0, 1.0, 2, 1.0, growth=1.4, outer=15.0)[:4].round(2)
    array([0. , 0.5, 1. , 1.7])
    """
    lines = [0.0]
    while lines[-1] < outer * largest:
        step = max(smallest, lines[-1]) / per_radius
        if len(lines) > 1 and lines[-1] >= fine * largest * (1 - 1e-9):
            step = (lines[-1] - lines[-2]) * growth
        lines.append(lines[-1] + step)
    return np.array(lines)


def even_then_growing_lines(
    element: float, fine: float, far: float, growth: float
) -> NDArray[np.float64]:
    """Return lines from 0 beyond `far`: cells of one length up to `fine`, then growing.

    >>> even_then_growing_lines(0.5, 1.0, 3.0, 1.6).round(2)
    array([0.  , 0.5 , 1.  , 1.8 , 3.08])
    """
    at = list(np.arange(0, int(np.ceil(fine / element - 1e-9)) + 1) * element)
    while at[-1] < far:
        at.append(at[-1] + growth * (at[-1] - at[-2]))
    return np.array(at)
