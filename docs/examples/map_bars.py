"""Hold the bars of measured maps and random surfaces against grids eight times finer.

Run from the repository's root (some three minutes on one core)::

    python docs/examples/map_bars.py SEED MAP...

Random surfaces and parts of the maps at random places, of 16 and 24 points a side, are solved on
grids once, twice and four times as fine, as scenes do, and on grids 16 and 32 times as fine, which
extrapolated are the truth. Printed are, of three grids and of the first two, how many bars cover
the true error at single loads, how many in the rms over six loads from 0.002 to 0.5 E* A0 h', and
the median of bar over error at single loads.
"""

# %%
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.facts.methods import GRID
from comparisons.geometry.prepare import prepare
from comparisons.judging.levels import Levels
from comparisons.judging.metrics import rms_and_maximum
from comparisons.scene.scene import Scene, make_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

LOADS = np.geomspace(2e-3, 0.5, 6).tolist()
FACTORS, FINE = (1, 2, 4), (16, 32)
# How many surfaces, by points a side: of each kind of random ones, and parts of each map.
NUMBERS = {
    "free": ({16: 8, 24: 4}, {}),
    "free, cells 2 : 1": ({16: 4, 24: 2}, {"size": [2.0, 1.0]}),
    "free, cells 1 : 2": ({16: 4, 24: 2}, {"size": [1.0, 2.0]}),
    "periodic": ({16: 8, 24: 4}, {"periodic": True}),
    "periodic, cells 2 : 1": ({16: 4, 24: 2}, {"periodic": True, "size": [2.0, 1.0]}),
}
PARTS = {16: 3, 24: 2}
# Orders with which the last two grids are extrapolated to the truth.
ORDERS = {"contact_area": 1.7, "penetration": 1.7, "mean_gap": 1.5, "stiffness": 1.5}


# %%
def surfaces(seed: int, maps: list[str]) -> Iterator[tuple[str, Scene]]:
    """Yield the kind of each surface, and its scene."""
    random = np.random.default_rng(seed)
    for kind, (numbers, changes) in NUMBERS.items():
        for n in (n for n, count in numbers.items() for _ in range(count)):
            surface: dict[str, Any] = {"kind": "self_affine", "hurst": random.uniform(0.3, 1)}
            surface |= {"size": [1.0, 1.0], "points": [n, n], "rms_slope": 0.1, "periodic": False}
            surface |= changes
            shortest, longest = int(random.choice((2, 4))) / n, 1 / int(random.choice((1, 2)))
            surface |= {"short_cutoff": shortest * max(surface["size"]), "long_cutoff": longest}
            yield kind, _scene(surface | {"seed": int(random.integers(1e6)), "realisations": 1})
    for file in maps:
        table = {"kind": "map", "file": str(Path(file).resolve())}
        points = prepare(_scene(table))[0].points
        for n in (n for n, count in PARTS.items() for _ in range(count)):
            corner = [int(random.integers(0, side - n)) for side in points]
            yield Path(file).name, _scene(table | {"crop": [*corner, n, n]})


def _scene(surface: dict[str, Any]) -> Scene:
    scene = {
        "name": "part",
        "half_space": {"effective_modulus": 1.0},
        "surface": surface,
        "loading": {"force": {"values": LOADS, "relative_to": "E* A0 h'"}},
        "compare": {"quantities": list(ORDERS), "methods": [GRID]},
    }
    return make_scene(scene, "part", Path())


def bars_and_errors(scene: Scene) -> dict[str, list[tuple[np.ndarray, np.ndarray]]]:
    """Return bars and true errors, (loads,), of three grids and of two, for each quantity."""
    (plan,) = plan_scene(scene)
    own = plan.geometry.points[0]
    solved = {(GRID, f * own): execute(task_of(plan, GRID, f * own), 1) for f in (*FACTORS, *FINE)}
    known: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {name: [] for name in ORDERS}
    for name, order in ORDERS.items():
        coarse, fine = (solved[GRID, f * own].quantities[name][0] for f in FINE)
        true = fine + (fine - coarse) / (2**order - 1)
        for grids in (FACTORS, FACTORS[:2]):
            levels = Levels.of({(GRID, f * own): solved[GRID, f * own] for f in grids}, GRID)
            error = levels.curves(grids[-1] * own)[name] / true - 1
            known[name].append((levels.discretisation(name), np.abs(error)))
    return known


# %%
def main(seed: int, maps: list[str]) -> None:
    """Print coverage and width of the bars."""
    parts: dict[str, list[dict[str, list[tuple[np.ndarray, np.ndarray]]]]] = {}
    for kind, scene in surfaces(seed, maps):
        parts.setdefault(kind, []).append(bars_and_errors(scene))
        print(kind, len(parts[kind]), file=sys.stderr, flush=True)
    parts["all"] = [case for cases in parts.values() for case in cases]
    for index, grids in enumerate(("three grids", "two grids")):
        print(f"\n| {grids} | surfaces |", " | ".join(n.replace("_", " ") for n in ORDERS), "|")
        print("|---|---|" + "---|" * len(ORDERS))
        for kind, cases in parts.items():
            cells = []
            for name in ORDERS:
                bars, errors = (np.array([case[name][index][k] for case in cases]) for k in (0, 1))
                single = 100 * np.mean(bars >= errors)
                rms = [
                    [rms_and_maximum(v)[0] for v in pair] for pair in zip(bars, errors, strict=True)
                ]
                over = 100 * np.mean([bar >= error for bar, error in rms])
                cells.append(f"{single:.0f} %, {over:.0f} %, {np.median(bars / errors):.1f}")
            print(f"| {kind} | {len(cases)} |", " | ".join(cells), "|")


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
