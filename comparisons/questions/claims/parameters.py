"""Tables of a claim: its sides, what it is tested along, and what it leaves open."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, StrictBool, field_validator, model_validator

from comparisons.facts.quantities import quantity
from comparisons.scene.fields import (
    Finite,
    KnownMethod,
    Positive,
    SceneTable,
    dimension_of,
    fail,
    number_and_unit,
    to_si,
)

RESOLUTION = "resolution"
MOST_STEPS = 200
MOST_BISECTIONS = 40
MOST_PRINTED = 4  # members of a list


def _listed(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


Name = Annotated[str, Field(min_length=1, max_length=200)]
Prose = Annotated[str, Field(min_length=1, max_length=2000)]
Names = Annotated[tuple[Name, ...], BeforeValidator(_listed), Field(min_length=1)]
Choice = bool | float | str


class Place(SceneTable):
    """Where the points of a claim stand among the numbers of scenes."""

    along: Name | None = None
    parameter: Prose | None = None  # in words, if not that of the claim
    unit: Positive = 1.0  # by which the claim's parameter is divided
    quantity: tuple[Name, ...] = ()  # if not that of the claim
    tolerance: Positive | None = None  # of the one claim of a family that stands for all


class Side(SceneTable):
    """What is stated or true: a scene that is solved, or a number that is known already."""

    # Where they differ from the claim's own.
    scene: Name | None = None
    changes: dict[str, Any] = Field(default_factory=dict)
    method: KnownMethod | None = None  # of the true side; by default the best reference there is
    # In place of a scene; the uncertainty is half of its last digit, in its unit.
    number: Finite | None = None
    unit: Annotated[str, Field(max_length=40)] = ""
    uncertainty: Annotated[Finite, Field(ge=0)] = 0.0
    source: Annotated[str, Field(max_length=300)] = ""

    @model_validator(mode="after")
    def _a_scene_or_a_number(self) -> Side:
        if self.number is None and (self.unit or self.uncertainty or self.source):
            raise fail("expected a number beside unit, uncertainty and source")
        if self.number is not None:
            if self.scene or self.changes or self.method:
                raise fail("expected either a number or a scene")
            if not self.number or not self.source:
                raise fail("expected a number other than zero, and its source")
        return self

    @property
    def solved(self) -> bool:
        """Whether it is a scene."""
        return self.number is None

    def same_scene(self, other: Side) -> bool:
        """Whether both sides are solved on one scene."""
        both = self.solved and other.solved
        return both and (self.scene, self.changes) == (other.scene, other.changes)

    def in_si(self, quantities: Iterable[str]) -> tuple[float, float]:
        """Return the number of these quantities, and its half-width, in their unit."""
        units = {dimension_of(quantity(name).unit) for name in quantities}
        try:
            (dimension,) = units
            number, width = (
                to_si(f"{value!r} {self.unit}", dimension)
                for value in (self.number, self.uncertainty)
            )
        except ValueError as error:
            raise fail(f"expected a unit of the quantity ({error})", self.unit) from error
        return number, width

    @property
    def words(self) -> str:
        """What it is, for the page of a claim."""
        if not self.solved:
            return f"{self.number:g} {self.unit} ({self.source})"
        options = "".join(f", {key} = {value}" for key, value in _leaves(self.changes).items())
        return f"the scene {self.scene}{options}"


def _leaves(table: dict[str, Any]) -> dict[str, str]:
    """Return the values in words by their dotted keys; of a key that is set twice the last one.

    >>> _leaves({"loading": {"time": [0, "1 s"], "substeps": 10}, "loading.time": [0, "2 s"]})
    {'loading.time': '[0, 2 s]', 'loading.substeps': '10'}
    >>> _leaves({"indenter.vertices": 6 * [["1 mm", "0 mm"]], "loading.penetration": ["1 um"]})
    {'indenter.vertices': '6 points', 'loading.penetration': '1 um'}
    """
    leaves: dict[str, str] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            leaves |= {f"{key}.{name}": text for name, text in _leaves(value).items()}
        elif not isinstance(value, list):
            leaves[key] = str(value)
        elif len(value) > MOST_PRINTED or any(isinstance(item, list) for item in value):
            leaves[key] = f"{len(value)} points"
        else:
            texts = [str(item) for item in value]
            leaves[key] = texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"
    return leaves


class Span(SceneTable):
    """A parameter between two ends."""

    # Keys of the scene that get the value (``indenter.radius_x``; numbers index lists), or
    # ``resolution`` of the judged method; experiments define their parameter.
    path: Annotated[tuple[Name, ...], BeforeValidator(_listed)] = ()
    name: Annotated[str, Field(max_length=100)] = ""  # in words, with its symbol; or the path
    spacing: Literal["linear", "log"] = "linear"  # the scale of grids, draws and bisections
    # Factor between the number and the value in the scene ("10 mm").
    unit: Annotated[str, Field(max_length=40)] = ""
    integer: StrictBool = False  # whole numbers only (points, terms, springs)
    # Number of bisections of an interval with a boundary at full effort; at quick effort half as
    # many of one between whose ends the error changes its sign.
    bisections: Annotated[int, Field(strict=True, ge=0, le=MOST_BISECTIONS)] = 6

    @field_validator("unit")
    @classmethod
    def _readable_unit(cls, value: str) -> str:
        if value:
            try:
                number_and_unit(value)
            except ValueError as error:
                raise fail(f"expected a number with a unit ({error})", value) from error
        return value

    @property
    def is_integer(self) -> bool:
        """Whether the parameter takes whole numbers only."""
        return self.integer or self.path == (RESOLUTION,)

    def halvings(self, effort: str) -> int:
        """Return the number of bisections of an interval."""
        return self.bisections if effort == "full" else self.bisections // 2

    def value(self, number: float) -> Any:
        """Return the value in the scene for a number: a multiple of the unit, as text."""
        if self.is_integer:
            return int(number)
        if not self.unit:
            return number
        factor, unit = number_and_unit(self.unit)
        return f"{float(number * factor)!r} {unit}"

    def between(self, low: float, high: float, share: float = 0.5) -> float:
        """Return the number at a share of the way from `low` to `high` on the parameter's scale."""
        if self.spacing == "log":
            middle = float(low ** (1 - share) * high**share)
        else:
            middle = low + share * (high - low)
        return float(round(middle)) if self.is_integer else middle


def _check_ends(start: float, end: float, spacing: str) -> None:
    if not start < end:
        raise fail(f"expected from < to, got from = {start:g}, to = {end:g}")
    if spacing == "log" and start <= 0:
        raise fail("expected from > 0 for logarithmic spacing", start)


class Premise(SceneTable):
    """A condition of the statement that ends at a value of the claim's own parameter."""

    to: Finite
    # In words, as "the real area is far below the apparent one".
    condition: Annotated[str, Field(min_length=1, max_length=200)]


class Vary(Span, populate_by_name=True):
    """The parameter along which a claim is tested, and the grid of values for the search."""

    start: Annotated[Finite, Field(alias="from")]
    end: Annotated[Finite, Field(alias="to")]
    steps: Annotated[int, Field(strict=True, ge=2, le=MOST_STEPS)]

    @model_validator(mode="after")
    def _a_range(self) -> Vary:
        _check_ends(self.start, self.end, self.spacing)
        return self

    def numbers(self) -> list[float]:
        """Return the initial values of the parameter, with exact end points."""
        spaced = np.geomspace if self.spacing == "log" else np.linspace
        inner = spaced(self.start, self.end, self.steps)[1:-1]
        values = [self.start, *(float(value) for value in inner), self.end]
        return list(dict.fromkeys(float(round(v)) for v in values)) if self.is_integer else values

    def halvings(self, effort: str) -> int:
        """Return the number of bisections: one more where quick effort left out values."""
        left_out = effort == "quick" and len(self.numbers()) > 3
        return super().halvings(effort) + left_out


class Nuisance(Span, populate_by_name=True):
    """A parameter that the statement leaves open, with the range that it plainly covers."""

    path: Names  # keys of the scene, or a keyword of the experiment
    name: Prose
    stated: Choice  # the value at which the claim is measured along its own parameter
    # The range, or `values`, the choices (readings, kinds of boundary); `stated` is one
    # of them.
    start: Annotated[Finite | None, Field(alias="from")] = None
    end: Annotated[Finite | None, Field(alias="to")] = None
    values: tuple[Choice, ...] = ()
    labels: tuple[Name, ...] = ()  # the choices in words, in the order of `values`
    reason: Prose  # what of the statement covers the range, or leaves the choice open
    bisections: Annotated[int, Field(strict=True, ge=0, le=MOST_BISECTIONS)] = 3

    @model_validator(mode="after")
    def _a_range_or_choices(self) -> Nuisance:
        if self.values:
            if self.start is not None or self.end is not None:
                raise fail("expected either values, or from and to")
            if len(self.values) < 2 or self.stated not in self.values:
                raise fail("expected two values or more, with the stated one among them")
            if self.labels and len(self.labels) != len(self.values):
                raise fail("expected as many labels as values")
            return self
        if self.start is None or self.end is None:
            raise fail("expected from and to, or values")
        _check_ends(self.start, self.end, self.spacing)
        if isinstance(self.stated, (bool, str)) or not self.start <= self.stated <= self.end:
            raise fail("expected a stated value between from and to", self.stated)
        return self

    @property
    def key(self) -> str:
        """What names the parameter among those of a claim."""
        return ", ".join(self.path)

    def numbers(self) -> list[float]:
        """Return the ends of the range and the stated value, or the places of the choices."""
        if self.values:
            return [float(place) for place in range(len(self.values))]
        assert self.start is not None
        assert self.end is not None
        return sorted({float(self.start), self.stated_number, float(self.end)})

    @property
    def stated_number(self) -> float:
        """The stated value, or its place among the choices."""
        return float(self.values.index(self.stated) if self.values else self.stated)

    def draw(self, share: float) -> float:
        """Return the number at a share in [0, 1) of the range, or the place of a choice."""
        if self.values:
            return float(int(share * len(self.values)))
        assert self.start is not None
        assert self.end is not None
        return self.between(self.start, self.end, share)

    def value(self, number: float) -> Any:
        """Return the value for a number: a choice by its place, else as for every parameter."""
        return self.values[int(number)] if self.values else super().value(number)

    @property
    def choices(self) -> list[str]:
        """The choices in words, none where the parameter is a number."""
        return list(self.labels or map(str, self.values))


class Map(SceneTable):
    """A validity map: the claim's own parameter across, one that the statement leaves open up."""

    up: Name
    rows: Annotated[int, Field(strict=True, ge=2, le=MOST_STEPS)] = 4
