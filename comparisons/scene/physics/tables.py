"""The tables [friction], [sliding], [adhesion] and [dynamics] of a scene."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, model_validator

from comparisons.scene.fields import Positive, quantity
from comparisons.scene.loading import LoadRange, ranged
from comparisons.scene.units import LENGTH, MASS, SPEED, SURFACE_ENERGY, to_si

# The tables that switch on physics, in the order in which a plan names them.
PHYSICS = ("friction", "viscoelastic", "sliding", "adhesion", "dynamics")


class PhysicsTable(BaseModel):
    """Base of these tables: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Friction(PhysicsTable):
    """Coulomb friction: a point slips where its shear stress reaches `coefficient` times p.

    coupling: "full", or "none" between pressure and tangential displacement and back, which is what
    the springs leave out; elements always have it, and then do not take part.
    """

    coefficient: Positive
    coupling: Literal["full", "none"] = "full"


class Sliding(PhysicsTable):
    """Steady sliding at each of the given speeds, independent of each other."""

    speed: Annotated[LoadRange, ranged(SPEED, "loads")]


class Adhesion(PhysicsTable):
    """Attraction of the surfaces.

    work: of adhesion w per area, to part the surfaces for good.
    range: of the attraction, the distance at which it ends; 0 is the limit of short range (JKR).
    """

    work: Annotated[float, quantity(SURFACE_ENERGY, kind="work of adhesion")]
    range: Annotated[float, quantity(LENGTH, sign="not negative", kind="length")] = 0.0

    @property
    def short_range(self) -> bool:
        """Whether the attraction acts at the edge of the contact only, as in JKR."""
        return self.range == 0.0


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

    mass: Annotated[float, quantity(MASS, kind="mass")]
    velocity: Annotated[LoadRange, ranged(SPEED, "loads")]

    @model_validator(mode="before")
    @classmethod
    def _rest(cls, value: Any) -> Any:
        if isinstance(value, dict) and "velocity" in value:
            return value | {"velocity": _velocities(value["velocity"])}
        return value

    @property
    def at_rest(self) -> bool:
        """Whether the mass starts without a velocity."""
        return self.velocity.values == (0.0,)
