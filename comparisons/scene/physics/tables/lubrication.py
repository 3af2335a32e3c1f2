"""The table [lubrication]."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from comparisons.formatting import unpadded
from comparisons.scene.fields import (
    LENGTH,
    SPEED,
    VISCOSITY,
    Finite,
    Length,
    SceneTable,
    fail,
    quantity,
)
from comparisons.scene.loading import PRESCRIBED, Control, LoadRange, ranged
from comparisons.scene.physics.tables.physics_table import PhysicsTable

# Longest over shortest wave of a rough ball: a thousand waves.
MOST_WAVES = 16


class Waviness(SceneTable):
    """A wave on the ball, with a crest in its middle, across the flow or along it."""

    amplitude: Length
    wavelength: Length
    crests: Literal["across", "along"] = "across"


class Roughness(SceneTable):
    """Self-affine waves on the ball, from the longest to the shortest."""

    rms_height: Length
    longest: Length
    shortest: Length
    hurst: Annotated[Finite, Field(ge=0, le=1)] = 0.8
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**63)] = 0

    @model_validator(mode="after")
    def _some_waves(self) -> Roughness:
        if not self.shortest <= self.longest <= MOST_WAVES * self.shortest:
            raise fail(f"longest: expected from 1 to {MOST_WAVES} times shortest", self.longest)
        return self


class Lubrication(PhysicsTable):
    """A Newtonian film of constant viscosity between the bodies."""

    key = "lubrication"
    place = 6
    compared = ("film_central", "film_minimum")
    apart: ClassVar = {
        "friction": "a full film leaves no solid friction",
        "rolling": "a full film leaves no stick",
        "sliding": "the film on rubber that relaxes is not modelled",
        "viscoelastic": "the film on rubber that relaxes is not modelled",
        "adhesion": "the film keeps the surfaces apart",
        "dynamics": "the film is steady, or the approach has a given speed",
    }
    one_body = True

    viscosity: Annotated[float, quantity(VISCOSITY, kind="viscosity")]
    # Of entrainment along x, the mean of both surfaces'; several are independent of each other.
    # Without it the bodies approach at [loading] squeeze_speed.
    speed: Annotated[LoadRange | None, ranged(SPEED, "loads")] = None
    # "mass_conserving": the film ruptures and forms again, no oil is lost.
    cavitation: Literal["mass_conserving"] = "mass_conserving"
    # Difference of the surfaces' speeds over their mean, for the friction; 2: the indenter stands.
    slide_to_roll: Annotated[Finite, Field(ge=0)] = 2.0
    # Distance before the middle where the oil begins; flooded by default.
    meniscus: Annotated[float | None, quantity(LENGTH, kind="length")] = None
    # Heights on the ball, which then stands.
    waviness: Waviness | None = None
    roughness: Roughness | None = None

    @model_validator(mode="after")
    def _steady(self) -> Lubrication:
        if not self.rough:
            return self
        if self.waviness and self.roughness:
            raise fail("expected one of waviness and roughness, got both")
        if self.speed is None:
            raise fail("expected no waviness or roughness of a ball that is squeezed")
        if self.slide_to_roll != 2:
            raise fail("slide_to_roll: expected 2: a rough ball that moves has no steady film")
        return self

    @classmethod
    def misfits(cls, data: Mapping[str, Any], loading: Mapping[str, Any]) -> Iterator[str]:
        """Expect a force on an indenter, which is drawn or approaches."""
        for name in PRESCRIBED:
            if name in loading and name not in ("force", "pressure"):
                yield f"loading.{name}: expected a force with [lubrication], which the film carries"
        table, squeezed = data["lubrication"], "squeeze_speed" in loading
        if isinstance(table, dict) and ("speed" in table) == squeezed:
            came = "both" if squeezed else "none"
            yield f"lubrication: expected speed or loading.squeeze_speed, got {came}"
        if "surface" in data:
            yield "lubrication: expected an [indenter]: rough films are not modelled"

    @property
    def varied(self) -> tuple[Control, tuple[float, ...]] | None:
        """The speed of entrainment; None of bodies that approach."""
        return None if self.speed is None else ("speed", self.speed.values)

    @property
    def rough(self) -> bool:
        """Whether the ball is rough."""
        return self.waviness is not None or self.roughness is not None

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        oil = f"viscosity {unpadded(self.viscosity, 'Pa s')}"
        moved = "bodies that approach" if self.speed is None else "steady state at each speed"
        inlet = "flooded" if self.meniscus is None else f"from {unpadded(self.meniscus, 'm')} on"
        rupture = f"{self.cavitation.replace('_', '-')} cavitation"
        ball = "a rough ball at rest, " if self.rough else ""
        return "lubricating film", f"{oil}, {ball}{inlet}, {rupture}; {moved}"
