"""Validation of study.json, because a results folder may be untrusted."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, TypeAdapter, ValidationError, model_validator

from comparisons.results.header import Form, Header
from comparisons.scene.problems import first_problems


class _Method(Form):
    method: str
    supported: bool
    reason: str = ""
    resolutions: list[int] = Field(default=[])
    modelled: str = ""
    numbers: list[int] = Field(default=[])
    title: str = ""


class _LeftOut(Form):
    effect: str = Field(alias="what")
    reason: str = Field(alias="why")


class _SwitchedOn(Form):
    physics: str = Field(alias="what")
    model: str = Field(alias="how")


class _Measured(Form):
    penetration: list[float]
    force: list[float]
    modulus: Annotated[float, Field(gt=0)]
    fit_zero: bool

    @model_validator(mode="after")
    def _of_pairs(self) -> Self:
        if len(self.penetration) != len(self.force):
            raise ValueError("expected as many forces as penetrations")
        return self


class _Roughness(Form):
    wavenumber: list[Annotated[float, Field(gt=0)]]
    density: list[Annotated[float, Field(gt=0)]]
    statistics: dict[str, float]

    @model_validator(mode="after")
    def _of_pairs(self) -> Self:
        if len(self.wavenumber) != len(self.density):
            raise ValueError("expected as many densities as wavenumbers")
        missing = {"rms_height", "rms_slope", "rms_curvature", "nayak"} - set(self.statistics)
        if missing or not self.statistics["rms_curvature"] > 0:
            raise ValueError("expected the statistics of a rough surface")
        return self


class _Plan(Form):
    methods: list[_Method]
    measured: _Measured | None = Field(default=None)
    roughness: _Roughness | None = Field(default=None)
    switched_on: list[_SwitchedOn] = Field(default=[])
    left_out: list[_LeftOut]
    notes: list[str]


class _Bar(Form):
    bar: float | None
    step: int


class _Reference(Form):
    """Empty where a scene has no truth."""

    method: str = ""
    resolution: int = 0
    text: str = ""
    uncertainty: dict[str, float | None] = Field(default={})
    sources: dict[str, dict[str, float | None]] = Field(default={})
    bars: dict[str, _Bar] = Field(default={})

    @model_validator(mode="after")
    def _whole_or_empty(self) -> Self:
        if self.model_fields_set and not {"method", "resolution", "text"} <= self.model_fields_set:
            raise ValueError("expected method, resolution and text, or nothing at all")
        return self


class _Scene(Form):
    name: str
    title: str
    text: str
    control: str
    axis: str = ""
    quantities: list[str]
    tolerance: Annotated[float, Field(gt=0, lt=1)]
    plan: _Plan
    reference: _Reference
    answer: str
    disagreements: list[str]
    fields: list[tuple[str, int, str]]


class _Run(Form):
    created: str
    command: str
    seconds: float
    machine: dict[str, str | int | float | None]


class _Study(Header):
    source: str = ""
    part: str = ""
    runs: list[_Run] = Field(default=[])
    scenes: list[_Scene]


_FORM = TypeAdapter(_Study)


def parse_study(text: str) -> dict[str, Any]:
    """Read study.json.

    Raises
    ------
    ValueError
        Naming the first few invalid entries.
    """
    try:
        return _FORM.validate_json(text).model_dump(exclude_unset=True, by_alias=True)
    except ValidationError as error:
        raise ValueError(first_problems(error, "study.json")) from error
