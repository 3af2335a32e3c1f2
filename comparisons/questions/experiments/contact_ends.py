"""How the densities of pressure and gap start at zero, on surfaces and on lines."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from scipy import stats

from comparisons.judging.uncertainty import combined
from comparisons.methods.normal.line_distributions import Springs, line_values
from comparisons.questions.experiments.experiment import Above, Finding, experiment
from comparisons.questions.experiments.rough_ensemble import SEED, Surface, press
from comparisons.solving.shared import shared
from comparisons.tasks.distributions import Stretches, histogram
from reduced.loads import Load
from reduced.rough import ensemble
from reduced.rough.press import press as press_line

_LINES, _LEAST_BAR = 60, 0.05
# How many times finer than the surface's points the grid is, and how many surfaces there are.
_SURFACES = {"quick": (8, 12), "full": (16, 24)}
# Lower end over the mean on a grid 32 times finer than the surface's points, and the width of each
# of two neighbouring intervals. Cells that the rim cuts carry what a surface has within a cell of
# it, p ~ h^(1/2) and gap ~ h^(3/2): the interval moves with the grid.
_WINDOWS = {"pressure": (0.08, 2.0, 0.5), "gap": (2e-4, 3.0, 1.5)}
_FINEST = 32


def _exponent(values: Stretches, start: float, ratio: float) -> float:
    """Return the exponent of a density between two neighbouring intervals [s, rs], [rs, r^2 s]."""
    bins = start * ratio ** np.arange(-1.0, 4.0)
    density = histogram(bins, values)[1:3] / np.diff(bins)[1:3]
    return float(np.log(density[1] / density[0]) / np.log(ratio))


@shared(maxsize=32)
def _of_surfaces(
    surface: Surface, load: float, factor: int, number: int
) -> dict[str, list[np.ndarray]]:
    """Return pressures in contact and gaps outside, an array for every surface."""
    operator = surface.operator(factor)
    contacts = [press(operator, surface.heights(k, factor), load)[0] for k in range(number)]
    return {
        "pressure": [c.pressure[c.mask] for c in contacts],
        "gap": [np.maximum(c.gap[~c.mask], np.finfo(float).tiny) for c in contacts],
    }


def _on_grid(
    surface: Surface, load: float, quantity: str, factor: int, number: int
) -> tuple[float, float, float]:
    """Return the exponent on a grid, its change with the interval, and its scatter (95 %).

    An exponent is one where it does not hang on the place of the interval: that is moved by a
    factor sqrt 2 to either side. The scatter is that of the surfaces, by leaving one out.
    """
    values = _of_surfaces(surface, load, factor, number)[quantity]
    start, ratio, power = _WINDOWS[quantity]
    place = start * (_FINEST / factor) ** power

    def exponent(arrays: list[np.ndarray], moved: float = 1.0) -> float:
        pooled = Stretches.points(np.concatenate(arrays))
        return _exponent(pooled, moved * place * _mean(pooled), ratio)

    here = exponent(values)
    moved = max(abs(exponent(values, step) - here) for step in (np.sqrt(2), np.sqrt(0.5)))
    left = [exponent(values[:k] + values[k + 1 :]) for k in range(number)]
    deviation = np.sqrt((number - 1) * np.var(left))
    return here, moved, float(stats.t.ppf(0.975, number - 1) * deviation)


def _of_lines(surface: Surface, load: float) -> dict[str, Stretches]:
    lines = ensemble.RandomLines(surface.line("rings"), 32 * surface.points, _LINES, seed=SEED)
    drawn = lines.draw()
    depths = press_line(drawn, 1.0, Load("force", load)).penetration[:, 0]
    several = [
        line_values(drawn[row], Springs(1.0, "sub_cell"), float(depth), (1.0, 1.0))
        for row, depth in enumerate(depths)
    ]
    return {
        name: Stretches(*(np.concatenate(part) for part in zip(*parts, strict=True)))
        for name, parts in {
            kind: [
                (v[f"{kind}_distribution"].first, v[f"{kind}_distribution"].last, w)
                for v in several
                for w in [v[f"{kind}_distribution"].weight]
            ]
            for kind in ("pressure", "gap")
        }.items()
    }


def _mean(values: Stretches) -> float:
    inside = (np.maximum(values.first, 0) + np.maximum(values.last, 0)) / 2
    positive = inside > 0
    return float(np.average(inside[positive], weights=values.weight[positive]))


@experiment(
    "contact-ends",
    "Exponents of the densities of pressure and gap near zero",
    "load",
    "load F/(E* A0 h')",
)
def contact_ends(
    effort: str,
    *,
    load: Annotated[float, Above(0)] = 0.02,
    quantity: Literal["pressure", "gap"] = "pressure",
    model: Literal["surface", "line"] = "surface",
    exponent: float = 1.0,
    hurst: float = 0.8,
) -> Finding:
    """Compare the exponent of a density near zero with the stated one, relative to one.

    Surfaces with 16 points to the shortest wave, on grids up to 16 times finer. The bar has the
    change from grids half as fine and with the place of the interval, and the scatter of surfaces.
    """
    surface = Surface.of(32, hurst, 1.0, 16.0, periodic=True)
    if model == "line":
        start, ratio, _ = _WINDOWS[quantity]
        values = _of_lines(surface, float(load))[quantity]
        some = [_exponent(values, share * start * _mean(values), ratio) for share in (1.0, 0.3)]
        parts = {"interval": abs(some[0] - some[1])}
    else:
        finest, number = _SURFACES[effort]
        here, moved, scatter = _on_grid(surface, float(load), quantity, finest, number)
        before = _on_grid(surface, float(load), quantity, finest // 2, number)[0]
        some = [here, before]
        parts = {"interval": moved, "grid": abs(here - before), "surfaces": scatter}
    bar = max(float(combined(*parts.values())), _LEAST_BAR)
    bars = {f"bar: {name}": part for name, part in parts.items()}
    return Finding(some[0], exponent, bar, {"exponent": some[0], "before": some[1], **bars}, of=1)
