"""Rough lines of surfaces (19.26)-(19.28), of one with a lay, and section 19.7 as a whole.

Heights, slopes, curvatures and peaks of the line relative to the surface; parallel ridges, unlike
the isotropic roughness assumed for lines; the contact from the map of a surface, checked on it.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from scipy import fft, stats

from comparisons.judging.uncertainty import SAFE, combined, ratio_of_means
from comparisons.questions.experiments.experiment import (
    Count,
    Effort,
    Finding,
    Fraction,
    Positive,
    Share,
    experiment,
    number_of,
    one_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    SEED,
    Surface,
    compare,
    pressed_surfaces,
)
from comparisons.solving.shared import shared
from reduced.loads import Load
from reduced.rough import surface_spectrum
from reduced.rough.ensemble import RandomLines
from reduced.rough.line_spectrum import line_of
from reduced.rough.press import press
from reduced.rough.procedure import Procedure, side_by_side
from reduced.rough.surface_spectrum import measured
from reference.closed_form import Westergaard
from reference.closed_form.rough_theories import line_peaks, surface_peaks
from reference.surfaces import hessian, summits

MOMENTS = (
    "mean_square_height",
    "slope",
    "section_slope",
    "curvature_laplacian",
    "curvature_product",
)


@experiment("line-moments", "points per side", along="points")
def line_moments(
    effort: str,
    *,
    surface: Surface = Surface(periodic=True),
    quantity: Annotated[str, one_of(*MOMENTS)] = "mean_square_height",
    rule: str = "printed",
) -> Finding:
    """Mean square heights, rms slopes and curvatures of line and surface.

    Compare moments of line and surface, (19.27) = (19.28) and footnote 7; slopes as their rms.
    ``"slope"`` is that of the full gradient, ``"section_slope"`` that of a measured profile;
    ``"curvature_product"`` is footnote 7, kappa^2 = kappa1 kappa2, ``"curvature_laplacian"`` what
    is actually conserved. Amplitudes are fixed, so there is no scatter: the bar is the rounding of
    sums of `points`^2 terms. The surface's product is measured from the Hessian of a realisation.
    """
    line = surface.line(rule)
    spectrum = surface_spectrum.self_affine(
        surface.points, 1.0, surface_spectrum.SelfAffineLaw(**surface.recipe)
    )
    stated = {"mean_square_height": line.rms_height**2, "curvature_laplacian": line.rms_curvature}
    true = {
        "mean_square_height": spectrum.rms_height**2,
        "slope": spectrum.rms_slope,
        "section_slope": spectrum.rms_slope / np.sqrt(2),
        "curvature_laplacian": spectrum.rms_curvature,
    }
    rounding = np.finfo(float).eps * surface.points**2
    if quantity == "curvature_product":
        hxx, hyy, hxy = hessian(surface.heights(0), (1 / surface.points,) * 2)
        product = float(np.mean(hxx * hyy - hxy**2))
        # the footnote's value of <h''^2> of the line is this product
        return Finding(product, line.rms_curvature**2, rounding, {})
    details = {"modes": float(np.count_nonzero(line.power))}
    return Finding(stated.get(quantity, line.rms_slope), true[quantity], rounding, details)


# Heights at which distribution functions are compared, in units of the rms height.
_LEVELS = np.linspace(-6, 6, 1201)


def _distance(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.abs(first.mean(axis=0) - second.mean(axis=0)).max())


@experiment("line-heights", "Hurst exponent H", along="hurst")
def line_heights(
    effort: str, *, surface: Surface = Surface(periodic=True), realisations: Count = 450
) -> Share:
    """Distance of the height distributions of lines and surfaces.

    The statistic of Kolmogorov and Smirnov. The bar is the 95 % quantile of the same distance
    between random halves of either ensemble, halves of whole realisations because the points of one
    are correlated.
    """
    count = number_of(realisations, effort, 40)
    maps = np.stack([surface.heights(k).ravel() for k in range(count)])
    # as many lines as give the number of points of the surfaces
    lines = surface.lines(20 * count, 2).draw().heights
    maps, lines = maps / maps.std(), lines / maps.std()
    shares = []  # of the heights below the levels, by row, (rows, levels)
    for heights in (maps, lines):
        place = np.searchsorted(_LEVELS, heights)
        counts = [np.bincount(row, minlength=_LEVELS.size + 1)[:-1] for row in place]
        shares.append(np.cumsum(counts, axis=1) / heights.shape[1])
    rng = np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(2,)))
    noise = []
    for _ in range(40):
        halves = [np.array_split(share[rng.permutation(len(share))], 2) for share in shares]
        # halves have twice the variance, so their distance is twice that of the complete ensembles
        of_maps, of_lines = (_distance(first, second) for first, second in halves)
        noise.append(0.5 * float(np.hypot(of_maps, of_lines)))
    details = {
        "excess kurtosis of surfaces": float(stats.kurtosis(maps.ravel())),
        "excess kurtosis of lines": float(stats.kurtosis(lines.ravel())),
        "peak of surfaces over rms": float(maps.max(axis=1).mean()),
        "peak of lines over rms": float(lines.max(axis=1).mean()),
    }
    return Share(_distance(*shares), float(np.quantile(noise, 0.95)), details, "distance")


def _pooled(sums: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return samples, one per realisation, of the mean over the peaks of all realisations.

    Their mean is sum/number; their scatter is that of this ratio, to first order.
    """
    if not numbers.sum():
        raise ValueError("no peak is so high")
    mean = sums.sum() / numbers.sum()
    samples: np.ndarray = mean + (sums - mean * numbers) / numbers.mean()
    return samples


@shared(maxsize=32)
def _surface_peaks(
    surface: Surface, count: int, factor: int, height: float
) -> dict[str, np.ndarray]:
    """Return means over the summits of `count` realisations, on a grid `factor` times finer."""
    step = 1 / (surface.points * factor)
    rows = []
    for k in range(count):
        heights = surface.heights(k, factor)
        peaks = summits(heights, (step, step))
        high = heights[tuple(peaks.places.T)] > height * heights.std()
        curvatures = peaks.curvatures[high]
        radii = 1 / np.sqrt(curvatures.prod(axis=1))
        rows.append((radii.sum(), curvatures.mean(axis=1).sum(), high.sum()))
    radius, curvature, number = np.array(rows).T
    return {
        "mean_radius": _pooled(radius, number),
        "mean_curvature": _pooled(curvature, number),
        "number": number,
    }


@shared(maxsize=32)
def _line_peaks(surface: Surface, count: int, factor: int, height: float) -> dict[str, np.ndarray]:
    """Return means over the maxima of `count` lines, `factor` times finer than necessary."""
    lines = surface.lines(count, 2 * factor).draw().heights
    points = lines.shape[1]
    wavenumber = 2 * np.pi * points * fft.rfftfreq(points)
    second = fft.irfft(fft.rfft(lines, axis=1) * wavenumber**2, n=points, axis=1)
    top = (lines > np.roll(lines, 1, axis=1)) & (lines > np.roll(lines, -1, axis=1)) & (second > 0)
    top &= lines > height * lines.std()
    number = top.sum(axis=1)
    curvature = np.where(top, second, 0.0).sum(axis=1)
    radius = np.where(top, 1 / np.where(top, second, 1.0), 0.0).sum(axis=1)
    return {
        "mean_radius": _pooled(radius, number),
        "mean_curvature": _pooled(curvature, number),
        "number": number,
    }


@experiment("line-peaks", "Hurst exponent H", along="hurst")
def peaks(
    effort: str,
    *,
    surface: Surface = Surface(shortest=4.0, periodic=True),
    quantity: Literal["mean_radius", "mean_curvature"] = "mean_radius",
    ratio: Positive = 0.5,
    height: float = -math.inf,
) -> Finding:
    """Mean peak radius of lines against a fraction of that of surfaces.

    `ratio` is the fraction ("half"). Peaks that are higher than `height` rms heights count, all by
    default. Surface: the Gaussian radius 1/sqrt(kappa1 kappa2) of every summit, or the mean of
    (kappa1 + kappa2)/2; line: 1/|h''| of every maximum, or the mean of |h''|, which `ratio` then
    divides. Bars: scatter of both, and the change on a grid twice as fine, at second order.
    """
    count = 120 if effort == "full" else 12
    of_surface = {n: _surface_peaks(surface, count, n, height) for n in (4, 8)}
    of_line = {n: _line_peaks(surface, 20 * count, n, height) for n in (4, 8)}
    line, true = of_line[8][quantity], of_surface[8][quantity]
    line_value = line / ratio if quantity == "mean_radius" else line * ratio
    coarse = of_line[4][quantity].mean() / of_surface[4][quantity].mean()
    change = abs(coarse / (line.mean() / true.mean()) - 1)
    gauss = line_peaks(1.0, 8 / 3), surface_peaks(0.5, 1.0)
    details = {
        "line over surface": float(line.mean() / true.mean()),
        "line over surface, Gaussian": getattr(gauss[0], quantity) / getattr(gauss[1], quantity),
        "summits per surface": float(of_surface[8]["number"].mean()),
        "maxima per line": float(of_line[8]["number"].mean()),
    }
    return compare(line_value, true, float(combined(SAFE * change / 3)), details)


# Points per ridge: of the map, and of the line on its coarser grid.
_RIDGES, _MAP, _LINE = 8, 16, 256


@experiment("ridges", "mean pressure over that of full contact")
def across_ridges(
    effort: str,
    *,
    load: Fraction = 0.1,
    quantity: Literal["contact_area", "mean_gap"] = "contact_area",
) -> Finding:
    """Line of a surface of parallel ridges against Westergaard's contact of a wavy surface.

    The line is made from a map of eight waves. `load`: mean pressure over that of full contact.
    All lines of one wave are equal, so there is no scatter; the bar is the change for twice as many
    points.
    """
    wave = Westergaard(1 / _RIDGES, 1 / _RIDGES, 1.0)  # A0 = E* = 1
    pressure = load * wave.full_contact_pressure
    read = {"contact_area": wave.contact_fraction, "mean_gap": wave.mean_gap}[quantity]
    true = float(read(pressure))
    points = _MAP * _RIDGES
    height = np.cos(2 * np.pi * np.arange(points) / _MAP)[:, None] / _RIDGES * np.ones(4)
    spectrum = line_of(measured(height, (1.0, 4 / points), periodic=True))
    contacts = (  # under the force of the map
        press(RandomLines(spectrum, per_ridge * _RIDGES, 1).draw(), 1.0, Load("force", pressure))
        for per_ridge in (_LINE, 2 * _LINE)
    )
    coarse, fine = (float(getattr(contact, quantity).item()) for contact in contacts)
    return Finding(fine, true, abs(fine - coarse) / true + 1e-12, {})


# Maps, with lines of their spectra: the scatter of lines is averaged before that of maps.
_COUNTS: dict[Effort, tuple[int, int]] = {"quick": (12, 20), "full": (300, 60)}


@lru_cache(maxsize=512)
def _calculated(surface: Surface, load: float, map_number: int, lines: int) -> dict[str, Procedure]:
    """Return the procedure's results for a map, as printed and as corrected; E* = A0 = h' = 1."""
    spectrum = measured(surface.heights(map_number), 1.0, surface.periodic)
    procedures = side_by_side(spectrum, 1.0, load, realisations=lines, seed=map_number)
    return dict(zip(("literal", "corrected"), procedures, strict=True))


@experiment("procedure", "load F/(E* A0 h')")
def procedure(
    effort: Effort,
    *,
    load: Positive = 0.01,
    variant: Literal["literal", "corrected"] = "literal",
    quantity: Literal["contact_area", "stress", "undefined"] = "contact_area",
    surface: Surface = Surface(roll_off=2.0, shortest=4.0),
) -> Finding | Share:
    """Section 19.7 on maps of rough surfaces, against the contact of the same surfaces.

    Means over maps. ``"contact_area"``: (19.29) over the area; ``"stress"``: mean of (19.37) where
    it is defined, over the mean pressure of the true contact; ``"undefined"``: fraction of the
    contact where it is undefined. Sources of the bar: the scatter of the maps, and the grid.
    """
    maps, lines = _COUNTS[effort]
    done = [_calculated(surface, load, k, lines)[variant] for k in range(maps)]
    ratios = np.mean([each.sums.ratio for each in done], axis=0)
    missing = np.array([each.undefined_share[0] for each in done])
    details = {
        **{
            f"{name} of the lines over the maps'": float(ratio)
            for name, ratio in zip(("rms height", "rms slope", "curvature"), ratios, strict=True)
        },
        "share of the contact without a stress": float(missing.mean()),
    }
    if quantity == "undefined":
        scatter = 2 * float(missing.std(ddof=1)) / np.sqrt(maps)
        return Share(float(missing.mean()), scatter, details)
    areas, grid_bar = pressed_surfaces(surface, load, "contact_area", maps, effort)
    if quantity == "contact_area":
        stated, true = np.array([each.ensemble["contact_area"].mean[0] for each in done]), areas
    else:
        stated, true = np.array([each.pressures[0].mean() for each in done]), load / areas
    ratio, bar = ratio_of_means(stated[:, None], true[:, None], paired=True)
    uncertainty = float(ratio[0] * combined(float(bar[0]), grid_bar))
    return Finding(float(stated.mean()), float(true.mean()), uncertainty, details)
