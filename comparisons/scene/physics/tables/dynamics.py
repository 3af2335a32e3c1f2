"""The table [dynamics]."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import model_validator

from comparisons.formatting import unpadded
from comparisons.scene.fields import quantity
from comparisons.scene.loading import LoadRange, ranged
from comparisons.scene.physics.tables.table import PhysicsTable
from comparisons.scene.units import MASS, SPEED, to_si


def _velocities(value: Any) -> Any:
    """Let a velocity of zero stand alone: a mass at rest that a force moves."""
    if value in ({"values": [0.0]}, {"values": (0.0,)}):  # as the text of a scene writes it
        value = 0.0
    try:
        at_rest = not isinstance(value, (dict, list, LoadRange)) and to_si(value, SPEED) == 0.0
    except ValueError:
        at_rest = False
    return LoadRange(values=(0.0,)) if at_rest else value


class Dynamics(PhysicsTable):
    """A rigid mass that hits the surface.

    mass: of the indenter.
    velocity: towards the surface, at first touch; several are independent impacts.
    """

    key = "dynamics"
    place = 5
    compared = ("restitution", "contact_duration", "penetration")

    mass: Annotated[float, quantity(MASS, kind="mass")]
    velocity: Annotated[LoadRange, ranged(SPEED, "loads")]

    @model_validator(mode="before")
    @classmethod
    def _velocity_list(cls, value: Any) -> Any:
        if isinstance(value, dict) and "velocity" in value:
            return value | {"velocity": _velocities(value["velocity"])}
        return value

    @property
    def at_rest(self) -> bool:
        """Whether the mass starts without a velocity."""
        return self.velocity.values == (0.0,)

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        """Say what acts, and how."""
        mass = unpadded(1e3 * self.mass, "g")
        return "inertia", f"of a rigid mass of {mass}; the half-space is massless"
