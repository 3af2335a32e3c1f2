r"""Elements of columns: integrals over a cell for waves in the plane, and over a layer in depth.

Functions of x and y are sums over all cells with the phases of a wave, each class of nodes with
those of its own places. They are even but for a complex conjugate, so that integrals of two values,
of two slopes and, over i, of a value and a slope are real. So are those of pressures that are odd
in a cell, if i is taken into them.

``"linear"``
    bilinear, with pressures constant in x and y;
``"splines"``
    quadratic B-splines, with bilinear pressures;
``"quadratic"``
    hexahedra of 27 nodes, with pressures that are linear in each (Hex2: Q2/P1, inf-sup stable).

The nodes of the first two stand in the middles of the cells of a contact solver, the elements of
the third are these cells.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Element = Literal["linear", "splines", "quadratic"]
ELEMENTS: tuple[Element, ...] = ("linear", "splines", "quadratic")

# Quadratic shape functions on a unit interval, nodes at 0, 1/2, 1: mass, stiffness, and the
# integrals of a function (row) and a slope (column). Pressures: 1 and 2 z - 1.
MASS = np.array([[4.0, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 30
STIFFNESS = np.array([[7.0, -8, 1], [-8, 16, -8], [1, -8, 7]]) / 3
MIXED = np.array([[-3.0, 4, -1], [-4, 0, 4], [1, -4, 3]]) / 6
PRESSED = np.array([[1.0, 4, 1], [-1, 0, 1]]) / 6
PRESSED_SLOPE = np.array([[-3.0, 0, 3], [2, -4, 2]]) / 3
PRESSURES = np.array([1.0, 1 / 3])

# Gauss points on the unit interval, exact to rounding for half a wave, and the functions there.
_PLACES, _WEIGHTS = (part / 2 for part in np.polynomial.legendre.leggauss(12))
_PLACES = _PLACES + 0.5
_SHAPES = np.array(
    [
        (1 - _PLACES) * (1 - 2 * _PLACES),
        4 * _PLACES * (1 - _PLACES),
        _PLACES * (2 * _PLACES - 1),
    ]
)

# A wave whose pressures do not act on the displacements at all, as two cells long: they are left
# out.
_MUTE = 1e-12


class Symbols(NamedTuple):
    """Integrals over a cell in one direction, for waves of phase theta from cell to cell.

    Attributes
    ----------
    mass, stiffness, mixed : (waves, classes, classes)
        Of two shape functions, of their slopes (times h^2), of one and the other's slope (times h
        and over i).
    value, slope : (waves, pressures, classes)
        Of a pressure and a shape function, and its slope (times h and over i).
    pressure : (waves, pressures)
        Of two pressures.
    force, point, wave : (waves, classes)
        Of a shape function over the cell of a contact solver; its value at the cell's centre; of it
        and the wave itself.
    """

    mass: Array
    stiffness: Array
    mixed: Array
    value: Array
    slope: Array
    pressure: Array
    force: Array
    point: Array
    wave: Array

    @classmethod
    def of(cls, element: Element, theta: Array) -> Symbols:
        """Return the symbols of an element; classes are corners and middles of "quadratic"."""
        cos, half = np.cos(theta), theta / 2
        if element == "linear":  # hat functions: exact integrals of piecewise polynomials
            ones = np.ones_like(theta)
            pairs = [(2 + cos) / 3, 4 * np.sin(half) ** 2, np.sin(theta)]
            pairs += [np.cos(half), 2 * np.sin(half)]
            single = [ones, (3 + cos) / 4, ones, np.sinc(theta / (2 * np.pi)) ** 2]
        elif element == "splines":  # their integrals are B-splines of higher degree, at numbers
            hats = (2 + cos) / 3
            pairs = [
                (33 + 26 * cos + np.cos(2 * theta)) / 60,
                4 * np.sin(half) ** 2 * hats,
                (10 * np.sin(theta) + np.sin(2 * theta)) / 12,
                (11 * np.cos(half) + np.cos(3 * half)) / 12,
                2 * np.sin(half) * hats,
            ]
            single = [hats, hats, (3 + cos) / 4, np.sinc(theta / (2 * np.pi)) ** 3]
        else:  # the nodes of an element at 0, 1/2, 1 by those of its class
            nodes = np.zeros((theta.size, 3, 2), dtype=complex)
            nodes[:, 0, 0], nodes[:, 2, 0] = np.exp(-0.5j * theta), np.exp(0.5j * theta)
            nodes[:, 1, 1] = 1.0
            conjugate = nodes.conj().transpose(0, 2, 1)
            odd = np.array([[1.0], [-1j]])  # conjugate of what is taken into odd pressures
            along = np.exp(1j * theta[:, None] * (_PLACES - 0.5)) * _WEIGHTS
            return cls(
                mass=(conjugate @ MASS @ nodes).real,
                stiffness=(conjugate @ STIFFNESS @ nodes).real,
                mixed=(conjugate @ MIXED @ nodes).imag,
                value=(odd * PRESSED @ nodes).real,
                slope=(odd * PRESSED_SLOPE @ nodes).imag,
                pressure=np.broadcast_to(PRESSURES, (theta.size, 2)),
                force=(PRESSED[0] @ nodes).real,
                point=np.broadcast_to([0.0, 1.0], (theta.size, 2)),
                wave=(conjugate @ (along @ _SHAPES.T)[:, :, None]).real[:, :, 0],
            )
        return cls(*(part[:, None, None] for part in pairs), *(part[:, None] for part in single))


# Degrees in x, y and depth of the pressures of an element.
_UNIFORM = (0, 0, 0), (0, 0, 1)
_PRESSURE_DEGREES: dict[Element, tuple[tuple[int, int, int], ...]] = {
    "linear": _UNIFORM,
    "splines": _UNIFORM,
    "quadratic": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
}


class WaveIntegrals(NamedTuple):
    """Products of the symbols of both directions, per area of the surface; the waves come last.

    Attributes
    ----------
    moves : (6, nodes, nodes, waves)
        Displacements: mass; stiffness along x and y; both slopes; one slope, in x and in y.
    volumes : (3, pressures, nodes, waves)
        Pressures and slopes along x and y, and values.
    stored : (pressures, waves)
        Two pressures.
    mute : (pressures, waves)
        1 for pressures that act on nothing, 0 for others.
    degrees : (pressures,)
        Of the pressures in depth.
    force, point, wave : (nodes, waves)
        Of a pressure on the cell, at its centre, and of the wave.
    """

    moves: Array
    volumes: Array
    stored: Array
    mute: Array
    degrees: NDArray[np.intp]
    force: Array
    point: Array
    wave: Array


def in_plane(
    element: Element, along: Array, across: Array, sides: tuple[float, float]
) -> WaveIntegrals:
    """Return the integrals in x and y for waves of given phases."""
    dx, dy = sides
    x, y = Symbols.of(element, along), Symbols.of(element, across)

    def pairs(first: Array, second: Array) -> Array:
        size = first.shape[1] * second.shape[1]
        return np.einsum("wij,wkl->wikjl", first, second).reshape(len(first), size, size)

    def both(first: Array, second: Array) -> Array:
        product = first[:, :, :, None] * second[:, :, None, :]
        return product.reshape(*product.shape[:2], -1)

    moves = [
        pairs(x.mass, y.mass),
        pairs(x.stiffness, y.mass) / dx**2,
        pairs(x.mass, y.stiffness) / dy**2,
        pairs(x.mixed, y.mixed) / (dx * dy),
        pairs(x.mixed, y.mass) / dx,
        pairs(x.mass, y.mixed) / dy,
    ]
    i, j, degrees = np.array(_PRESSURE_DEGREES[element]).T
    volumes = np.array(
        [
            both(x.slope[:, i], y.value[:, j]) / dx,
            both(x.value[:, i], y.slope[:, j]) / dy,
            both(x.value[:, i], y.value[:, j]),
        ]
    )
    mute = (np.abs(volumes).sum(axis=(0, 3)) < _MUTE).T
    volumes = volumes.transpose(0, 2, 3, 1)
    volumes[:, mute.nonzero()[0], :, mute.nonzero()[1]] = 0.0
    stored = (x.pressure[:, i] * y.pressure[:, j]).T
    return WaveIntegrals(
        np.ascontiguousarray(np.array(moves).transpose(0, 2, 3, 1)),
        np.ascontiguousarray(volumes),
        np.ascontiguousarray(np.where(mute, 0.0, stored)),
        np.ascontiguousarray(mute, dtype=float),
        np.ascontiguousarray(degrees),
        *(
            both(first[:, None], second[:, None])[:, 0].T
            for first, second in ((x.force, y.force), (x.point, y.point), (x.wave, y.wave))
        ),
    )
