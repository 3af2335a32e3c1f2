"""The elastic bodies: [half_space], [counter_body], and a user's mesh in place of them, [body]."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from comparisons.scene.fields import (
    LENGTH,
    FiniteLength,
    Length,
    Modulus,
    SceneTable,
    fail,
    flagged,
    to_si,
)

FEM_DEFAULT_POISSON = 0.3
# What validation is told about a scene: its moduli stand in [viscoelastic].
RELAXES = "relaxes"

CONSTANTS = ("youngs_modulus", "shear_modulus", "effective_modulus", "poisson_ratio")
# Keys that make a half-space depend on depth.
DEPTH_KEYS = ("layers", "thickness", "grading")


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _poisson(value: Any) -> float:
    if not _number(value) or not -1 < value <= 0.5:
        raise fail("expected a number with -1 < nu <= 0.5", value)
    return float(value)


def _exponent(value: Any) -> float:
    if not _number(value) or not -1 < value < 1:
        raise fail(
            "expected a number with -1 < k < 1: with k of one and above no pressure has a finite "
            "displacement",
            value,
        )
    return float(value)


PoissonRatio = Annotated[float, BeforeValidator(_poisson)]


class Layer(SceneTable):
    """One elastic layer, bonded to what lies below."""

    thickness: Length
    youngs_modulus: Modulus
    poisson_ratio: PoissonRatio


class Grading(SceneTable):
    """A modulus E (z/depth)^exponent, E that of the table, at all depths z."""

    exponent: Annotated[float, BeforeValidator(_exponent)]
    depth: Length


class HalfSpace(SceneTable):
    """Elastic half-space: E and nu, or G and nu, or E* alone."""

    youngs_modulus: Modulus | None = None
    shear_modulus: Modulus | None = None
    effective_modulus: Modulus | None = None
    poisson_ratio: Annotated[float | None, BeforeValidator(_poisson)] = None
    layers: tuple[Layer, ...] = ()  # on top of it, from the surface down, bonded
    thickness: Length | None = None  # of a layer on a rigid base in place of the half-space, bonded
    grading: Grading | None = None  # the modulus as a power of the depth

    @model_validator(mode="after")
    def _one_way(self, info: ValidationInfo) -> HalfSpace:
        constants = {name for name in CONSTANTS if getattr(self, name) is not None}
        ways = (
            {"youngs_modulus", "poisson_ratio"},
            {"shear_modulus", "poisson_ratio"},
            {"effective_modulus"},
        )
        if constants not in ways and not (
            flagged(info, RELAXES) and constants == {"poisson_ratio"}
        ):
            raise fail(
                "expected youngs_modulus and poisson_ratio, or shear_modulus and poisson_ratio, "
                f"or effective_modulus alone, got {', '.join(sorted(constants)) or 'nothing'}"
            )
        return self

    @property
    def uniform(self) -> bool:
        """Whether it is the same at all depths."""
        return not self.layers and self.thickness is None and self.grading is None

    @property
    def modulus(self) -> float:
        """Effective modulus E* = E / (1 - nu^2) = 2 G / (1 - nu)."""
        if self.effective_modulus is not None:
            return self.effective_modulus
        nu = self.poisson_ratio or 0.0
        if self.shear_modulus is not None:
            return 2 * self.shear_modulus / (1 - nu)
        assert self.youngs_modulus is not None
        return self.youngs_modulus / (1 - nu**2)

    @property
    def elastic_constants(self) -> tuple[float, float]:
        """E and nu; nu = 0.3 where only E* is given (normal contact depends on E* alone)."""
        return self.modulus * (1 - self.nu**2), self.nu

    @property
    def nu(self) -> float:
        """Poisson ratio, 0.3 where only E* is given."""
        return FEM_DEFAULT_POISSON if self.poisson_ratio is None else self.poisson_ratio


AXES = "xyz"
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
    elastic = {key: body[key] for key in CONSTANTS if key in body}
    remaining = {key: value for key, value in body.items() if key not in elastic}
    return data | {"half_space": elastic, "body": remaining}
