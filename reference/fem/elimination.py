"""Columns of elements, eliminated from below: compiled, a group of waves at a time.

The unknowns of a layer of elements are the displacements at its bottom, in the middle and at the
top, each in three components on all nodes, and pressures. All but those at the top are eliminated
in this order, without pivoting: what is left of the displacements is positive definite where the
top is held, and pressures have one sign.

The equation of a pressure is scaled by the root of |r| (see `columns`), which makes the matrix
symmetric.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.fem import column_elements as elements
from reference.fem.column_elements import Plane

Array = NDArray[np.float64]

# Waves whose matrices are eliminated side by side, by vector instructions.
GROUP = 16

_DEPTH = np.array([elements.MASS, elements.STIFFNESS, elements.MIXED])
_PRESSED = np.array([elements.PRESSED, elements.PRESSED_SLOPE])


def eliminated(
    plane: Plane,
    layers: Array,
    active: NDArray[np.intp],
    inertia: float,
    base: tuple[Array, int] | None = None,
) -> Array:
    """Return the stiffness at the top of all layers.

    Parameters
    ----------
    plane : Plane
        A whole number of groups of waves, in the order of their wavenumbers.
    layers : ndarray, shape (layers, 4)
        From the top down: thickness, shear modulus, r and s of `columns`.
    active : ndarray of int, shape (layers,)
        The number of waves that reach a layer; the others stand on a rigid base.
    inertia : float
        See `columns.tensor`.
    base : (ndarray, int), optional
        Stiffness of what the layers stand on, (unknowns, unknowns, waves), and the number of waves
        that reach it; a rigid base if left out.

    Returns
    -------
    ndarray, shape (waves, unknowns, unknowns)
        Unknowns: three components on each node.
    """
    waves, nodes = plane.moves.shape[-1], plane.moves.shape[1]
    top, reached = base or (np.zeros((3 * nodes, 3 * nodes, waves)), 0)
    stored = np.where(plane.mute, 0.0, plane.stored)
    parts = plane.moves, plane.volumes, stored, plane.mute * 1.0, plane.degrees
    _eliminate(parts, (_DEPTH, _PRESSED), layers, np.append(active, reached), inertia, top)
    lower: Array = np.ascontiguousarray(top.transpose(2, 0, 1))
    return lower


@njit(cache=True, error_model="numpy")
def _eliminate(plane, depth, layers, active, inertia, result):
    """Turn the stiffness of the base into that of the surface, from the bottom up."""
    size, pressures = result.shape[0], plane[2].shape[0]
    matrix = np.empty((3 * size + pressures, 3 * size + pressures, GROUP))
    last = 2 * size + pressures
    for start in range(0, result.shape[2], GROUP):
        carried = active[-1] > start
        for layer in range(len(layers) - 1, -1, -1):
            if active[layer] <= start:
                continue
            _fill(matrix, plane, depth, layers[layer], inertia, start)
            if carried:
                _add(matrix, result, start)
            _reduce(matrix, 0 if carried else size, last)
            _take(matrix, last, start, result)
            carried = True


# Loops in place of slices, whose checks of shapes take longer to compile than all the rest.
@njit(cache=True)
def _add(matrix, result, start):
    """Add to the bottom of a layer what is below it."""
    for i in range(result.shape[0]):
        for j in range(result.shape[1]):
            for w in range(GROUP):
                matrix[i, j, w] += result[i, j, start + w]


@njit(cache=True)
def _take(matrix, last, start, result):
    """Take the stiffness of the top of a layer from the lower triangle."""
    for i in range(result.shape[0]):
        for j in range(i + 1):
            for w in range(GROUP):
                result[i, j, start + w] = matrix[last + i, last + j, w]
                result[j, i, start + w] = matrix[last + i, last + j, w]


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _reduce(matrix, first, last):
    """Eliminate unknowns from the lower triangle of symmetric matrices."""
    factor = np.empty(GROUP)
    for k in range(first, last):
        for i in range(k + 1, len(matrix)):
            for w in range(GROUP):
                factor[w] = matrix[i, k, w] / matrix[k, k, w]
            for j in range(k + 1, i + 1):
                for w in range(GROUP):
                    matrix[i, j, w] -= factor[w] * matrix[j, k, w]


@njit(cache=True, error_model="numpy")
def _fill(matrix, plane, depth, layer, inertia, start):
    """Fill the matrices of one layer of elements: 2 e : e, less inertia, and the pressures."""
    moves, volumes, stored, mute, degrees = plane
    thickness, modulus, ratio, storing = layer
    size, pressures = 3 * moves.shape[1], stored.shape[0]
    # by depth: top, middle, bottom; the pressures stand before the top
    places = (2 * size + pressures, size, 0)
    for a in range(3):
        for b in range(3):
            factors = (
                depth[0][0, a, b] * thickness * modulus,
                depth[0][1, a, b] / thickness * modulus,
                depth[0][2, b, a] * modulus,
            )
            _fill_strain(matrix, moves, factors, inertia, (places[a], places[b], start))
    matrix[2 * size : places[0], 2 * size : places[0]] = 0.0
    sign = -1.0 if ratio < 0 else 1.0
    for k in range(pressures):
        row, root = 2 * size + k, np.sqrt(abs(ratio)) * modulus
        share = sign * thickness * modulus * (1 / 3 if degrees[k] else 1.0)
        for w in range(GROUP):
            kept = storing * stored[k, start + w] + mute[k, start + w]
            matrix[row, row, w] = -kept * share
        for a in range(3):
            flat = -depth[1][0, degrees[k], a] * thickness * root
            factors = (flat, flat, depth[1][1, degrees[k], a] * root)
            _fill_volume(matrix, volumes[:, k], factors, (row, places[a], start))


@njit(cache=True, error_model="numpy")
def _fill_strain(matrix, moves, factors, inertia, place):
    """Fill the block of displacements at two depths."""
    (flat, steep, turned), (first, second, start) = factors, place
    nodes = moves.shape[1]
    for i in range(nodes):
        for j in range(nodes):
            row, column = first + 3 * i, second + 3 * j
            for w in range(GROUP):
                at = start + w
                along, across = moves[1, i, j, at] * flat, moves[2, i, j, at] * flat
                upright, slanted = moves[0, i, j, at] * steep, moves[3, i, j, at] * flat
                moving = inertia * along
                matrix[row, column, w] = 2 * along + across + upright - moving
                matrix[row + 1, column + 1, w] = along + 2 * across + upright - moving
                matrix[row + 2, column + 2, w] = along + across + 2 * upright - moving
                matrix[row, column + 1, w] = slanted
                matrix[row + 1, column, w] = slanted
                for axis in range(2):
                    matrix[row + axis, column + 2, w] = moves[4 + axis, i, j, at] * turned
                    matrix[column + 2, row + axis, w] = moves[4 + axis, i, j, at] * turned


@njit(cache=True, error_model="numpy")
def _fill_volume(matrix, volumes, factors, place):
    """Fill what one pressure does to the displacements at one depth."""
    row, first, start = place
    for i in range(volumes.shape[1]):
        for axis in range(3):
            column = first + 3 * i + axis
            for w in range(GROUP):
                value = volumes[axis, i, start + w] * factors[axis]
                matrix[row, column, w] = value
                matrix[column, row, w] = value
