"""Pressures and distributions compared at the last load.

Of pressures: the L2 difference, the integral, the peak. Of distributions: how far values of equal
rank are apart. With x(s) the pressure, gap or size that a share s of all of them stays below, the
distance is int_0^1 |x_1 - x_2| ds over the mean of the truth (Wasserstein's, of first order): 10 %
is an average over the ranks. Both are normalised, as the area itself is a quantity of its own.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy import special
from scipy.interpolate import LinearNDInterpolator, RegularGridInterpolator

from comparisons.facts.methods import GRID, METHODS
from comparisons.facts.quantities import DISTRIBUTIONS
from comparisons.geometry.prepare import IndenterGeometry, RoughGeometry
from comparisons.judging.levels import Levels
from comparisons.judging.truth import Truth
from comparisons.judging.uncertainty import SAFE, combined
from comparisons.methods.normal.closed_form import form_of
from comparisons.scene.polygons import distance_to_outline
from comparisons.solving.plan import Plan
from comparisons.tasks.distributions import edges
from comparisons.tasks.solution import Solution, Solved
from reference.closed_form import ClosedForm

# A ring of this share of the contact radius is left out on either side of a singular edge or tip.
SINGULAR_RING = 0.1
Fields = dict[str, np.ndarray]
# What is compared at the last load: name, error, bar.
Measure = tuple[str, float, float]


def field_measures(
    plan: Plan, solved: Solved, method: str, resolution: int, truth: Truth
) -> list[Measure]:
    """Return name, error and bar of each measure at the last load of one solution.

    Pressures are compared without rings of `SINGULAR_RING`.
    """
    solution, measures = solved[method, resolution], []
    fields = solution.fields
    if "pressure" in fields and solution.converged[0, -1]:
        pressure, weight = fields["pressure"], fields["pressure_weight"]
        force = float(solution.quantities["force"][0, -1])
        integral = float(np.nansum(pressure * weight) / force - 1)
        measures.append(("pressure_integral", integral, 0.0))
        # A grid solver's pressure from FFT BEM's on its cells: both solve the same equations, so it
        # is of the order of their violations of the contact conditions, or one of them is wrong.
        other = solved.get((GRID, resolution)) if method != GRID else None
        if other is not None and other.converged[0, -1] and "pressure_shape" in fields:
            theirs, every = other.fields, np.ones(pressure.shape, dtype=bool)
            if np.array_equal(fields["pressure_shape"], theirs.get("pressure_shape", ())):
                same = pressure_difference(pressure, weight, theirs["pressure"], every)
                measures.append(("pressure_same_grid", same, 0.0))
        true, regular = true_pressure(plan, truth, fields)
        if true is not None:
            keep = regular & np.isfinite(pressure)
            error = pressure_difference(pressure, weight, true, keep)
            measures.append(("pressure", error, pressure_bar(plan, truth, fields)))
    for name in (name for name in DISTRIBUTIONS if name in plan.compared):
        if name not in truth.solution.distributions or name not in solution.distributions:
            continue
        bins, levels = _bins(plan, name), Levels.of(solved, method)
        bars = [change(name, truth.levels, truth.resolution, bins)]
        if METHODS[method].dimension == 3:
            own, true = last_histograms(name, solution, truth.solution)
        else:
            true = mean_histogram(truth.levels, name, truth.resolution)
            own = mean_histogram(levels, name, resolution)
            bars += [scatter(name, several, bins) for several in (truth.levels, levels)]
            if resolution == levels.finest:
                bars.append(float(np.nan_to_num(change(name, levels, resolution, bins))))
        measures.append((name, distance(own, true, bins), float(combined(*bars))))
    return measures


def field_bar(plan: Plan, truth: Truth, name: str) -> float | None:
    """Return how well the truth knows a field at the last load; None where it gives none."""
    if name in truth.solution.distributions:
        return change(name, truth.levels, truth.resolution, _bins(plan, name))
    if name in DISTRIBUTIONS:
        return None
    given = "pressure" in truth.solution.fields or (truth.exact and form_under(plan) is not None)
    return pressure_bar(plan, truth) if given else None


def form_under(plan: Plan) -> ClosedForm | None:
    """Return the closed form of a scene's shape, which knows where its pressure is singular."""
    geometry, scene = plan.geometry, plan.scene
    if not isinstance(geometry, IndenterGeometry) or not scene.half_space.uniform:
        return None
    return form_of(geometry.indenter, scene.effective_modulus)


def true_pressure(plan: Plan, truth: Truth, fields: Fields) -> tuple[np.ndarray | None, np.ndarray]:
    """Return the truth's pressure at a method's points, and which lie away from singularities.

    No pressure where the truth gives none: a closed form has it everywhere, a solution where it was
    kept.
    """
    x, y = fields["pressure_x"], fields["pressure_y"]
    form, geometry, keep = form_under(plan), plan.geometry, np.ones(len(fields["pressure_x"]), bool)
    if form is not None and form.singular_at is not None:
        rho = form.relative_radius(x, y, float(truth.curves["penetration"][-1]))
        keep = np.abs(rho - (1.0 if form.singular_at == "edge" else 0.0)) > SINGULAR_RING
    elif form is None and isinstance(geometry, IndenterGeometry):
        corners = geometry.indenter.outline
        if corners is not None:
            rim = SINGULAR_RING * geometry.contact_radius
            keep = distance_to_outline(x, y, corners) > rim
    stored = truth.solution.fields
    if form is not None and truth.exact:
        return np.asarray(form.pressure(x, y, float(truth.curves["penetration"][-1]))), keep
    if "pressure" not in stored:
        return None, keep
    if "pressure_shape" in stored:
        other_shape = fields.get("pressure_shape")
        shape = None if other_shape is None else tuple(int(n) for n in other_shape)
        return grid_pressure_at(stored, x, y, shape), keep
    points = np.stack([stored["pressure_x"], stored["pressure_y"]], axis=-1)
    # a half or a quarter stands for the whole
    x, y = (np.abs(c) if (p >= 0).all() else c for c, p in zip((x, y), points.T, strict=True))
    look_up = LinearNDInterpolator(points, stored["pressure"], fill_value=0.0)
    return np.asarray(look_up(x, y)), keep


def pressure_bar(plan: Plan, truth: Truth, fields: Fields | None = None) -> float:
    """Return how well the truth's pressure is known, as an L2 difference; NaN of one resolution.

    The change from the next coarser resolution, at first order: with r the ratio of resolutions,
    1.25 times that change over r - 1. A compared solution (`fields`) on coarser cells meets the
    mean over k of the truth's cells, in which errors at the contact's edges cancel: its bar is that
    of the change between means over k cells of the coarser grid.
    """
    if truth.exact and form_under(plan) is not None:
        return 0.0
    coarser = truth.levels.below(truth.resolution)
    coarse = {} if coarser is None else truth.levels.solutions[coarser].fields
    if coarser is None or "pressure" not in coarse:
        return float("nan")
    after, keep = true_pressure(plan, truth, coarse)
    if after is None:
        return float("nan")
    weight, before = coarse["pressure_weight"], coarse["pressure"]
    grids = (truth.solution.fields, fields or {}, coarse)
    own, other, shape = (known.get("pressure_shape") for known in grids)
    if own is not None and other is not None and shape is not None and not np.any(own % other):
        # how many of the truth's cells along x and y one cell of the solution covers; blocks of
        # as many as divide the coarser grid, kept where all of their cells are
        covered = own // other
        (bx, by), (nx, ny) = np.gcd(shape, covered), shape

        def in_blocks(array: np.ndarray) -> np.ndarray:
            split = array.reshape(nx // bx, bx, ny // by, by)
            return split.transpose(0, 2, 1, 3).reshape(-1, bx * by)

        if np.any(covered > 1):
            parts = in_blocks(weight)
            weight, keep = parts.sum(axis=1), np.asarray(in_blocks(keep).all(axis=1))
            pair = (in_blocks(p) * parts for p in (before, after))
            before, after = (products.sum(axis=1) / weight for products in pair)
    change = pressure_difference(before, weight, after, keep)
    return SAFE * change / (truth.resolution / coarser - 1)


def pressure_difference(
    pressure: np.ndarray, weight: np.ndarray, reference: np.ndarray, keep: np.ndarray
) -> float:
    """Return the relative L2 difference over the reference's contact, by `weight`, (n,)."""
    inside = keep & (reference > 0) & np.isfinite(reference)
    norm = float(np.sum(weight[inside] * reference[inside] ** 2))
    if norm == 0:
        return float("nan")
    difference = weight[inside] * (pressure[inside] - reference[inside]) ** 2
    return float(np.sqrt(np.sum(difference) / norm))


def grid_pressure_at(
    fields: dict[str, np.ndarray], x: np.ndarray, y: np.ndarray, shape: tuple[int, ...] | None
) -> np.ndarray:
    """Return a gridded reference pressure at other points.

    On a grid that is coarser by a whole number as means over its cells; else by interpolation.
    """
    nx, ny = (int(n) for n in fields["pressure_shape"])
    values = fields["pressure"].reshape(nx, ny)
    if shape is not None and nx % shape[0] == 0 and ny % shape[1] == 0:
        fx, fy = nx // shape[0], ny // shape[1]
        same_extent = np.isclose(
            float(np.ptp(x)) * shape[0] / max(shape[0] - 1, 1),
            float(np.ptp(fields["pressure_x"])) * nx / max(nx - 1, 1),
            rtol=1e-6,
        )
        if same_extent:
            return values.reshape(shape[0], fx, shape[1], fy).mean(axis=(1, 3)).ravel()
    axes = (fields["pressure_x"].reshape(nx, ny)[:, 0], fields["pressure_y"].reshape(nx, ny)[0])
    look_up = RegularGridInterpolator(axes, values, bounds_error=False, fill_value=0.0)
    return np.asarray(look_up(np.stack([x, y], axis=-1)))


def distance(values: np.ndarray, reference: np.ndarray, bins: np.ndarray) -> float:
    """Return the mean difference at equal rank, over the reference's mean; NaN of empty histograms.

    >>> bins = np.geomspace(1, 10, 11)
    >>> shape = np.arange(10.0)
    >>> distance(3 * shape, shape, bins)
    0.0
    """
    shares = []  # below each edge of the bins
    for histogram in (values, reference):
        total = float(histogram.sum())
        if not total > 0:
            return float("nan")
        shares.append(np.concatenate([[0.0], np.cumsum(histogram) / total]))
    mean = bins[0] + float(np.trapezoid(1 - shares[1], bins))
    return float(np.trapezoid(np.abs(shares[0] - shares[1]), bins) / mean)


def last_histograms(name: str, *solutions: Solution) -> list[np.ndarray]:
    """Return the means of a distribution at the last load over the surfaces of all, (bins,)."""
    common, means = min(len(solution.distributions[name]) for solution in solutions), []
    for solution in solutions:
        several = solution.distributions[name][:common]
        answered = several[np.isfinite(several).all(axis=1)]
        nothing = np.full(several.shape[1], np.nan)
        means.append(np.asarray(answered.mean(axis=0)) if len(answered) else nothing)
    return means


def mean_histogram(levels: Levels, name: str, resolution: int) -> np.ndarray:
    """Return a distribution's mean over surfaces: the coarsest grid's, and finer grids' changes."""
    grids = [s for n, s in levels.solutions.items() if n <= resolution and name in s.distributions]
    (mean,) = last_histograms(name, grids[0])
    for coarser, finer in pairwise(grids):
        before, after = last_histograms(name, coarser, finer)
        mean = mean + after - before
    return mean


def _bins(plan: Plan, name: str) -> np.ndarray:
    assert isinstance(plan.geometry, RoughGeometry)
    return edges(name, plan.scene, plan.geometry)


def change(name: str, levels: Levels, resolution: int, bins: np.ndarray) -> float:
    """Return how far the grid moves a distribution, on the same surfaces; NaN with one grid.

    1.25 times what is left of the change from the next coarser grid, at first order.
    """
    coarser = levels.below(resolution)
    if coarser is None:
        return float("nan")
    pair = [levels.solutions[n] for n in (coarser, resolution)]
    if any(name not in solution.distributions for solution in pair):
        return float("nan")
    before, after = last_histograms(name, *pair)
    return SAFE * distance(before, after, bins) / (resolution / coarser - 1)


def scatter(name: str, levels: Levels, bins: np.ndarray) -> float:
    """Return the 95 % half-width of a distribution by the jackknife; zero of a single surface."""
    rows = next(s for s in levels.solutions.values() if name in s.distributions).distributions[name]
    if len(rows) == 1:
        return 0.0
    rows = rows[np.isfinite(rows).all(axis=1)]
    count = len(rows)
    if count < 2:
        return float("nan")
    mean = rows.mean(axis=0)
    moves = [distance((count * mean - row) / (count - 1), mean, bins) for row in rows]
    error = np.sqrt((count - 1) / count * np.square(moves).sum())
    return float(special.stdtrit(count - 1, 0.975) * error)


def distribution_rows(plan: Plan, solved: Solved) -> list[dict[str, Any]]:
    """Return each method's distributions at the last load on its finest grid, by bins with any.

    ``amount`` is the share of the nominal area, or the number of contacts on it: a mean.
    """
    rows = []
    for method in dict.fromkeys(method for method, _ in solved):
        levels = Levels.of(solved, method)
        finest = levels.finest
        known = () if finest is None else levels.solutions[finest].distributions
        for name in (name for name in DISTRIBUTIONS if name in known):
            assert finest is not None
            bins = _bins(plan, name)
            amount = mean_histogram(levels, name, finest)
            common = {"scene": plan.scene.name, "method": method, "resolution": finest}
            rows += [
                common | {"quantity": name, "low": low, "high": high, "amount": float(part)}
                for low, high, part in zip(bins[:-1], bins[1:], amount, strict=True)
                if part > 0
            ]
    return rows
