"""Hard cases of rubber that slides: creeping, racing, twelve decades of memory, and what cannot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from comparisons.hard_cases.case import (
    Curves,
    Expected,
    HardCase,
    Known,
    Trusted,
    degraded,
    not_for,
)
from comparisons.hard_cases.usual import BALL

if TYPE_CHECKING:
    from comparisons.planning import Plan

_RUBBER = {"model": "standard", "shear_moduli": ["0.5 MPa", "5 MPa"], "relaxation_times": "10 ms"}
_RESOLUTIONS = {"reduced": 40, "bem_fft": 12}
_FORCE = {"force": "1 N"}
_COMPARED = {"quantities": ["friction_coefficient", "penetration"]}
_LACKS = not_for("does not model [viscoelastic]")
_GRIDS = Trusted("bem_fft", (6, 12, 24))
# What takes seconds for its truth alone, only --full runs.
_SLOW = {"slow": frozenset({"closed_form", "reduced", "bem_fft", "bem_dense", "fem"})}


def _expected(reduced: Expected, bem_fft: Expected) -> Mapping[str, Expected]:
    return {
        "closed_form": _LACKS,
        "reduced": reduced,
        "bem_fft": bem_fft,
        "bem_dense": _LACKS,
        "fem": _LACKS,
    }


def _case(name: str, title: str, hard: str, speed: Any, **more: Any) -> HardCase:
    tables = {
        "indenter": BALL,
        "viscoelastic": _RUBBER,
        "sliding": {"speed": speed},
        "loading": _FORCE,
        "compare": _COMPARED,
    }
    tables |= {key: more.pop(key) for key in ("indenter", "viscoelastic") if key in more}
    settings = {"resolutions": _RESOLUTIONS, "truth": _GRIDS} | more
    return HardCase(f"sliding-{name}", title, hard, tables, **settings)


def _creeping(plan: Plan) -> Curves:
    """Return mu = (eta/G) v/R, eta = sum G_i tau_i: what slow sliding tends to in 3-D."""
    scene = plan.scene
    material, indenter = scene.viscoelastic, scene.indenter
    assert material is not None
    assert indenter is not None
    viscosity = sum(modulus * time for modulus, time in material.branches)
    slope = viscosity / material.long_term_modulus / indenter.radius  # type: ignore[attr-defined]
    return {"friction_coefficient": slope * plan.loads.values}


_NEVER_STEADY = not_for("nothing is steady")
_SHARP = not_for("sharp edge")

CASES = (
    _case(
        "creeping",
        "A ball that creeps, 0.1 um in a retardation time and less",
        "friction of 1e-8 from pressures that are symmetric but for as much; far below a cell",
        ["1 nm/s", "1 um/s"],
        truth=Known(_creeping, "first order in the speed: docs/rubber-sliding.md"),
        expected=_expected(
            reduced=degraded(1.01, why="the line has the slopes of all directions: twice as much"),
            bem_fft=degraded(0.2, why="first order in the cells at the edge, 12 on a half-width"),
        ),
    ),
    _case(
        "racing",
        "A ball at 10 m/s and 1 km/s",
        "relaxation takes 10 to 1000 contact radii: all is glass, and friction hardly anything",
        ["10 m/s", "1 km/s"],
        expected=_expected(
            reduced=degraded(0.05, 0.06, why="the bar of the grids; springs are right in glass"),
            bem_fft=degraded(0.1, 0.1, why="12 cells on a half-width"),
        ),
    ),
    _case(
        "dashpot",
        "A ball at 10 m/s on a body with a dashpot",
        "nothing limits the modulus: the contact shrinks to a leading edge in the overlap of rest",
        ["10 m/s"],
        viscoelastic={
            "model": "kelvin_voigt",
            "shear_moduli": "0.5 MPa",
            "relaxation_times": "10 ms",
        },
        truth=Trusted("bem_fft", (12, 24, 48)),
        **_SLOW,
        expected=_expected(
            reduced=degraded(0.55, 0.35, why="the line has the slopes of all directions"),
            bem_fft=degraded(0.1, 0.2, why="12 cells on a half-width"),
        ),
    ),
    _case(
        "twelve-decades",
        "Relaxation times from 0.1 ns to 100 s",
        "explicit steps would have to be shorter than the shortest of them",
        ["10 cm/s"],
        viscoelastic={
            "model": "prony",
            "shear_moduli": ["0.5 MPa", "0.5 MPa", "0.5 MPa", "2 MPa"],
            "relaxation_times": ["100 s", "10 ms", "0.1 ns"],
        },
        **_SLOW,
        expected=_expected(
            reduced=degraded(0.55, 0.12, why="the line has the slopes of all directions"),
            bem_fft=degraded(0.03, 0.1, why="12 cells on a half-width"),
        ),
    ),
    _case(
        "fluid",
        "A Maxwell fluid",
        "the body sinks without end: there is no steady state",
        ["1 mm/s"],
        viscoelastic={"model": "maxwell", "shear_moduli": "1 MPa", "relaxation_times": "10 ms"},
        truth=None,
        expected=_expected(_NEVER_STEADY, _NEVER_STEADY),
    ),
    _case(
        "flat-face",
        "A flat punch",
        "its leading edge is sharp: pressures and friction there have no bound",
        ["1 mm/s"],
        indenter={"shape": "cylinder", "radius": "1 mm"},
        truth=None,
        expected=_expected(_SHARP, _SHARP),
    ),
)
