"""Field types of scene files, with validation and conversion to SI units."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, ValidationInfo
from pydantic_core import PydanticCustomError

from comparisons.facts.methods import METHODS, is_known
from comparisons.reasons import near
from comparisons.scene.units import LENGTH, NUMBER, PRESSURE, Dimension, to_si

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
