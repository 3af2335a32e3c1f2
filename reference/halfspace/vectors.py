"""Vector instructions for the transforms: butterflies and transpositions of whole registers.

Numba leaves it to LLVM to find vectors in a loop, and LLVM gives up on a butterfly, which reads and
writes eight streams that might overlap: the loops stay scalar and take three to seven times as
long. These intrinsics write the vector code themselves, for any processor (LLVM splits 64-byte
vectors where the registers are shorter). A *row* is one complex number per lane: `lanes` real
parts, then as many imaginary parts, 64 bytes each, so 8 lanes in double and 16 in single precision.

All offsets are in elements of flat arrays and are not checked: only `convolution` calls these.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

LANE_BYTES = 64
RADICES = (8, 5, 4, 3, 2)

# x*y + z in one rounding where the processor can; nothing is reordered.
_FUSED = ("contract",)
_WORD = ir.IntType(64)
_INDEX = ir.IntType(32)
_OFFSET = types.intp

Complex = tuple[Any, Any]


class _Lanes:
    """Loads and stores of vectors in one flat array, while its code is being generated."""

    def __init__(self, context: Any, builder: Any, array: Any, value: Any) -> None:
        self.builder = builder
        self.data = context.make_array(array)(context, builder, value).data
        self.align = array.dtype.bitwidth // 8
        self.count = LANE_BYTES // self.align
        self.vector = ir.VectorType(context.get_data_type(array.dtype), self.count)

    def _address(self, offset: Any) -> Any:
        address = self.builder.gep(self.data, [offset])
        return self.builder.bitcast(address, self.vector.as_pointer())

    def load(self, offset: Any) -> Any:
        return self.builder.load(self._address(offset), align=self.align)

    def store(self, value: Any, offset: Any) -> None:
        self.builder.store(value, self._address(offset), align=self.align)

    def load_complex(self, offset: Any, swapped: Any = None) -> Complex:
        """Real and imaginary lanes of a row, exchanged where `swapped` is 1."""
        return tuple(self.load(place) for place in self._halves(offset, swapped))

    def store_complex(self, value: Complex, offset: Any, swapped: Any = None) -> None:
        for part, place in zip(value, self._halves(offset, swapped), strict=True):
            self.store(part, place)

    def _halves(self, offset: Any, swapped: Any) -> tuple[Any, Any]:
        if swapped is None:
            return offset, self.after(offset, self.count)
        shift = self.builder.mul(swapped, ir.Constant(_WORD, self.count))
        real = self.builder.add(offset, shift)
        return real, self.builder.sub(self.after(offset, self.count), shift)

    def after(self, offset: Any, elements: int) -> Any:
        return self.builder.add(offset, ir.Constant(_WORD, elements))

    def at(self, offset: Any, step: Any, number: int) -> Any:
        """Return offset + number * step."""
        return self.builder.add(offset, self.builder.mul(step, ir.Constant(_WORD, number)))

    def spread(self, offset: Any) -> Any:
        """One element in all lanes."""
        scalar = self.builder.load(self.builder.gep(self.data, [offset]))
        empty = ir.Constant(self.vector, ir.Undefined)
        first = self.builder.insert_element(empty, scalar, ir.Constant(_INDEX, 0))
        everywhere = ir.Constant(ir.VectorType(_INDEX, self.count), [0] * self.count)
        return self.builder.shuffle_vector(first, empty, everywhere)

    def constant(self, value: float) -> Any:
        return ir.Constant(self.vector, [float(value)] * self.count)

    def plus(self, x: Any, y: Any) -> Any:
        return self.builder.fadd(x, y, flags=_FUSED)

    def minus(self, x: Any, y: Any) -> Any:
        return self.builder.fsub(x, y, flags=_FUSED)

    def times(self, x: Any, y: Any) -> Any:
        return self.builder.fmul(x, y, flags=_FUSED)


def _add(lanes: _Lanes, x: Complex, y: Complex) -> Complex:
    return lanes.plus(x[0], y[0]), lanes.plus(x[1], y[1])


def _subtract(lanes: _Lanes, x: Complex, y: Complex) -> Complex:
    return lanes.minus(x[0], y[0]), lanes.minus(x[1], y[1])


def _turn(lanes: _Lanes, x: Complex) -> Complex:
    """Return -i x."""
    return x[1], lanes.minus(lanes.constant(-0.0), x[0])


def _multiply(lanes: _Lanes, x: Complex, y: Complex) -> Complex:
    real = lanes.minus(lanes.times(x[0], y[0]), lanes.times(x[1], y[1]))
    return real, lanes.plus(lanes.times(x[0], y[1]), lanes.times(x[1], y[0]))


def _transform(lanes: _Lanes, values: list[Complex]) -> list[Complex]:
    """Discrete Fourier transform of a handful of vectors, exp(-2 pi i j k/n)."""
    radix = len(values)
    if radix == 1:
        return values
    if radix % 2:
        return _odd_transform(lanes, values)
    even, odd = _transform(lanes, values[0::2]), _transform(lanes, values[1::2])
    turned = [_eighth(lanes, value, 8 * k // radix) for k, value in enumerate(odd)]
    sums = [_add(lanes, x, y) for x, y in zip(even, turned, strict=True)]
    return sums + [_subtract(lanes, x, y) for x, y in zip(even, turned, strict=True)]


def _eighth(lanes: _Lanes, value: Complex, eighths: int) -> Complex:
    """Turn by exp(-2 pi i eighths/8), eighths from 0 to 3."""
    if eighths >= 2:
        value = _turn(lanes, value)
    if eighths % 2 == 0:
        return value
    half = lanes.constant(math.sqrt(0.5))
    real, imaginary = value
    return (
        lanes.times(half, lanes.plus(real, imaginary)),
        lanes.times(half, lanes.minus(imaginary, real)),
    )


def _odd_transform(lanes: _Lanes, values: list[Complex]) -> list[Complex]:
    """Transform of odd length; inputs k and n - k share their cosines and sines."""
    radix, half = len(values), len(values) // 2
    pairs = [(values[k], values[radix - k]) for k in range(1, half + 1)]
    sums = [_add(lanes, x, y) for x, y in pairs]
    differences = [_turn(lanes, _subtract(lanes, x, y)) for x, y in pairs]
    result = [values[0]] * radix
    for total in sums:
        result[0] = _add(lanes, result[0], total)
    for j in range(1, half + 1):
        even, odd = values[0], None
        for k in range(1, half + 1):
            angle = 2 * math.pi * (j * k % radix) / radix
            cosine, sine = lanes.constant(math.cos(angle)), lanes.constant(math.sin(angle))
            even = _add(lanes, even, tuple(lanes.times(cosine, x) for x in sums[k - 1]))
            part = tuple(lanes.times(sine, x) for x in differences[k - 1])
            odd = part if odd is None else _add(lanes, odd, part)
        result[j], result[radix - j] = _add(lanes, even, odd), _subtract(lanes, even, odd)
    return result


def _butterfly(radix: int) -> Callable[..., Any]:
    """Return the intrinsic for one radix."""

    def typed(source: Any, target: Any, twiddles: Any) -> Any:
        signature = types.void(source, target, twiddles, *[_OFFSET] * 6)

        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            read, write, turns = (
                _Lanes(context, builder, kind, value)
                for kind, value in zip(signature.args[:3], args[:3], strict=True)
            )
            first, step, into, stride, turn, swapped = args[3:]
            values = [read.load_complex(read.at(first, step, k), swapped) for k in range(radix)]
            for k, value in enumerate(_transform(read, values)):
                if k:
                    place = turns.after(turn, 2 * (k - 1))
                    factor = turns.spread(place), turns.spread(turns.after(place, 1))
                    value = _multiply(read, value, factor)
                write.store_complex(value, write.at(into, stride, k), swapped)
            return context.get_dummy_value()

        return signature, generate

    def butterfly(context, source, target, twiddles, first, step, into, stride, turn, swapped):
        """Transform rows first + k step of the source, twiddle, store at into + k stride.

        With `swapped` = 1 real and imaginary parts change places on both sides, which reverses
        the transform: one code for both directions is half as much to compile.
        """
        return typed(source, target, twiddles)

    return intrinsic(butterfly)


BUTTERFLIES = {radix: _butterfly(radix) for radix in RADICES}


def _pair(kinds: Any, context: Any, builder: Any, args: Any) -> tuple[_Lanes, _Lanes]:
    return tuple(
        _Lanes(context, builder, kind, a) for kind, a in zip(kinds[:2], args, strict=False)
    )


@intrinsic
def copy(context, source, target, first, into):
    """Copy one vector."""
    signature = types.void(source, target, _OFFSET, _OFFSET)

    def generate(context, builder, signature, args):
        read, write = _pair(signature.args, context, builder, args)
        write.store(read.load(args[2]), args[3])
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def scale(context, rows, factors, row, factor):
    """Multiply a row by one real vector of factors."""
    signature = types.void(rows, factors, _OFFSET, _OFFSET)

    def generate(context, builder, signature, args):
        lanes, real = _pair(signature.args, context, builder, args)
        by = real.load(args[3])
        values = lanes.load_complex(args[2])
        lanes.store_complex(tuple(lanes.times(value, by) for value in values), args[2])
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def multiply(context, rows, factors, row, factor):
    """Multiply a row by one complex number."""
    signature = types.void(rows, factors, _OFFSET, _OFFSET)

    def generate(context, builder, signature, args):
        lanes, single = _pair(signature.args, context, builder, args)
        by = single.spread(args[3]), single.spread(single.after(args[3], 1))
        lanes.store_complex(_multiply(lanes, lanes.load_complex(args[2]), by), args[2])
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def part(context, rows, spectra, row, mirrored, left, right):
    """Split a row and the one of the opposite wavenumber into the spectra of two real fields.

    Twice the spectrum of the real part goes to `left`, of the imaginary part to `right`.
    """
    signature = types.void(rows, spectra, *[_OFFSET] * 4)

    def generate(context, builder, signature, args):
        read, write = _pair(signature.args, context, builder, args)
        (real, imaginary), (other_real, other_imaginary) = map(read.load_complex, args[2:4])
        first = read.plus(real, other_real), read.minus(imaginary, other_imaginary)
        second = read.plus(imaginary, other_imaginary), read.minus(other_real, real)
        write.store_complex(first, args[4])
        write.store_complex(second, args[5])
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def join(context, spectra, rows, left, right, row, mirrored):
    """Undo `part`: rows of left + i right at a wavenumber and its opposite."""
    signature = types.void(spectra, rows, *[_OFFSET] * 4)

    def generate(context, builder, signature, args):
        read, write = _pair(signature.args, context, builder, args)
        (real, imaginary), (right_real, right_imaginary) = map(read.load_complex, args[2:4])
        opposite = read.plus(real, right_imaginary), read.minus(right_real, imaginary)
        # the zero mode is its own opposite: the row itself is written last and is right for it
        write.store_complex(opposite, args[5])
        itself = read.minus(real, right_imaginary), read.plus(imaginary, right_real)
        write.store_complex(itself, args[4])
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def transpose(context, source, target, first, step, into, stride):
    """Transpose a square of as many vectors as there are lanes."""
    signature = types.void(source, target, *[_OFFSET] * 4)

    def generate(context, builder, signature, args):
        read, write = _pair(signature.args, context, builder, args)
        rows = [read.load(read.at(args[2], args[3], k)) for k in range(read.count)]
        for k, row in enumerate(_transposed(builder, rows)):
            write.store(row, write.at(args[4], args[5], k))
        return context.get_dummy_value()

    return signature, generate


def _transposed(builder: Any, rows: list[Any]) -> list[Any]:
    """Exchange off-diagonal halves of ever larger blocks."""
    count, step = len(rows), 1
    while step < count:
        lower = [k if k & step == 0 else count + k - step for k in range(count)]
        upper = [k + step if k & step == 0 else count + k for k in range(count)]
        masks = [ir.Constant(ir.VectorType(_INDEX, count), mask) for mask in (lower, upper)]
        for k in (k for k in range(count) if k & step == 0):
            pair = rows[k], rows[k + step]
            rows[k], rows[k + step] = (builder.shuffle_vector(*pair, mask) for mask in masks)
        step *= 2
    return rows
