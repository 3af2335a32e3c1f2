"""Fig. 19.8 and the chapter's conclusions: load curves of rough surfaces and lines."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from comparisons.questions.experiments.experiment import (
    Above,
    Finding,
    OneOf,
    experiment,
    number_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    QUANTITIES,
    Drawing,
    Surface,
    compare,
    line_samples,
    surface_samples,
    truth,
)
from reference.closed_form.rough_theories import bush_gibson_thomas_area

# Lines per surface and smallest number of lines; lines are cheap, so surfaces should limit the bar.
_LINES_PER_SURFACE, _LEAST_LINES = 4, 450


@experiment(
    "rough-contact",
    "Load curves of random rough lines against those of the surfaces",
    "load",
    "load F/(E* A0 h')",
)
def measure_area(  # noqa: PLR0913 (the parameters in a claim's file)
    effort: str,
    *,
    load: Annotated[float, Above(0)] = 0.01,
    quantity: Annotated[str, OneOf(*QUANTITIES)] = "contact_area",
    grid: Literal["native", "refined"] = "refined",
    statement: Literal["line", "bush"] = "line",
    points: float = 64,
    hurst: float = 0.8,
    roll_off: float = 1.0,
    shortest: float = 2.0,
    periodic: bool = False,
    rule: str = "rings",
    edges: str = "sub_cell",
    line_length: Annotated[float, Above(0)] = 1.0,
    line_points: float = 0,
    sided: float = 2,
    realisations: Annotated[float, Above(2)] = 450,
) -> Finding:
    """Compare the mean of lines with the mean of surfaces at equal F/(E* A0 h').

    Or what Bush, Gibson and Thomas say of light loads.
    """
    if statement != "line" and not quantity.startswith("contact_area"):
        raise ValueError(f"{statement} speaks of contact_area, not of {quantity}")
    surface = Surface.of(points, hurst, roll_off, shortest, periodic)
    count = number_of(realisations, effort, 20)
    stiffness = quantity == "stiffness"

    def sample(factor: int, number: int) -> np.ndarray:
        return surface_samples(surface, float(load), factor, number, stiffness)[quantity]

    true, grid_bar = truth(sample, grid, count, effort)
    if statement == "line":
        drawing = Drawing(rule, edges, float(line_length), int(line_points), int(sided))
        number = max(_LINES_PER_SURFACE * count, _LEAST_LINES)
        stated = line_samples(surface, float(load), number, drawing)[quantity]
    else:
        stated = np.atleast_1d(bush_gibson_thomas_area(load))
    share = surface_samples(surface, float(load), 1, count, stiffness)
    details: dict[str, float | str] = {
        "bar of the grid": grid_bar,
        "realisations": float(count),
        "counted area share": float(share["contact_area_raw"].mean()),
        "L/lambda_l": surface.roll_off,
        "lambda_l/lambda_s": surface.points / surface.shortest / surface.roll_off,
        "half-space": "periodic" if surface.periodic else "free patch",
    }
    return compare(stated, true, grid_bar, details)
