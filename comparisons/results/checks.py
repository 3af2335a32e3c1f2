"""Validation of study.json, of tables and of fields read from a results folder.

A folder may be untrusted or edited by hand, so every deviation from roughline's format is reported
before the data are used.
"""

from __future__ import annotations

from typing import Annotated, Any, Self

import numpy as np
import pandas as pd
from pydantic import Field, TypeAdapter, ValidationError, model_validator

from comparisons.judging.verdicts import NO_RESULT, NOT_RESOLVED, OUTSIDE, WITHIN
from comparisons.results.header import Form, Header
from comparisons.scene.problems import first_problems
from comparisons.tasks.shown_loads import NAMES, at_step, stored_steps

VERDICTS = (WITHIN, OUTSIDE, NOT_RESOLVED, NO_RESULT)
# Columns that must be there, and what may stand in them; all other columns are read with care.
TEXTS = {
    "rows": ("scene", "method"),
    "measures": ("scene", "method", "quantity", "at", "verdict"),
    "distributions": ("scene", "method", "quantity"),
}
NUMBERS = {
    "rows": ("resolution", "step"),
    "measures": ("resolution", "rms", "maximum"),
    "distributions": ("resolution", "low", "high", "amount"),
}
LARGEST_RESOLUTION = 2**31
# Arrays that belong together: of one dimension and one length.
TOGETHER = (
    ("profile_x", "profile_height"),
    ("line_x", "line_height"),
    ("pressure_x", "pressure_y", "pressure", "pressure_weight"),
    ("pressure", "displacement", "gap"),
)
SCALARS = ("penetration", "profile_spacing", "line_penetration", "particle_spacing")
POINTS = ("mesh_points", "mesh_displacement", "particle_places", "particle_displacement")
# Arrays with a row for each particle.
PARTICLES = ("particle_places", "particle_displacement", "particle_von_mises")


def with_columns(table: pd.DataFrame, kind: str) -> pd.DataFrame:
    """Return a table; without rows (nothing was solved), it has the columns that readers expect."""
    if len(table) or "scene" not in table:
        return table
    return table.reindex(columns=list(dict.fromkeys([*table, *TEXTS[kind], *NUMBERS[kind]])))


def table_problems(table: pd.DataFrame, kind: str) -> list[str]:
    """Return what is wrong with a table; `kind` is a key of `TEXTS` ("rows": results.csv)."""
    if not len(table) and "scene" in table:
        return []
    missing = [name for name in (*TEXTS[kind], *NUMBERS[kind]) if name not in table]
    if missing:
        return [f"column {name}: missing" for name in missing]
    problems = [
        f"column {name}: expected a text in every row"
        for name in TEXTS[kind]
        if table[name].isna().any() or not (table[name].astype(str).str.len() > 0).all()
    ]
    for name in NUMBERS[kind]:
        number = pd.to_numeric(table[name], errors="coerce")
        if (number.isna() & table[name].notna()).any():
            problems.append(f"column {name}: expected numbers")
    level = pd.to_numeric(table["resolution"], errors="coerce").dropna()
    if not ((level >= 0) & (level <= LARGEST_RESOLUTION)).all():
        problems.append(f"column resolution: expected numbers from 0 to {LARGEST_RESOLUTION}")
    if "verdict" in table and not table["verdict"].isin(VERDICTS).all():
        problems.append(f"column verdict: expected {', '.join(VERDICTS)}")
    return problems


def field_problems(fields: dict[str, np.ndarray]) -> list[str]:
    """Return what is wrong with the arrays of one solution, at the last load and before."""
    problems = _problems_at_one_load(fields)
    for step in stored_steps(fields) if not problems else ():
        earlier = _problems_at_one_load(_pressure_at(fields, step))
        problems += [f"step {step}: {problem}" for problem in earlier]
    return problems


def _pressure_at(fields: dict[str, np.ndarray], step: int) -> dict[str, np.ndarray]:
    """Return the arrays that an earlier load has of its own."""
    return {name: value for name, value in at_step(fields, step).items() if name in NAMES}


def _problems_at_one_load(fields: dict[str, np.ndarray]) -> list[str]:
    names = {name for group in TOGETHER for name in group} | {*SCALARS, *POINTS}
    arrays = {name: value for name, value in fields.items() if name in names}
    problems = [
        f"{name}: expected numbers"
        for name, value in arrays.items()
        if value.dtype.kind not in "iuf"
    ]
    problems += [
        f"{name}: expected one number"
        for name in SCALARS
        if name in arrays and arrays[name].size != 1
    ]
    problems += [
        f"{name}: expected points (n, 3)"
        for name in POINTS
        if name in arrays and (arrays[name].ndim != 2 or arrays[name].shape[1] != 3)
    ]
    for group in TOGETHER:
        shapes = {arrays[name].shape for name in group if name in arrays}
        if len(shapes) > 1 or any(len(shape) != 1 or shape == (0,) for shape in shapes):
            problems.append(f"{', '.join(group)}: expected lists of one length")
    return problems + _shape_problems(fields)


def _shape_problems(fields: dict[str, np.ndarray]) -> list[str]:
    """Check the arrays that say how others are laid out."""
    problems = []
    shape = fields.get("pressure_shape")
    if shape is not None and (
        shape.shape != (2,)
        or shape.dtype.kind not in "iu"
        or int(np.prod(shape)) != fields.get("pressure", np.empty(0)).size
    ):
        problems.append("pressure_shape: expected the two numbers of cells of the pressure")
    heights = fields.get("heights")
    if heights is not None:
        size, contact = fields.get("size"), fields.get("contact")
        if heights.ndim != 2 or heights.dtype.kind not in "iuf" or min(heights.shape) < 1:
            problems.append("heights: expected a map of numbers")
        if size is None or size.shape != (2,) or size.dtype.kind not in "iuf":
            problems.append("size: expected two numbers")
        if contact is not None and contact.shape != heights.shape:
            problems.append("contact: expected a map like that of the heights")
    if len({np.shape(fields[name])[:1] for name in PARTICLES if name in fields}) > 1:
        problems.append(f"{', '.join(PARTICLES)}: expected a row for each particle")
    cells, points = fields.get("mesh_cells"), fields.get("mesh_points")
    if cells is not None and (
        cells.ndim != 2
        or cells.dtype.kind not in "iu"
        or points is None
        or not ((cells >= 0) & (cells < len(points))).all()
    ):
        problems.append("mesh_cells: expected numbers of mesh points")
    return problems


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
