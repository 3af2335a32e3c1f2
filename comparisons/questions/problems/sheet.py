"""Problem sheets: a scene, the quantities that are asked for, and what is known of them.

A sheet states its reference with the half-width of its error, and what theorems enclose; or it
is sealed, and states only a hash of the rounded reference: its recipe, the scene, gives the numbers
again, and the hash shows that they are those which were sealed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError

from comparisons.errors import InputError
from comparisons.facts.quantities import CURVES
from comparisons.scene.fields import Positive, SceneTable
from comparisons.scene.problems import in_file
from comparisons.scene.scene import Scene, load_scene
from comparisons.scene.toml_files import read_toml

FOLDER = Path(__file__).with_name("sheets")
Text = Annotated[str, Field(min_length=1, max_length=2000)]
Values = tuple[float, ...]
BAR_DIGITS = 2


class Known(SceneTable):
    """What is known of a quantity at every load: the value, its bar, a proved interval."""

    values: Values
    bars: Values
    lower: Values = ()
    upper: Values = ()


class Seal(SceneTable):
    """The hash of the values of all quantities, rounded, and of their bars."""

    digits: Annotated[int, Field(ge=2, le=12)]
    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class Sheet(SceneTable):
    """A problem sheet."""

    id: Annotated[str, Field(pattern=r"^RL-\d{3}$")]
    version: Annotated[int, Field(ge=1)] = 1
    title: Text
    definition: Text
    source: Text
    licence: Text = "CC0-1.0"
    quantities: tuple[str, ...]
    tolerance: Positive = 0.01
    tables: dict[str, Any] = Field(alias="scene")
    reference: dict[str, Known] = Field(default_factory=dict)
    sealed: Seal | None = None

    @cached_property
    def scene(self) -> Scene:
        """The scene as roughline solves it."""
        compare = {"quantities": list(self.quantities), "tolerance": self.tolerance}
        tables = {**self.tables, "compare": {**self.tables.get("compare", {}), **compare}}
        return load_scene({"name": self.id.lower(), "title": self.title, **tables})


def builtin_sheets() -> dict[str, Sheet]:
    """Return the sheets by id, in the order of their numbers."""
    sheets = [read_sheet(path) for path in sorted(FOLDER.glob("*.toml"))]
    return {sheet.id: sheet for sheet in sheets}


def sheet_of(name: str) -> Sheet:
    """Return a sheet by its id, in capitals or not.

    Raises
    ------
    InputError
        If there is none.
    """
    sheets = builtin_sheets()
    if name.upper() not in sheets:
        raise InputError(f"problem: expected one of {', '.join(sheets)}, got {name!r}")
    return sheets[name.upper()]


def read_sheet(path: Path) -> Sheet:
    """Read a sheet.

    Raises
    ------
    InputError
        With all that is wrong with it.
    """
    try:
        sheet = Sheet.model_validate(read_toml(path))
    except ValidationError as error:
        problems = in_file(error, Sheet)
        raise InputError("\n".join([f"{path.name}:", *problems])) from error
    unknown = [name for name in sheet.quantities if name not in CURVES]
    if unknown:
        raise InputError(f"{path.name}: quantities: not a curve: {', '.join(unknown)}")
    return sheet


def seal(known: Mapping[str, Known], digits: int) -> Seal:
    """Return the seal of what is known of all quantities: values, and bars, which judge as well.

    >>> one, other = (Known(values=(value,), bars=(1e-3,)) for value in (1.00004, 1.00001))
    >>> seal({"force": one}, 4) == seal({"force": other}, 4)
    True
    """

    def written(values: Values, digits: int) -> str:
        return " ".join(f"{value:.{digits - 1}e}" for value in values)

    lines = [
        f"{name}: {written(part.values, digits)} bars {written(part.bars, BAR_DIGITS)}"
        for name, part in sorted(known.items())
    ]
    return Seal(digits=digits, sha256=hashlib.sha256("\n".join(lines).encode()).hexdigest())
