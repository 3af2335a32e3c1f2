"""Partial slip of rough surfaces: springs with stick and slip compared with the half-space.

Ensembles of thousands of lines and a thousand surfaces at their original resolution are needed,
because displacements scatter by a quarter. The effect of finer grids is measured on some of the
surfaces, because ratios scatter a hundred times less.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.questions.experiments.experiment import Above, Effort, Finding, experiment
from comparisons.questions.experiments.rough_ensemble import Surface, compare, truth
from comparisons.solving.shared import shared
from reduced.friction.slide import Friction, slide_lines, tangential_modulus
from reduced.loads import Load, LoadPath
from reference import loads as reference_loads
from reference.halfspace.friction import FrictionalPress, sweep
from reference.halfspace.traction import Compliance, NormalAndTangential

# nu = 1/2: normal and tangential tractions are uncoupled, and the displacement is proportional to
# mu. E* = A0 = h' = 1.
_POISSON, _SHEAR_MODULUS, _FRICTION = 0.5, 0.25, 0.5
# Steps of the tangential force as fractions.
_PARTS = np.array([1 / 3, 2 / 3, 1.0])
_TOLERANCE = 1e-5
_COUNTS: dict[Effort, tuple[int, int]] = {"quick": (36, 300), "full": (1200, 4000)}


@shared(maxsize=256)
def _true(surface: Surface, load: float, share: float, realisation: int, factor: int) -> float:
    """Return the tangential displacement of a surface at F_x = share mu F."""
    points = surface.points * factor
    compliance = Compliance.of(_SHEAR_MODULUS, _POISSON)
    body = NormalAndTangential((points,) * 2, (1 / points,) * 2, compliance)
    heights = surface.heights(realisation, factor)
    press = FrictionalPress(body, heights.max() - heights, _FRICTION)
    path = reference_loads.LoadPath("tangential_force", share * _FRICTION * load * _PARTS)
    stays = reference_loads.LoadPath("force", load)
    *_, last = sweep(press, stays, path, tolerance=_TOLERANCE)
    return last.tangential_displacement


def _stated(surface: Surface, load: float, share: float, count: int) -> np.ndarray:
    """Return the tangential displacements of lines with the same spectrum."""
    friction = Friction(tangential_modulus(_SHEAR_MODULUS, _POISSON), _FRICTION)
    path = LoadPath("tangential_force", share * _FRICTION * load)
    answer = slide_lines(surface.lines(count, 4).draw(), 1.0, friction, Load("force", load), path)
    return answer.tangential_displacement[:, -1]


@experiment(
    "rough-slip",
    "Tangential displacement of lines on springs that slip, against rough surfaces",
    "share",
    "tangential force F_x/(mu F)",
)
def rough_slip(
    effort: Effort,
    *,
    share: Annotated[float, Above(0)] = 0.9,
    load: Annotated[float, Above(0)] = 0.02,
    points: float = 48,
) -> Finding:
    """Compare the mean displacements of lines and surfaces at F_x = share mu F.

    Surfaces with H = 0.8, waves of a half to an eighth of the side. Sources of the bar: the scatter
    of both ensembles, and the grid.
    """
    if not share < 1:
        raise ValueError(f"share must be below 1, where the contact slides, not {share!r}")
    surface = Surface.of(points, 0.8, 2.0, points / 8, False)
    surfaces, count = _COUNTS[effort]

    def sample(factor: int, number: int) -> np.ndarray:
        return np.array([_true(surface, load, share, k, factor) for k in range(number)])

    true, grid_bar = truth(sample, "refined", surfaces, effort)
    details: dict[str, float | str] = {
        "surfaces": float(surfaces),
        "lines": float(count),
        "bar: grid": grid_bar,
    }
    return compare(_stated(surface, load, share, count), true, grid_bar, details)
