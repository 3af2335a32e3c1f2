"""Finite elements as a truth of rough contacts: the waves that they know."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.questions.experiments.experiment import Above, Finding, experiment, worst
from reference.fem import Material
from reference.fem.column_elements import Element
from reference.fem.columns import Layers, of_smooth_pressure

# Growth of the elements with depth, whose floor is 1e-7, and depth of the body in waves.
GROWTH, DEPTH, FLOOR = 1.08, 4.0, 2e-7


@experiment(
    "element-waves",
    "Work of a wave of pressure on a half-space of finite elements, against the exact one",
    "wavelength",
    "wavelength in elements",
)
def element_waves(
    effort: str,
    *,
    wavelength: Annotated[float, Above(1.999)] = 8.0,
    element: Element = "quadratic",
    poisson_ratio: float = 0.3,
) -> Finding:
    """Compare the work of a wave of pressure, `wavelength` in elements, with the half-space's.

    Along the elements and across their diagonal; the larger error counts. The bar is the floor
    below all waves, from elements that grow with depth.
    """
    angles = np.array([0.0, np.pi / 4])
    q = 2 * np.pi / wavelength
    body = Layers([DEPTH * wavelength], [Material(1.0, poisson_ratio)])
    phases = q * np.cos(angles), q * np.sin(angles)
    work = of_smooth_pressure(phases, (1.0, 1.0), body, element=element, growth=GROWTH)
    stated = work * q / (2 * (1 - poisson_ratio**2))
    details: dict[str, float | str] = {
        "along": float(stated[0]) - 1,
        "diagonal": float(stated[1]) - 1,
    }
    return Finding(*worst(stated, np.ones(2)), FLOOR, details)
