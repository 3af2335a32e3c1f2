"""The penetration at which a half-space first yields below a round shape, by finite elements."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.fem.recovery import von_mises
from reference.plastic.indentation import Indentation
from reference.plastic.materials import PlasticMaterial

Array = NDArray[np.float64]

_ROUNDS, _TOLERANCE = 30, 1e-4


def first_yield(
    material: PlasticMaterial,
    shape: Callable[[Array], Array],
    contact_radius: Callable[[float], float],
    start: float,
    *,
    per_radius: int = 8,
) -> float:
    """Return the penetration at which von Mises' stress first reaches the yield stress.

    Parameters
    ----------
    material : PlasticMaterial
    shape : callable
        f(r), the gap at first touch.
    contact_radius : callable
        Of the elastic contact at a penetration; the mesh is made for it.
    start : float
        A penetration from which the search starts.
    per_radius : int
        Elements per contact radius.

    Raises
    ------
    ConvergenceError
        If the stress hardly rises with the penetration, as below a cone.
    """
    modulus = material.elastic.youngs_modulus
    elastic = PlasticMaterial(material.scaled(modulus).elastic, np.inf)

    def excess(depth: float) -> float:
        length = contact_radius(depth)
        body = Indentation(elastic, lambda r: shape(r * length) / length, per_radius=per_radius)
        state = body.press(body.virgin, depth / length)
        return float(np.log(von_mises(state.stress).max() * modulus / material.yield_stress))

    here, value, slope = float(np.log(start)), excess(start), 0.5
    for _ in range(_ROUNDS):
        if abs(value) <= _TOLERANCE:
            return float(np.exp(here - value / slope))
        step = float(np.clip(-value / slope, -5.0, 5.0))
        before, value = value, excess(float(np.exp(here + step)))
        here, slope = here + step, (value - before) / step
        if not slope > 0.02:
            raise ConvergenceError("the stress does not rise with the penetration: a sharp tip")
    raise ConvergenceError("the penetration of first yield was not found")
