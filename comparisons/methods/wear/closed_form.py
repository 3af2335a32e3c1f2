"""A flat punch that slides and wears, in closed form (Galin; Goryacheva 1998)."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.friction.path import normal_load
from comparisons.methods.normal.closed_form import ClosedForm
from comparisons.methods.solver import Refused
from comparisons.methods.wear.motion import FRETTING, SLIDING, Motion
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference.closed_form.worn import WornPunch

# From this k E* s/b on the series is exact to far less than any tolerance.
_SHORTEST = 1e-3


class ClosedFormWear(ClosedForm):
    """The pressure below a flat punch decays to the uniform one, mode by mode."""

    physics = SLIDING

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if self.indenter.shape != "cylinder":
            raise Refused("the wear of flat circular punches only is known in closed form")
        self.punch = WornPunch(
            float(self.indenter.parameters["radius"]), self.modulus, Motion.of(scene).coefficient
        )
        assert scene.wear is not None
        travelled = scene.wear.varied[1][0] * self.punch.coefficient * self.modulus
        if travelled < _SHORTEST * self.punch.radius:
            raise Refused(f"the series needs k E* s/b of {_SHORTEST:g} and more")
        self.note = "Galin; Goryacheva 1998, ch. 7"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Sum up the modes at each distance."""
        control, load = normal_load(task)
        worn = self.punch.under_force if control == "force" else self.punch.at_penetration
        rows = np.array([worn(load, float(distance)) for distance in task.loads.values])
        names = ("penetration", "force", "worn_volume")
        area = np.pi * self.punch.radius**2
        curves = dict(zip(names, rows.T, strict=True)) | {"contact_area": area}
        return Solution.of(task, curves, unknowns=1, violation=0.0)


class ClosedFormFretting(ClosedForm):
    """Fretting: none but the limit of many cycles, of which a claim makes use."""

    physics = FRETTING

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        raise Refused("of fretting only the limit of many cycles is known in closed form")
