"""Hard shapes and grids: re-entrant, hollow, conforming, needle-like, edges on and off nodes."""

from __future__ import annotations

import math
from typing import Any

from comparisons.hard_cases.case import (
    ONLY_FULL,
    HardCase,
    Trusted,
    accurate,
    degraded,
    not_for,
    refused,
)
from comparisons.hard_cases.usual import RESOLUTIONS, USUAL, all_methods, indenter_scene, usual


def _case(name: str, title: str, hard: str, expected: Any, **more: Any) -> HardCase:
    tables = {key: more.pop(key) for key in ("indenter", "loading", "methods") if key in more}
    settings = {"resolutions": RESOLUTIONS} | more
    return HardCase(name, title, hard, indenter_scene(**tables), expected, **settings)


_FEW = "two cells in the smallest contact, and a tip with infinite pressure"
_NO_PROFILE = not_for("no closed form is known for a profile")
_NO_POLYGON = not_for("no closed form is known for a polygon punch")

PROFILES = (
    _case(
        "profile-re-entrant",
        "A re-entrant profile",
        "an overhang has two heights at one radius",
        all_methods(refused("expected r strictly increasing from 0")),
        indenter={"shape": "profile", "r": [0, 1e-3, 8e-4], "f": [0, 1e-6, 2e-6]},
    ),
    _case(
        "profile-hollow",
        "A hollow profile",
        "the contact is a ring, which the reduced model cannot represent",
        all_methods(refused("hollow profiles have no reduced model")),
        indenter={"shape": "profile", "r": [0, 1e-3, 2e-3], "f": [0, -1e-6, 2e-6]},
    ),
    _case(
        "profile-step",
        "A profile with a step",
        "behind the step the flank flattens out: the equivalent profile falls",
        all_methods(refused("the contact would be a ring")),
        indenter={
            "shape": "profile",
            "r": [0, 1e-4, 1.0001e-4, 2e-4],
            "f": [0, 1e-7, 1e-6, 2e-6],
            "interpolation": "linear",
        },
    ),
    _case(
        "profile-two-points",
        "A profile of two points: a cone",
        "nothing to interpolate",
        usual(
            closed_form=_NO_PROFILE,
            bem_dense=degraded(0.02, 0.3, why=_FEW),
            bem_fft=accurate(3e-3, 0.05),
        ),
        indenter={"shape": "profile", "r": [0, 1e-3], "f": [0, 1e-4], "interpolation": "linear"},
        truth=Trusted("closed_form", (1,), {"indenter": {"shape": "cone", "slope": 0.1}}),
    ),
    _case(
        "conforming-20",
        "Nearly conforming: f = c r^20",
        "the contact grows at once to nearly its full size",
        usual(reduced=accurate(2e-5, 5e-5), bem_dense=accurate(5e-3, 0.05)),
        indenter={"shape": "power_law", "exponent": 20, "coefficient": 1e54},
    ),
    _case(
        "conforming-100",
        "Almost a flat punch: f = c r^100",
        "heights over 300 decades on the same mesh",
        usual(
            reduced=accurate(2e-3, 4e-3),
            bem_dense=accurate(8e-3, 0.03),
            bem_fft=accurate(3e-3, 0.015),
            fem=accurate(3e-3, 6e-3),
        ),
        indenter={"shape": "power_law", "exponent": 100, "coefficient": 1e294},
    ),
    _case(
        "cusp",
        "A cusp: f = c r^0.1",
        "the slope at the tip is infinite, the contact radius grows as the tenth power of depth",
        usual(
            reduced=degraded(0.03, 1e-6, why="the profile x^0.1 is no cubic near its tip"),
            bem_dense=accurate(8e-3, 0.08),
            fem=degraded(0.03, 0.1, why="the pressure is as singular at the tip"),
        ),
        indenter={"shape": "power_law", "exponent": 0.1, "coefficient": 1e-5},
    ),
    _case(
        "steep",
        "A cone of slope 20",
        "far outside small slopes, yet inside the linear theory that all methods share",
        usual(bem_dense=degraded(0.02, 0.3, why=_FEW), bem_fft=accurate(3e-3, 0.05)),
        indenter={"shape": "cone", "slope": 20},
    ),
)

_GAUSSIAN = "the Gaussian radius holds for nearly round contacts"


def _ellipsoid(ratio: float, name: str, expected: Any) -> HardCase:
    return _case(
        f"ellipsoid-{name}",
        f"An ellipsoid with radii {ratio:g} : 1",
        "the contact is long and narrow: few cells across, a circle is a poor guess",
        expected,
        indenter={"shape": "ellipsoid", "radius_x": ratio * 0.01, "radius_y": 0.01},
    )


ELLIPSOIDS = (
    _ellipsoid(
        100,
        "100",
        usual(
            reduced=degraded(0.35, 0.25, why=_GAUSSIAN),
            bem_dense=degraded(0.05, 0.25, why="two cells across the contact"),
            bem_fft=accurate(3e-3, 0.04),
            fem=accurate(2e-3, 4e-3),
        ),
    ),
    _ellipsoid(
        1000,
        "1000",
        usual(
            reduced=degraded(0.55, 0.35, why=_GAUSSIAN),
            bem_dense=degraded(0.15, 1.5, why="one cell across the contact"),
            bem_fft=accurate(6e-3, 0.25),
            fem=refused("elements are tested to 50"),
        ),
    ),
    _ellipsoid(
        1e5,
        "100000",
        usual(
            reduced=degraded(0.8, 0.6, why=_GAUSSIAN),
            bem_dense=degraded(3.0, 10.0, why="a contact of a fraction of a cell across"),
            bem_fft=degraded(0.2, 2.5, why="one cell across the contact"),
            fem=refused("elements are tested to 50"),
        ),
    ),
)

_SQUARE = {"shape": "square_punch", "side": "2 mm"}
_TURNED = [
    [math.sqrt(2) * 1e-3 * math.cos(angle), math.sqrt(2) * 1e-3 * math.sin(angle)]
    for angle in (math.radians(45 + 17 + 90 * corner) for corner in range(4))
]
_TRUE_SQUARE = Trusted("bem_fft", (64, 128, 256), {"indenter": _SQUARE})
_EQUAL_AREA = "D = (4A/pi)^(1/2) takes the square for a circle"
_EDGE = "an edge singularity converges linearly with the cell"

EDGES = (
    _case(
        "edge-on-nodes",
        "A square punch, edges on grid lines",
        "the pressure is singular at the edge",
        usual(
            closed_form=not_for("no closed form is known for a square punch"),
            reduced=degraded(0.03, 1e-6, why=_EQUAL_AREA),
            bem_dense=degraded(0.03, 1e-6, why=_EDGE),
            bem_fft=accurate(0.01, 1e-6),
            fem=degraded(0.03, 1e-6, why=_EDGE),
        ),
        indenter=_SQUARE,
        truth=_TRUE_SQUARE,
    ),
    _case(
        "edge-off-nodes",
        "The same square turned by 17 degrees",
        "the edge cuts cells and elements: a staircase",
        usual(
            closed_form=_NO_POLYGON,
            reduced=degraded(0.03, 1e-6, why=_EQUAL_AREA),
            bem_dense=degraded(0.03, 1e-6, why=_EDGE),
            bem_fft=accurate(0.01, 1e-6),
            fem=degraded(0.1, 1e-6, why="a staircase of trilinear elements"),
        ),
        indenter={"shape": "polygon_punch", "vertices": _TURNED},
        resolutions=RESOLUTIONS | {"fem": 5},
        truth=_TRUE_SQUARE,
    ),
    _case(
        "edge-odd-cells",
        "A flat cylinder on five cells per radius",
        "a circle on square cells, its edge on no grid line",
        usual(
            bem_dense=degraded(0.03, 1e-11, why=_EDGE),
            bem_fft=degraded(0.03, 1e-11, why=_EDGE),
            fem=degraded(0.012, 1e-11, why=_EDGE),
        ),
        indenter={"shape": "cylinder", "radius": "1 mm"},
        resolutions={"reduced": 3, "bem_dense": 5, "bem_fft": 5, "fem": 2},
    ),
    _case(
        "needle",
        "A flat punch of 1 mm x 10 um",
        "a hundred times as long as wide",
        usual(
            closed_form=_NO_POLYGON,
            reduced=degraded(0.7, 1e-6, why="a needle is no circle"),
            bem_dense=degraded(0.04, 1e-6, why=_EDGE),
            bem_fft=degraded(0.02, 1e-6, why=_EDGE),
            fem=degraded(0.12, 1e-6, why=_EDGE),
        ),
        indenter={
            "shape": "polygon_punch",
            "vertices": [[0, 0], [1e-3, 0], [1e-3, 1e-5], [0, 1e-5]],
        },
        truth=Trusted("bem_fft", (40, 80, 160)),
        resolutions=RESOLUTIONS | {"fem": 5},
    ),
    _case(
        "polygon-without-area",
        "A polygon without an area",
        "all corners on one line",
        all_methods(refused("expected a polygon with an area")),
        indenter={"shape": "polygon_punch", "vertices": [[0, 0], [1e-3, 0], [2e-3, 0]]},
    ),
)

GRIDS = (
    _case(
        "grid-coarse",
        "Two springs, cells, elements per contact radius",
        "the coarsest that may be asked for; the smallest contact has one cell",
        usual(
            bem_dense=degraded(0.2, 0.5, why="one cell across the smallest contact"),
            bem_fft=degraded(0.2, 0.5, why="one cell across the smallest contact"),
            fem=accurate(1e-3, 2e-3),
        ),
        resolutions=dict.fromkeys(RESOLUTIONS, 2),
    ),
    _case(
        "grid-fine",
        "A hundred thousand springs, 256 cells, 8 elements",
        "memory and time; round-off of long sums",
        usual(
            bem_dense=refused("more than 5000: use bem_fft"),
            bem_fft=accurate(1e-5, 1e-3),
            fem=accurate(1e-4, 2e-4),
        ),
        resolutions={"reduced": 100_000, "bem_dense": 50, "bem_fft": 256, "fem": 8},
        slow=ONLY_FULL | {"bem_fft"},
    ),
    _case(
        "tolerance-round-off",
        "A solver tolerance of 2e-13",
        "below it only round-off is left, and an iteration may stall there",
        USUAL,
        methods={"bem_fft": {"tolerance": 2e-13}},
    ),
)

CASES = (*PROFILES, *ELLIPSOIDS, *EDGES, *GRIDS)
