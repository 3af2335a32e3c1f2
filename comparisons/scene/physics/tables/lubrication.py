"""The table [lubrication]."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from comparisons.formatting import unpadded
from comparisons.scene.fields import Finite, quantity
from comparisons.scene.loading import LoadRange, ranged
from comparisons.scene.physics.tables.table import PhysicsTable
from comparisons.scene.units import LENGTH, SPEED, VISCOSITY

if TYPE_CHECKING:
    from comparisons.scene.scene import Scene


class Lubrication(PhysicsTable):
    """A Newtonian film of constant viscosity between the bodies.

    speed: of entrainment along x, the mean of both surfaces'; several are independent of each
    other. Without it the bodies approach at [loading] squeeze_speed.
    cavitation: "mass_conserving": the film ruptures and forms again, no oil is lost.
    slide_to_roll: difference of the surfaces' speeds over their mean, for the friction; 2: the
    indenter stands.
    meniscus: distance before the middle where the oil begins; flooded by default.
    """

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
    speed: Annotated[LoadRange | None, ranged(SPEED, "loads")] = None
    cavitation: Literal["mass_conserving"] = "mass_conserving"
    slide_to_roll: Annotated[Finite, Field(ge=0)] = 2.0
    meniscus: Annotated[float | None, quantity(LENGTH, kind="length")] = None

    def description(self, scene: Scene) -> tuple[str, str]:
        """Say what acts, and how."""
        oil = f"viscosity {unpadded(self.viscosity, 'Pa s')}"
        moved = "bodies that approach" if self.speed is None else "steady state at each speed"
        inlet = "flooded" if self.meniscus is None else f"from {unpadded(self.meniscus, 'm')} on"
        rupture = f"{self.cavitation.replace('_', '-')} cavitation"
        return "lubricating film", f"{oil}, {inlet}, {rupture}; {moved}"
