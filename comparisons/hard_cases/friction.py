"""Hard cases of Coulomb friction: next to none, next to sliding, reversals, strong coupling.

Truth is the half-space on three grids, unless a formula is named.
"""

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
from comparisons.hard_cases.usual import BALL, STEEL, all_methods

if TYPE_CHECKING:
    from comparisons.planning import Plan

RUBBER = {"youngs_modulus": "3 MPa", "poisson_ratio": 0.5}
RESOLUTIONS = {"reduced": 40, "bem_fft": 16, "fem": 4}
# Without coupling the springs lack the slip across the load, 0.4 % along a whole cycle; the bar of
# the grid is added.
_AREA = 0.06  # counted cells, 16 on a radius
_SPRINGS, _GRID = accurate(8e-3, _AREA), accurate(8e-3, _AREA)
_NO_FORM = not_for("Cattaneo's superposition leaves out slip across the load")
_LACKS = not_for("does not model [friction]")
_NO_ELEMENTS = not_for("elements with friction go to 0.4999")
_WHOLE = "slides as a whole"


def _expected(
    reduced: Expected = _SPRINGS,
    bem_fft: Expected = _GRID,
    closed_form: Expected = _NO_FORM,
    fem: Expected = _NO_ELEMENTS,
) -> Mapping[str, Expected]:
    return {
        "closed_form": closed_form,
        "reduced": reduced,
        "bem_fft": bem_fft,
        "bem_dense": _LACKS,
        "fem": fem,
    }


def _case(name: str, title: str, hard: str, **more: Any) -> HardCase:
    tables: dict[str, Any] = {"half_space": RUBBER, "indenter": BALL}
    tables |= {key: more.pop(key) for key in ("half_space", "indenter") if key in more}
    coefficient, loading = more.pop("coefficient", 0.3), more.pop("loading")
    tables |= {"friction": {"coefficient": coefficient}, "loading": loading}
    settings = {"resolutions": RESOLUTIONS, "expected": _expected()} | more
    settings.setdefault("truth", Trusted("bem_fft", (4, 8, 16)))
    return HardCase(f"friction-{name}", title, hard, tables, **settings)


def _stuck(plan: Plan) -> Curves:
    """Return u = F_x/(2 a G*): the whole circle of Hertz sticks, but for a rim of 1e-7 of it."""
    normal = plan.loads.normal
    assert normal is not None
    scene = plan.scene
    assert scene.indenter is not None
    force, modulus = float(normal.values[-1]), scene.effective_modulus
    radius = np.cbrt(0.75 * force / modulus * scene.indenter.radius)  # type: ignore[attr-defined]
    steps = np.ones(len(plan.loads.values))
    shift = plan.loads.values / (2 * radius * scene.tangential_modulus)
    return {"tangential_displacement": shift, "contact_area": np.pi * radius**2 * steps}


_DECAY = [0.28 * (-0.9) ** k for k in range(16)]

CASES = (
    _case(
        "next-to-none",
        "A coefficient of friction of 1e-9",
        "tangential tractions nine orders below the pressure",
        coefficient=1e-9,
        loading={"force": "1 N", "tangential_force": ["0.5e-9 N", "-0.5e-9 N"]},
    ),
    _case(
        "huge",
        "A coefficient of friction of a million",
        "everything sticks: slip is a rim of 1e-7 of the contact",
        coefficient=1e6,
        loading={"force": "1 N", "tangential_force": ["0.5 N", "-0.5 N"]},
        truth=Known(_stuck, "Mindlin 1949: u = F_x/(2 a G*)"),
        expected=_expected(reduced=accurate(1e-6, 1e-9), bem_fft=accurate(8e-3, 0.02)),
    ),
    _case(
        "next-to-sliding",
        "Pulled to 0.999 of sliding",
        "in 3-D F_x tends to mu F only as slip turns into the direction of the load",
        loading={"force": "1 N", "tangential_force": ["0.2997 N", "-0.2997 N"]},
        expected=_expected(
            reduced=degraded(0.3, _AREA, why="springs slip along the load from the beginning"),
            bem_fft=degraded(0.03, _AREA, why="few cells stick, if any"),
        ),
    ),
    _case(
        "beyond-sliding",
        "Pulled beyond sliding",
        "no equilibrium from the second step on",
        loading={"force": "1 N", "tangential_force": ["0.2 N", "0.31 N", "0.1 N"]},
        expected=_expected(
            reduced=accurate(8e-3, _AREA, lost=(1, 2), text=_WHOLE),
            bem_fft=accurate(5e-3, _AREA, lost=(1, 2), text=_WHOLE),
        ),
    ),
    _case(
        "reversals",
        "Sixteen reversals, each smaller than the one before",
        "every turning point stays in memory",
        loading={"force": "1 N", "tangential_force": _DECAY},
    ),
    _case(
        "dragged-beyond",
        "Shifted far beyond sliding and back",
        "gross slip forgets the past, a displacement of hundreds of contact radii goes on",
        loading={"force": "1 N", "tangential_displacement": ["1 m", "0.99999 m", "-1 m"]},
    ),
    _case(
        "auxetic",
        "A rigid ball on a body of nu = -0.9",
        "pressing and shearing act on each other the most: Dundurs' constant 0.74",
        slow=frozenset({"closed_form", "reduced", "bem_fft", "bem_dense", "fem"}),
        half_space={"youngs_modulus": "3 MPa", "poisson_ratio": -0.9},
        loading={"force": "1 N", "tangential_force": ["0.15 N", "-0.15 N"]},
        expected=_expected(
            reduced=degraded(0.4, 0.1, why="the springs leave the coupling out"),
            bem_fft=degraded(0.12, _AREA, why="first order in the steps that press and pull"),
            fem=degraded(0.12, why="first order in the steps that press and pull"),
            closed_form=not_for("no exact solution where pressing drags the surface"),
        ),
    ),
    _case(
        "steel-rigid",
        "A rigid ball on steel",
        "pressing alone makes a rim slip before any tangential load",
        half_space=STEEL,
        loading={"force": "100 N", "tangential_force": ["15 N", "27 N"]},
        expected=_expected(
            reduced=degraded(0.15, 0.08, why="the springs leave the coupling out"),
            bem_fft=accurate(0.01, _AREA),
            fem=degraded(0.03, why="the bar of the half-space, 16 cells per contact radius"),
            closed_form=not_for("no exact solution where pressing drags the surface"),
        ),
    ),
    _case(
        "flat-punch",
        "A flat circular punch",
        "everything sticks until everything slips, at once and under a singular pressure",
        indenter={"shape": "cylinder", "radius": "1 mm"},
        loading={"force": "1 N", "tangential_force": ["0.299 N", "-0.299 N"]},
        truth=None,
        expected=_expected(
            reduced=accurate(1e-11, 1e-11),
            bem_fft=degraded(0.02, 0.02, why="a staircase of cells for the edge"),
            fem=not_for("round smooth contacts"),
            closed_form=accurate(1e-11),
        ),
    ),
    _case(
        "modulus-only",
        "Friction where only E* is known",
        "the tangential stiffness depends on nu",
        half_space={"effective_modulus": "4 MPa"},
        loading={"force": "1 N", "tangential_force": ["0.1 N"]},
        truth=None,
        expected=all_methods(refused("expected E or G with nu")),
    ),
)
