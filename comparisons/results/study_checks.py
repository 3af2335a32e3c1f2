"""The form of study.json, checked when it is read: a results folder may come from strangers."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, model_validator


class _Form(BaseModel):
    """Types as JSON has them; keys that a later version adds are kept."""

    model_config = ConfigDict(strict=True, extra="allow", allow_inf_nan=False)


class _Method(_Form):
    method: str
    supported: bool
    reason: str = ""
    resolutions: list[int] = []
    modelled: str = ""


class _LeftOut(_Form):
    what: str
    why: str


class _SwitchedOn(_Form):
    what: str
    how: str


class _Plan(_Form):
    methods: list[_Method]
    switched_on: list[_SwitchedOn] = []
    left_out: list[_LeftOut]
    notes: list[str]


class _Bar(_Form):
    bar: float | None
    step: int


class _Reference(_Form):
    """Empty where a scene has no truth."""

    method: str = ""
    resolution: int = 0
    text: str = ""
    uncertainty: dict[str, float | None] = {}
    sources: dict[str, dict[str, float | None]] = {}
    bars: dict[str, _Bar] = {}

    @model_validator(mode="after")
    def _whole_or_empty(self) -> Self:
        if self.model_fields_set and not {"method", "resolution", "text"} <= self.model_fields_set:
            raise ValueError("expected method, resolution and text, or nothing at all")
        return self


class _Scene(_Form):
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


class _Run(_Form):
    created: str
    command: str
    seconds: float
    machine: dict[str, str | int | float | None]


class _Study(_Form):
    created: str
    command: str
    effort: str
    seconds: float
    machine: dict[str, str | int | float | None]
    versions: dict[str, str]
    interrupted: bool
    source: str = ""
    part: str = ""
    runs: list[_Run] = []
    scenes: list[_Scene]


_FORM = TypeAdapter(_Study)


def parse_study(text: str) -> dict[str, Any]:
    """Read study.json.

    Raises
    ------
    ValueError
        Naming the first few places that are not as they should be.
    """
    try:
        return _FORM.validate_json(text).model_dump(exclude_unset=True)
    except ValidationError as error:
        places = [
            f"{'.'.join(str(key) for key in each['loc']) or 'study.json'}: {each['msg']}"
            for each in error.errors(include_url=False, include_input=False)[:3]
        ]
        raise ValueError("; ".join(places)) from error
