"""What the cases share: an easy scene, the resolutions of a quick answer, and its usual errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from comparisons.hard_cases.case import Expected, accurate, not_for

STEEL = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
BALL = {"shape": "paraboloid", "radius": "10 mm"}
DEPTHS = {"penetration": ["1 um", "2 um", "5 um"]}
# Springs, cells and elements per contact radius: each method answers within about half a second.
RESOLUTIONS = {"reduced": 40, "bem_dense": 10, "bem_fft": 32, "fem": 3}
# The errors on Hertz' paraboloid at these resolutions, with a margin of two. The smallest of the
# contacts has half the radius of the largest, and as few cells.
USUAL = {
    "closed_form": accurate(1e-11),
    "reduced": accurate(1e-11, 1e-11),
    "bem_dense": accurate(8e-3, 0.08),
    "bem_fft": accurate(8e-4, 0.015),
    "fem": accurate(5e-4, 1e-3),
}
NO_FORM_FLAT = not_for("a rough surface has no closed form")


def indenter_scene(**tables: Any) -> dict[str, Any]:
    """Return the tables of a ball on steel at three depths, but for what is given."""
    return {"half_space": STEEL, "indenter": BALL, "loading": DEPTHS} | tables


def usual(**changes: Expected) -> Mapping[str, Expected]:
    """Return what every method does on an easy indenter, but for what is given."""
    return USUAL | changes


def all_methods(expected: Expected) -> Mapping[str, Expected]:
    """Return the same expectation for every built-in method."""
    return dict.fromkeys(USUAL, expected)
