"""The tables [half_space] and [counter_body]: an elastic half-space."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationInfo, field_validator, model_validator

from comparisons.scene.fields import Modulus, fail, flagged

FEM_DEFAULT_POISSON = 0.3
# What validation is told about a scene: its moduli stand in [viscoelastic].
RELAXES = "relaxes"


class HalfSpace(BaseModel):
    """Elastic half-space: E and nu, or G and nu, or E* alone."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    youngs_modulus: Modulus | None = None
    shear_modulus: Modulus | None = None
    effective_modulus: Modulus | None = None
    poisson_ratio: float | None = None

    @field_validator("poisson_ratio", mode="before")
    @classmethod
    def _poisson_range(cls, value: Any) -> Any:
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not number or not -1 < value <= 0.5:
            raise fail("expected a number with -1 < nu <= 0.5", value)
        return float(value)

    @model_validator(mode="after")
    def _one_way(self, info: ValidationInfo) -> HalfSpace:
        constants = {name for name in type(self).model_fields if getattr(self, name) is not None}
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
    def has_modulus(self) -> bool:
        """Whether the table has a modulus; beside [viscoelastic] it needs none."""
        return any((self.youngs_modulus, self.shear_modulus, self.effective_modulus))

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
