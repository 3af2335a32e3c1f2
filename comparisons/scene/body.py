"""The [body] table: a user's mesh in place of the half-space, with its supports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from comparisons.scene.fields import FiniteLength, SceneTable, fail
from comparisons.scene.units import LENGTH, to_si

AXES = "xyz"
ELASTIC_KEYS = ("youngs_modulus", "shear_modulus", "effective_modulus", "poisson_ratio")
Name = Annotated[str, Field(min_length=1, max_length=200)]


def _length_unit(value: Any) -> Any:
    try:
        if not isinstance(value, str) or not 0.0 < to_si(f"1 {value}", LENGTH) < float("inf"):
            raise ValueError
    except ValueError as error:
        raise fail('expected the unit of the file\'s coordinates, such as "mm"', value) from error
    return value


def _support(value: Any) -> Any:
    """Bring "fixed", "roller", "xy" or ["x", "y"] to "roller" or the held directions in order."""
    text = value
    if isinstance(value, (list, tuple)) and all(isinstance(axis, str) for axis in value):
        text = "".join(value)
    if text in ("roller", "fixed"):
        return "roller" if text == "roller" else AXES
    if not isinstance(text, str) or not text or len(set(text)) != len(text) or set(text) - {*AXES}:
        raise fail('expected "fixed", "roller", or held directions such as "x", "xy"', value)
    return "".join(sorted(text))


def _supports(value: Any) -> Any:
    if not isinstance(value, Mapping) or not value:
        raise fail('expected a table of supports such as { bottom = "fixed" }', value)
    return value


Support = Annotated[str, BeforeValidator(_support)]


class Body(SceneTable):
    """A mesh from a file: what presses on it where, and what holds it."""

    file: Annotated[str, Field(min_length=1, max_length=4096)]
    # Of the coordinates in the file, which itself does not know.
    length_unit: Annotated[str, BeforeValidator(_length_unit)]
    contact_surface: Name  # named faces that the indenter may touch
    # Name -> "fixed", "roller" (no displacement along the normal) or held directions.
    supports: Annotated[dict[Name, Support], BeforeValidator(_supports)]
    # Where the indenter moves, in the coordinates of the file.
    direction: Literal["+x", "-x", "+y", "-y", "+z", "-z"] = "-z"
    # Of the indenter's axis, in the two other coordinates (alphabetical); default: the centre of
    # the contact surface.
    position: tuple[FiniteLength, FiniteLength] | None = None
    # Of how many equal parts the mesh is one; forces and areas are those of all.
    symmetric_parts: Annotated[int, Field(strict=True, ge=1, le=1000)] = 1

    @property
    def unit(self) -> float:
        """The length unit in metres."""
        return to_si(f"1 {self.length_unit}", LENGTH)


def with_material(data: dict[str, Any]) -> dict[str, Any]:
    """Move elastic constants that stand in [body] to [half_space], where there is none.

    They belong to the same elastic body; where both tables have them, validation objects.
    """
    body = data.get("body")
    if not isinstance(body, dict) or "half_space" in data:
        return data
    elastic = {key: body[key] for key in ELASTIC_KEYS if key in body}
    remaining = {key: value for key, value in body.items() if key not in elastic}
    return data | {"half_space": elastic, "body": remaining}
