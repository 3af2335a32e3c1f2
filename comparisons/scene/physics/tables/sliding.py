"""The table [sliding]."""

from __future__ import annotations

from typing import Annotated, ClassVar

from comparisons.scene.loading import LoadRange, ranged
from comparisons.scene.physics.tables.table import PhysicsTable
from comparisons.scene.units import SPEED


class Sliding(PhysicsTable):
    """Steady sliding at each of the given speeds, independent of each other."""

    key = "sliding"
    place = 3
    compared = ("friction_coefficient", "contact_area", "force", "penetration")
    apart: ClassVar = {"dynamics": "steady sliding has no inertia"}
    one_body = True

    speed: Annotated[LoadRange, ranged(SPEED, "loads")]

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        """Say what acts, and how."""
        return "steady sliding", "steady state at each speed"
