"""Springs with stick and slip (19.18), (19.19): the stick zone, and a changing normal load."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.judging.uncertainty import SAFE
from comparisons.questions.experiments.experiment import Above, Between, Effort, Finding, experiment
from comparisons.solving.shared import shared
from reduced.friction.slide import Friction, slide, tangential_modulus
from reduced.friction.stick_slip import follow
from reduced.loads import Load, LoadPath
from reduced.profiles import equivalents
from reduced.springs.line import Springs
from reference import loads as reference_loads
from reference.closed_form import PartialSlip, power_law
from reference.halfspace.friction import FrictionalPress, sweep
from reference.halfspace.traction import Compliance, NormalAndTangential

EXACT = 1e-12
# Incompressible: normal and tangential tractions are uncoupled. E* = R = 1.
_POISSON, _SHEAR_MODULUS, _FRICTION = 0.5, 0.25, 0.5
_MODULUS = tangential_modulus(_SHEAR_MODULUS, _POISSON)
_DEPTH = 0.01  # over the radius of the ball; forces are scaled, so the value is arbitrary
_SPRINGS = 2001  # enough for a discretisation error far below that of any grid
# Cells per contact radius and steps of the path, coarse and fine: their difference is the bar.
_GRIDS: dict[Effort, tuple[tuple[int, int], ...]] = {
    "quick": ((8, 6), (16, 12)),
    "full": ((16, 16), (32, 32)),
}


@experiment(
    "stick-radius",
    "Length of the springs that stick against the stick radius in closed form",
    "share",
    "tangential force F_x/(mu F)",
)
def stick_radius(
    effort: str,
    *,
    share: Annotated[float, Between(0, 1)] = 0.5,
    exponent: Annotated[float, Above(0)] = 2.0,
) -> Finding:
    """Compare half the length of sticking springs with the stick radius; f = r^n, F_x = share mu F.

    The reference is Cattaneo's and Mindlin's for n = 2, Jaeger's and Ciavarella's for every n.
    """
    exact = PartialSlip(
        power_law(exponent, 1.0, 1.0),
        penetration=_DEPTH,
        friction=_FRICTION,
        modulus_ratio=_MODULUS,
    )
    path = exact.along([share * exact.limit])
    profile = equivalents.power_law(exponent, 1.0)
    springs, finer = (
        slide(
            Springs(profile, 1.0, per_radius=count),
            Friction(_MODULUS, _FRICTION),
            Load("penetration", _DEPTH),
            LoadPath("tangential_force", path.tangential_force),
        ).stick_length[0]
        / 2
        for count in ((40, 80) if effort == "quick" else (80, 160))
    )
    true = float(path.stick_radius[0])
    details: dict[str, float | str] = {
        "displacement over that at which all slides": float(
            path.tangential_displacement[0] / exact.sliding_displacement
        ),
    }
    return Finding(float(finer), true, float(abs(finer - springs) / true) + EXACT, details)


def _way(final: float, reach: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Return depth and displacement: normal loading in one step, then proportional changes."""
    part = np.linspace(0.0, 1.0, steps + 1)
    limit = _FRICTION * _DEPTH / _MODULUS  # displacement of full sliding at the first depth
    return _DEPTH * (1 + (final - 1) * part), reach * limit * part


@shared(maxsize=64)
def _true(final: float, reach: float, cells: int, steps: int) -> tuple[float, float]:
    """Return the normal and tangential force on the half-space at the end of the path."""
    radius = float(np.sqrt(_DEPTH * max(final, 1.0)))
    spacing = float(np.sqrt(_DEPTH)) / cells
    count = 2 * int(np.ceil(1.1 * radius / spacing))
    x = (np.arange(count) - (count - 1) / 2) * spacing
    body = NormalAndTangential(
        (count, count), (spacing, spacing), Compliance.of(_SHEAR_MODULUS, _POISSON)
    )
    depth, shift = _way(final, reach, steps)
    gap = (x[:, None] ** 2 + x**2) / 2
    *_, last = sweep(
        FrictionalPress(body, gap, _FRICTION),
        reference_loads.LoadPath("penetration", depth),
        reference_loads.LoadPath("tangential_displacement", shift),
    )
    return last.force, last.tangential_force


@experiment(
    "changing-load",
    "Tangential force on a ball that is pushed while its depth changes, against the half-space",
    "final",
    "last penetration over the first",
)
def changing_load(
    effort: Effort,
    *,
    final: Annotated[float, Above(0)] = 0.5,
    reach: Annotated[float, Above(0)] = 0.5,
) -> Finding:
    """Measure the tangential force over mu F on a ball displaced at changing depth.

    The ball is pressed in, then displaced by `reach` times the displacement of full sliding, while
    the depth changes to `final` times its value. The difference is relative to mu F. Springs take
    the path in one proportional step, the half-space in steps that halve with the cells.
    """
    radius = 1.05 * float(np.sqrt(_DEPTH * max(final, 1.0)))
    x = np.linspace(-radius, radius, _SPRINGS)
    depth, shift = _way(final, reach, 1)
    springs = follow(x**2, x[1] - x[0], 1.0, Friction(_MODULUS, _FRICTION), depth, shift)
    stated = springs.tangential_force[-1] / (_FRICTION * springs.force[-1])
    coarse, fine = (_true(final, reach, *grid) for grid in _GRIDS[effort])
    shares = [tangential / (_FRICTION * normal) for normal, tangential in (coarse, fine)]
    details: dict[str, float | str] = {
        "share of the springs that stick": float(
            springs.stick_length[-1] / springs.contact_length[-1]
        ),
    }
    bar = SAFE * abs(shares[1] - shares[0])
    return Finding(float(stated), shares[1], bar + EXACT, details, of=1)
