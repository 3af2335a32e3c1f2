"""Section 19.7 as a whole: the contact from the map of a surface, checked on the same surface."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated

import numpy as np

from comparisons.judging.uncertainty import combined, ratio_of_means
from comparisons.questions.experiments.experiment import (
    Above,
    Effort,
    Finding,
    OneOf,
    Share,
    experiment,
)
from comparisons.questions.experiments.rough_ensemble import Surface, surface_samples, truth
from reduced.rough.ensemble import Sampling
from reduced.rough.procedure import Procedure, side_by_side
from reduced.rough.surface_spectrum import measured

VARIANTS = ("literal", "corrected")
QUANTITIES = ("contact_area", "stress", "undefined")
# Maps, with lines of their spectra: the scatter of lines is averaged before that of maps.
_COUNTS: dict[Effort, tuple[int, int]] = {"quick": (12, 20), "full": (60, 60)}


@lru_cache(maxsize=512)
def _calculated(surface: Surface, load: float, map_number: int, lines: int) -> dict[str, Procedure]:
    """Return the procedure's results for a map, as printed and as corrected; E* = A0 = h' = 1."""
    spectrum = measured(surface.heights(map_number), 1.0, surface.periodic)
    procedures = side_by_side(spectrum, 1.0, load, Sampling(lines, seed=map_number))
    return dict(zip(VARIANTS, procedures, strict=True))


@experiment(
    "procedure",
    "Section 19.7 on maps of rough surfaces, against the contact of the same surfaces",
    "load",
    "load F/(E* A0 h')",
)
def _procedure(
    effort: Effort,
    *,
    load: Annotated[float, Above(0)] = 0.01,
    variant: Annotated[str, OneOf(*VARIANTS)] = "literal",
    quantity: Annotated[str, OneOf(*QUANTITIES)] = "contact_area",
    hurst: float = 0.8,
    roll_off: float = 2.0,
    shortest: float = 4.0,
    points: float = 64,
    periodic: bool = False,
) -> Finding | Share:
    """Compare the procedure with the half-space solution, as means over maps.

    ``"contact_area"``: (19.29) over the area; ``"stress"``: mean of (19.37) where it is defined,
    over the mean pressure of the true contact; ``"undefined"``: fraction of the contact where it is
    undefined. Sources of the bar: the scatter of the maps, and the grid.
    """
    surface = Surface.of(points, hurst, roll_off, shortest, periodic)
    maps, lines = _COUNTS[effort]
    procedures = [_calculated(surface, float(load), k, lines)[variant] for k in range(maps)]
    ratios = np.mean([procedure.sums.ratio for procedure in procedures], axis=0)
    missing = np.array([procedure.undefined_share[0] for procedure in procedures])
    details: dict[str, float | str] = {
        **{
            f"{name} of the lines over the maps'": float(ratio)
            for name, ratio in zip(("rms height", "rms slope", "curvature"), ratios, strict=True)
        },
        "share of the contact without a stress": float(missing.mean()),
    }
    if quantity == "undefined":
        scatter = 2 * float(missing.std(ddof=1)) / np.sqrt(maps)
        return Share(float(missing.mean()), scatter, details)

    def sample(factor: int, number: int) -> np.ndarray:
        return surface_samples(surface, float(load), factor, number)["contact_area"]

    areas, grid_bar = truth(sample, "refined", maps, effort)
    if quantity == "contact_area":
        stated, true = (
            np.array([procedure.ensemble["contact_area"].mean[0] for procedure in procedures]),
            areas,
        )
    else:
        stated, true = (
            np.array([procedure.pressures[0].mean() for procedure in procedures]),
            load / areas,
        )
    ratio, bar = ratio_of_means(stated[:, None], true[:, None], paired=True)
    uncertainty = float(ratio[0] * combined(float(bar[0]), grid_bar))
    return Finding(float(stated.mean()), float(true.mean()), uncertainty, details)
