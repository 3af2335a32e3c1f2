"""The table [plasticity]."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from comparisons.formatting import unpadded, with_unit
from comparisons.scene.fields import PRESSURE, Finite, fail, quantity
from comparisons.scene.physics.tables.physics_table import PhysicsTable

# H/Y of full yield: 2.8 under a rigid ball by Tabor (1951), 2.84 between a deformable ball and a
# rigid flat while a << R (Jackson & Green 2005).
HARDNESS = 2.84


class Plasticity(PhysicsTable):
    """A half-space that yields (von Mises, isotropic hardening).

    Below a rigid indenter; below a rough surface its pressure is capped at 2.84 yield_stress.
    """

    key = "plasticity"
    place = 4.5
    adds = ("residual_depth",)
    remembers = True
    two_constants = "where a body yields depends on both elastic constants"
    apart: ClassVar = {
        other: f"{motion} on a half-space that yields is not modelled"
        for other, motion in {
            "rolling": "rolling",
            "friction": "friction",
            "viscoelastic": "relaxation",
            "sliding": "sliding",
            "adhesion": "adhesion",
            "dynamics": "an impact",
        }.items()
    }
    one_body = True

    yield_stress: Annotated[float, quantity(PRESSURE, kind="yield stress")]  # Y in uniaxial tension
    # Slope of the flow stress over the plastic strain; 0: perfectly plastic.
    hardening: Annotated[float, quantity(PRESSURE, sign="not negative", kind="slope")] = 0.0
    # n of the flow stress Y (1 + E p/Y)^n, in place of a slope.
    hardening_exponent: Annotated[Finite, Field(ge=0, lt=1)] = 0.0
    # How the reduced model reads "use the stress for the yield criterion": all of a spring's
    # deflection counts ("stress") or its elastic part ("elastic_root"); Zunker & Kamrin's springs;
    # or it stays elastic ("none").
    model: Literal["stress", "elastic_root", "zunker_kamrin", "none"] = "stress"

    @model_validator(mode="after")
    def _one_law(self) -> Plasticity:
        if self.hardening and self.hardening_exponent:
            raise fail("expected one of hardening and hardening_exponent, got both")
        return self

    @property
    def hardens(self) -> bool:
        """Whether the flow stress rises with the plastic strain."""
        return bool(self.hardening or self.hardening_exponent)

    @property
    def hardness(self) -> float:
        """H, the mean pressure of full yield, in Pa."""
        return HARDNESS * self.yield_stress

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        law = "perfectly plastic"
        if self.hardening:
            law = f"linear hardening, slope {with_unit(self.hardening, 'Pa')}"
        if self.hardening_exponent:
            law = f"Y (1 + E p/Y)^n, n = {unpadded(self.hardening_exponent, '')}"
        return "plasticity", f"von Mises, Y = {with_unit(self.yield_stress, 'Pa')}, {law}"
