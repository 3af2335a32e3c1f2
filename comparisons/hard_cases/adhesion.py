"""Hard paths of adhesive contacts: no touch, no load, lost and found again, tips of nanometres."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from comparisons.hard_cases.case import Expected, HardCase, Known, accurate, degraded, not_for
from comparisons.hard_cases.usual import BALL

_RUBBER = {"effective_modulus": "2 MPa"}
_RESOLUTIONS = {"reduced": 40, "bem_fft": 16}
_NO_ADHESION = not_for("does not model [adhesion]")
_NOT_HELD = not_for("sharper than the root of r")
_COMPARED = {"quantities": ["pull_off_force", "force", "penetration"]}
# The largest pull at these resolutions; cells let go at a tension calibrated to the mesh.
_USUAL: Mapping[str, Expected] = {
    "closed_form": accurate(1e-11),
    "reduced": accurate(1e-10),
    "bem_fft": degraded(0.25, why="detachment is calibrated, not derived: docs/adhesion.md"),
    "bem_dense": _NO_ADHESION,
    "fem": _NO_ADHESION,
}


def _path(
    name: str,
    title: str,
    hard: str,
    loading: Mapping[str, Any],
    expected: Any = None,
    truth: Known | None = None,
    **tables: Any,
) -> HardCase:
    scene = {"half_space": _RUBBER, "indenter": BALL, "adhesion": {"work": "50 mJ/m^2"}}
    return HardCase(
        id=f"adhesion-{name}",
        title=title,
        hard=hard,
        scene=scene | {"loading": dict(loading), "compare": _COMPARED} | tables,
        expected=_USUAL if expected is None else expected,
        resolutions=_RESOLUTIONS,
        truth=truth,
    )


CASES = (
    _path(
        "again",
        "Laid down, torn off, and laid down again",
        "the state at a load depends on what was before; between, nothing holds the pull",
        {"force": ["0 mN", "2 mN", "-1 mN", "-5 mN", "-1 mN", "0 mN", "1 mN", "-5 mN"]},
    ),
    _path(
        "no-load",
        "A ball that is only laid down",
        "the contact has a size at zero force, and the fold is never reached",
        {"force": ["0 mN", "0.001 mN"]},
        compare={"quantities": ["penetration"]},
    ),
    _path(
        "afm",
        "A tip of 10 nm on a stiff solid",
        "lengths of picometres, forces of nanonewtons",
        {"force": ["0 nN", "2 nN", "-1 nN", "-10 nN"]},
        half_space={"effective_modulus": "70 GPa"},
        indenter={"shape": "paraboloid", "radius": "10 nm"},
    ),
    _path(
        "spike",
        "f = c r^0.4, a tip sharper than the root of r",
        "d(a) rises from zero on: adhesion does not hold it, and spreads without end further out",
        {"force": ["0 mN", "2 mN", "-1 mN"]},
        {
            "closed_form": _NOT_HELD,
            "reduced": _NOT_HELD,
            "bem_fft": _NOT_HELD,
            "bem_dense": _NO_ADHESION,
            "fem": _NO_ADHESION,
        },
        truth=Known(
            lambda plan: {"pull_off_force": np.zeros(plan.loads.values.size)}, "nothing is held"
        ),
        indenter={"shape": "power_law", "exponent": 0.4, "coefficient": 0.1},
    ),
)
