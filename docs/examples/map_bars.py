"""Hold the bars of measured maps and random surfaces against grids four times finer.

Run from the repository's root (some four minutes on one core for each half)::

    python docs/examples/map_bars.py fitting|reported MAP...

Parts of the maps, of 16, 32 and 64 points a side at random places, and random surfaces of 32 and 64
points are solved on grids once, twice and four times as fine, as scenes do, and on grids 8 and 16
times as fine, which extrapolated are the truth. Printed are how many bars cover the true error and
their median width, both of the rms over five loads from 0.002 to 0.2 E* A0 h'.
"""

# %%
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np

from comparisons.geometry.prepare import RoughGeometry, prepare
from comparisons.judging.located import located_uncertainty
from comparisons.judging.metrics import rms_and_maximum
from comparisons.judging.uncertainty import share_uncertainty
from comparisons.methods.normal.grid import make_grid
from comparisons.scene.scene import make_scene
from reference.halfspace import FreeOperator, PeriodicOperator, areas, fft
from reference.halfspace.contact_line import located_area
from reference.halfspace.solution import Press
from reference.loads import Load

LOADS = np.geomspace(2e-3, 0.2, 5)
FACTORS, SOLVED = (1, 2, 4, 8, 16), 3
# Parts of each map, and the orders with which the last two grids are extrapolated to the truth.
PARTS = {16: 5, 32: 7, 64: 3}
ORDERS = {"contact area": 1.7, "penetration": 2.0, "mean gap": 1.5, "stiffness": 1.5}
SEEDS = {"fitting": 14, "reported": 15}


# %%
def surfaces(half: str, maps: list[str]) -> Iterator[tuple[str, RoughGeometry]]:
    """Yield the kind of each surface, and its geometry."""
    random = np.random.default_rng(SEEDS[half])
    for file in maps:
        points = _geometry({"kind": "map", "file": str(Path(file).resolve())}).points
        for n, count in PARTS.items():
            for _ in range(count):
                corner = [int(random.integers(0, side - n)) for side in points]
                crop = {"crop": [*corner, n, n]}
                yield (
                    Path(file).name,
                    _geometry({"kind": "map", "file": str(Path(file).resolve())} | crop),
                )
    for n, hurst, cutoff, periodic in product(
        (32, 64), (0.2, 0.5, 0.8, 1.0), (2, 4), (False, True)
    ):
        for waves in (1, 2) if n == 32 else (2,):
            surface = {"kind": "self_affine", "hurst": hurst, "size": 1.0, "points": n}
            surface |= {"rms_slope": 0.1, "periodic": periodic, "short_cutoff": cutoff / n}
            surface |= {"long_cutoff": 1 / waves, "seed": int(random.integers(1, 10000))}
            kind = "random, periodic" if periodic else "random, free"
            yield kind, _geometry(surface | {"realisations": 1})


def _geometry(surface: dict) -> RoughGeometry:
    scene = {
        "name": "part",
        "half_space": {"effective_modulus": 1.0},
        "surface": surface,
        "loading": {"force": {"values": [0.01], "relative_to": "E* A0 h'"}},
    }
    return prepare(make_scene(scene, "part", Path()))[0]


def solved(geometry: RoughGeometry) -> np.ndarray:
    """Return area, penetration, mean gap, stiffness and counted area, (grids, loads, 5)."""
    forces, values = LOADS * geometry.area * geometry.rms_slope, []
    for factor in FACTORS:
        grid = make_grid(geometry, factor * geometry.points[0])
        kind = PeriodicOperator if geometry.periodic else FreeOperator
        operator = kind(grid.gap.shape, grid.spacing, 1.0)
        contacts = fft.sweep(Press(operator, grid.gap), Load("force", forces))
        values.append(
            [
                (
                    located_area(contact, patch=True),
                    contact.penetration,
                    contact.mean_gap,
                    areas.contact_stiffness(operator, contact.mask, 1e-4),
                    areas.raw_area(contact.mask, grid.spacing),
                )
                for contact in contacts
            ]
        )
    return np.array(values)


def ratios(geometry: RoughGeometry) -> dict[str, float]:
    """Return the bar over the true error of each quantity, rms over the loads."""
    values, known = solved(geometry), {}
    grids = geometry.points[0] * np.array(FACTORS[:SOLVED])
    for column, (name, order) in enumerate(ORDERS.items()):
        curves = values[:, :, column]
        true = curves[-1] + (curves[-1] - curves[-2]) / (2**order - 1)
        error = rms_and_maximum(curves[SOLVED - 1] / true - 1)[0]
        if name == "contact area":
            counted = values[SOLVED - 1, :, -1]
            sides = tuple(FACTORS[SOLVED - 1] * n for n in geometry.points)
            bar = located_uncertainty(curves[:SOLVED], counted, sides, periodic=geometry.periodic)
        else:
            kind = "periodic" if geometry.periodic else "free"
            bar = share_uncertainty(grids, curves[:SOLVED], (name.replace(" ", "_"), kind))
        known[name] = rms_and_maximum(bar)[0] / error
    return known


# %%
def main(half: str, maps: list[str]) -> None:
    """Print how many bars cover the true error, and their median width over it."""
    parts: dict[str, list[dict[str, float]]] = {}
    for kind, geometry in surfaces(half, maps):
        parts.setdefault(kind, []).append(ratios(geometry))
        print(
            kind,
            geometry.points,
            {n: round(r, 2) for n, r in parts[kind][-1].items()},
            file=sys.stderr,
            flush=True,
        )
    parts["all"] = [row for rows in parts.values() for row in rows]
    print(f"| {half}: surfaces | cases |", " | ".join(ORDERS), "|")
    print("|---|---|" + "---|" * len(ORDERS))
    for kind, rows in parts.items():
        cells = []
        for name in ORDERS:
            own = np.array([row[name] for row in rows])
            cells.append(f"{100 * np.mean(own >= 1):.0f} %, {np.median(own):.1f}")
        print(f"| {kind} | {len(rows)} |", " | ".join(cells), "|")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
