"""A surface with a lay: parallel ridges, unlike the isotropic roughness assumed for lines."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.questions.experiments.experiment import Above, Finding, OneOf, experiment
from reduced.loads import Load
from reduced.rough.ensemble import RandomLines
from reduced.rough.line_spectrum import line_of
from reduced.rough.press import press
from reduced.rough.surface_spectrum import measured
from reference.closed_form import Westergaard

QUANTITIES = ("contact_area", "mean_gap")
_MAP, _LINE = 16, 256  # points per ridge: of the map, and of the line on its coarser grid


@experiment(
    "ridges",
    "Line of a surface of parallel ridges against Westergaard's contact of a wavy surface",
    "load",
    "mean pressure over that of full contact",
)
def _ridges(
    effort: str,
    *,
    load: Annotated[float, Above(0)] = 0.1,
    ridges: Annotated[float, Above(0.5)] = 8,
    quantity: Annotated[str, OneOf(*QUANTITIES)] = "contact_area",
) -> Finding:
    """Measure the error of a line made from a map of `ridges` waves against Westergaard's solution.

    `load`: mean pressure over that of full contact. All lines of one wave are equal, so there is no
    scatter; the bar is the change for twice as many points.
    """
    count = int(ridges)
    if not load < 1:
        raise ValueError(f"load must be below 1, where all is in contact, not {load!r}")
    wave = Westergaard(1.0 / count, 1.0 / count, 1.0)  # A0 = E* = 1
    pressure = load * wave.full_contact_pressure
    true = {
        "contact_area": wave.contact_fraction(pressure),
        "mean_gap": wave.mean_gap(pressure),
    }[quantity]
    points = _MAP * count
    height = np.cos(2 * np.pi * np.arange(points) / _MAP)[:, None] / count * np.ones(4)
    spectrum = line_of(measured(height, (1.0, 4 / points), periodic=True))
    contacts = (  # under the force of the map
        press(RandomLines(spectrum, per_ridge * count, 1).draw(), 1.0, Load("force", pressure))
        for per_ridge in (_LINE, 2 * _LINE)
    )
    coarse, fine = (float(getattr(contact, quantity).item()) for contact in contacts)
    return Finding(fine, float(true), abs(fine - coarse) / float(true) + 1e-12, {})
