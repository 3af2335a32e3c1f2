"""The table [wear]."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import model_validator

from comparisons.formatting import number, unpadded
from comparisons.scene.fields import fail, quantity
from comparisons.scene.loading import Control, LoadRange, ranged
from comparisons.scene.physics.tables.table import PhysicsTable
from comparisons.scene.units import LENGTH, NUMBER, Dimension

_WEAR_COEFFICIENT = Dimension(-1, 1, 2)


class Wear(PhysicsTable):
    """Archard's law: the rigid body loses k times pressure times slip, where it slips.

    coefficient: k, volume lost per force and distance, 1/Pa.
    sliding_distance: of steady sliding in which all of the contact slips.
    amplitude, cycles: of a tangential oscillation, and how often; with [friction], which lets the
    middle of the contact stick.
    """

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

    coefficient: Annotated[float, quantity(_WEAR_COEFFICIENT, kind="wear coefficient")]
    sliding_distance: Annotated[LoadRange | None, ranged(LENGTH, "loads")] = None
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

    @property
    def progress(self) -> tuple[Control, LoadRange]:
        """What wear goes on along: sliding_distance or cycles, and its values."""
        if self.sliding_distance is not None:
            return "sliding_distance", self.sliding_distance
        assert self.cycles is not None
        return "cycles", self.cycles

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        """Say what acts, and how."""
        law = f"the rigid body loses k p per slip, k = {number(self.coefficient)}/Pa"
        if self.amplitude is None:
            return "wear", f"{law}; all of the contact slips, without tangential tractions"
        amplitude = unpadded(self.amplitude, "m")
        return "wear", f"{law}; oscillation of amplitude {amplitude} under Coulomb friction"
