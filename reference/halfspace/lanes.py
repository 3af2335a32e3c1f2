"""Vector code of the transforms: butterflies, squares of vectors, pairs of opposite wavenumbers.

Numba leaves it to LLVM to find vectors in a loop, and LLVM gives up on a butterfly, which reads and
writes streams that might overlap: the loops stay scalar and take three to seven times as long.
These intrinsics write the vector code themselves, for any processor (LLVM splits vectors of 64
bytes where registers are shorter): 8 numbers in double, 16 in single precision.

Arrays are flat, offsets are in numbers and not checked: only `transforms` calls these. Complex
vectors are a vector of real parts and behind it one of imaginary parts; in a *row* all real parts
come first.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable
from functools import reduce
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic as numba_intrinsic

LANE_BYTES = 64
RADICES = (8, 5, 4, 3, 2)

# x*y + z in one rounding where the processor can; nothing is reordered.
_FUSED = ("contract",)
_WORD, _INDEX = ir.IntType(64), ir.IntType(32)

Complex = tuple[Any, Any]

# calls have one argument less than the function: its context
intrinsic: Any = numba_intrinsic


class _Lanes:
    """Vectors of one flat array, while their code is generated."""

    def __init__(self, context: Any, builder: Any, kind: Any, value: Any) -> None:
        self.builder = builder
        array = context.make_array(kind)(context, builder, value)
        self.data, self.size = array.data, array.nitems
        self.bytes = kind.dtype.bitwidth // 8
        self.count = LANE_BYTES // self.bytes
        self.vector = ir.VectorType(context.get_data_type(kind.dtype), self.count)

    def at(self, offset: Any, number: int, step: Any) -> Any:
        """Return offset + number * step."""
        return self.builder.add(offset, self.builder.mul(step, ir.Constant(_WORD, number)))

    def after(self, offset: Any, number: int) -> Any:
        return self.builder.add(offset, ir.Constant(_WORD, number))

    def _address(self, offset: Any) -> Any:
        address = self.builder.gep(self.data, [offset])
        return self.builder.bitcast(address, self.vector.as_pointer())

    def load(self, offset: Any) -> Any:
        return self.builder.load(self._address(offset), align=self.bytes)

    def store(self, value: Any, offset: Any) -> None:
        self.builder.store(value, self._address(offset), align=self.bytes)

    def plane(self) -> Any:
        """Return where the imaginary parts of a row begin."""
        return self.builder.lshr(self.size, ir.Constant(_WORD, 1))

    def load_complex(self, offset: Any, plane: Any = None) -> Complex:
        """Return a complex vector, the imaginary part behind the real one or in its own plane."""
        return self.load(offset), self.load(self._imaginary(offset, plane))

    def store_complex(self, value: Complex, offset: Any, plane: Any = None) -> None:
        self.store(value[0], offset)
        self.store(value[1], self._imaginary(offset, plane))

    def _imaginary(self, offset: Any, plane: Any) -> Any:
        return self.after(offset, self.count) if plane is None else self.builder.add(offset, plane)

    def spread(self, offset: Any) -> Any:
        """Return one number in all lanes."""
        return self.fill(self.builder.load(self.builder.gep(self.data, [offset])))

    def fill(self, scalar: Any) -> Any:
        empty = ir.Constant(self.vector, ir.Undefined)
        first = self.builder.insert_element(empty, scalar, ir.Constant(_INDEX, 0))
        return self.shuffle(first, empty, [0] * self.count)

    def shuffle(self, x: Any, y: Any, picks: list[int]) -> Any:
        mask = ir.Constant(ir.VectorType(_INDEX, len(picks)), picks)
        return self.builder.shuffle_vector(x, y, mask)

    def mirrored(self, x: Complex) -> Complex:
        """Return the conjugate, lanes in reverse."""
        real, imaginary = (self.shuffle(y, y, list(range(self.count))[::-1]) for y in x)
        return real, self.negative(imaginary)

    def constant(self, value: float) -> Any:
        return ir.Constant(self.vector, [float(value)] * self.count)

    def plus(self, x: Any, y: Any) -> Any:
        return self.builder.fadd(x, y, flags=_FUSED)

    def minus(self, x: Any, y: Any) -> Any:
        return self.builder.fsub(x, y, flags=_FUSED)

    def times(self, x: Any, y: Any) -> Any:
        return self.builder.fmul(x, y, flags=_FUSED)

    def negative(self, x: Any) -> Any:
        return self.builder.fneg(x)

    def add(self, x: Complex, y: Complex) -> Complex:
        return self.plus(x[0], y[0]), self.plus(x[1], y[1])

    def subtract(self, x: Complex, y: Complex) -> Complex:
        return self.minus(x[0], y[0]), self.minus(x[1], y[1])

    def multiply(self, x: Complex, y: Complex) -> Complex:
        real = self.minus(self.times(x[0], y[0]), self.times(x[1], y[1]))
        return real, self.plus(self.times(x[0], y[1]), self.times(x[1], y[0]))

    def turn(self, x: Complex, number: int, of: int) -> Complex:
        """Return exp(-2 pi i number/of) x."""
        eighths = 8 * number / of
        if eighths == 0:
            return x
        if eighths >= 4:
            return tuple(map(self.negative, self.turn(x, number - of // 2, of)))
        if eighths >= 2:
            real, imaginary = self.turn(x, number - of // 4, of)
            return imaginary, self.negative(real)
        if eighths == 1:
            half = self.constant(0.5**0.5)
            sums = self.plus(x[0], x[1]), self.minus(x[1], x[0])
            return self.times(half, sums[0]), self.times(half, sums[1])
        factor = cmath.exp(-2j * cmath.pi * number / of)
        return self.multiply(x, (self.constant(factor.real), self.constant(factor.imag)))

    def transform(self, values: list[Complex]) -> list[Complex]:
        """Return the discrete Fourier transform of a handful of vectors."""
        radix = len(values)
        if radix == 1:
            return values
        if radix % 2:
            return self._odd_transform(values)
        even, odd = self.transform(values[0::2]), self.transform(values[1::2])
        turned = [self.turn(value, k, radix) for k, value in enumerate(odd)]
        pairs = list(zip(even, turned, strict=True))
        return [self.add(x, y) for x, y in pairs] + [self.subtract(x, y) for x, y in pairs]

    def _odd_transform(self, values: list[Complex]) -> list[Complex]:
        """Return a transform of odd length; inputs k and n - k share cosines and sines."""
        radix, half = len(values), len(values) // 2
        pairs = [(values[k], values[radix - k]) for k in range(1, half + 1)]
        sums = [self.add(x, y) for x, y in pairs]
        differences = [self.turn(self.subtract(x, y), 1, 4) for x, y in pairs]
        result = [values[0]] * radix
        for total in sums:
            result[0] = self.add(result[0], total)
        for j in range(1, half + 1):
            factors = [
                cmath.exp(2j * cmath.pi * (j * k % radix) / radix) for k in range(1, half + 1)
            ]
            even = self._summed([1.0, *(x.real for x in factors)], [values[0], *sums])
            odd = self._summed([x.imag for x in factors], differences)
            result[j], result[radix - j] = self.add(even, odd), self.subtract(even, odd)
        return result

    def _summed(self, factors: list[float], values: list[Complex]) -> Complex:
        """Return the sum of vectors times real factors."""
        terms = [
            (self.times(self.constant(factor), x), self.times(self.constant(factor), y))
            for factor, (x, y) in zip(factors, values, strict=True)
        ]
        return reduce(self.add, terms)

    def transpose(self, rows: list[Any]) -> list[Any]:
        """Exchange off-diagonal halves of ever larger blocks."""
        rows, count, step = list(rows), len(rows), 1
        while step < count:
            lower = [k if k & step == 0 else count + k - step for k in range(count)]
            upper = [k + step if k & step == 0 else count + k for k in range(count)]
            for k in (k for k in range(count) if k & step == 0):
                pair = rows[k], rows[k + step]
                rows[k], rows[k + step] = (self.shuffle(*pair, mask) for mask in (lower, upper))
            step *= 2
        return rows


def _swapped(value: Complex) -> Complex:
    return value[1], value[0]


def _lanes(context: Any, builder: Any, signature: Any, args: Any, number: int) -> list[_Lanes]:
    pairs = zip(signature.args[:number], args[:number], strict=True)
    return [_Lanes(context, builder, kind, value) for kind, value in pairs]


def _butterfly(radix: int, *, backward: bool) -> Callable[..., Any]:
    """Return the intrinsic of one radix: factors after the transform, backward before it."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        lanes, turns = _lanes(context, builder, signature, args, 2)
        first, step, turn = args[2:]
        places = [lanes.at(first, k, step) for k in range(radix)]
        values = [lanes.load_complex(place) for place in places]

        def turned(values: list[Complex]) -> list[Complex]:
            after = [turns.after(turn, 2 * k) for k in range(radix - 1)]
            factors = [(turns.spread(k), turns.spread(turns.after(k, 1))) for k in after]
            pairs = zip(values[1:], factors, strict=True)
            return [values[0], *(lanes.multiply(*pair) for pair in pairs)]

        if backward:  # exchanged parts reverse a transform
            values = list(map(_swapped, lanes.transform(turned(list(map(_swapped, values))))))
        else:
            values = turned(lanes.transform(values))
        for place, value in zip(places, values, strict=True):
            lanes.store_complex(value, place)
        return context.get_dummy_value()

    def butterfly(context, vectors, turns, first, step, turn):
        """Transform the complex vectors at first + k step in place."""
        return types.void(vectors, turns, *[types.intp] * 3), generate

    return intrinsic(butterfly)


FORTH = {radix: _butterfly(radix, backward=False) for radix in RADICES}
BACK = {radix: _butterfly(radix, backward=True) for radix in RADICES}


@intrinsic
def square(context, vectors, row, turns, places, k):
    """Transform across lanes: as many vectors, k and following, into a row.

    `places` says where a vector is. Vectors times their factors are transposed and transformed; the
    results lie `places.size` numbers apart.
    """

    def generate(context, builder, signature, args):
        lanes, target, factors = _lanes(context, builder, signature, args, 3)
        sources = context.make_array(signature.args[3])(context, builder, args[3])
        values = []
        for i in range(lanes.count):
            index = lanes.after(args[4], i)
            value = lanes.load_complex(builder.load(builder.gep(sources.data, [index])))
            factor = factors.load_complex(
                builder.mul(index, ir.Constant(_WORD, lanes.count)), factors.plane()
            )
            values.append(lanes.multiply(value, factor))
        parts = [lanes.transpose([value[part] for value in values]) for part in (0, 1)]
        for i, value in enumerate(lanes.transform(list(zip(*parts, strict=True)))):
            target.store_complex(value, target.at(args[4], i, sources.nitems), target.plane())
        return context.get_dummy_value()

    return types.void(vectors, row, turns, places, k), generate


def _pairs(combine: Callable[..., tuple[Complex, Complex]]) -> Callable[..., Any]:
    """Return the intrinsic that combines wavenumbers of a row with their opposites, in place."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        lanes, turns = _lanes(context, builder, signature, args, 2)
        k, plane = args[2], lanes.plane()
        opposite = builder.sub(plane, lanes.after(k, lanes.count - 1))
        there = lanes.mirrored(lanes.load_complex(opposite, plane))
        here = lanes.load_complex(k, plane)
        here, there = combine(lanes, here, there, turns.load_complex(k, plane))
        lanes.store_complex(here, k, plane)
        lanes.store_complex(there, opposite, plane)
        return context.get_dummy_value()

    def pairs(context, row, turns, k):
        """Combine the vector at k with that which ends at the opposite of k."""
        return types.void(row, turns, k), generate

    return intrinsic(pairs)


def _untangled(lanes: _Lanes, x: Complex, y: Complex, factor: Complex) -> tuple[Complex, Complex]:
    even, odd = lanes.add(x, y), lanes.turn(lanes.subtract(x, y), 1, 4)
    odd = lanes.multiply(odd, factor)
    return lanes.add(even, odd), lanes.mirrored(lanes.subtract(even, odd))


def _tangled(lanes: _Lanes, x: Complex, y: Complex, factor: Complex) -> tuple[Complex, Complex]:
    even, odd = lanes.add(x, y), lanes.subtract(x, y)
    odd = lanes.multiply(odd, (factor[0], lanes.negative(factor[1])))
    odd = lanes.turn(odd, 3, 4)
    here, there = lanes.add(even, odd), lanes.mirrored(lanes.subtract(even, odd))
    return _swapped(here), _swapped(there)


# Twice the spectrum of a real row from that of its neighbours taken as complex numbers, and back,
# real and imaginary parts exchanged for a transform forth that is one back.
untangle, tangle = _pairs(_untangled), _pairs(_tangled)


@intrinsic
def part(context, numbers, vectors, k):
    """Take neighbours from 2 k on as complex numbers, into a vector."""

    def generate(context, builder, signature, args):
        read, write = _lanes(context, builder, signature, args, 2)
        place = builder.shl(args[2], ir.Constant(_WORD, 1))
        pair = read.load_complex(place)
        parts = [read.shuffle(*pair, list(range(k, 2 * read.count, 2))) for k in (0, 1)]
        write.store_complex(tuple(parts), place)
        return context.get_dummy_value()

    return types.void(numbers, vectors, k), generate


@intrinsic
def join(context, row, numbers, k, factor):
    """Undo `part` from a row of exchanged parts; times a factor."""

    def generate(context, builder, signature, args):
        read, write = _lanes(context, builder, signature, args, 2)
        count, by = read.count, read.fill(args[3])
        odd, even = (read.times(x, by) for x in read.load_complex(args[2], read.plane()))
        order = [k // 2 + count * (k % 2) for k in range(2 * count)]
        pair = tuple(read.shuffle(even, odd, half) for half in (order[:count], order[count:]))
        write.store_complex(pair, builder.shl(args[2], ir.Constant(_WORD, 1)))
        return context.get_dummy_value()

    return types.void(row, numbers, k, row.dtype), generate


@intrinsic
def put(context, rows, vectors, k, plane, place):
    """Copy a vector of a row, whose imaginary parts are a plane behind, to a place."""

    def generate(context, builder, signature, args):
        read, write = _lanes(context, builder, signature, args, 2)
        write.store_complex(read.load_complex(args[2], args[3]), args[4])
        return context.get_dummy_value()

    return types.void(rows, vectors, k, plane, place), generate


@intrinsic
def take(context, vectors, rows, place, k, plane):
    """Undo `put`."""

    def generate(context, builder, signature, args):
        read, write = _lanes(context, builder, signature, args, 2)
        write.store_complex(read.load_complex(args[2]), args[3], args[4])
        return context.get_dummy_value()

    return types.void(vectors, rows, place, k, plane), generate


@intrinsic
def scale(context, vectors, factors, place, k):
    """Multiply a complex vector by a vector of real factors, from k on."""

    def generate(context, builder, signature, args):
        lanes, reals = _lanes(context, builder, signature, args, 2)
        by = reals.load(args[3])
        value = lanes.load_complex(args[2])
        lanes.store_complex(tuple(lanes.times(x, by) for x in value), args[2])
        return context.get_dummy_value()

    return types.void(vectors, factors, place, k), generate
