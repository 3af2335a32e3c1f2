"""The table [rolling]."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import field_validator, model_validator

from comparisons.facts.quantities import TANGENTIAL
from comparisons.formatting import unpadded
from comparisons.scene.fields import NUMBER, Dimension, fail, quantity
from comparisons.scene.loading import LoadRange, ranged
from comparisons.scene.physics.tables.physics_table import PhysicsTable

SPIN = Dimension(length=-1)


class Rolling(PhysicsTable):
    """Steady rolling along x with each of the given creeps, independent of each other."""

    key = "rolling"
    place = 0.5
    compared = ("traction", "tangential_force")
    apart: ClassVar = {
        "sliding": "a roller that sticks somewhere does not slide as a whole",
        "viscoelastic": "rolling without friction is [sliding] on rubber; both are not modelled",
        "adhesion": "a roller that is pulled off at its rear is not modelled",
        "dynamics": "steady rolling has no inertia",
    }
    one_body = True

    # The rigid slip of the roller over the half-space, as a fraction of the rolling speed, of any
    # sign; the force is that on the half-space and has the sign of the creep. Positive creep points
    # along +x, the way of the contact over the half-space: a roller that is braked.
    creep: Annotated[LoadRange, ranged(NUMBER, "path")]
    # The same along y. One of both may be a list.
    lateral_creep: Annotated[LoadRange, ranged(NUMBER, "path")] = LoadRange(values=(0.0,))
    # Rotation of the roller about z through its middle per distance rolled, of any sign; it slips
    # by spin x along y.
    spin: Annotated[float, quantity(SPIN, sign="any")] = 0.0

    @field_validator("creep", "lateral_creep")
    @classmethod
    def _increasing(cls, value: LoadRange) -> LoadRange:
        if any(b <= a for a, b in pairwise(value.values)):
            raise fail("expected strictly increasing creeps", list(value.values))
        return value

    @model_validator(mode="after")
    def _one_list(self) -> Rolling:
        if len(self.creep.values) > 1 and len(self.lateral_creep.values) > 1:
            raise fail("lateral_creep: expected one value beside several of creep")
        return self

    @classmethod
    def misfits(cls, data: Mapping[str, Any], loading: Mapping[str, Any]) -> Iterator[str]:
        """Expect friction and an indenter, and no other tangential load."""
        if "friction" not in data:
            yield "rolling: expected [friction], which transmits tangential forces"
        else:
            for name in (name for name in TANGENTIAL if name in loading):
                yield f"loading.{name}: expected none with [rolling], whose creep is prescribed"
        if "surface" in data:
            yield "rolling: expected an [indenter]: a rough roller has no steady state"

    @property
    def varied(self) -> tuple[Literal["creep", "lateral_creep"], tuple[float, ...]]:
        """The creep that has several values, else the longitudinal one."""
        if len(self.lateral_creep.values) > 1:
            return "lateral_creep", self.lateral_creep.values
        return "creep", self.creep.values

    def both(self, value: float) -> tuple[float, float]:
        """Return creep and lateral creep at a step, from the one that is varied."""
        if self.varied[0] == "creep":
            return value, self.lateral_creep.values[0]
        return self.creep.values[0], value

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        varied, _ = self.varied
        held = "creep" if varied == "lateral_creep" else "lateral_creep"
        other = getattr(self, held).values[0]
        beside = f", {held.replace('_', ' ')} {unpadded(other, '')}" if other else ""
        beside += f", spin {self.spin:.4g} per m" if self.spin else ""
        return "steady rolling", f"steady state at each {varied.replace('_', ' ')}{beside}"
