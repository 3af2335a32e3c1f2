"""The tables [half_space] and [counter_body]: an elastic half-space, with layers or graded."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, ValidationInfo, model_validator

from comparisons.scene.fields import Length, Modulus, SceneTable, fail, flagged

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
