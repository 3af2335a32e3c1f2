"""Contacts of rough surfaces: area, sizes, their ends, and what a power spectrum fixes."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy import stats

from comparisons.judging.uncertainty import combined, ratio_of_means
from comparisons.methods.normal.reduced import line_values
from comparisons.questions.experiments.experiment import (
    Count,
    Finding,
    Positive,
    Share,
    experiment,
    number_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    PeriodicSurface,
    Surface,
    compare,
    each_line,
    press,
    pressed_surfaces,
    surface_samples,
    truth,
)
from comparisons.solving.shared import shared
from comparisons.tasks.distributions import Stretches, histogram
from reduced.loads import Load
from reduced.rough import regions
from reduced.rough.press import press as press_line
from reference.halfspace import areas
from reference.surfaces import rms_gradient_spectral

_MIDDLE = 0.01  # the load through which the straight line goes


@experiment("straight-area", "load F/(E* A0 h')")
def straight_area(
    effort: str,
    *,
    load: Positive = 0.1,
    surface: Surface = Surface(shortest=4.0),
    realisations: Count = 60,
) -> Finding:
    """Contact area of rough surfaces against a straight line through zero.

    Compare the straight line through zero and A(0.01 E* A0 h') with A(F). Means over surfaces, at
    vanishing spacing; the same surfaces at both loads.
    """
    count = number_of(realisations, effort, 12)
    (there, bar), (middle, bar_of_middle) = (
        pressed_surfaces(surface, force, "contact_area", count, effort) for force in (load, _MIDDLE)
    )
    ratio, scatter = ratio_of_means(middle[:, None], there[:, None], paired=True)
    width = float(ratio[0]) * load / _MIDDLE * combined(float(scatter[0]), bar, bar_of_middle)
    details = {
        "A E* h'/F there": float(there.mean()) / load,
        "A E* h'/F in the middle": float(middle.mean()) / _MIDDLE,
    }
    stated = float(middle.mean()) * load / _MIDDLE
    return Finding(stated, float(there.mean()), float(width), details)


def _of_spots(sizes: np.ndarray, quantity: str) -> float:
    """Return the number of contacts, or their mean or largest area."""
    if quantity == "number":
        return float(len(sizes))
    return float(sizes.mean() if quantity == "mean_size" else sizes.max())


@shared(maxsize=128)
def _spots(surface: Surface, load: float, factor: int, count: int) -> tuple[np.ndarray, ...]:
    """Return the areas of the contacts of `count` surfaces, one array each."""
    operator = surface.operator(factor)
    masks = (press(operator, surface.heights(k, factor), load)[0].mask for k in range(count))
    return tuple(areas.patches(mask, operator.spacing, operator.periodic).areas for mask in masks)


@experiment("contact-sizes", "load F/(E* A0 h')")
def contact_sizes(
    effort: str,
    *,
    load: Positive = 0.01,
    quantity: Literal["number", "mean_size", "largest_size"] = "number",
    surface: Surface = Surface(shortest=4.0),
    realisations: Count = 60,
) -> Finding:
    """Number and sizes of the contacts of lines against those of surfaces.

    A region of length l has the area (pi/4) l^2 (19.29).
    """
    count = number_of(realisations, effort, 12)

    def sample(factor: int, number: int) -> np.ndarray:
        spots = _spots(surface, load, factor, number)
        return np.array([_of_spots(sizes, quantity) for sizes in spots])

    true, grid_bar = truth(sample, count, effort)
    stated = []
    for line, depth in each_line(surface, load, 4 * count, 8):
        lengths = regions.regions(line, depth).lengths
        stated.append(_of_spots(np.pi / 4 * lengths**2, quantity))
    return compare(stated, true, grid_bar, {})


@experiment("same-spectrum", "skewness of the heights, exp(s z)")
def same_spectrum(
    effort: str,
    *,
    skew: Positive = 0.3,
    load: Positive = 0.01,
    quantity: Literal["contact_area", "penetration", "stiffness"] = "contact_area",
    statement: Literal["skewness", "phases"] = "skewness",
    surface: Surface = Surface(roll_off=4.0, shortest=4.0, periodic=True),
    realisations: Count = 60,
) -> Finding | Share:
    """Differences between surfaces with the same power spectrum.

    Surfaces are defined by their points. ``"skewness"``: a surface of heights exp(skew z) against
    its negative, over the mean of both. ``"phases"``: standard deviation over surfaces of equal
    amplitudes and random phases, over the mean.
    """
    count = number_of(realisations, effort, 16)
    if statement == "phases":
        values = surface_samples(surface, load, 1, count, quantity == "stiffness")[quantity]
        spread = float(values.std(ddof=1) / values.mean())
        # the standard deviation of n normal values is known to 1/sqrt(2 n)
        bar = 2 * spread / np.sqrt(2 * count)
        return Share(spread, bar, {"mean": float(values.mean())}, "scatter")
    operator = surface.operator()
    samples = np.empty((2, count))
    for k in range(count):
        heights = surface.heights(k)
        bent = np.expm1(skew * heights / heights.std()) / skew
        # a surface and its negative have the same power spectrum; both of rms gradient one
        bent -= bent.mean()
        bent /= rms_gradient_spectral(bent, (1 / surface.points,) * 2)
        for sample, sign in zip(samples, (1.0, -1.0), strict=True):
            _, row = press(operator, sign * bent, load, quantity == "stiffness")
            sample[k] = row[quantity]
    ratio, scatter = ratio_of_means(samples[0][:, None], samples[1][:, None], paired=True)
    r = float(ratio[0])
    # the difference over the mean, (r - 1)/((r + 1)/2), changes with r as 4/(r + 1)^2
    bar = 4 * r / (r + 1) ** 2 * float(scatter[0])
    peaks, valleys = (float(sample.mean()) for sample in samples)
    return Finding(peaks, valleys, bar, {"peaks over valleys": r}, of=(peaks + valleys) / 2)


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


def _mean(values: Stretches) -> float:
    inside = (np.maximum(values.first, 0) + np.maximum(values.last, 0)) / 2
    positive = inside > 0
    return float(np.average(inside[positive], weights=values.weight[positive]))


@experiment("contact-ends", "load F/(E* A0 h')")
def contact_ends(
    effort: str,
    *,
    load: Positive = 0.02,
    quantity: Literal["pressure", "gap"] = "pressure",
    model: Literal["surface", "line"] = "surface",
    exponent: float = 1.0,
    surface: Surface = PeriodicSurface(32, shortest=16.0),
) -> Finding:
    """Exponents of the densities of pressure and gap near zero.

    Compare exponents of a density near zero: the difference, of one. Of a surface: the stated
    `exponent` against the one measured; of the line: its own against the `exponent` of a surface.

    Surfaces with 16 points to the shortest wave, on grids up to 16 times finer. The bar has the
    change from grids half as fine and with the place of the interval, and the scatter of surfaces.
    """
    if model == "line":
        start, ratio, _ = _WINDOWS[quantity]
        drawn = surface.lines(_LINES, 32).draw()
        depths = press_line(drawn, 1.0, Load("force", load)).penetration[:, 0].tolist()
        ofs = [
            line_values(drawn[row], 1.0, "sub_cell", depth, (1.0, 1.0))[f"{quantity}_distribution"]
            for row, depth in enumerate(depths)
        ]
        parts_of = ([getattr(of, part) for of in ofs] for part in ("first", "last", "weight"))
        values = Stretches(*map(np.concatenate, parts_of))
        some = [_exponent(values, share * start * _mean(values), ratio) for share in (1.0, 0.3)]
        parts = {"interval": abs(some[0] - some[1])}
    else:
        finest, number = _SURFACES[effort]
        here, moved, scatter = _on_grid(surface, load, quantity, finest, number)
        before = _on_grid(surface, load, quantity, finest // 2, number)[0]
        some = [here, before]
        parts = {"interval": moved, "grid": abs(here - before), "surfaces": scatter}
    bar = max(float(combined(*parts.values())), _LEAST_BAR)
    bars = {f"bar: {name}": part for name, part in parts.items()}
    stated, true = (exponent, some[0]) if model == "surface" else (some[0], exponent)
    details = {"exponent": some[0], "before": some[1]}
    return Finding(stated, true, bar, {**details, **bars}, of=1)
