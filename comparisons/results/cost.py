"""What the stated error of a setting costs: the one place that tables, plots and advice read.

The error of a mean over random surfaces belongs to the time of all solves that the mean stands on;
the time of one surface, or line, belongs to the errors of single ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from comparisons.facts.methods import GRID, METHODS, title_of
from comparisons.formatting import count
from comparisons.results import selection
from comparisons.results.store import SceneRecord, once


@dataclass(frozen=True)
class Cost:
    """The cost of one setting; NaN where it is not known.

    Attributes
    ----------
    seconds, setup_seconds : float
        Of all solves that the stated error stands on, and of their set-up.
    single_seconds : float
        Seconds of one surface or line.
    surfaces : int
        Surfaces or lines solved at this resolution; 1 where the scene is one surface.
    solves : str
        Those of an ensemble, coarse to fine: "375 + 24 surfaces", or "".
    """

    seconds: float
    setup_seconds: float
    single_seconds: float
    surfaces: int
    solves: str

    @property
    def spent(self) -> float:
        """Seconds of the solves at this resolution alone."""
        return self.single_seconds * self.surfaces


@once
def cost(record: SceneRecord, method: str, resolution: float) -> Cost:
    """Return the cost of a setting, from the rows of results.csv."""
    first = partial(_first, record, method, resolution)
    surfaces, solves = int(first("surfaces", 1.0)), ""
    if surfaces > 1:  # in words what a mean stands on (`comparisons.judging.levels.Levels`)
        row = METHODS.get(method)
        levels = [n for n in selection.run_at(record, method) if n <= resolution]
        beside = ""
        three = row is None or row.dimension == 3
        if three and method != GRID and selection.run_at(record, GRID):
            levels, beside = [resolution], f" beside those of {title_of(GRID)}"
        numbers = [count(_first(record, method, n, "surfaces", 1.0)) for n in levels]
        noun = "lines" if row is not None and row.dimension == 1 else "surfaces"
        solves = f"{' + '.join(numbers)} {noun}{beside}"
    return Cost(
        seconds=first("seconds_all"),
        setup_seconds=first("setup_seconds_all"),
        single_seconds=first("seconds"),
        surfaces=surfaces,
        solves=solves,
    )


def spent(record: SceneRecord) -> float:
    """Return the seconds of all solves of a scene, each counted once."""
    settings = [(m, n) for m in selection.methods(record) for n in selection.run_at(record, m)]
    return float(np.nansum([cost(record, *setting).spent for setting in settings]))


def _first(
    record: SceneRecord, method: str, resolution: float, name: str, missing: float = np.nan
) -> float:
    """Return the first number in a column of a setting, whose rows share it."""
    values = selection.setting_rows(record, method, resolution)[name]
    return float(next((value for value in values if np.isfinite(value)), missing))
