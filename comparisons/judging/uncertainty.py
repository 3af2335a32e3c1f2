"""How well a reference value is known: grid convergence and standard errors.

All uncertainties are half-widths at 95 %, relative to the value.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import optimize, special

from reference.halfspace.punches import EDGE_OFFSET

# The grid convergence index is for quantities and physics whose share was not measured (`Share`).
# On single contacts, where both can be told, it covers every case at nine times the true error.
# Safety factors where three grids converge with a credible order, where they do not, and of two
# grids, which have no order of their own (Roache takes 1.25, 3 and 3).
SAFE, UNSAFE, OF_TWO = 1.25, 2.0, 3.0
# Contact edges move in jumps of a cell, so the observed order is noisy: nothing beyond the highest
# is trusted, and below the lowest convergence is not credible at all.
LOWEST, HIGHEST = 0.5, 1.25
FLOOR = 0.5  # least share of the median difference that a step's own counts as

# What a share of the error was measured of: a "free" or "periodic" rough surface; a single contact
# on "cells", or on finite "elements" that are fitted to it. Those of a "pair" of bodies are not:
# the contact line crosses them as it does cells, at every load the same ones.
Kind = Literal["free", "periodic", "cells", "elements", "pair"]
Calibrated = tuple[str, Kind]
# Radii of single contacts, whose share is that of the area, and how the area goes with each.
AREAS = {"contact_area": 1, "contact_radius": 2, "equivalent_radius": 2}


class Share(NamedTuple):
    """Bars as a share of the changes from one grid to the next.

    An observed order is noise: contact edges move in jumps of a cell, spots of rough surfaces
    appear and join, and single changes are small by chance. But the error left is a share of the
    changes that were measured: of single contacts against closed forms, of rough surfaces against
    grids eight times finer. What the changes between the last three grids leave is pooled over all
    loads (`share_uncertainty`).
    """

    order: float  # at which errors fall with cells or elements to a side
    # Of rough surfaces, of which many loads or few may be asked: that of Student's t of as many
    # degrees of freedom as there are changes, for as many estimates may all be small by chance.
    factor: float
    # What the factor of single contacts is multiplied by where there are two grids, or meshes of
    # elements, only. Of their cases, with their coarsest grid left out, 99 % and more are covered
    # then.
    two: float = 1.0
    # By which powers of the contact area, and of the open share of a rough surface, errors fall.
    area: float = 0.0
    gap: float = 0.0


Shares = Mapping[Calibrated, Share]
# Factors of single contacts are fixed by `fitted_shares` (comparisons.questions.calibration_cases)
# on the fitting halves; orders, the coverage that is required there, and margins were chosen by
# hand, after proved intervals had been seen. Those of rough surfaces were chosen by hand on
# patches, periods and parts of maps, and held against others (`docs/examples/map_bars.py`).
# Areas of rough surfaces err by cells at the contact line, too (`line_uncertainty`).
SHARES: Shares = {
    ("contact_area", "free"): Share(1.5, 0.63, area=0.5, gap=0.5),
    ("contact_area", "periodic"): Share(1.5, 0.5, area=0.5, gap=0.5),
    ("penetration", "free"): Share(1.5, 1.1, area=0.75),
    ("penetration", "periodic"): Share(2.25, 0.75, area=1.125, gap=0.25),
    ("mean_gap", "free"): Share(1.5, 0.9, gap=2.0),
    ("mean_gap", "periodic"): Share(2.25, 0.76, area=0.25, gap=1.5),
    ("stiffness", "free"): Share(1.0, 1.0, area=0.65, gap=0.75),
    ("stiffness", "periodic"): Share(1.0, 0.7, area=0.5, gap=0.75),
    ("force", "cells"): Share(2.0, 3.16, 1.4, area=1.0),
    ("penetration", "cells"): Share(2.0, 2.97, 1.4, area=1.0),
    ("contact_area", "cells"): Share(2.0, 3.38, 1.4, area=1.0),
    ("stiffness", "cells"): Share(1.0, 2.74, 1.4, area=0.5),
    ("force", "elements"): Share(2.0, 1.06, 3.0),
    ("contact_area", "elements"): Share(2.0, 2.0, 3.0),
    ("stiffness", "elements"): Share(2.0, 1.07, 3.0),
}


def share_of(quantity: Calibrated, shares: Shares = SHARES) -> Share | None:
    """Return the share of a quantity or of its like; None where neither was measured.

    Radii have that of the area, other quantities of rough surfaces that of the stiffness, a pair of
    bodies that of cells, as many at every load.
    """
    name, kind = quantity
    if kind == "pair":
        share = share_of((name, "cells"), shares)
        return None if share is None else share._replace(area=0.0)
    if name in AREAS:
        name = "contact_area"
    elif kind in ("free", "periodic") and name not in ("penetration", "mean_gap"):
        name = "stiffness"
    elif (name, kind) == ("penetration", "elements"):
        # at a prescribed force it errs by less than the force at a prescribed penetration
        name = "force"
    return shares.get((name, kind))


# Open share of a rough surface that counts at the least: none below a fifth was measured.
LEAST_OPEN = 0.1
# Orders between which an observed one is looked for.
LEAST, MOST = 1e-3, 10.0


def grid_uncertainty(
    resolutions: np.ndarray, curves: np.ndarray, *, sizes: np.ndarray | None = None
) -> np.ndarray:
    """Return the relative uncertainty of the finest of several solutions, per load step.

    The grid convergence index of Roache (J. Fluids Eng. 116 (1994) 405): with f3 the finest of
    three values, r the ratio of resolutions and p the observed order, u = Fs |f3 - f2| / (r^p - 1).
    The order comes from the median differences over all load steps, because single steps can agree
    by chance; for the same reason a step's own difference counts no less than a share of the median
    over the steps, and no less than the difference before it predicts. Values that oscillate or
    diverge have no order: first order and the unsafe factor; values that converge slowly, the
    lowest order and the unsafe factor.

    Curves are (m, k), coarse to fine; the uncertainty is relative to `sizes`, else to the finest.
    NaN with one resolution, and at steps that one of the two finest lost. With two the order is
    taken as one, with the factor of two grids.

    >>> n = np.array([10, 20, 40])
    >>> value = 1 + 0.5 / n[:, None] ** 2
    >>> bool(grid_uncertainty(n, value)[0] >= abs(value[-1, 0] - 1))
    True
    """
    curves = np.asarray(curves, dtype=float)
    steps = curves.shape[1]
    usable = np.isfinite(curves).any(axis=1)
    resolutions, curves = np.asarray(resolutions, dtype=float)[usable], curves[usable]
    if len(curves) < 2:
        return np.full(steps, np.nan)
    finest = np.abs(curves[-1]) if sizes is None else sizes
    with np.errstate(divide="ignore", invalid="ignore"):
        last = np.where(finest > 0, (curves[-1] - curves[-2]) / finest, np.nan)
        ratio = resolutions[-1] / resolutions[-2]
        if len(curves) == 2:
            order, factor = 1.0, OF_TWO
        else:
            previous = np.where(finest > 0, (curves[-2] - curves[-3]) / finest, np.nan)
            before = resolutions[-2] / resolutions[-3]
            fine, coarse = _typical(last), _typical(previous)
            order, factor = 1.0, SAFE
            if fine != 0 and np.isfinite(fine * coarse):

                def excess(p: float) -> float:
                    """Return how much more differences of c n^-p shrink than they did; it grows."""
                    shrinking = np.expm1(p * np.log(before)) / -np.expm1(-p * np.log(ratio))
                    return float(shrinking - coarse / fine)

                observed = MOST
                if excess(LEAST) >= 0:
                    observed = 0.0
                elif excess(MOST) > 0:
                    observed = optimize.brentq(excess, LEAST, MOST)
                monotone = np.nansum(last * previous) > 0
                if monotone and observed >= LOWEST:
                    order = float(min(observed, HIGHEST))
                else:
                    order = LOWEST if monotone and observed > 0 else 1.0
                    factor = UNSAFE
            predicted = np.abs(previous) * (1 - ratio**-order) / (before**order - 1)
            last = np.fmax(np.abs(last), predicted)
        difference = np.fmax(np.abs(last), FLOOR * _typical(last))
    known = np.isfinite(curves[-2:]).all(axis=0)
    return np.where(known, factor * difference / (ratio**order - 1), np.nan)


def share_uncertainty(
    resolutions: np.ndarray,
    curves: np.ndarray,
    quantity: Calibrated,
    share: Share | None = None,
    areas: np.ndarray | None = None,
    apparent: float = np.nan,
) -> np.ndarray:
    """Return the relative uncertainty of the finest of several grids or meshes by its share, (k,).

    How a contact lies on the grid is much like chance, but an error depends only on the cells
    across it and across its gaps: its size is c s n^-p on n cells to a side, with the same c on all
    grids and at all loads, and s of powers of contact area and open share (`Share`). Were the
    errors of different grids independent, a change from N to n would be c s (N^-2p + n^-2p)^(1/2):
    each change at each load is an estimate of c, and the root of their mean square is known far
    better than any of them, which may be small by chance.

    Parameters as of `grid_uncertainty`, the quantity with what it is of, its share (default: of
    `SHARES`), the contact areas at the load steps (k,), and the apparent area of a rough surface.
    Without areas all loads count as equal.
    NaN where the finest value is zero or infinite, too: nothing is relative to that.

    >>> depth = np.array([[1.2], [1.1], [1.05]])
    >>> free = ("penetration", "free")
    >>> round(float(share_uncertainty(np.array([64, 128, 256]), depth, free)[0]), 3)
    0.064
    """
    curves = np.asarray(curves, dtype=float)
    usable = np.isfinite(curves).any(axis=1)
    resolutions, curves = np.asarray(resolutions, dtype=float)[usable], curves[usable]
    if len(curves) < 2:
        return np.full(curves.shape[1], np.nan)
    share = share or SHARES[quantity]
    factor = share.factor * (share.two if len(curves) == 2 else 1.0)
    name, kind = quantity
    if name in AREAS:
        areas = np.abs(curves[-1]) ** AREAS[name]
    touching = np.ones(curves.shape[1]) if areas is None else np.abs(areas)
    rough = kind in ("free", "periodic")
    n, power = resolutions[-3:], -2 * share.order
    left = np.sqrt(n[-1] ** power / (n[:-1] ** power + n[1:] ** power))
    with np.errstate(divide="ignore", invalid="ignore"):
        changes = np.abs(np.where(curves[1:] != 0, curves[:-1] / curves[1:] - 1, np.nan))[-2:]
        # a share of no power of the area needs none: 0^0 = 1
        counts = (touching > 0) | (share.area == 0)
        smaller = np.where(counts, touching**share.area, np.nan)
        if rough and not np.isnan(apparent):
            smaller *= np.maximum(1 - touching / apparent, LEAST_OPEN) ** share.gap
        estimates = (changes * left[:, None] * smaller).ravel()
    estimates = estimates[np.isfinite(estimates)]
    if not estimates.size:
        return np.full(curves.shape[1], np.nan)
    constant = np.sqrt(np.mean(estimates**2))
    if rough:
        factor *= special.stdtrit(estimates.size, 0.975)
    known = np.isfinite(curves[-1]) & (curves[-1] != 0)
    return np.where(known, factor * constant / smaller, np.nan)


def discretisation(
    resolutions: np.ndarray,
    curves: np.ndarray,
    quantity: tuple[str, Kind | None],
    *,
    shares: Shares = SHARES,
    sizes: np.ndarray | None = None,
    areas: np.ndarray | None = None,
    apparent: float = np.nan,
) -> np.ndarray:
    """Return the finest solution's relative uncertainty, (k,): by its share, else by GCI."""
    name, kind = quantity
    share = None if kind is None else share_of((name, kind), shares)
    if kind is not None and share is not None:
        return share_uncertainty(resolutions, curves, (name, kind), share, areas, apparent)
    bar = grid_uncertainty(resolutions, curves, sizes=sizes)
    return of_fewer_cells(bar) if kind == "cells" else bar


def of_fewer_cells(bars: np.ndarray) -> np.ndarray:
    """Return bars that are nowhere below those of heavier loads, at loads that increase.

    At a lighter load fewer cells touch, and the error is larger: a narrower bar is one by chance.

    >>> of_fewer_cells(np.array([0.01, 0.03, np.nan, 0.02])).tolist()
    [0.03, 0.03, nan, 0.02]
    """
    return np.where(np.isnan(bars), bars, np.fmax.accumulate(bars[::-1])[::-1])


def _typical(values: np.ndarray) -> float:
    """Median absolute value: small loads, with their few cells, must not speak for all."""
    finite = np.abs(values[np.isfinite(values)])
    return float(np.median(finite)) if len(finite) else float("nan")


def standard_error(samples: np.ndarray) -> np.ndarray:
    """Return the standard error of the mean over axis 0 (realisations), NaN below two samples."""
    count = np.isfinite(samples).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.nansum(samples, axis=0) / count
        variance = np.nansum((samples - mean) ** 2, axis=0) / (count - 1)
        return np.where(count > 1, np.sqrt(variance / count), np.nan)


def ratio_of_means(
    numerator: np.ndarray, denominator: np.ndarray, *, paired: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ratio of two ensemble means and its relative 95 % half-width, each (k,).

    The delta method: with x, y the means and s their standard errors, the relative variance of x/y
    is (s_x/x)^2 + (s_y/y)^2 - 2 s_xy/(x y). The covariance counts where realisation k of both
    ensembles is the same surface (`paired`); it makes ratios far better known than either mean.
    Realisations, along axis 0, that either of a pair lost are left out. Student's t with the
    smaller number of degrees of freedom turns the standard error into a half-width: NaN below two
    realisations, except where both ensembles are single values, which do not scatter: zero.

    >>> y = np.array([[1.0], [2.0], [3.0]])
    >>> ratio, bar = ratio_of_means(2 * y, y, paired=True)
    >>> float(ratio[0]), round(float(bar[0]), 12)
    (2.0, 0.0)
    """
    x, y = np.asarray(numerator, dtype=float), np.asarray(denominator, dtype=float)
    if paired:
        both = np.isfinite(x) & np.isfinite(y)
        x, y = np.where(both, x, np.nan), np.where(both, y, np.nan)
    counts = [np.isfinite(sample).sum(axis=0) for sample in (x, y)]
    with np.errstate(invalid="ignore", divide="ignore"):
        means = [np.nansum(e, axis=0) / n for e, n in zip((x, y), counts, strict=True)]
        # Relative deviations: their difference has the variance of the ratio, to first order.
        deviations = [e / m - 1 for e, m in zip((x, y), means, strict=True)]
        if len(x) == len(y) == 1:
            return means[0] / means[1], np.zeros(x.shape[1])
        if paired:
            error = standard_error(deviations[0] - deviations[1])
        else:
            error = np.hypot(*(standard_error(sample) for sample in deviations))
        freedom = np.maximum(np.minimum(*counts) - 1, 1)
        return means[0] / means[1], special.stdtrit(freedom, 0.975) * error


def combined(*sources: ArrayLike) -> np.ndarray:
    """Combine independent relative half-widths: the root of the sum of squares."""
    return np.sqrt(np.sum([np.asarray(source) ** 2 for source in sources], axis=0))


# Bar per x^ORDER: some more than what that order leaves.
FACTOR, ORDER = 0.5, 1.5


def line_uncertainty(
    area: np.ndarray, counted: np.ndarray, sides: tuple[float, float], *, periodic: bool
) -> np.ndarray:
    """Return what cells at the contact line leave not known of an area, relative to it, per load.

    How many these are is known: counted areas are too large by 0.118 cells to each cell edge of the
    line (`reference.halfspace.areas.corrected_area`), a seventh of a cell along it. Of that excess
    x = A_counted/A - 1 located areas err by some 0.25 x^(3/2) on rough surfaces, where spots of a
    few cells and narrow gaps are always there. Where waves have two points, as on maps, that is
    more than changes between grids tell (`share_uncertainty`).

    On the rim of a free patch the line lies a known part of a cell inside (`areas`) that depends on
    how the area grows with the load: half of that strip is taken as not known.

    `sides` are the cells to the sides of the grid. NaN where an area is lost or zero.

    >>> bar = line_uncertainty(np.array([1.0]), np.array([1.06]), (512, 512), periodic=True)
    >>> round(float(bar[0]), 4)
    0.0073
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        excess = np.where(area > 0, np.maximum(counted / area - 1, 0.0), np.nan)
    rim = 0.0 if periodic else EDGE_OFFSET * (1 / sides[0] + 1 / sides[1])
    return np.asarray(FACTOR * excess**ORDER + rim)
