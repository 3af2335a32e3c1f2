"""Pivoting between contact sets: pressures and clearances that exclude each other, exactly.

Find p >= 0 with clearance c = A p + g - d >= 0 and p c = 0, where A gives the displacement of an
elastic body under pressures at its points, g is the gap and d the depth. On a given contact set
c = 0 are linear equations; points of it in tension leave, free points that overlap join.

All wrong points change at once (primal-dual active set: M. Hintermueller, K. Ito & K. Kunisch, SIAM
J. Optim. 13 (2002) 865), which takes few rounds but may cycle. If a contact set recurs, or blocks
stop to reduce the number of wrong points, the last wrong point alone changes from then on (K. G.
Murty, 1974): finite if A is a P-matrix, as every positive definite matrix is, symmetric or not
(J. J. Judice & F. M. Pires, Comput. Oper. Res. 21 (1994) 587).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve

from reference.errors import ConvergenceError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Respond = Callable[[NDArray[np.intp], Array], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class Pivoted:
    """The contact of n points.

    Attributes
    ----------
    depth : float
    pressures, displacement : (n,)
        p >= 0 and A p.
    active : (n,) bool
        The contact set.
    slope : float
        Increase of sum p with the depth on this contact set.
    history : list of int
        Number of wrong points by round.
    """

    depth: float
    pressures: Array
    displacement: Array
    active: Mask
    slope: float
    history: list[int]


def pivot(
    respond: Respond,
    gap: Array,
    active: Mask,
    value: float,
    *,
    per_depth: float = 1.0,
    per_pressure: float = 0.0,
    changes: Callable[[Mask, Mask], Mask] = np.logical_or,
    patience: float = 10,
    rounding: float = 1e-13,
    max_rounds: int = 1000,
) -> Pivoted:
    """Return the contact at a prescribed depth, force, or combination of both.

    ``per_depth d + per_pressure sum p = value`` closes the equations: by default a depth is given;
    with (0, cell area) a force. On a fixed contact set the pressures are linear in d,
    p = d p_1 - p_g with A p_1 = 1 and A p_g = g.

    Parameters
    ----------
    respond : callable
        ``respond(inside, right)`` solves A x = right (k, 2) on the points `inside` (k,), and
        returns x (k, 2) and the displacements A x of all points (n, 2).
    gap : (n,)
        +inf where contact is impossible.
    active : (n,) bool
        The contact set to start from.
    changes : callable
        Which of the points in tension and of those that overlap change in a block; by default all.
    patience : float
        Blocks that may fail to lower the number of wrong points before single points change; 10 as
        in Judice & Pires.
    rounding : float
        Tension and overlap below this fraction of the largest terms of pressure and displacement
        are rounding: 1e-13 suits the well-conditioned bodies below grids and elements.
    max_rounds : int
        Limit of contact sets; where single points change, of ten more for each point.

    Raises
    ------
    ConvergenceError
        If no contact set is right in `max_rounds`, or the numbers overflow; the history has the
        number of wrong points by round.

    Examples
    --------
    Two springs of compliance 1 that do not feel each other, with gaps 0 and 3:

    >>> import numpy as np
    >>> both = pivot(compliance(np.eye(2)), np.array([0.0, 3.0]), np.ones(2, bool), 5.0)
    >>> both.pressures, both.history
    (array([5., 2.]), [0])
    >>> one = pivot(compliance(np.eye(2)), np.array([0.0, 3.0]), np.ones(2, bool), 2.0)
    >>> one.pressures, one.history
    (array([2., 0.]), [1, 0])
    """
    active = active.copy()
    history: list[int] = []
    visited: set[bytes] = set()
    fewest, patient, singly, depth = gap.size + 1, patience, False, np.nan
    while len(history) < max_rounds + (10 * gap.size if singly else 0):
        if per_pressure and not active.any():  # something carries the force
            active[np.argmin(gap)] = True
        inside = np.flatnonzero(active)
        right = np.stack([np.ones(inside.size), gap[inside]], axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            response = respond(inside, right) if inside.size else (right, np.zeros((gap.size, 2)))
            (unit, shape), displaced = (part.T for part in response)
            slope = float(unit.sum())
            balance = (value + per_pressure * shape.sum()) / (per_pressure * slope + per_depth)
            if not singly:
                depth = float(balance)
            pressures = np.zeros(gap.size)
            pressures[inside] = depth * unit - shape
            displacement = depth * displaced[0] - displaced[1]
        if not (np.isfinite(pressures.sum()) and np.isfinite(displacement).all()):
            raise ConvergenceError(f"pressures overflow at depth {depth:.6g}", history)
        terms = np.abs(depth * unit) + np.abs(shape)
        tension = pressures < -rounding * terms.max(initial=0.0)
        terms = np.abs(depth * displaced[0]) + np.abs(displaced[1])
        overlap = ~active & (displacement + gap - depth < -rounding * terms.max())
        count = int(np.count_nonzero(tension | overlap))
        history.append(count)
        if count == 0:
            if not singly or abs(balance - depth) <= rounding * abs(depth):
                pressures = np.maximum(pressures, 0.0)
                return Pivoted(depth, pressures, displacement, active, slope, history)
            depth = float(balance)  # Newton: the total is convex and piecewise linear in the depth
            continue
        if not singly:
            patient = patience if count < fewest else patient - 1
            fewest = min(fewest, count)
            key = np.packbits(active).tobytes()
            singly = patient < 0 or key in visited
            visited.add(key)
        if singly:  # Murty: the last wrong point only, at this depth
            active[np.flatnonzero(tension | overlap)[-1]] ^= True
        else:
            active ^= changes(tension, overlap)
    raise ConvergenceError(f"contact set not found in {len(history)} rounds", history)


def compliance(matrix: Array) -> Respond:
    """Return the response of a body by its matrix (n, n), which need not be symmetric."""

    def respond(inside: NDArray[np.intp], right: Array) -> tuple[Array, Array]:
        factor = lu_factor(matrix[np.ix_(inside, inside)], check_finite=False)
        solved = lu_solve(factor, right, check_finite=False)
        return solved, matrix[:, inside] @ solved

    return respond
