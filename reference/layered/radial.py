r"""What a point force on a body of layers displaces: G(r), and its integral over cells.

With M(q) = q C(q)/(q C(q) at short waves) - a half-space of the uppermost material has M = 1 -

    G(r) = S(r)/(pi E1 r),    S(r) = 1 + int_0^inf (M(x/r) - 1) J0(x) dx,

a function of log r without steps, from 1 near the force to E1/E of the base far away. The integral
is taken by Gauss points up to some zeros of J0, on panels that shrink towards x = 0 because M may
vary anywhere; the rest as an alternating sum between zeros, by Euler's averages.

The displacement at the centre of one cell under pressure on another is the integral of G over it.
Over a triangle from the force to one side, a distance Y away and X long, it is

    int_0^asinh(X/Y) I(Y cosh s)/cosh s ds,    I(R) = int_0^R G(r) r dr,

and a rectangle is made of such triangles; far cells take Gauss points of G.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.special import j0, jn_zeros

from reference.halfspace import kernels
from reference.layered.graded import Graded
from reference.layered.stack import Stack, plane_modulus

Array = NDArray[np.float64]
Body = Stack | Graded

# Nodes per decade of the tables: cubic splines between them err by 1e-11.
_PER_DECADE = 400
# Panels of Gauss points below the first zero of J0, each a fraction of the next.
_PANELS, _SHRINK, _GAUSS = 46, 0.5, 10
# Zeros of J0 that are integrated to as they are, and those that are averaged.
_PLAIN, _AVERAGED = 16, 28
# Short waves beyond which a body is its uppermost material: `stack._HIDDEN`.
_SHORT = 24.0
# Sides of a cell to which triangles are summed, and Gauss points over farther cells.
_NEAR, _POINTS, _POINTS_FAR, _FAR = 3.0, 8, 4, 16.0


@dataclass(frozen=True)
class Radial:
    """Displacement by a point force, and its integral over a disc.

    Attributes
    ----------
    point, disc : callable
        r G(r) and I(r) for arrays r > 0.
    """

    point: Callable[[Array], Array]
    disc: Callable[[Array], Array]


def radial(body: Body, smallest: float, largest: float) -> Radial:
    """Return the displacement by a point force on a body, for distances in a range.

    Below it the body is taken as its uppermost material: `smallest` is far below the cells.
    """
    if isinstance(body, Graded):
        k, factor = body.exponent, body.point_factor
        return Radial(lambda r: factor * r**-k, lambda r: factor * r ** (1 - k) / (1 - k))
    scale = 1 / (np.pi * plane_modulus(body.top))
    smallest = min(smallest, 1e-3 * min(body.thicknesses, default=smallest))
    number = int(_PER_DECADE * np.log10(1.1 * largest / smallest)) + 8
    x = np.linspace(np.log(smallest), np.log(1.1 * largest), number)
    r = np.exp(x)
    values = _decay(body, r) * scale
    point = CubicSpline(x, values)
    within = CubicSpline(x, values * r).antiderivative()
    # S begins as a straight line
    start = smallest * (scale + values[0]) / 2

    def disc(radius: Array) -> Array:
        inside = start + within(np.log(np.maximum(radius, smallest)))
        return np.where(radius < smallest, scale * radius, inside)

    return Radial(lambda radius: point(np.log(radius)), disc)


def _decay(body: Stack, r: Array) -> Array:
    """S(r)."""
    if not body.thicknesses:
        return np.ones_like(r)
    excess = softening(body, 1e-13 / r[-1], 1e3 / body.thicknesses[0])
    x, weights = _bessel_rule()
    return np.array([1 + weights @ excess(x / radius) for radius in r])


def softening(body: Stack, lowest: float, highest: float) -> Callable[[Array], Array]:
    """Return M - 1 as a function of q, interpolated from a table."""
    highest = max(highest, 2 * lowest)
    number = int(_PER_DECADE * np.log10(highest / lowest)) + 8
    logs = np.linspace(np.log(lowest), np.log(highest), number)
    q = np.exp(logs)
    table = CubicSpline(logs, np.log(q * body.compliance(q) * plane_modulus(body.top) / 2))

    def excess(wavenumber: Array) -> Array:
        inside = np.clip(np.log(wavenumber), logs[0], logs[-1])
        hidden = wavenumber * body.thicknesses[0] > _SHORT
        return np.where(hidden, 0.0, np.expm1(table(inside)))

    return excess


@cache
def _bessel_rule() -> tuple[Array, Array]:
    """Points and weights of int_0^inf f(x) J0(x) dx, for smooth f that need not decay."""
    zeros = jn_zeros(0, _PLAIN + _AVERAGED)
    first = zeros[0] * _SHRINK ** np.arange(_PANELS, -1, -1.0)
    ends = np.concatenate([[0.0], first, zeros[1:]])
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS)
    middle, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
    x = middle[:, None] + half[:, None] * nodes
    whole = half[:, None] * weights * j0(x)
    share = np.ones(len(middle))
    odds = np.cumprod([1.0] + [(_AVERAGED - i) / (i + 1) for i in range(_AVERAGED)])
    share[-_AVERAGED:] = 1 - np.cumsum(odds)[:-1] / 2.0**_AVERAGED
    return x.ravel(), (whole * share[:, None]).ravel()


def cell_coefficients(body: Body, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Displacement at cell centres under unit pressure on another, offsets from zero to `shape`.

    Parameters
    ----------
    body : Stack or Graded
        Stacks on a rigid base lose digits where they are thin against the distances: their
        displacement decays there, as a difference of numbers that do not.
    shape, spacing
        As for `FreeOperator`.

    Returns
    -------
    ndarray, shape `shape`
    """
    if isinstance(body, Stack) and not body.thicknesses:
        i, j = np.ix_(np.arange(shape[0]), np.arange(shape[1]))
        return kernels.love(i, j, spacing, plane_modulus(body.top))
    dx, dy = spacing
    largest = float(np.hypot(shape[0] * dx, shape[1] * dy)) + max(spacing)
    answer = radial(body, 1e-4 * min(spacing), largest)
    x, y = np.broadcast_arrays(np.arange(shape[0])[:, None] * dx, np.arange(shape[1]) * dy)
    reach = np.maximum(x, y) / max(spacing)
    result = np.empty(shape)
    near, far = reach < _NEAR, reach > _FAR
    result[near] = _by_triangles(answer, x[near], y[near], spacing)
    for part, points in ((~near & ~far, _POINTS), (far, _POINTS_FAR)):
        result[part] = _by_points(answer, x[part], y[part], spacing, points)
    return result


def _by_points(
    answer: Radial, x: Array, y: Array, spacing: tuple[float, float], points: int
) -> Array:
    nodes, weights = np.polynomial.legendre.leggauss(points)
    total = np.zeros(x.shape)
    for node_x, weight_x in zip(nodes, weights, strict=True):
        for node_y, weight_y in zip(nodes, weights, strict=True):
            r = np.hypot(x + node_x * spacing[0] / 2, y + node_y * spacing[1] / 2)
            total += weight_x * weight_y * answer.point(r) / r
    return total * spacing[0] * spacing[1] / 4


def _by_triangles(answer: Radial, x: Array, y: Array, spacing: tuple[float, float]) -> Array:
    total = np.zeros(x.shape)
    for sign_x in (1, -1):
        for sign_y in (1, -1):
            right, upper = x + sign_x * spacing[0] / 2, y + sign_y * spacing[1] / 2
            total += sign_x * sign_y * _corner(answer, right, upper)
    return total


def _corner(answer: Radial, x: Array, y: Array) -> Array:
    """Integral of G over the rectangle from the force to a corner; odd in both coordinates."""
    wide, high = np.abs(x), np.abs(y)
    return np.sign(x * y) * (_triangle(answer, wide, high) + _triangle(answer, high, wide))


def _triangle(answer: Radial, length: Array, distance: Array) -> Array:
    nodes, weights = np.polynomial.legendre.leggauss(40)
    reach = np.arcsinh(length / distance)
    total = np.zeros(length.shape)
    for node, weight in zip(nodes, weights, strict=True):
        cosh = np.cosh(reach * (node + 1) / 2)
        total += weight * answer.disc(distance * cosh) / cosh
    return total * reach / 2
