"""References of hard cases as formulas of the planned scene, exact up to round-off."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from comparisons.facts.quantities import COMPARABLE
from comparisons.questions.hard_cases.recipes import Table
from comparisons.scene.fields import Length, fail
from comparisons.scene.scene import Scene

if TYPE_CHECKING:
    from comparisons.solving.plan import Plan

Curves = dict[str, np.ndarray]


class Hertz(Table):
    """Hertz's solution for a tip that the scene samples by a map: F = 4/3 E* sqrt(R) d^1.5."""

    needs: ClassVar = ("surface", "loading.penetration")

    radius: Length

    def curves(self, plan: Plan) -> Curves:
        """Return the force and the area pi R d at the penetrations of the scene."""
        depth = plan.loads.values
        force = 4 / 3 * plan.scene.effective_modulus * np.sqrt(self.radius) * depth**1.5
        return {"force": force, "contact_area": np.pi * self.radius * depth}


class Stuck(Table):
    """u = F_x/(2 a G*) (Mindlin 1949): stick in the whole Hertzian contact."""

    needs: ClassVar = ("indenter.radius", "friction", "loading.tangential_force")

    def curves(self, plan: Plan) -> Curves:
        """Return the displacement at the last normal force; at mu = 1e6 a rim of 1e-7 slips."""
        normal = plan.loads.normal
        assert normal is not None
        scene = plan.scene
        force, modulus = float(normal.values[-1]), scene.effective_modulus
        radius = np.cbrt(0.75 * force / modulus * _at(scene, "indenter.radius"))
        steps = np.ones(len(plan.loads.values))
        shift = plan.loads.values / (2 * radius * scene.tangential_modulus)
        return {"tangential_displacement": shift, "contact_area": np.pi * radius**2 * steps}


class Creeping(Table):
    """mu = (eta/G) v/R, eta = sum G_i tau_i: the 3-D limit of slow sliding on rubber."""

    needs: ClassVar = ("indenter.radius", "viscoelastic", "sliding")

    def curves(self, plan: Plan) -> Curves:
        """Return the coefficient of friction at the speeds of the scene."""
        scene = plan.scene
        material = scene.viscoelastic
        assert material is not None
        viscosity = sum(modulus * time for modulus, time in material.branches)
        slope = viscosity / material.long_term_modulus / _at(scene, "indenter.radius")
        return {"friction_coefficient": slope * plan.loads.values}


class ClosedGap(Table):
    """Full contact of a periodic surface: d = max h - <h>, A = A0."""

    needs: ClassVar = ("surface",)

    def curves(self, plan: Plan) -> Curves:
        """Return the penetration and area of the first surface with its gap closed."""
        from comparisons.geometry.prepare import RoughGeometry

        geometry = plan.geometry
        assert isinstance(geometry, RoughGeometry)
        heights = geometry.heights(0, geometry.points[0])
        steps = np.ones(len(plan.loads.values))
        depth = geometry.top(0) - float(heights.mean())
        return {"penetration": depth * steps, "contact_area": geometry.area * steps}


class Formula(Table):
    """Exactly one formula; `constant` gives quantities that are equal at all steps."""

    constant: dict[Literal[COMPARABLE], float] | None = None  # type: ignore[valid-type]
    hertz: Hertz | None = None
    stuck: Stuck | None = None
    creeping: Creeping | None = None
    closed_gap: ClosedGap | None = None

    @model_validator(mode="after")
    def _exactly_one(self) -> Formula:
        if len(self.model_fields_set) != 1:
            got = " and ".join(sorted(self.model_fields_set)) or "none"
            keys = ", ".join(type(self).model_fields)
            raise fail(f"expected exactly one of {keys}, got {got}")
        return self

    def missing(self, scene: Scene) -> list[str]:
        """Return the keys that the formula needs and the scene lacks."""
        (name,) = self.model_fields_set
        return [key for key in getattr(getattr(self, name), "needs", ()) if _at(scene, key) is None]

    def curves(self, plan: Plan) -> Curves:
        """Return the quantities of the planned scene at its steps."""
        if self.constant is not None:
            steps = np.ones(plan.loads.values.size)
            return {name: value * steps for name, value in self.constant.items()}
        (name,) = self.model_fields_set
        return getattr(self, name).curves(plan)


def _at(scene: Scene, path: str) -> Any:
    """Return the value at a dotted key of a scene, or None."""
    table: Any = scene
    for key in path.split("."):
        table = getattr(table, key, None)
    return table
