"""The table [friction]."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Literal

from comparisons.facts.quantities import TANGENTIAL
from comparisons.formatting import unpadded
from comparisons.scene.fields import Positive
from comparisons.scene.physics.tables.physics_table import PhysicsTable


class Friction(PhysicsTable):
    """Coulomb friction: a point slips where its shear stress reaches `coefficient` times p."""

    key = "friction"
    place = 1
    compared = ("tangential_force", "tangential_displacement")
    apart: ClassVar = {
        "sliding": "in steady sliding there is no stick, and the friction is due to the body",
        "viscoelastic": "a tangential path on a relaxing body would need times",
        "dynamics": "the mass moves along the normal only",
    }
    one_body = True
    two_constants = "tangential contact needs two elastic constants"

    coefficient: Positive
    # "full", or "none" between pressure and tangential displacement and back, which is what the
    # springs leave out; elements always have it, and then do not take part.
    coupling: Literal["full", "none"] = "full"

    @classmethod
    def misfits(cls, data: Mapping[str, Any], loading: Mapping[str, Any]) -> Iterator[str]:
        """Expect a tangential load, unless a roller or an oscillation makes it."""
        if not {"rolling", "wear"} & set(data) and not any(name in loading for name in TANGENTIAL):
            yield "friction: expected loading.tangential_force or loading.tangential_displacement"

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        return "Coulomb friction", f"µ = {unpadded(self.coefficient, '')}, with stick and slip"
