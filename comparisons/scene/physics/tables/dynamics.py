"""The table [dynamics]."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import model_validator

from comparisons.formatting import unpadded
from comparisons.scene.fields import MASS, SPEED, fail, quantity, to_si
from comparisons.scene.loading import PRESCRIBED, Control, LoadRange, ranged
from comparisons.scene.physics.tables.physics_table import PhysicsTable

if TYPE_CHECKING:
    from comparisons.scene.scene import Scene


class Dynamics(PhysicsTable):
    """A rigid mass that hits the surface."""

    key = "dynamics"
    place = 5
    compared = ("restitution", "contact_duration", "penetration")

    mass: Annotated[float, quantity(MASS, kind="mass")]  # of the indenter
    # Towards the surface, at first touch; several are independent impacts.
    velocity: Annotated[LoadRange, ranged(SPEED, "loads")]

    @model_validator(mode="before")
    @classmethod
    def _velocity_list(cls, table: Any) -> Any:
        """Let a velocity of zero stand alone: a mass at rest that a force moves."""
        if not isinstance(table, dict) or "velocity" not in table:
            return table
        value = table["velocity"]
        if value in ({"values": [0.0]}, {"values": (0.0,)}):  # as the text of a scene writes it
            value = 0.0
        try:
            at_rest = not isinstance(value, (dict, list, LoadRange)) and to_si(value, SPEED) == 0.0
        except ValueError:
            at_rest = False
        return table | {"velocity": LoadRange(values=(0.0,)) if at_rest else value}

    @classmethod
    def misfits(cls, data: Mapping[str, Any], loading: Mapping[str, Any]) -> Iterator[str]:
        """Expect no normal load but a force in time."""
        normal = [name for name in PRESCRIBED if name in loading]
        if normal and "time" not in loading:
            name = "force" if normal[0] == "pressure" else normal[0]
            yield f"loading.{name}: expected its times (loading.time) with [dynamics]"
        if "penetration" in normal:
            yield (
                "loading.penetration: expected a force or nothing: the motion of the mass is "
                "computed"
            )

    def check(self, scene: Scene) -> None:
        """Expect a force on a mass at rest, and a single impact in time."""
        if scene.loading.time is not None and len(self.velocity.values) > 1:
            raise fail("dynamics.velocity: expected one velocity with loading.time")
        if self.at_rest and not scene.loading.forces:
            raise fail("dynamics.velocity: expected above zero, or a loading.force with its times")

    @property
    def varied(self) -> tuple[Control, tuple[float, ...]]:
        return "velocity", self.velocity.values

    @property
    def at_rest(self) -> bool:
        """Whether the mass starts without a velocity."""
        return self.velocity.values == (0.0,)

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        mass = unpadded(1e3 * self.mass, "g")
        return "inertia", f"of a rigid mass of {mass}; the half-space is massless"
