"""The table [sliding]."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar

from comparisons.scene.fields import SPEED
from comparisons.scene.loading import Control, LoadRange, ranged
from comparisons.scene.physics.tables.physics_table import PhysicsTable


class Sliding(PhysicsTable):
    """Steady sliding at each of the given speeds, independent of each other."""

    key = "sliding"
    place = 3
    compared = ("friction_coefficient", "contact_area", "force", "penetration")
    apart: ClassVar = {"dynamics": "steady sliding has no inertia"}
    one_body = True

    speed: Annotated[LoadRange, ranged(SPEED, "loads")]

    @classmethod
    def misfits(cls, data: Mapping[str, Any], loading: Mapping[str, Any]) -> Iterator[str]:
        """Expect a body that relaxes, and no times."""
        if "viscoelastic" not in data:
            yield "sliding: expected [viscoelastic]: an elastic body slides without loss"
        if "time" in loading:
            yield "loading.time: expected none with [sliding], which is steady"

    @property
    def varied(self) -> tuple[Control, tuple[float, ...]]:
        return "speed", self.speed.values

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        return "steady sliding", "steady state at each speed"
