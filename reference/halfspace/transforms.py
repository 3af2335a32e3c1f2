"""Transforms of large real fields in vectors: three passes through memory for a convolution.

    rows forth -> blocks of columns forth, times a kernel, and back -> rows back

Lanes of a vector are neighbours in a row, so columns need no transposition. A row of 2 h numbers is
h complex numbers, h = K lanes: K vectors are transformed, a square of vectors is transposed and
transformed across the lanes, and opposite wavenumbers give the real row's spectrum (W. H. Press et
al., Numerical Recipes, section 12.3); the real numbers at wavenumbers 0 and h share one complex
number. Modes are kept by blocks of as many columns as lanes, which a column's transform reads one
after the other and changes in place: forth by decimation in frequency, which leaves wavenumbers in
another order, back by that in time, which undoes it (C. Van Loan, Computational Frameworks for the
Fast Fourier Transform, SIAM 1992, chapters 1 and 2). Between the first and the last of its stages
parts of a column are independent, and stay in the nearest cache.

Lengths have the factors 2, 3 and 5; `suits` says of which fields.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import DTypeLike, NDArray
from scipy import fft

from reference.halfspace.lanes import (
    BACK,
    FORTH,
    LANE_BYTES,
    RADICES,
    join,
    part,
    put,
    scale,
    square,
    take,
    tangle,
    untangle,
)

Array = NDArray[np.floating]

_forth2, _forth3, _forth4, _forth5, _forth8 = (FORTH[radix] for radix in (2, 3, 4, 5, 8))
_back2, _back3, _back4, _back5, _back8 = (BACK[radix] for radix in (2, 3, 4, 5, 8))

# Rows at a time, of which a block of columns gets a few lines of the cache together.
_GROUP = 4


class Line(NamedTuple):
    """Transform of one length: its stages in place.

    Attributes
    ----------
    stages : ndarray, shape (n, 3)
        Radix, length of the transform that is left, and where its factors begin.
    turns : ndarray
        Factors exp(-2 pi i p k/length) of every stage, real and imaginary parts in turn.
    order : ndarray
        Wavenumbers in the order that the stages leave.
    """

    stages: NDArray[np.int64]
    turns: Array
    order: NDArray[np.int64]


class Plan(NamedTuple):
    """All that the transforms of one period need.

    Attributes
    ----------
    row, column : Line
        Of the K vectors of a row, and of a column.
    places : ndarray, shape (K,)
        Where the vector of a wavenumber is after `row`.
    squares, pairs : ndarray
        Factors across lanes, and of opposite wavenumbers: all real parts, then the imaginary ones.
    """

    row: Line
    column: Line
    places: NDArray[np.int64]
    squares: Array
    pairs: Array


def suits(padded: tuple[int, int], dtype: DTypeLike) -> bool:
    """Return whether these transforms have a period of these sides."""
    lanes = _lanes(dtype)
    rows, columns = padded
    smooth = _factors(rows) is not None and _factors(columns) is not None
    return columns % (2 * lanes**2) == 0 and rows > 1 and smooth


def plan(padded: tuple[int, int], dtype: DTypeLike) -> Plan:
    """Return the plan of a period that suits."""
    lanes, (rows, columns) = _lanes(dtype), padded
    count = columns // (2 * lanes)
    row = _line(count, dtype)
    places = np.empty(count, np.int64)
    places[row.order] = 2 * lanes * np.arange(count)
    across = np.outer(np.arange(count), np.arange(lanes)).ravel() / (count * lanes)
    opposite = np.arange(columns // 2) / columns
    squares, pairs = (
        np.concatenate([np.cos(2 * np.pi * x), -np.sin(2 * np.pi * x)]).astype(dtype)
        for x in (across, opposite)
    )
    return Plan(row, _line(rows, dtype), places, squares, pairs)


def modes(rows: int, columns: int, dtype: DTypeLike) -> Array:
    """Return room for the modes of some rows: blocks of as many columns as lanes.

    Blocks are a line apart, as the cache has no room for powers of two apart.
    """
    row = 2 * _lanes(dtype)
    return aligned((columns // row, (rows + 1) * row), dtype)


def aligned(shape: tuple[int, ...], dtype: DTypeLike) -> Array:
    """Return a new array whose vectors begin with lines of the cache."""
    size = math.prod(shape) * np.dtype(dtype).itemsize
    memory = np.empty(size + LANE_BYTES, np.uint8)
    first = -memory.ctypes.data % LANE_BYTES
    return memory[first : first + size].view(dtype).reshape(shape)


def work(plan: Plan) -> Array:
    """Return work memory of `rows_forth` and `rows_back`."""
    return aligned(((_GROUP + 2) * plan.pairs.size,), plan.pairs.dtype)


def room(plan: Plan) -> Array:
    """Return room for a block of columns that is padded with zeros."""
    dtype = plan.pairs.dtype
    return aligned((2 * _lanes(dtype) * plan.column.order.size,), dtype)


def shared(modes: Array) -> Array:
    """Return the column that wavenumbers 0 and h share: real and imaginary parts, a view."""
    lanes = _lanes(modes.dtype)
    return modes[0, : -2 * lanes].reshape(-1, 2, lanes)[:, :, 0]


def edges(modes: Array, transfer: Array, plan: Plan) -> Array:
    """Return what the shared column becomes, in the place of `columns`.

    Two real columns are the real and the imaginary part of one; where their factors differ, so do
    those of a wavenumber and its opposite.
    """
    column, length = shared(modes), plan.column.order.size
    mode = np.arange(length)
    lowest, highest = transfer[:, [0, -1]][np.minimum(mode, length - mode)].T
    spectrum = fft.fft(column[:, 0] + 1j * column[:, 1], length)
    opposite = spectrum[-mode].conj()
    spectrum = (lowest + highest) * spectrum + (lowest - highest) * opposite
    result = fft.ifft(spectrum)[: len(column)] * (length / 2)
    return np.stack([result.real, result.imag], axis=1).astype(modes.dtype)


def _lanes(dtype: DTypeLike) -> int:
    return LANE_BYTES // np.dtype(dtype).itemsize


def _factors(length: int) -> list[int] | None:
    """Return factors among the radices, or None where a larger prime is left."""
    radices = []
    for radix in RADICES:
        # two fours are quicker than an eight and a two
        while length % radix == 0 and not (radix == 8 and length == 16):
            radices.append(radix)
            length //= radix
    return radices if length == 1 else None


def _line(length: int, dtype: DTypeLike) -> Line:
    stages, turns, order = [], [np.empty(0)], np.zeros(1, np.int64)
    rest, begin, step = length, 0, 1
    for radix in _factors(length) or ():
        stages.append((radix, rest, begin))
        angles = np.outer(np.arange(rest // radix), np.arange(1, radix)).ravel() / rest
        turns.append(np.stack([np.cos(2 * np.pi * angles), -np.sin(2 * np.pi * angles)], 1).ravel())
        order = (order[:, None] + step * np.arange(radix)).ravel()
        begin, rest, step = begin + 2 * angles.size, rest // radix, step * radix
    return Line(np.array(stages), np.concatenate(turns).astype(dtype), order)


@njit(cache=True, nogil=True, error_model="numpy")
def _forth(vectors, line, begin, end, start, stop):
    """Do the stages from begin to end on the vectors from start to stop."""
    row = 2 * LANE_BYTES // vectors.itemsize
    for stage in range(begin, end):
        radix, length, turns = line.stages[stage]
        groups = length // radix
        step = groups * row
        for block in range(start, stop, length):
            for group in range(groups):
                first, turn = (block + group) * row, turns + 2 * (radix - 1) * group
                if radix == 8:
                    _forth8(vectors, line.turns, first, step, turn)
                elif radix == 4:
                    _forth4(vectors, line.turns, first, step, turn)
                elif radix == 2:
                    _forth2(vectors, line.turns, first, step, turn)
                elif radix == 3:
                    _forth3(vectors, line.turns, first, step, turn)
                else:
                    _forth5(vectors, line.turns, first, step, turn)


@njit(cache=True, nogil=True, error_model="numpy")
def _back(vectors, line, begin, end, start, stop):
    """Undo `_forth`, but for a factor."""
    row = 2 * LANE_BYTES // vectors.itemsize
    for stage in range(end - 1, begin - 1, -1):
        radix, length, turns = line.stages[stage]
        groups = length // radix
        step = groups * row
        for block in range(start, stop, length):
            for group in range(groups):
                first, turn = (block + group) * row, turns + 2 * (radix - 1) * group
                if radix == 8:
                    _back8(vectors, line.turns, first, step, turn)
                elif radix == 4:
                    _back4(vectors, line.turns, first, step, turn)
                elif radix == 2:
                    _back2(vectors, line.turns, first, step, turn)
                elif radix == 3:
                    _back3(vectors, line.turns, first, step, turn)
                else:
                    _back5(vectors, line.turns, first, step, turn)


@njit(cache=True, nogil=True, error_model="numpy")
def rows_forth(field, modes, plan, work, first, stop):
    """Fill the modes of the rows from first to stop, twice as large; rows end with zeros."""
    half, lanes = plan.pairs.size // 2, LANE_BYTES // field.itemsize
    vectors, padded, width = work[: 2 * half], work[2 * half : 4 * half], field.shape[1]
    count, flat = half // lanes, modes.reshape(modes.size)
    padded[width:] = 0
    for start in range(first, stop, _GROUP):
        group = min(_GROUP, stop - start)
        for g in range(group):
            numbers = field[start + g]
            if width < 2 * half:
                padded[:width] = numbers
                numbers = padded
            for k in range(0, half, lanes):
                part(numbers, vectors, k)
            _forth(vectors, plan.row, 0, len(plan.row.stages), 0, count)
            row = work[2 * (2 + g) * half : 2 * (3 + g) * half]
            for k in range(0, count, lanes):
                square(vectors, row, plan.squares, plan.places, k)
            lowest, highest = row[0] + row[half], row[0] - row[half]
            for k in range(1, half // 2, lanes):
                untangle(row, plan.pairs, k)
            row[0], row[half] = 2 * lowest, 2 * highest
        for block in range(count):
            for g in range(group):
                k, place = 2 * (2 + g) * half + block * lanes, 2 * lanes * (start + g)
                put(work, flat, k, half, block * modes.shape[1] + place)


@njit(cache=True, nogil=True, error_model="numpy")
def rows_back(modes, field, plan, work, first, stop):
    """Fill the rows from first to stop; undo `rows_forth`, and the factors of `columns`."""
    half, lanes = plan.pairs.size // 2, LANE_BYTES // field.itemsize
    vectors, padded, width = work[: 2 * half], work[2 * half : 4 * half], field.shape[1]
    count, flat = half // lanes, modes.reshape(modes.size)
    factor = field.dtype.type(1 / (4.0 * half * plan.column.order.size))
    for start in range(first, stop, _GROUP):
        group = min(_GROUP, stop - start)
        for block in range(count):
            for g in range(group):
                k, place = 2 * (2 + g) * half + block * lanes, 2 * lanes * (start + g)
                take(flat, work, block * modes.shape[1] + place, k, half)
        for g in range(group):
            row = work[2 * (2 + g) * half : 2 * (3 + g) * half]
            lowest, highest = row[0], row[half]
            for k in range(1, half // 2, lanes):
                tangle(row, plan.pairs, k)
            row[0], row[half] = lowest - highest, lowest + highest
            for k in range(0, half, lanes):
                put(row, vectors, k, half, 2 * k)
            _forth(vectors, plan.row, 0, len(plan.row.stages), 0, count)
            for k in range(0, count, lanes):
                square(vectors, row, plan.squares, plan.places, k)
            numbers = field[start + g] if width == 2 * half else padded
            for k in range(0, half, lanes):
                join(row, numbers, k, factor)
            if width < 2 * half:
                field[start + g] = padded[:width]


@njit(cache=True, nogil=True, error_model="numpy")
def columns(modes, transfer, plan, vectors, first, stop):
    """Transform blocks of columns, multiply them by the transfer function, and transform back.

    `vectors` is room for a block that is padded with zeros. The first column shares wavenumbers 0
    and h, which have factors of their own: it is not right.
    """
    line, row = plan.column, 2 * LANE_BYTES // modes.itemsize
    length, rows, stages = line.order.size, modes.shape[1] // row - 1, len(line.stages)
    width, factors = transfer.shape[1], transfer.reshape(transfer.size)
    parts = line.stages[0, 0]
    for block in range(first, stop):
        column = modes[block, : rows * row] if rows == length else vectors
        if rows < length:
            column[: rows * row] = modes[block, : rows * row]
            column[rows * row : length * row] = 0
        # the first stage, the parts one after the other, the last stage
        for step in range(-1, parts + 1):
            whole = step < 0 or step == parts
            begin, end = (0, 1) if whole else (1, stages)
            start = 0 if whole else step * (length // parts)
            last = length if whole else start + length // parts
            if step < parts:
                _forth(column, line, begin, end, start, last)
            if not whole:
                for k in range(start, last):
                    mode = min(line.order[k], length - line.order[k])
                    scale(column, factors, k * row, mode * width + block * row // 2)
            if step >= 0:
                _back(column, line, begin, end, start, last)
        if rows < length:
            modes[block, : rows * row] = column[: rows * row]
