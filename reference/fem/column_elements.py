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

from collections.abc import Callable
from dataclasses import dataclass
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
    mass, stiffness, mixed : ndarray, shape (waves, classes, classes)
        Of two shape functions, of their slopes (times h^2), of one and the other's slope (times h
        and over i).
    value, slope : ndarray, shape (waves, pressures, classes)
        Of a pressure and a shape function, and its slope (times h and over i).
    pressure : ndarray, shape (waves, pressures)
        Of two pressures.
    force, point, wave : ndarray, shape (waves, classes)
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


def _one_class(pairs: tuple[Array, ...], single: tuple[Array, ...]) -> Symbols:
    """Return symbols of elements with one class of nodes and one pressure."""
    return Symbols(*(part[:, None, None] for part in pairs), *(part[:, None] for part in single))


def _linear(theta: Array) -> Symbols:
    """Hat functions: exact integrals of piecewise polynomials."""
    cos, half, ones = np.cos(theta), theta / 2, np.ones_like(theta)
    stiffness, slope = 4 * np.sin(half) ** 2, 2 * np.sin(half)
    pairs = (2 + cos) / 3, stiffness, np.sin(theta), np.cos(half), slope
    return _one_class(pairs, (ones, (3 + cos) / 4, ones, np.sinc(theta / (2 * np.pi)) ** 2))


def _splines(theta: Array) -> Symbols:
    """Quadratic B-splines: their integrals are B-splines of higher degree at whole numbers."""
    cos, half, hats = np.cos(theta), theta / 2, (2 + np.cos(theta)) / 3
    pairs = (
        (33 + 26 * cos + np.cos(2 * theta)) / 60,
        4 * np.sin(half) ** 2 * hats,
        (10 * np.sin(theta) + np.sin(2 * theta)) / 12,
        (11 * np.cos(half) + np.cos(3 * half)) / 12,
        2 * np.sin(half) * hats,
    )
    return _one_class(pairs, (hats, hats, (3 + cos) / 4, np.sinc(theta / (2 * np.pi)) ** 3))


def _quadratic(theta: Array) -> Symbols:
    """Quadratic elements between corners (first class), with a node in the middle (second)."""
    nodes = np.zeros((theta.size, 3, 2), dtype=complex)
    nodes[:, 0, 0], nodes[:, 2, 0] = np.exp(-0.5j * theta), np.exp(0.5j * theta)
    nodes[:, 1, 1] = 1.0
    conjugate = nodes.conj().transpose(0, 2, 1)
    odd = np.array([[1.0], [-1j]])  # conjugate of what is taken into odd pressures
    along = np.exp(1j * theta[:, None] * (_PLACES - 0.5)) * _WEIGHTS
    return Symbols(
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


@dataclass(frozen=True)
class _Kind:
    """An element in the plane; the degrees in x, y and depth of its pressures."""

    symbols: Callable[[Array], Symbols]
    pressures: tuple[tuple[int, int, int], ...]


_UNIFORM = (0, 0, 0), (0, 0, 1)
_KINDS: dict[Element, _Kind] = {
    "linear": _Kind(_linear, _UNIFORM),
    "splines": _Kind(_splines, _UNIFORM),
    "quadratic": _Kind(_quadratic, ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))),
}


class Plane(NamedTuple):
    """Products of the symbols of both directions, per area of the surface; the waves come last.

    Attributes
    ----------
    moves : ndarray, shape (6, nodes, nodes, waves)
        Displacements: mass; stiffness along x and y; both slopes; one slope, in x and in y.
    volumes : ndarray, shape (3, pressures, nodes, waves)
        Pressures and slopes along x and y, and values.
    stored : ndarray, shape (pressures, waves)
        Two pressures.
    mute : ndarray of bool, shape (pressures, waves)
        Pressures that act on nothing.
    degrees : ndarray of int, shape (pressures,)
        Of the pressures in depth.
    force, point, wave : ndarray, shape (nodes, waves)
        Of a pressure on the cell, at its centre, and of the wave.
    """

    moves: Array
    volumes: Array
    stored: Array
    mute: NDArray[np.bool_]
    degrees: NDArray[np.intp]
    force: Array
    point: Array
    wave: Array


def in_plane(element: Element, along: Array, across: Array, sides: tuple[float, float]) -> Plane:
    """Return the integrals in x and y for waves of given phases."""
    kind, (dx, dy) = _KINDS[element], sides
    x, y = kind.symbols(along), kind.symbols(across)
    moves = [
        _product(x.mass, y.mass),
        _product(x.stiffness, y.mass) / dx**2,
        _product(x.mass, y.stiffness) / dy**2,
        _product(x.mixed, y.mixed) / (dx * dy),
        _product(x.mixed, y.mass) / dx,
        _product(x.mass, y.mixed) / dy,
    ]
    i, j, degrees = (np.array(degree) for degree in zip(*kind.pressures, strict=True))
    volumes = np.array(
        [
            _both(x.slope[:, i], y.value[:, j]) / dx,
            _both(x.value[:, i], y.slope[:, j]) / dy,
            _both(x.value[:, i], y.value[:, j]),
        ]
    )
    mute = (np.abs(volumes).sum(axis=(0, 3)) < _MUTE).T
    volumes = volumes.transpose(0, 2, 3, 1)
    volumes[:, mute.nonzero()[0], :, mute.nonzero()[1]] = 0.0
    return Plane(
        np.ascontiguousarray(np.array(moves).transpose(0, 2, 3, 1)),
        np.ascontiguousarray(volumes),
        np.ascontiguousarray((x.pressure[:, i] * y.pressure[:, j]).T),
        mute,
        degrees,
        *(
            _both(along_x[:, None], along_y[:, None])[:, 0].T
            for along_x, along_y in ((x.force, y.force), (x.point, y.point), (x.wave, y.wave))
        ),
    )


def _product(x: Array, y: Array) -> Array:
    """Return the products of all nodes in x and y, (waves, nodes, nodes)."""
    size = x.shape[1] * y.shape[1]
    products: Array = np.einsum("wij,wkl->wikjl", x, y).reshape(len(x), size, size)
    return products


def _both(x: Array, y: Array) -> Array:
    """Return the products of nodes in x and y of the same pressures, (waves, pressures, nodes)."""
    products: Array = (x[:, :, :, None] * y[:, :, None, :]).reshape(*x.shape[:2], -1)
    return products
