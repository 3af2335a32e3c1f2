"""Hard materials and scales: incompressible, auxetic, penalties, nanometres and megametres."""

from __future__ import annotations

from typing import Any

from comparisons.hard_cases.case import ONLY_FULL, HardCase, accurate, degraded, refused
from comparisons.hard_cases.usual import (
    RESOLUTIONS,
    USUAL,
    all_methods,
    indenter_scene,
)

_LOCKING = "displacement elements lock as the bulk modulus grows without bound"


def _poisson(nu: float, name: str, **more: Any) -> HardCase:
    return HardCase(
        id=f"nu-{name}",
        title=f"Poisson's ratio {nu:g}",
        hard=_LOCKING if nu > 0.4 else "bulk and shear modulus differ by orders of magnitude",
        scene=indenter_scene(half_space={"shear_modulus": "1 MPa", "poisson_ratio": nu}),
        resolutions=RESOLUTIONS,
        slow=frozenset() if nu < 0 or nu > 0.4 else ONLY_FULL,
        **{"expected": USUAL} | more,
    )


POISSON = (
    _poisson(-0.99, "auxetic"),
    _poisson(-0.5, "negative"),
    _poisson(0.0, "0"),
    _poisson(0.3, "0.3".replace(".", "-")),
    _poisson(0.49, "0-49"),
    _poisson(0.499, "0-499"),
    _poisson(0.4999, "0-4999"),
    _poisson(0.5, "0-5"),
    _poisson(
        0.6, "0-6", expected=all_methods(refused("expected a number with -1 < nu <= 0.5, got 0.6"))
    ),
)

_ONLY_FEM = "the penalty is an option of the finite-element solver"


def _penalty(value: float, name: str, expected: Any, contact: str = "penalty") -> HardCase:
    return HardCase(
        id=f"{contact.replace('_', '-')}-{name}",
        title=f"{contact.replace('_', ' ').capitalize()}, eps h/E* = {value:g}",
        hard="a soft penalty lets the bodies overlap, a stiff one spoils the condition number",
        scene=indenter_scene(methods={"fem": {"contact": contact, "penalty": value}}),
        expected={"fem": expected},
        resolutions=RESOLUTIONS,
        only=_ONLY_FEM,
        slow=frozenset() if value in (1e-2, 1e10) else ONLY_FULL,
    )


_OVERLAP = "the overlap is of order 1/eps"
PENALTIES = (
    _penalty(1e-2, "1e-2", degraded(0.98, 1.0, why=_OVERLAP)),
    _penalty(1.0, "1", degraded(0.15, 0.2, why=_OVERLAP)),
    _penalty(1e2, "1e2", accurate(3e-3, 0.012)),
    _penalty(1e4, "1e4", accurate(5e-4, 1e-3)),
    _penalty(1e6, "1e6", accurate(5e-4, 1e-3)),
    _penalty(1e10, "1e10", accurate(5e-4, 1e-3)),
    _penalty(
        1.0, "1", refused("the overlap did not vanish in 100 updates"), "augmented_lagrangian"
    ),
    _penalty(1e10, "1e10", accurate(5e-4, 1e-3), "augmented_lagrangian"),
)


def _scaled(name: str, title: str, modulus: Any, radius: Any, depths: list[Any]) -> HardCase:
    return HardCase(
        id=f"scale-{name}",
        title=title,
        hard="an absolute tolerance, or a product of many lengths, fails far from 1",
        scene=indenter_scene(
            half_space={"effective_modulus": modulus},
            indenter={"shape": "paraboloid", "radius": radius},
            loading={"penetration": depths},
        ),
        expected=USUAL,
        resolutions=RESOLUTIONS,
    )


SCALES = (
    _scaled("nanometre", "A tip of 10 nm on 100 GPa", "100 GPa", "10 nm", ["0.1 nm", "0.5 nm"]),
    _scaled("planet", "A ball of 1000 km on 1 Pa", "1 Pa", 1e6, [1e4, 5e4]),
    _scaled("modulus-1e300", "A modulus of 1e300 Pa", 1e300, "10 mm", ["1 um", "5 um"]),
    _scaled("modulus-1e-300", "A modulus of 1e-300 Pa", 1e-300, "10 mm", ["1 um", "5 um"]),
    _scaled("length-1e60", "Lengths of 1e60 m", 1.0, 1e60, [1e56, 5e56]),
    _scaled("length-1e-60", "Lengths of 1e-60 m", 1.0, 1e-60, [1e-64, 5e-64]),
    HardCase(
        id="scale-length-1e300",
        title="A radius of 1e300 m",
        hard="the product of radius and depth is beyond double precision",
        scene=indenter_scene(
            indenter={"shape": "paraboloid", "radius": 1e300}, loading={"penetration": [1e296]}
        ),
        expected=all_methods(refused("beyond the range of double precision")),
    ),
)

CASES = (*POISSON, *PENALTIES, *SCALES)
