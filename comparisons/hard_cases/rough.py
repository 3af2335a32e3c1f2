"""Hard rough surfaces: white noise, full contact, steep, elongated; one and no realisation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from comparisons.hard_cases.case import (
    Curves,
    Expected,
    HardCase,
    Known,
    Trusted,
    accurate,
    degraded,
    not_for,
    refused,
)
from comparisons.hard_cases.usual import NO_FORM_FLAT, STEEL, all_methods

if TYPE_CHECKING:
    from comparisons.planning import Plan

_SURFACE = {"kind": "self_affine", "size": "1 um", "points": 16, "rms_slope": 0.1, "seed": 3}
_FORCES = {"force": {"values": [0.01, 0.05], "relative_to": "E* A0 h'"}}
# The subject is the solver, not the grid: the dense one is exact to round-off on the same cells.
SAME_GRID = Trusted("bem_dense", (16,))
LINE = "a line of random phases is another surface: its force and area are those of the claims"
NODES = "nodes carry the load instead of cells: another surface below the size of a cell"


def rough_expected(
    line: float, line_area: float, nodes: float, nodes_area: float, **changes: Expected
) -> Mapping[str, Expected]:
    """Return what methods do on the same grid as the truth."""
    return {
        "closed_form": NO_FORM_FLAT,
        "reduced": degraded(line, line_area, why=LINE),
        "bem_dense": accurate(1e-8, 1e-8),
        "bem_fft": accurate(1e-6, 1e-6),
        "fem": degraded(nodes, nodes_area, why=NODES),
    } | changes


def _rough(name: str, title: str, hard: str, expected: Any, **more: Any) -> HardCase:
    loading = more.pop("loading", _FORCES)
    settings = {
        key: more.pop(key) for key in ("truth", "resolutions", "slow", "only") if key in more
    }
    surface = _SURFACE | ({} if "power" in more else {"hurst": 0.8}) | more
    scene = {"half_space": STEEL, "surface": surface, "loading": loading}
    points = surface["points"]
    first = points[0] if isinstance(points, list) else points
    settings = {"truth": SAME_GRID, "resolutions": _own_points(first)} | settings
    return HardCase(f"rough-{name}", title, hard, scene, expected, **settings)


def _own_points(points: int) -> dict[str, int]:
    return dict.fromkeys(("reduced", "bem_dense", "bem_fft", "fem"), points)


_PERIODIC = {
    "bem_dense": not_for("the chapter's kernel (19.3) is that of a free half-space"),
    "fem": not_for("models one free patch, not a periodic half-space"),
}


def _closed(plan: Plan) -> Curves:
    """Full contact of a periodic surface: nothing is left of the gap."""
    from comparisons.geometry import RoughGeometry

    geometry = plan.geometry
    assert isinstance(geometry, RoughGeometry)
    heights = geometry.heights(0, geometry.points[0])
    steps = np.ones(len(plan.loads.values))
    depth = float(heights.max() - heights.mean())
    return {"penetration": depth * steps, "contact_area": geometry.area * steps}


CASES = (
    _rough(
        "white-noise",
        "White noise",
        "every wavelength down to two cells has the same power: the grid resolves nothing",
        rough_expected(0.8, 7.0, 0.6, 2.0),
        power=0.0,
    ),
    _rough(
        "white-noise-continuum",
        "White noise, against the surface between its points",
        "the shortest wave has two points: the grid of the map is no solution of its surface",
        rough_expected(
            0.6,
            9.0,
            0.6,
            3.0,
            bem_dense=degraded(0.6, 2.5, why="two cells per wave"),
            bem_fft=degraded(0.6, 2.5, why="two cells per wave"),
        ),
        power=0.0,
        truth=Trusted("bem_fft", (32, 64, 128)),
    ),
    _rough(
        "steep",
        "Slopes far above 1",
        "rms slope 3: far outside small slopes, yet inside the linear theory of all methods",
        rough_expected(0.8, 7.0, 0.6, 2.0),
        rms_slope=3.0,
    ),
    _rough(
        "nearly-flat",
        "An rms slope of 1e-12",
        "heights of attometres: an absolute tolerance would call them flat",
        rough_expected(0.8, 7.0, 0.6, 2.0),
        rms_slope=1e-12,
    ),
    _rough(
        "full-contact-periodic",
        "Full contact of a periodic surface",
        "no cell is free, and the penetration no longer depends on the force",
        {
            "closed_form": NO_FORM_FLAT,
            "reduced": degraded(
                1e3, 0.3, why="springs are never full: A <= pi/4 A0, and d grows with the force"
            ),
            "bem_fft": accurate(1e-6, 1e-9),
            **_PERIODIC,
        },
        loading={"force": {"values": [10.0, 100.0], "relative_to": "E* A0 h'"}},
        points=32,
        periodic=True,
        truth=Known(_closed, "the gap is closed: d = max h - <h>, A = A0"),
    ),
    _rough(
        "full-contact-free",
        "Full contact of a free patch",
        "every cell carries, the pressure is singular along the border",
        rough_expected(0.2, 0.3, 0.03, 0.2),
        loading={"force": {"values": [2.0, 10.0], "relative_to": "E* A0 h'"}},
    ),
    _rough(
        "mean-gap-open",
        "A mean gap wider than at first touch",
        "nothing touches at the second load",
        {
            "closed_form": NO_FORM_FLAT,
            "reduced": Expected("degraded", 3.0, 5.0, "nothing touches", (1,), LINE),
            "bem_fft": accurate(1e-6, 1e-6, lost=(1,), text="nothing touches"),
            **_PERIODIC | {"fem": not_for("no mean-gap control")},
        },
        loading={"mean_gap": [1e-9, 1.0]},
        periodic=True,
        truth=Trusted("bem_fft", (16,)),
    ),
    _rough(
        "decades",
        "A patch under forces over 15 decades",
        "the smallest contact is a fraction of a cell, on every grid",
        rough_expected(1e6, 10.0, 3.0, 3.0),
        loading={
            "force": {
                "from": 1e-15,
                "to": 1.0,
                "steps": 16,
                "spacing": "log",
                "relative_to": "E* A0 h'",
            }
        },
    ),
    _rough(
        "absurd-force",
        "A force of 1e300 E* A0 h' among usual ones",
        "the absurd load must not take the others with it",
        rough_expected(
            0.8,
            4.0,
            0.6,
            2.0,
            reduced=Expected("degraded", 0.8, 4.0, "came out as inf", (2,), LINE),
            bem_dense=accurate(1e-8, 1e-8, lost=(2,), text="came out as inf"),
            bem_fft=accurate(1e-6, 1e-6, lost=(2,), text="range of numbers"),
            fem=Expected("degraded", 0.6, 2.0, "the energy overflows", (2,), NODES),
        ),
        loading={"force": {"values": [0.01, 0.05, 1e300], "relative_to": "E* A0 h'"}},
    ),
    _rough(
        "elongated",
        "A patch of 64 x 8 points",
        "eight times as long as wide",
        rough_expected(0.8, 4.0, 0.6, 2.0, fem=refused("64 points per side, more than 32")),
        size=["4 um", "0.5 um"],
        points=[64, 8],
        truth=Trusted("bem_dense", (64,)),
    ),
    _rough(
        "rectangular-cells",
        "Cells ten times as long as wide",
        "the own influence of a cell is a different integral",
        rough_expected(2.0, 4.0, 0.9, 4.0),
        size=["10 um", "1 um"],
        points=[16, 16],
        long_cutoff="5 um",
    ),
    _rough(
        "coarse",
        "A surface of 4 x 4 points",
        "the smallest map there is",
        rough_expected(0.9, 4.0, 0.6, 3.0),
        points=4,
        truth=Trusted("bem_dense", (4,)),
    ),
    _rough(
        "fine",
        "A periodic surface of 512 x 512 points",
        "a quarter of a million unknowns",
        {
            "closed_form": NO_FORM_FLAT,
            "reduced": degraded(0.8, 6.0, why=LINE),
            "bem_fft": accurate(1e-6, 1e-6),
            **_PERIODIC,
        },
        points=512,
        periodic=True,
        truth=Trusted("bem_fft", (512,)),
        slow=frozenset({"reduced", "bem_fft", "bem_dense", "fem", "closed_form"}),
    ),
    _rough(
        "one-realisation",
        "One realisation",
        "no scatter, no standard error",
        rough_expected(0.8, 7.0, 0.6, 2.0),
        realisations=1,
    ),
    _rough(
        "two-realisations",
        "Two realisations",
        "the fewest with a standard error",
        rough_expected(0.8, 7.0, 0.6, 2.0),
        realisations=2,
    ),
    _rough(
        "no-realisation",
        "No realisation",
        "an empty ensemble has no mean",
        all_methods(refused("expected greater than or equal to 1, got 0")),
        realisations=0,
    ),
)
