"""The table [adhesion]."""

from __future__ import annotations

from typing import Annotated, ClassVar

from comparisons.formatting import unpadded
from comparisons.scene.fields import LENGTH, SURFACE_ENERGY, quantity
from comparisons.scene.physics.tables.physics_table import PhysicsTable


class Adhesion(PhysicsTable):
    """Attraction of the surfaces."""

    key = "adhesion"
    place = 4
    adds = ("pull_off_force",)
    remembers = True
    apart: ClassVar = {"sliding": "detachment at the edge of a sliding contact is not modelled"}

    # Of adhesion w per area, to part the surfaces for good.
    work: Annotated[float, quantity(SURFACE_ENERGY, kind="work of adhesion")]
    # Of the attraction, the distance at which it ends; 0 is the limit of short range (JKR).
    range: Annotated[float, quantity(LENGTH, sign="not negative", kind="length")] = 0.0

    @property
    def short_range(self) -> bool:
        """Whether the attraction acts at the edge of the contact only, as in JKR."""
        return self.range == 0.0

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        short = "at the edge of the contact only (JKR)"
        reach = f"up to a distance of {unpadded(self.range, 'm')}"
        return (
            "adhesion",
            f"w = {unpadded(self.work, 'J/m²')}, {short if self.short_range else reach}",
        )
