"""Best of many readings of Fig. 19.8: spectrum and line length for which the areas coincide.

A search over readings selects the one most favourable to the statement. Therefore all readings are
tried on some surfaces, and the best one is judged on others.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import product

import numpy as np

from comparisons.questions.experiments.base import Effort
from comparisons.questions.experiments.rough_area import measure_area
from comparisons.questions.experiments.rough_ensemble import Drawing, Surface, line_samples, press
from comparisons.questions.experiments.running import Finding, above, experiment, one_of

HURSTS = (0.1, 0.3, 0.5, 0.8, 1.0)
ROLL_OFFS = (1.0, 2.0, 4.0, 8.0)
LINE_LENGTHS = (0.125, 0.25, 0.5, 1.0)
LOADS = (0.001, 0.003, 0.01, 0.03, 0.1)
Reading = tuple[float, float, float]
READINGS: tuple[Reading, ...] = tuple(product(HURSTS, ROLL_OFFS, LINE_LENGTHS))
# Surfaces and lines of the search; the surfaces differ from those of the judgement.
_FIRST = 200_000
_COUNTS: dict[Effort, tuple[int, int]] = {"quick": (8, 150), "full": (24, 450)}


@lru_cache(maxsize=4)
def scan(points: int = 64, effort: Effort = "full") -> dict[Reading, np.ndarray]:
    """Return counted area of the line over that of the surface, less one, at `LOADS`, by reading.

    Means over 24 surfaces and 450 lines, at quick effort 8 and 150: enough to rank readings, not
    to judge one.
    """
    surfaces, count = _COUNTS[effort]
    errors = {}
    for hurst, roll_off in product(HURSTS, ROLL_OFFS):
        surface = Surface.of(points, hurst, roll_off, 2.0, False)
        operator = surface.operator()
        maps = [surface.heights(_FIRST + k) for k in range(surfaces)]
        true = [
            np.mean([press(operator, heights, load)[1]["contact_area_raw"] for heights in maps])
            for load in LOADS
        ]
        for length in LINE_LENGTHS:
            drawing = Drawing(length=length)
            lines = [line_samples(surface, load, count, drawing) for load in LOADS]
            stated = [lines_pressed["contact_area_raw"].mean() for lines_pressed in lines]
            errors[hurst, roll_off, length] = np.array(stated) / np.array(true) - 1
    return errors


def best_reading(points: int = 64, by: str = "largest", effort: Effort = "full") -> Reading:
    """Return the reading whose error over `LOADS`, as a factor, is the smallest.

    By the largest error over the loads, if curves should coincide everywhere, or by the median one,
    if they should coincide over a part of the loads.
    """
    middle = one_of("by", by, "largest", "median") == "median"
    size: Callable[[np.ndarray], np.floating] = np.median if middle else np.max
    tried = scan(points, effort)
    return min(tried, key=lambda reading: float(size(np.abs(np.log1p(tried[reading])))))


def _best(
    effort: Effort,
    *,
    load: float = 0.01,
    points: float = 64,
    realisations: float = 450,
    by: str = "largest",
) -> Finding:
    """Compare the counted areas under the best of all readings, on fresh surfaces."""
    above("points", points, 3)
    hurst, roll_off, length = best_reading(int(points), by, effort)
    finding = measure_area(
        effort,
        load=load,
        quantity="contact_area_raw",
        grid="native",
        points=points,
        hurst=hurst,
        roll_off=roll_off,
        line_length=length,
        realisations=realisations,
    )
    chosen = {"readings tried": float(len(READINGS)), "H": hurst, "line length L1/L": length}
    return finding._replace(details={**finding.details, **chosen})


EXPERIMENTS = (
    experiment(
        "best-reading",
        f"Contact area of line and surface under the best of {len(READINGS)} readings of Fig. 19.8",
        "load F/(E* A0 h')",
        "load",
        _best,
    ),
)
