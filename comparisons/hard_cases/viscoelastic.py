"""Hard histories of viscoelastic bodies: imprints, retreats, jumps, impacts that stick."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from comparisons.hard_cases.case import (
    Expected,
    HardCase,
    Known,
    Trusted,
    accurate,
    not_for,
    refused,
)
from comparisons.hard_cases.usual import BALL

_RUBBER = {"model": "standard", "shear_moduli": ["1 MPa", "9 MPa"], "relaxation_times": "50 ms"}
_RESOLUTIONS = {"reduced": 40, "bem_fft": 64}
_NO_MEMORY = not_for("does not model [viscoelastic]")
# The errors on an easy history (in, rest, out of standard rubber) at these resolutions, with a
# margin of two: of the largest force and of the largest area.
_USUAL: Mapping[str, Expected] = {
    "closed_form": accurate(1e-11),
    "reduced": accurate(1e-4, 1e-3),
    "bem_fft": accurate(1e-3, 0.015),
    "bem_dense": _NO_MEMORY,
    "fem": _NO_MEMORY,
}
# Where nothing but the half-space in time knows the answer.
_GRIDS = Trusted("bem_fft", (16, 32, 64))
# The springs then are judged with the bar of the grids, which is that of their areas above all.
_BY_GRIDS = {"reduced": accurate(2e-3, 0.03), "bem_fft": accurate(4e-3, 0.06)}


def _same(quantity: str, value: float, source: str) -> Known:
    """Return a truth that is the same number at every step."""
    return Known(lambda plan: {quantity: np.full(plan.loads.values.size, value)}, source)


def _history(
    name: str, title: str, hard: str, loading: Mapping[str, Any], expected: Any = None, **more: Any
) -> HardCase:
    tables = {"indenter": BALL, "viscoelastic": _RUBBER, "loading": dict(loading)}
    tables |= {key: more.pop(key) for key in ("indenter", "viscoelastic") if key in more}
    return HardCase(
        id=f"memory-{name}",
        title=title,
        hard=hard,
        scene=tables,
        expected=_USUAL if expected is None else expected,
        **{"resolutions": _RESOLUTIONS} | more,
    )


_OUT = {
    "time": [0, "0.1 s", "0.2 s", "0.3 s"],
    "penetration": [0, "100 um", "100 um", "20 um"],
    "substeps": 4,
}
_HELD = {"time": [0, "1 s", "2 s"], "penetration": ["100 um"] * 3}
_AWAY = {
    "time": [0, "0.1 s", "0.3 s", "0.31 s", "0.5 s", "0.6 s"],
    "penetration": [0, "100 um", "100 um", "-50 um", "-50 um", "110 um"],
    "substeps": 4,
}
_SLOWS = {
    "time": [0, "0.1 s", "0.12 s", "0.5 s"],
    "penetration": [0, "100 um", "60 um", "58 um"],
    "substeps": 4,
}
HISTORIES = (
    _history("easy", "In, rest, out", "nothing: the yardstick of the others", _OUT),
    _history(
        "eighteen-decades",
        "Relaxation times over eighteen decades",
        "explicit steps would have to be shorter than the shortest of them",
        _OUT,
        viscoelastic={
            "model": "prony",
            "shear_moduli": ["1 MPa"] * 5,
            "relaxation_times": ["1 ps", "1 us", "1 s", "1e6 s"],
        },
    ),
    _history(
        "step-over-relaxation",
        "A step a billion relaxation times long",
        "an explicit update is multiplied by -1e9 in every step",
        _HELD,
        viscoelastic=_RUBBER | {"relaxation_times": "1 ns"},
    ),
    _history(
        "nanoseconds",
        "A tip of 10 nm in nanoseconds",
        "an absolute tolerance of time or length fails here",
        {
            "time": [0, "0.1 ns", "0.2 ns", "0.3 ns"],
            "penetration": [0, "0.1 nm", "0.1 nm", "0.02 nm"],
            "substeps": 4,
        },
        indenter={"shape": "paraboloid", "radius": "10 nm"},
        viscoelastic=_RUBBER | {"relaxation_times": "50 ps"},
    ),
    _history(
        "imprint-of-a-fluid",
        "A ball comes back to the imprint that it left in a fluid",
        "the surface must remember where nothing touches it, for good",
        _AWAY,
        dict(_USUAL) | _BY_GRIDS | {"closed_form": not_for("falls once")},
        viscoelastic={"model": "maxwell", "shear_moduli": "5 MPa", "relaxation_times": "0.2 s"},
        truth=_GRIDS,
        resolutions=_RESOLUTIONS | {"bem_fft": 32},
    ),
    _history(
        "retreat-slows",
        "A retreat that the recovering surface overtakes",
        "the contact grows while the depth falls, and Ting's integral says otherwise",
        _SLOWS,
        dict(_USUAL) | _BY_GRIDS | {"closed_form": not_for("grows again")},
        truth=_GRIDS,
        resolutions=_RESOLUTIONS | {"bem_fft": 32},
    ),
    _history(
        "flat-punch",
        "A flat punch in and out",
        "all springs leave at one instant, inside a step",
        _OUT,
        dict(_USUAL) | {"reduced": accurate(1e-11, 1e-11), "bem_fft": not_for("a flat face")},
        indenter={"shape": "cylinder", "radius": "1 mm"},
    ),
    _history(
        "dashpot-step",
        "A jump of the depth against a dashpot",
        "it takes an infinite force",
        _HELD,
        dict.fromkeys(("closed_form", "reduced", "bem_fft"), not_for("resists a jump"))
        | {"bem_dense": _NO_MEMORY, "fem": _NO_MEMORY},
        viscoelastic={"model": "kelvin_voigt", "shear_moduli": "1 MPa", "viscosities": "1 kPa s"},
        truth=_same("force", np.inf, "the force of a dashpot under a jump"),
    ),
    _history(
        "force-ends",
        "A force that ends",
        "no depth belongs to no force: the body has left, or rests on the surface",
        {"time": [0, "0.1 s", "0.2 s"], "force": ["0.2 N", "0.2 N", "0 N"]},
        dict.fromkeys(("closed_form", "reduced", "bem_fft"), not_for("leaves the depth open"))
        | {"bem_dense": _NO_MEMORY, "fem": _NO_MEMORY},
        truth=_same("penetration", np.nan, "any depth above the surface has no force"),
    ),
)


def _impact(
    name: str,
    title: str,
    hard: str,
    body: Mapping[str, Any],
    mass: str,
    expected: Any,
    **more: Any,
) -> HardCase:
    nothing = not_for("does not model [viscoelastic] and [dynamics]")
    return HardCase(
        id=f"impact-{name}",
        title=title,
        hard=hard,
        scene={
            "indenter": BALL,
            "viscoelastic": dict(body),
            "dynamics": {"mass": mass, "velocity": ["1 cm/s", "1 m/s"]},
        },
        expected=dict.fromkeys(("bem_fft", "bem_dense", "fem"), nothing) | expected,
        **{"resolutions": _RESOLUTIONS} | more,
    )


IMPACTS = (
    _impact(
        "overdamped",
        "A ball that hardly comes back",
        "of the speed before some thousandth is left, the difference of large numbers",
        {"model": "kelvin_voigt", "shear_moduli": "1 MPa", "relaxation_times": "0.1 s"},
        "1 g",
        {"closed_form": accurate(1e-11), "reduced": accurate(1e-3)},
    ),
    _impact(
        "sticky",
        "A heavy ball sinks into a fluid",
        "the fluid keeps it for longer than any impact lasts",
        {"model": "maxwell", "shear_moduli": "1 MPa", "relaxation_times": "1 us"},
        "1000 kg",
        {
            "closed_form": refused("does not come back"),
            "reduced": refused("still in contact"),
        },
        truth=_same("restitution", 0.0, "the ball stays in the fluid"),
        resolutions={"reduced": 8},
    ),
)

CASES = (*HISTORIES, *IMPACTS)
