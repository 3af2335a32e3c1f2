"""Field types of scene files, and quantities with units, converted to SI on input.

A number is taken as SI; a text is a number and a unit: ``"1 mm"``, ``"210 GPa"``, ``"40 m^-2"``,
``"20 mJ/m^2"``. Decimal prefixes are applied in decimal arithmetic and rounded once, so that
``"10 nm"`` is the very same float as ``1e-8``.
"""

from __future__ import annotations

import math
import re
import sys
from dataclasses import dataclass
from decimal import Context, Decimal, InvalidOperation
from typing import Annotated, Any, Literal, NamedTuple, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, ValidationInfo
from pydantic_core import PydanticCustomError

from comparisons.facts.methods import METHODS, is_known
from comparisons.reasons import near


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

_PREFIXES = {"f": -15, "p": -12, "n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3, "c": -2, "d": -1}
_PREFIXES |= {"h": 2, "k": 3, "M": 6, "G": 9, "T": 12}
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


_NOTHING = object()


class SceneTable(BaseModel):
    """A table of a scene file: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def fail(expected: str, came: Any = _NOTHING) -> PydanticCustomError:
    """Make the one kind of error of scene files: what was expected, and what came."""
    text = expected if came is _NOTHING else f"{expected}, got {excerpt(came)}"
    return PydanticCustomError("scene", text)


def flagged(info: ValidationInfo, key: str) -> bool:
    """Whether validation is told this about the scene that a table belongs to (its context)."""
    return bool((info.context or {}).get(key, False))


def excerpt(value: Any) -> str:
    """Return a value as it may stand in a one-line message, cut where it is long."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


Sign = Literal["positive", "not negative", "any"]


@dataclass(frozen=True, slots=True)
class WithUnit(BeforeValidator):
    """A pydantic validator that knows the dimension of what it reads."""

    dimension: Dimension = NUMBER


def quantity(dimension: Dimension, *, sign: Sign = "positive", kind: str = "number") -> WithUnit:
    """Return a validator for a finite quantity of one dimension."""

    def check(value: Any) -> float:
        try:
            number = to_si(value, dimension)
        except ValueError as error:
            raise fail(str(error), value) from error
        wrong = {"positive": number <= 0, "not negative": number < 0, "any": False}[sign]
        if wrong or not math.isfinite(number):
            raise fail(f"expected a {'' if sign == 'any' else sign + ' '}finite {kind}", value)
        # Below it floats lose digits, and the smallest product is zero.
        if 0 < abs(number) < sys.float_info.min:
            raise fail(f"expected a {kind} of at least {sys.float_info.min:.2g}", value)
        return number

    return WithUnit(check, dimension=dimension)


_READABLE = {
    "a plain number": "",
    "kg s^-2": "J/m²",
    "kg m^-1 s^-1": "Pa s",
    "kg^-1 m s^2": "1/Pa",
    "m s^-1": "m/s",
    "m^-1": "1/m",
}


def unit_of(field: Any) -> str:
    """Return the unit of a field of a table, from the validator that reads it."""
    waiting = [*field.metadata, field.annotation]
    while waiting:
        part = waiting.pop()
        if isinstance(part, WithUnit):
            return _READABLE.get(str(part.dimension), str(part.dimension))
        waiting += [*getattr(part, "__metadata__", ()), *get_args(part)]
    return ""


Length = Annotated[float, quantity(LENGTH, kind="length")]
FiniteLength = Annotated[float, quantity(LENGTH, sign="any", kind="length")]
Modulus = Annotated[float, quantity(PRESSURE, kind="modulus")]
Positive = Annotated[float, quantity(NUMBER)]
Finite = Annotated[float, quantity(NUMBER, sign="any")]


def _method_name(name: str) -> str:
    if not is_known(name.lower()):
        text = f"expected one of {', '.join(METHODS)}, got {excerpt(name)}"
        raise fail(text + near(name, METHODS))
    return name.lower()


KnownMethod = Annotated[str, AfterValidator(_method_name)]
