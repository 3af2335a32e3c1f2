"""Convolution of a real field with a real, even kernel by FFT, compiled and without allocations.

    out = F^-1[ T F[field, padded with zeros] ], cut back to the field,

T(q_x, q_y) real and even in both wavenumbers: influence coefficients, or |q|. A solver of contacts
does little else, and three things make it two to four times as fast as SciPy's transforms: two
columns of the real field are one complex transform; the second axis is transformed, multiplied and
transformed back block by block in the cache; all work memory is kept (a fresh array of a megabyte
costs more page faults than arithmetic). Single precision takes half the time of double.

Transforms along an axis are Stockham's, of mixed radix 2, 3, 4, 5, 8, one vector of columns at a
time; lengths with larger prime factors go by Bluestein's chirp (L. I. Bluestein, IEEE Trans.
Audio Electroacoust. 18 (1970) 451), at some four times the cost.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import DTypeLike, NDArray
from scipy import fft

from reference.halfspace.vectors import (
    BUTTERFLIES,
    LANE_BYTES,
    RADICES,
    copy,
    join,
    multiply,
    part,
    scale,
    transpose,
)

_butterfly2, _butterfly3, _butterfly4, _butterfly5, _butterfly8 = (
    BUTTERFLIES[radix] for radix in (2, 3, 4, 5, 8)
)

Array = NDArray[np.floating]


class Line(NamedTuple):
    """Transform of one length: its stages, and the chirps where the length has large factors."""

    length: int
    work_length: int
    factors: NDArray[np.int64]
    twiddles: Array
    chirps: Array  # (2, 2 length) forward and backward, real and imaginary parts in turn, or empty
    chirp_spectra: Array


class Plan(NamedTuple):
    """Everything that the compiled convolution needs."""

    lanes: int
    transfer: Array
    line_x: Line
    line_y: Line
    spectra: Array  # (blocks of wavenumbers, columns, real and imaginary lanes)
    first: Array
    second: Array
    square: Array


class Convolution:
    """Convolution of fields of one shape with one kernel.

    Parameters
    ----------
    shape : (int, int)
        Shape of field and result.
    padded : (int, int)
        Lengths of the transforms: `shape` for a periodic field, at least the field and the reach
        of the kernel less one for a free one.
    transfer : ndarray, shape (padded[0], padded[1]//2 + 1)
        Real transfer function on the modes of `rfft2`, even in both wavenumbers.
    dtype : float32 or float64
        Precision of fields, transforms and result.

    Examples
    --------
    >>> one_cell_on = np.exp(-2j * np.pi * np.fft.fftfreq(6))[:, None].real * np.ones((1, 3))
    >>> neighbours = Convolution((6, 4), (6, 4), one_cell_on, np.float64)
    >>> field = np.zeros((6, 4))
    >>> field[0, 1] = 2.0
    >>> neighbours(field)[:, 1].round(12) + 0.0
    array([0., 1., 0., 0., 0., 1.])
    """

    def __init__(
        self,
        shape: tuple[int, int],
        padded: tuple[int, int],
        transfer: NDArray[np.float64],
        dtype: DTypeLike,
    ) -> None:
        self.shape = shape
        self.padded = padded
        self.dtype = np.dtype(dtype)
        lanes = LANE_BYTES // self.dtype.itemsize
        lines = [_line(n, self.dtype) for n in padded]
        modes = padded[0] // 2 + 1
        blocks = -(-modes // lanes)
        half = -(-((shape[1] + 1) // 2) // lanes) * lanes
        longest = max(line.work_length for line in lines)
        # a half for the two fields that `part` adds up
        self.mean_unit = 1 / (2 * padded[0] * padded[1])
        blocked = np.zeros(blocks * padded[1] * lanes, self.dtype)
        _fill_blocks(transfer, blocked, modes, padded[1], lanes, self.mean_unit)
        self.plan = Plan(
            lanes,
            blocked,
            *lines,
            np.zeros((blocks, 2 * half, 2 * lanes), self.dtype),
            np.zeros(2 * lanes * longest, self.dtype),
            np.zeros(2 * lanes * longest, self.dtype),
            np.zeros(4 * lanes**2, self.dtype),
        )

    def __call__(self, field: Array, out: Array | None = None) -> Array:
        """Return the convolution of a contiguous field of the right shape and precision."""
        out = np.empty(self.shape, self.dtype) if out is None else out
        convolve(field, out, self.plan)
        return out

    def set_mean_factor(self, value: float) -> None:
        """Change the transfer function at zero wavenumber; `mean_unit` stands for one there."""
        self.plan.transfer[0] = value * self.mean_unit


@njit(cache=True)
def _fill_blocks(transfer, blocked, modes, columns, lanes, factor):
    """Order the transfer function as it is used: blocks of q_x, all q_y, the lanes of a block."""
    for block in range(-(-modes // lanes)):
        for j in range(columns):
            for lane in range(min(lanes, modes - block * lanes)):
                value = transfer[block * lanes + lane, min(j, columns - j)] * factor
                blocked[(block * columns + j) * lanes + lane] = value


def _line(length: int, dtype: np.dtype) -> Line:
    factors = _factors(length)
    nothing = np.zeros((2, 0), dtype)
    if factors is not None:
        return Line(length, length, factors, _twiddles(length, factors, dtype), nothing, nothing)
    work = fft.next_fast_len(2 * length - 1, real=True)
    factors = _factors(work)
    k = np.arange(length)
    # k^2 modulo the period 2 n, so that the angle keeps its digits
    chirp = np.exp(-1j * np.pi * (k * k % (2 * length)) / length)
    wrapped = np.zeros(work, complex)
    wrapped[:length] = chirp.conj()
    wrapped[work - length + 1 :] = chirp[:0:-1].conj()
    spectra = [fft.fft(w) / work for w in (wrapped, wrapped.conj())]
    return Line(
        length,
        work,
        factors,
        _twiddles(work, factors, dtype),
        np.stack([_interleaved(c, dtype) for c in (chirp, chirp.conj())]),
        np.stack([_interleaved(s, dtype) for s in spectra]),
    )


def _factors(length: int) -> NDArray[np.int64] | None:
    """Return factors among the radices, or None where a larger prime is left."""
    found = []
    for radix in RADICES:
        # two fours are quicker than an eight and a two
        while length % radix == 0 and not (radix == 8 and length == 16):
            found.append(radix)
            length //= radix
    return np.array(found, dtype=np.int64) if length == 1 else None


def _twiddles(length: int, factors: NDArray[np.int64], dtype: np.dtype) -> Array:
    """Factors exp(-2 pi i p k/rest) of every stage, for each of its groups p and k > 0."""
    stages, rest = [np.ones(1, complex)], length
    for radix in factors:
        groups = np.arange(rest // radix)[:, None]
        stages.append(np.exp(-2j * np.pi * groups * np.arange(1, radix) / rest).ravel())
        rest //= radix
    return _interleaved(np.concatenate(stages[1:] or stages), dtype)


def _interleaved(values: NDArray[np.complex128], dtype: np.dtype) -> Array:
    return np.stack([values.real, values.imag], axis=-1).ravel().astype(dtype)


@njit(cache=True, error_model="numpy")
def _stages(first, second, lanes, line, backward):
    """Stockham's stages between two work arrays; (result, other array)."""
    row = 2 * lanes
    stride, rest, turn, turns = row, line.work_length, 0, line.twiddles
    for radix in line.factors:
        groups = rest // radix
        step = stride * groups
        for group in range(groups):
            for start in range(stride * group, stride * (group + 1), row):
                into = start + (radix - 1) * stride * group
                if radix == 8:
                    _butterfly8(first, second, turns, start, step, into, stride, turn, backward)
                elif radix == 4:
                    _butterfly4(first, second, turns, start, step, into, stride, turn, backward)
                elif radix == 2:
                    _butterfly2(first, second, turns, start, step, into, stride, turn, backward)
                elif radix == 3:
                    _butterfly3(first, second, turns, start, step, into, stride, turn, backward)
                else:
                    _butterfly5(first, second, turns, start, step, into, stride, turn, backward)
            turn += 2 * (radix - 1)
        stride *= radix
        rest = groups
        first, second = second, first
    return first, second


@njit(cache=True, error_model="numpy")
def _transform(first, second, lanes, line, backward):
    """Transform the rows of `first`, backward 0 or 1; (result, other array)."""
    if line.chirps.shape[1] == 0:
        return _stages(first, second, lanes, line, backward)
    row = 2 * lanes
    chirp, spectrum = line.chirps[backward], line.chirp_spectra[backward]
    for k in range(line.length):
        multiply(first, chirp, k * row, 2 * k)
    _clear(first, line.length * row, line.work_length * row)
    for way in range(2):
        first, second = _stages(first, second, lanes, line, way)
        if way == 0:
            for k in range(line.work_length):
                multiply(first, spectrum, k * row, 2 * k)
    for k in range(line.length):
        multiply(first, chirp, k * row, 2 * k)
    return first, second


@njit(cache=True, error_model="numpy")
def _clear(rows, start, stop):
    for k in range(start, stop):
        rows[k] = 0


@njit(cache=True, error_model="numpy")
def convolve(field, out, plan):
    """Convolve a contiguous field with the kernel of the plan."""
    columns = field.shape[1]
    half = (columns + 1) // 2
    source, target = field.reshape(field.size), out.reshape(out.size)
    spectra = plan.spectra.reshape(plan.spectra.size)
    # one call of the transforms for both ways: each call is compiled into this function
    for backward in range(2):
        if backward:
            for block in range(plan.spectra.shape[0]):
                _second_axis(spectra, block, half, columns, plan)
        for start in range(0, half, plan.lanes):
            if backward:
                _join_columns(spectra, plan.first, start, plan)
            else:
                _load(source, plan.first, plan.lanes, start, half, columns)
                row = 2 * plan.lanes
                _clear(plan.first, row * field.shape[0], row * plan.line_x.length)
            rows, _ = _transform(plan.first, plan.second, plan.lanes, plan.line_x, backward)
            if backward:
                _unload(rows, target, plan.lanes, start, half, columns)
            else:
                _split_columns(rows, spectra, start, plan)


@njit(cache=True, error_model="numpy")
def _load(source, rows, lanes, start, half, columns):
    """Columns from `start` become real parts, those half a field further imaginary parts."""
    count = source.size // columns
    if half + start + lanes <= columns and start + lanes <= half:
        for i in range(count):
            copy(source, rows, i * columns + start, 2 * i * lanes)
            copy(source, rows, i * columns + half + start, (2 * i + 1) * lanes)
        return
    _clear(rows, 0, 2 * lanes * count)
    for i in range(count):
        for lane in range(min(lanes, half - start)):
            rows[2 * i * lanes + lane] = source[i * columns + start + lane]
        for lane in range(min(lanes, columns - half - start)):
            rows[(2 * i + 1) * lanes + lane] = source[i * columns + half + start + lane]


@njit(cache=True, error_model="numpy")
def _unload(rows, target, lanes, start, half, columns):
    """Undo `_load`."""
    count = target.size // columns
    if half + start + lanes <= columns and start + lanes <= half:
        for i in range(count):
            copy(rows, target, 2 * i * lanes, i * columns + start)
            copy(rows, target, (2 * i + 1) * lanes, i * columns + half + start)
        return
    for i in range(count):
        for lane in range(min(lanes, half - start)):
            target[i * columns + start + lane] = rows[2 * i * lanes + lane]
        for lane in range(min(lanes, columns - half - start)):
            target[i * columns + half + start + lane] = rows[(2 * i + 1) * lanes + lane]


@njit(cache=True, error_model="numpy")
def _split_columns(rows, spectra, start, plan):
    """Store the spectra of the columns with the wavenumbers q_x in the lanes."""
    lanes, length = plan.lanes, plan.line_x.length
    row, width = 2 * lanes, plan.spectra.shape[1]
    for block in range(plan.spectra.shape[0]):
        for lane in range(lanes):
            mode = min(block * lanes + lane, length // 2)
            opposite = length - mode if mode > 0 else 0
            part(
                rows, plan.square, mode * row, opposite * row, 2 * lane * row, (2 * lane + 1) * row
            )
        left = (block * width + start) * row
        right = left + width // 2 * row
        for piece in range(2):
            transpose(plan.square, spectra, piece * lanes, 2 * row, left + piece * lanes, row)
            transpose(
                plan.square, spectra, row + piece * lanes, 2 * row, right + piece * lanes, row
            )


@njit(cache=True, error_model="numpy")
def _join_columns(spectra, rows, start, plan):
    """Undo `_split_columns`."""
    lanes, length = plan.lanes, plan.line_x.length
    row, width = 2 * lanes, plan.spectra.shape[1]
    for block in range(plan.spectra.shape[0]):
        left = (block * width + start) * row
        right = left + width // 2 * row
        for piece in range(2):
            transpose(spectra, plan.square, left + piece * lanes, row, piece * lanes, 2 * row)
            transpose(
                spectra, plan.square, right + piece * lanes, row, row + piece * lanes, 2 * row
            )
        for lane in range(min(lanes, length // 2 + 1 - block * lanes)):
            mode = block * lanes + lane
            opposite = length - mode if mode > 0 else 0
            join(
                plan.square, rows, 2 * lane * row, (2 * lane + 1) * row, mode * row, opposite * row
            )


@njit(cache=True, error_model="numpy")
def _second_axis(spectra, block, half, columns, plan):
    """Transform a block of wavenumbers q_x along y, multiply, and transform it back."""
    lanes, width = plan.lanes, plan.spectra.shape[1]
    row, length = 2 * lanes, plan.line_y.length
    base = block * width * row
    # the columns come as two halves, each padded to whole vectors
    gap = (width // 2 - half) * row
    for j in range(2 * columns):
        place = base + j * lanes + (gap if j >= 2 * half else 0)
        copy(spectra, plan.first, place, j * lanes)
    _clear(plan.first, columns * row, length * row)
    rows, other = plan.first, plan.second
    for backward in range(2):
        rows, other = _transform(rows, other, lanes, plan.line_y, backward)
        if not backward:
            for mode in range(length):
                scale(rows, plan.transfer, mode * row, (block * length + mode) * lanes)
    for j in range(2 * columns):
        place = base + j * lanes + (gap if j >= 2 * half else 0)
        copy(rows, spectra, j * lanes, place)
