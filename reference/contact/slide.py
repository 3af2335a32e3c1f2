"""Tangential tractions within friction bounds: stick, slip and its direction, by Newton's method.

Coulomb's law on points with given bounds b = mu p, where s = w - A q is the slip that is left of a
displacement w by the tractions q (Duvaut & Lions 1976; Kalker 1990):

    stick  s = 0, |q| <= b;      slip  q = b s/|s|.

A point below its bound is free in both directions, one on its bound that slips outwards may turn
along the circle |q| = b only, which resists like a spring of |s|/b. Newton's method on these
freedoms is an active set that turns the direction of slip at the same time. Its linear equations
are solved to a tenth, by conjugate residuals (Eisenstat, Elman & Schultz 1983), so that A may be
unsymmetric (rolling) and is never stored; the new tractions are projected onto their bounds. A
prescribed total is one more equation, for the rigid displacement. There is no proof of
convergence; random problems by the thousand are solved (test_slide).
"""

from dataclasses import dataclass, field, replace
from math import frexp
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from reference.arrays import Array, Mask
from reference.errors import ConvergenceError

# Tractions this close to their bound count as on it.
ON_BOUND = 1 - 1e-12
# Precision of the linear equations of a round, and their largest number of products.
_FORCING, _PRODUCTS = 0.1, 30
# Rounds of whole steps; then half of each.
_WHOLE_STEPS = 30
# Rounds with a prescribed total before the rigid displacement is searched.
_PATIENCE = 60
_TINY = float(np.finfo(float).tiny)


class TangentialBody(Protocol):
    """An elastic body under tangential tractions (2, ...) on points: A, positive definite."""

    @property
    def own(self) -> float:
        """Displacement of a point by a unit traction on itself, roughly."""
        ...

    def shear(self, traction: Array) -> Array:
        """Return A q."""
        ...

    def near(self, slip: Array) -> Array:
        """Return the approximate solution q of A q = s; s/own will do."""
        ...


@dataclass
class Tractions:
    """Tractions that obey Coulomb's law."""

    # (2, ...): q, A q and s = w + U e_x - A q, the slip of loaded points only
    traction: Array
    displacement: Array
    slip: Array
    # loaded points on their bound, also after the next correction by their slip
    sliding: Mask
    shift: float  # U, the rigid displacement along x if a total is given, otherwise 0
    # largest difference between q and q + s/own projected onto its bound, over the largest
    # traction; with a total, the share of sum |q| by which it is missed, if larger
    error: float
    history: list[float] = field(default_factory=list, repr=False)  # errors of the rounds

    @property
    def rounds(self) -> int:
        """Number of rounds of Newton's method."""
        return len(self.history)


def slide(
    body: TangentialBody,
    bound: Array,
    target: Array,
    *,
    total: float | None = None,
    start: Array | None = None,
    tolerance: float = 1e-9,
    max_rounds: int = 200,
) -> Tractions:
    """Return the tractions q for the displacement w.

    Parameters
    ----------
    bound : ndarray, shape (...)
        b >= 0; points with 0 carry no traction, points with infinity always stick.
    target : ndarray, shape (2, ...)
        w.
    total : float, optional
        Sum of the tractions along x, smaller than that of the bounds: then w + U e_x is imposed,
        U unknown.
    start : ndarray, shape (2, ...), optional
    tolerance : float
        Largest `Tractions.error`.

    Examples
    --------
    Two springs of compliance 1, bounds 1 and 3:

    >>> class Springs:
    ...     own = 1.0
    ...     shear = near = staticmethod(lambda field: field)
    >>> slide(Springs(), np.array([1.0, 3.0]), np.array([[2.0, 2.0], [0.0, 0.0]])).traction[0]
    array([1., 2.])
    >>> slide(Springs(), np.array([1.0, 3.0]), np.zeros((2, 2)), total=3.5).shift
    2.5
    """
    loaded = bound > 0
    if total is not None and not abs(total) < bound.sum():
        raise ConvergenceError(f"a total of {total:.6g} is not below that of the bounds")
    # in units of powers of two, in which own compliance and displacement are near one
    moved = np.where(loaded, target, 0.0)
    given = 0.0 if total is None else total
    largest = max(float(np.abs(moved).max()), body.own * abs(given) / max(1, loaded.sum()))
    if largest == 0:
        rest = np.zeros_like(moved)
        return Tractions(rest, rest, rest, np.zeros_like(loaded), 0.0, 0.0, [0.0])
    own, length = 2.0 ** frexp(body.own)[1], 2.0 ** frexp(largest)[1]
    stress = length / own
    moved, limit, given = moved / length, np.where(loaded, bound / stress, 0.0), given / stress
    along_x = np.zeros_like(moved)
    along_x[0] = loaded & (total is not None)
    inverse = np.divide(1.0, limit, out=np.zeros_like(limit), where=loaded)
    highest = float(limit[np.isfinite(limit)].max(initial=0.0))

    q, shift = np.zeros_like(moved), 0.0
    # a start far beyond what the displacement can cause is only rounding to it
    if start is not None and float(np.abs(start).max()) < 2.0**40 * stress:
        q = _within(start / stress, limit)
    elif total is not None:
        stuck = np.isinf(limit)
        q[0] = given * (stuck / stuck.sum() if stuck.any() else limit / limit.sum())
    history: list[float] = []
    while True:
        displacement = body.shear(q) / own
        slip = np.where(loaded, moved - displacement, 0.0)
        below = loaded & (np.hypot(*q) < ON_BOUND * limit)
        if total is not None and not history:
            shift = -float(slip[0][below if below.any() else loaded].mean())
        slip += shift * along_x
        tried = _within(q + slip, limit)
        sizes = np.hypot(*np.stack([q, tried, q - tried], axis=1))
        largest = max(float(sizes[:2].max()), min(1.0, highest) * 2.0**-52, _TINY)
        missing = 0.0 if total is None else given - float(q[0].sum())
        error = max(float(sizes[2].max()), abs(missing) / loaded.sum()) / largest
        history.append(error)
        if error <= tolerance:
            sliding = loaded & (sizes[1] >= ON_BOUND * limit)
            fields = q * stress, displacement * length, slip * length
            return Tractions(*fields, sliding, shift * length, error, history)

        if not np.isfinite(error) or len(history) >= max_rounds:
            raise ConvergenceError(
                f"Coulomb's law is violated by {error:.1e} of the largest traction after "
                f"{len(history)} rounds",
                history,
            )
        # free are both components, or the turn along the circle with its curvature
        outwards = (q * inverse * slip).sum(axis=0)
        held = loaded & ~below & (outwards >= 0)
        radius, curve = np.where(held, q * inverse, 0.0), np.where(held, outwards * inverse, 0.0)
        change = _free_change(body, own, (loaded, radius, curve), along_x, slip, missing)
        if total is not None and (change is None or len(history) > _PATIENCE):
            return _by_shift(body, bound, target, total, tolerance, history)
        assert change is not None
        if len(history) > _WHOLE_STEPS:
            change = change / 2  # ends the cycles of bodies whose points act on each other strongly
        q = q + change[:-1].reshape(q.shape)
        shift += float(change[-1])
        # who turned stays on the circle
        size = np.hypot(*q)
        turned = held & (size > 0)
        q = _within(q * np.where(turned, limit / np.where(turned, size, 1.0), 1.0), limit)


def _free_change(
    body: TangentialBody,
    own: float,
    state: tuple[Mask, Array, Array],
    along_x: Array,
    slip: Array,
    missing: float,
) -> Array | None:
    """Return the change of tractions and shift for the slip of free components and the missing sum.

    By generalised conjugate residuals; None if nothing free can take up the sum.
    """
    loaded, radius, curve = state
    soft = 1 / (1 + curve)

    def free(values: Array) -> Array:
        return np.where(loaded, values - (values * radius).sum(axis=0) * radius, 0.0)

    def precondition(values: Array) -> Array:  # exact for a body of springs
        return free(soft * (own * body.near(soft * values) + curve * soft * values))

    given, border, lifted, answer = bool(along_x.any()), free(along_x), along_x, 0.0
    if given:
        lifted = precondition(border)
        answer = float((lifted * border).sum())
        if not answer > 0:
            return None
    residual = np.append(free(slip), missing)
    change, goal = np.zeros_like(residual), _FORCING * _dot(residual, residual) ** 0.5
    directions: list[Array] = []
    images: list[Array] = []
    while len(images) < _PRODUCTS and _dot(residual, residual) ** 0.5 > goal:
        step, shift = precondition(residual[:-1].reshape(slip.shape)), 0.0
        if given:
            shift = float(residual[-1] - (step * border).sum()) / answer
            step = step + shift * lifted
        image = free(body.shear(step) / own + curve * step) - shift * border
        direction = np.append(step, shift)
        image = np.append(image, (step * border).sum() if given else 0.0)
        for known, other in zip(directions, images, strict=True):
            share = _dot(image, other)
            direction, image = direction - share * known, image - share * other
        size, length = _dot(image, image) ** 0.5, _dot(direction, direction) ** 0.5
        if size <= 1e-12 * length:
            # nothing resists, as where all of a periodic body sticks: far up to the bounds
            return change + direction * (2.0**40 / length) if length > 0 else change
        directions.append(direction / size)
        images.append(image / size)
        share = _dot(residual, images[-1])
        change, residual = change + share * directions[-1], residual - share * images[-1]
    return change


def _by_shift(
    body: TangentialBody,
    bound: Array,
    target: Array,
    total: float,
    tolerance: float,
    history: list[float],
) -> Tractions:
    """Return the tractions of a given total by Brent's method: it grows with the shift.

    Near full sliding and far from it in single points no change of the shift leads to the total.
    """
    solved: dict[float, Tractions] = {}

    def excess(shift: float) -> float:
        shifted, start = target.copy(), [answer.traction for answer in solved.values()][-1:]
        shifted[0] += shift
        answer = slide(body, bound, shifted, start=start[0] if start else None, tolerance=tolerance)
        solved[shift] = answer
        history.extend(answer.history)
        over = float(answer.traction[0].sum()) - total
        close = tolerance * float(np.hypot(*answer.traction).max()) * np.count_nonzero(bound)
        return 0.0 if abs(over) <= close else over

    loaded = bound > 0
    reach = 2 * float(np.abs(target[:, loaded]).max()) + body.own * abs(total) / loaded.sum()
    low = high = reach
    for _ in range(40):
        if excess(-low) <= 0:
            break
        low *= 2
    for _ in range(40):
        if excess(high) >= 0:
            break
        high *= 2
    else:
        raise ConvergenceError("no rigid displacement carries the tangential force", history)
    shift = float(brentq(excess, -low, high, xtol=1e-15 * reach, rtol=1e-15))
    return replace(solved[shift], shift=shift, history=history)


def _dot(first: Array, second: Array) -> float:
    """Return the scalar product by one thread: BLAS would wake all of its own for it."""
    return float(np.einsum("i,i", first, second))


def _within(traction: Array, bound: Array) -> Array:
    """Return tractions projected onto their bounds."""
    size = np.hypot(*traction)
    over = size > bound
    return traction * np.where(over, bound / np.where(over, size, 1.0), 1.0)
