"""Hard loads: fifteen decades, absurd, twins, deeper than the shape."""

from __future__ import annotations

from typing import Any

import numpy as np

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

_FORCES = {"force": {"from": 1e-12, "to": 1e3, "steps": 16, "spacing": "log"}}
_DECADES = "one grid for all loads would put the smallest contact into 1e-5 of a cell"


def _decades(name: str, title: str, expected: Any, **tables: Any) -> HardCase:
    return HardCase(
        id=f"decades-{name}",
        title=title,
        hard=_DECADES,
        scene=indenter_scene(**{"loading": _FORCES} | tables),
        expected=expected,
        resolutions=RESOLUTIONS,
        slow=ONLY_FULL | {"bem_dense"},
    )


# The smallest contact on one grid has an eighth of the radius of the largest.
_COARSE = {"bem_dense": degraded(0.05, 0.4, why="an eighth of 10 cells per contact radius")}
DECADES = (
    _decades(
        "ball",
        "A ball under forces over 15 decades",
        usual(**_COARSE, bem_fft=accurate(3e-3, 0.05)),
    ),
    _decades(
        "power-law-4",
        "f = c r^4 under forces over 15 decades",
        usual(reduced=accurate(1e-4, 1e-4), **_COARSE, bem_fft=accurate(8e-3, 0.05)),
        indenter={"shape": "power_law", "exponent": 4, "coefficient": "1e6 m^-3"},
    ),
    _decades(
        "cone",
        "A cone under forces over 15 decades",
        usual(**_COARSE, bem_fft=accurate(3e-3, 0.05)),
        indenter={"shape": "cone", "slope": 0.1},
    ),
    _decades(
        "sphere",
        "A sphere at depths over 15 decades",
        usual(reduced=accurate(1e-8, 1e-8), **_COARSE, bem_fft=accurate(5e-3, 0.05)),
        indenter={"shape": "sphere", "radius": "10 mm"},
        loading={"penetration": {"from": 1e-20, "to": 1e-5, "steps": 16, "spacing": "log"}},
    ),
    _decades(
        "rounded-punch",
        "A rounded punch under forces over 15 decades",
        usual(
            reduced=accurate(1e-3, 2e-3),
            bem_dense=degraded(0.04, 0.1, why="a kink, and 10 cells per contact radius"),
            bem_fft=accurate(6e-3, 0.02),
            fem=accurate(8e-3, 0.015),
        ),
        indenter={"shape": "rounded_punch", "flat_radius": "1 mm", "edge_radius": "10 mm"},
    ),
)


def _loads(name: str, title: str, hard: str, loading: Any, expected: Any) -> HardCase:
    return HardCase(
        id=f"load-{name}",
        title=title,
        hard=hard,
        scene=indenter_scene(loading=loading),
        expected=expected,
        resolutions=RESOLUTIONS,
        slow=frozenset() if "absurd" in name else ONLY_FULL,
    )


def _without_last(method: str, text: str) -> Any:
    easy = USUAL[method]
    return accurate(easy.error, easy.area, lost=(2,), text=text)


LOADS = (
    _loads(
        "absurd-penetration",
        "1e300 m among micrometres",
        "the absurd load must not take the others with it",
        {"penetration": [1e-6, 2e-6, 1e300]},
        usual(
            closed_form=_without_last("closed_form", "came out as"),
            reduced=_without_last("reduced", "came out as"),
            bem_dense=_without_last("bem_dense", "came out as"),
            bem_fft=_without_last("bem_fft", "came out as"),
            fem=_without_last("fem", ""),
        ),
    ),
    _loads(
        "tiny",
        "1e-100 m beside a micrometre",
        "squares and cubes of the depth leave the range of double precision",
        {"penetration": [1e-100, 1e-6]},
        USUAL,
    ),
    _loads("one", "One load only", "no curve to interpolate", {"penetration": "1 um"}, USUAL),
    _loads(
        "twins-penetration",
        "Two depths that differ in the last digit",
        "divided differences of the sweep are rounding only",
        {"penetration": [1e-6, float(np.nextafter(1e-6, 1.0))]},
        USUAL,
    ),
    _loads(
        "twins-force",
        "Two forces that differ in the last digit",
        "divided differences of the sweep are rounding only",
        {"force": [1.0, float(np.nextafter(1.0, 2.0))]},
        USUAL,
    ),
    _loads(
        "zero",
        "A load of zero",
        "nothing is in contact",
        {"penetration": [0.0, 1e-6]},
        all_methods(refused("expected positive finite loads")),
    ),
    _loads(
        "not-a-number",
        "A load that is no number",
        "NaN passes every comparison",
        {"penetration": [1e-6, float("nan")]},
        all_methods(refused("expected positive finite loads")),
    ),
    HardCase(
        id="depth-beyond-radius",
        title="A paraboloid pressed to three times its radius",
        hard="far outside small slopes, yet inside the linear theory that all methods share",
        scene=indenter_scene(loading={"penetration": ["5 mm", "30 mm"]}),
        expected=usual(bem_fft=accurate(1e-3, 0.03)),
        resolutions=RESOLUTIONS,
    ),
    HardCase(
        id="depth-beyond-sphere",
        title="A sphere pressed to three times its radius",
        hard="the contact comes within 1 % of the equator, where the flank is vertical",
        scene=indenter_scene(
            indenter={"shape": "sphere", "radius": "10 mm"},
            loading={"penetration": ["5 mm", "30 mm"]},
        ),
        expected=usual(reduced=accurate(6e-4, 6e-4), fem=accurate(8e-4, 0.03)),
        resolutions=RESOLUTIONS,
    ),
    HardCase(
        id="depth-to-the-equator",
        title="A sphere pressed to a hundred times its radius",
        hard="the contact would reach the equator, where the sphere ends",
        scene=indenter_scene(
            indenter={"shape": "sphere", "radius": "10 mm"}, loading={"penetration": ["1 m"]}
        ),
        expected=all_methods(refused("the contact would reach the radius of")),
    ),
    HardCase(
        id="depth-beyond-table",
        title="A table pressed to ten times its height",
        hard="the contact stands at the sharp edge of the last tabulated radius",
        scene=indenter_scene(
            indenter={"shape": "profile", "r": ["0 mm", "1 mm"], "f": ["0 mm", "10 um"]},
            loading={"penetration": ["50 um", "100 um"]},
        ),
        truth=Trusted("bem_fft", (64, 128, 256)),
        expected=usual(
            closed_form=not_for("no closed form is known for a profile"),
            reduced=accurate(8e-3, 1e-2),
            bem_dense=degraded(0.03, 0.04, why="a sharp edge converges linearly"),
            bem_fft=accurate(0.01, 1e-2),
            fem=accurate(0.01, 1e-2),
        ),
        resolutions=RESOLUTIONS,
    ),
)

CASES = (*DECADES, *LOADS)
