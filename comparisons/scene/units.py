"""Quantities with units, converted to SI on input.

A number is taken as SI; a text is a number and a unit: ``"1 mm"``, ``"210 GPa"``, ``"40 m^-2"``,
``"20 mJ/m^2"``. Decimal prefixes are applied in decimal arithmetic and rounded once, so that
``"10 nm"`` is the very same float as ``1e-8``.
"""

from __future__ import annotations

import re
from decimal import Context, Decimal, InvalidOperation
from typing import NamedTuple


class Dimension(NamedTuple):
    """Exponents of kilogram, metre and second."""

    mass: int = 0
    length: int = 0
    time: int = 0

    def __str__(self) -> str:
        """Return the SI unit in base units, for example ``kg m^-1 s^-2``."""
        names = {FORCE: "N", PRESSURE: "Pa", NUMBER: "a plain number"}
        if self in names:
            return names[self]
        parts = zip(("kg", "m", "s"), self, strict=True)
        return " ".join(u if n == 1 else f"{u}^{n}" for u, n in parts if n)


NUMBER = Dimension()
LENGTH = Dimension(length=1)
FORCE = Dimension(1, 1, -2)
PRESSURE = Dimension(1, -1, -2)
TIME = Dimension(time=1)
SPEED = Dimension(0, 1, -1)
MASS = Dimension(mass=1)
VISCOSITY = Dimension(1, -1, -1)
SURFACE_ENERGY = Dimension(1, 0, -2)
WEAR_COEFFICIENT = Dimension(-1, 1, 2)

_PREFIXES = {
    "f": -15,
    "p": -12,
    "n": -9,
    "u": -6,
    "µ": -6,
    "μ": -6,
    "m": -3,
    "c": -2,
    "d": -1,
    "h": 2,
    "k": 3,
    "M": 6,
    "G": 9,
    "T": 12,
}
_UNITS = {
    "m": (0, LENGTH),
    "g": (-3, Dimension(mass=1)),
    "s": (0, Dimension(time=1)),
    "N": (0, FORCE),
    "Pa": (0, PRESSURE),
    "J": (0, Dimension(1, 2, -2)),
    "Hz": (0, Dimension(time=-1)),
}
_NUMBER_TEXT = r"[+-]?(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"\s*({_NUMBER_TEXT})\s*(.*?)\s*", re.DOTALL)
_FACTOR = re.compile(r"([A-Za-zµμ%]+)(?:\^?([+-]?\d{1,2}))?")
_BELOW = re.compile(r"/\s*\(([^()/]+)\)")
# Beyond this a decimal exponent is no measurement, and would make the arithmetic slow.
_LARGEST_EXPONENT = 400
# More digits than a text may have: the default 28 would round once before the float rounds.
_ALL_DIGITS = Context(prec=100)


def to_si(value: object, dimension: Dimension) -> float:
    """Convert a number (SI) or a text with a unit to SI; ValueError says what was expected.

    >>> to_si("10 nm", LENGTH) == 1e-8
    True
    >>> to_si("210 GPa", PRESSURE)
    210000000000.0
    >>> to_si("40 m^-2", Dimension(length=-2)), to_si("2 mm^3/(N m)", WEAR_COEFFICIENT)
    (40.0, 2e-09)
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ValueError(_expectation(dimension))
    if isinstance(value, str):
        match = _QUANTITY.fullmatch(value)
        if match is None or len(value) > 100:
            raise ValueError(_expectation(dimension))
        try:
            number = Decimal(match[1].replace("_", ""))
        except InvalidOperation as error:
            raise ValueError(_expectation(dimension)) from error
        exponent, unit = _unit(match[2], dimension)
        if unit != dimension and (number or match[2]):  # zero needs no unit
            got = f"one of {unit}" if match[2] else "none"
            raise ValueError(f"expected a unit of {dimension}, got {got}")
        if abs(number.adjusted()) > _LARGEST_EXPONENT:
            raise ValueError("expected a number within the range of floats")
        return float(number.scaleb(exponent, _ALL_DIGITS))
    try:
        return float(value)
    except OverflowError as error:
        raise ValueError("expected a number within the range of floats") from error


def number_and_unit(text: str) -> tuple[float, str]:
    """Split a text such as "10 mm" into number and unit; ValueError where it has no number.

    >>> number_and_unit("10 mm")
    (10.0, 'mm')
    """
    match = _QUANTITY.fullmatch(text)
    if match is None or len(text) > 100:
        raise ValueError('expected a number with a unit such as "10 mm"')
    return float(match[1].replace("_", "")), match[2]


def dimension_of(unit: str) -> Dimension:
    """Return the dimension of a unit.

    >>> str(dimension_of("mN/m2"))
    'Pa'
    """
    return _unit(unit, NUMBER)[1]


def _expectation(dimension: Dimension) -> str:
    if dimension == NUMBER:
        return "expected a number"
    examples = {
        LENGTH: '"1 mm"',
        FORCE: '"5 N"',
        PRESSURE: '"210 GPa"',
        TIME: '"2 ms"',
        SPEED: '"1 mm/s"',
        MASS: '"10 g"',
        VISCOSITY: '"0.1 Pa s"',
        SURFACE_ENERGY: '"50 mJ/m^2"',
        WEAR_COEFFICIENT: '"2e-13 m^3/(N m)"',
    }
    example = examples.get(dimension, f'"1 {dimension}"')
    return f"expected a number in {dimension} or a text with a unit such as {example}"


def _unit(text: str, dimension: Dimension) -> tuple[int, Dimension]:
    """Return the decimal exponent and the dimension of a unit such as ``mJ/m^2``."""
    exponent, total = 0, NUMBER
    # m^3/(N m) is m^3/N/m
    text = _BELOW.sub(lambda below: "/" + "/".join(re.split(r"[\s*]+", below[1].strip())), text)
    numerator, *denominators = text.split("/")
    for sign, part in [(1, numerator), *((-1, denominator) for denominator in denominators)]:
        for factor in part.replace("*", " ").split():
            if sign == 1 and factor == "1" and denominators:
                continue
            match = _FACTOR.fullmatch(factor)
            if match is None:
                raise ValueError(f"{_expectation(dimension)}; {factor[:20]!r} is no unit")
            symbol, power = match[1], sign * int(match[2] or 1)
            if symbol == "%":
                power_of_ten, base = -2, NUMBER
            elif symbol in _UNITS:
                power_of_ten, base = _UNITS[symbol]
            elif symbol[0] in _PREFIXES and symbol[1:] in _UNITS:
                power_of_ten, base = _UNITS[symbol[1:]]
                power_of_ten += _PREFIXES[symbol[0]]
            else:
                raise ValueError(f"{_expectation(dimension)}; {symbol[:20]!r} is no known unit")
            exponent += power * power_of_ten
            total = Dimension(*(t + power * b for t, b in zip(total, base, strict=True)))
    return exponent, total
