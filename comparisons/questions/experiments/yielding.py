"""Springs that yield (19.6): force, area and dent of each reading against finite elements.

A ball of R = E = 1, nu = 0.3, Y = 1/500; depths in units of that at first yield.
"""

from __future__ import annotations

from functools import cache
from typing import cast

import numpy as np

from comparisons.questions.experiments.base import Effort
from comparisons.questions.experiments.running import Finding, experiment, one_of
from comparisons.scene.physics.tables.plasticity import HARDNESS
from reduced.loads import LoadPath as SpringPath
from reduced.plasticity.caps import Reading, YieldingSprings
from reduced.plasticity.zunker_kamrin import ZunkerKamrin
from reduced.profiles.equivalents import paraboloid
from reference.fem.elasticity import Material
from reference.loads import LoadPath
from reference.plastic import PlasticMaterial, Walk, yield_depth, yield_pressure

_NU, _YIELD_STRESS = 0.3, 1 / 500
_MODULUS = 1 / (1 - _NU**2)
_DEPTH = yield_depth(1.0, _MODULUS, yield_pressure(_NU) * _YIELD_STRESS)
_QUANTITIES = ("force", "area", "residual_depth")
_READINGS = ("stress", "elastic_root", "zunker_kamrin", "none")
_GRIDS: dict[Effort, tuple[int, int]] = {"quick": (4, 6), "full": (6, 10)}
_SPRINGS = 2000
Contact = dict[str, float]


@cache
def _elements(depth: float, per_radius: int) -> Contact:
    """Press a ball into finite elements."""
    d = depth * _DEPTH
    radius = np.sqrt(d * min(2.0, 1 + 0.25 * max(np.log10(depth), 0.0) ** 1.2))
    steel = PlasticMaterial(Material(1.0, _NU), _YIELD_STRESS)
    walk = Walk(steel, lambda r: r**2 / 2, float(radius), per_radius=per_radius)
    (moment,) = walk.along(LoadPath("penetration", d))
    return {
        "force": moment.force,
        "area": np.pi * moment.contact_radius**2,
        "residual_depth": walk.residual_depth(moment),
    }


def _springs(depth: float, reading: str) -> Contact:
    """Press it onto springs."""
    d = depth * _DEPTH
    path = SpringPath("penetration", d)
    if reading == "zunker_kamrin":
        line = ZunkerKamrin(1.0, _MODULUS, _YIELD_STRESS).walk(path)
    else:
        hardness = HARDNESS * _YIELD_STRESS
        line = YieldingSprings(
            paraboloid(1.0),
            _MODULUS,
            hardness,
            cast("Reading", reading),
            reach=d,
            springs=_SPRINGS,
        ).walk(path)
    area = np.pi * float(line.contact_radius[0]) ** 2
    force, left = float(line.force[0]), float(line.residual_depth[0])
    return {"force": force, "area": area, "residual_depth": left}


def _yielding(
    effort: Effort, *, depth: float = 10.0, reading: str = "stress", quantity: str = "force"
) -> Finding:
    """Compare a quantity of a reading with that of finite elements at equal penetration."""
    one_of("reading", reading, *_READINGS)
    one_of("quantity", quantity, *_QUANTITIES)
    if not 0.1 <= depth <= 1000:
        raise ValueError(f"depth must be from 0.1 to 1000, not {depth!r}")
    coarse, fine = (_elements(depth, n)[quantity] for n in _GRIDS[effort])
    stated = _springs(depth, reading)[quantity]
    if fine == 0:
        raise ValueError(f"no {quantity} at {depth!r} times the depth of first yield")
    details: dict[str, float | str] = {
        "of springs": stated,
        "of finite elements": fine,
        "over Hertz's": fine / _hertz(depth)[quantity] if quantity != "residual_depth" else "",
    }
    # steps and elements err in proportion to their size (Richardson's rule of first order)
    fewer, more = _GRIDS[effort]
    bar = abs(fine - coarse) / (more / fewer - 1)
    return Finding(stated / fine - 1, bar * stated / fine**2, details)


def _hertz(depth: float) -> Contact:
    d = depth * _DEPTH
    return {"force": 4 / 3 * _MODULUS * d**1.5, "area": np.pi * d}


EXPERIMENTS = (
    experiment(
        "yielding-springs",
        "Force, area or dent of springs that yield against finite elements",
        "depth over that of first yield d/d_y",
        "depth",
        _yielding,
    ),
)
