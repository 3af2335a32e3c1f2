"""Print the tables of docs/finite-elements.md, "Two references": both below one surface.

Run from the repository's root (a minute on one core); maps of your own are cropped and added::

    python docs/examples/second_truth_tables.py disagreement agreement
    python docs/examples/second_truth_tables.py agreement MAP.di OTHER.opd
"""

# %%
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from comparisons.geometry.prepare import RoughGeometry, prepare
from comparisons.questions.experiments.boundary_elements import (
    QUANTITIES,
    TwoTruths,
    drawn,
    two_truths,
)
from comparisons.scene.scene import Scene, load_scene
from reference.fem import Material
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "finite-elements.md"
RUNS = 200
SCENES = ("rough-patch", "rough-free", "rough-periodic", "measured-map")
FINEST = 512
# Cells of the part of a map, and where it begins.
SIDE, CORNER = 256, 100


# %% [markdown]
# Random surfaces: how often both agree within both bars.


# %%
def disagreement() -> list[list[str]]:
    """Shares of contacts inside both bars, and differences."""
    cases = drawn(RUNS)
    rows = [["quantity", "inside", "free", "periodic", "difference", "over both bars", "at most"]]
    for quantity in QUANTITIES:
        ratios = np.array([abs(case.difference(quantity)) / case.bar(quantity) for case in cases])
        periodic = np.array([case.periodic for case in cases])
        inside = [100 * np.mean(ratios[some] <= 1) for some in (ratios >= 0, ~periodic, periodic)]
        difference = 100 * np.median([abs(case.difference(quantity)) for case in cases])
        numbers = f"{difference:.2f} %", f"{np.median(ratios):.2f}", f"{ratios.max():.2f}"
        rows.append([quantity.replace("_", " "), *(f"{i:.0f} %" for i in inside), *numbers])
    pressures = np.array([case.pressure for case in cases])
    ratios = pressures / np.array([np.hypot(*case.pressure_changes) for case in cases])
    share, size = f"{100 * np.mean(ratios <= 1):.0f} %", f"{100 * np.median(pressures):.2f} %"
    last = f"{np.median(ratios):.2f}", f"{ratios.max():.2f}"
    return [*rows, ["pressure (L2)", share, "", "", size, *last]]


# %% [markdown]
# Scenes of the quick suite, and measured maps, at their largest loads.


# %%
def of_scene(scene: Scene) -> TwoTruths:
    """Return the largest load of a scene on its points and up to three grids that are finer."""
    geometry, loads = prepare(scene)
    assert isinstance(geometry, RoughGeometry)
    grids = [k * geometry.points[0] for k in (1, 2, 4, 8) if k * geometry.points[0] <= FINEST]
    maps = [geometry.heights(0, n) for n in grids]
    material, force = Material(*scene.elastic_constants), float(loads.values[-1])
    return two_truths(maps, geometry.size, material, force, periodic=geometry.periodic)


def scenes(maps: list[str]) -> Iterator[tuple[str, TwoTruths]]:
    """Yield the scenes of the quick suite and parts of maps."""
    for name in SCENES:
        yield name, of_scene(load_scene(name))
    for path in maps:
        crop = [CORNER, CORNER, SIDE, SIDE]
        surface = {"kind": "map", "file": str(Path(path).resolve()), "crop": crop}
        surface["undefined"] = "interpolate"
        table = {"youngs_modulus": "70 GPa", "poisson_ratio": 0.33}
        force = {"values": [0.05], "relative_to": "E* A0 h'"}
        data = {"name": "map", "half_space": table, "surface": surface}
        yield (
            f"{Path(path).name}, {SIDE}²",
            of_scene(load_scene(data | {"loading": {"force": force}})),
        )


def agreement(maps: list[str]) -> list[list[str]]:
    """Differences on the finest grid with both bars; pressures with both changes; times."""
    names = ["contact area", "penetration", "mean gap", "stiffness", "pressure (L2)"]
    rows = [["surface", "cells", *names, "seconds: elements", "set-up", "half-space"]]
    for name, case in scenes(maps):
        cells = [f"{100 * case.difference(q):+.2f} ({100 * case.bar(q):.2f})" for q in QUANTITIES]
        pressure = f"{100 * case.pressure:.1f} ({100 * np.hypot(*case.pressure_changes):.1f})"
        made, elements, half = (f"{seconds:.2f}" for seconds in case.seconds)
        grid = f"{case.resolutions[-1]}²"
        rows.append([name, grid, *cells, pressure, elements, made, half])
    return rows


# %%
if __name__ == "__main__":
    named = [name for name in sys.argv[1:] if name in ("disagreement", "agreement")]
    files = [name for name in sys.argv[1:] if name not in named]
    rewrite(PAGE, {"disagreement": disagreement, "agreement": lambda: agreement(files)}, named)
