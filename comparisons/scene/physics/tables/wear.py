"""The table [wear]."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import model_validator

from comparisons.facts.quantities import TANGENTIAL
from comparisons.formatting import number, unpadded
from comparisons.scene.fields import LENGTH, NUMBER, WEAR_COEFFICIENT, fail, quantity
from comparisons.scene.loading import Control, LoadRange, ranged
from comparisons.scene.physics.tables.physics_table import PhysicsTable

if TYPE_CHECKING:
    from comparisons.scene.scene import Scene


class Wear(PhysicsTable):
    """Archard's law: the rigid body loses k times pressure times slip, where it slips."""

    key = "wear"
    place = 0.7
    compared = ("worn_volume", "wear_depth", "force", "penetration")
    apart: ClassVar = {
        "rolling": "wear by creep is not modelled",
        "lubrication": "a full film lets nothing touch",
        "viscoelastic": "wear of what presses on a relaxing body is not modelled",
        "sliding": "distances are those of [wear]; its half-space is elastic",
        "adhesion": "wear under adhesion is not modelled",
        "plasticity": "wear on a half-space that yields is not modelled",
        "dynamics": "wear is quasi-static",
    }
    one_body = True

    # k, volume lost per force and distance, 1/Pa.
    coefficient: Annotated[float, quantity(WEAR_COEFFICIENT, kind="wear coefficient")]
    # Of steady sliding in which all of the contact slips.
    sliding_distance: Annotated[LoadRange | None, ranged(LENGTH, "loads")] = None
    # Of a tangential oscillation, and how often; with [friction], which lets the middle stick.
    amplitude: Annotated[float | None, quantity(LENGTH, kind="amplitude")] = None
    cycles: Annotated[LoadRange | None, ranged(NUMBER, "loads")] = None

    @model_validator(mode="after")
    def _one_motion(self) -> Wear:
        slides, swings = self.sliding_distance is not None, self.amplitude is not None
        if slides == (swings or self.cycles is not None) or swings != (self.cycles is not None):
            given = [
                key for key in ("sliding_distance", "amplitude", "cycles") if getattr(self, key)
            ]
            raise fail(
                "expected sliding_distance, or amplitude and cycles, got "
                + (" and ".join(given) or "none")
            )
        return self

    @classmethod
    def misfits(cls, data: Mapping[str, Any], loading: Mapping[str, Any]) -> Iterator[str]:
        """Expect friction with an oscillation of an indenter, and none with sliding."""
        table, friction = data["wear"], data.get("friction")
        swings = isinstance(table, dict) and "amplitude" in table
        if swings and friction is None:
            yield "wear.amplitude: expected [friction], which lets the middle of the contact stick"
        if swings and "surface" in data:
            yield "wear.amplitude: expected an [indenter]: rough fretting is not modelled"
        if friction is not None and not swings:
            yield "friction: expected none with wear.sliding_distance: all of the contact slips"
        if swings and isinstance(friction, dict) and friction.get("coupling", "full") != "none":
            yield 'friction.coupling: expected "none" with [wear]: no method wears with coupling'
        for name in (name for name in TANGENTIAL if name in loading):
            yield f"loading.{name}: expected none with [wear], whose motion is in its own table"

    def check(self, scene: Scene) -> None:
        """Expect one load, which is held."""
        count = len(scene.loading.range.values)
        if count > 1:
            name = scene.loading.control
            raise fail(f"loading.{name}: expected one load with [wear], which is held, got {count}")

    @property
    def varied(self) -> tuple[Control, tuple[float, ...]]:
        if self.sliding_distance is not None:
            return "sliding_distance", self.sliding_distance.values
        assert self.cycles is not None
        return "cycles", self.cycles.values

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        law = f"the rigid body loses k p per slip, k = {number(self.coefficient)}/Pa"
        if self.amplitude is None:
            return "wear", f"{law}; all of the contact slips, without tangential tractions"
        amplitude = unpadded(self.amplitude, "m")
        return "wear", f"{law}; oscillation of amplitude {amplitude} under Coulomb friction"
