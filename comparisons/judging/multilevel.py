"""Means over random surfaces by multilevel Monte Carlo: many on a coarse grid, few differences.

Between surfaces a quantity scatters by ten to thirty per cent, but the difference between two grids
on the same surface by one, and a fine grid costs a hundred times as much as a coarse one. So

    E[Q_L] = E[Q_0] + sum over l of E[Q_l - Q_(l-1)],

each mean over its own number of surfaces (M. B. Giles, Acta Numerica 24 (2015) 259, eq. 1.4). Here
the surfaces of a finer grid are the first of those of the coarser one, so that each is solved once
per grid. The terms then share surfaces: with Y_0 = Q_0, Y_l = Q_l - Q_(l-1) and n_l surfaces on
grid l, the variance of the sum is

    sum over l of a_l / n_l,   a_l = Var Y_l + 2 sum over m > l of Cov(Y_l, Y_m),

because two means over n_l >= n_m of the same surfaces have the covariance Cov(Y_l, Y_m) / n_l.

Features of a surface that cost no solve could serve as control variates (Giles, section 2.1). They
were measured and left out: its highest peak and the depth at which the geometric overlap carries
the load explain 96 % of the variance of the mean gap at 0.005 E* A0 h', but 63 % of that of the
stiffness there and 1 % of that of the mean gap at 0.1 (free, H = 0.8): the worst of the means,
which sets the numbers, would need half the surfaces on the cheapest grid at best.

Nothing here knows of scenes: arrays (surfaces, load steps) go in, NaN where a solve was lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from comparisons.facts.methods import METHODS

# A variance from fewer surfaces than this says nothing.
FEWEST = 2
# Multipliers of the constraints settle in some tens of rounds; more change no number of surfaces.
_ROUNDS = 500


@dataclass(frozen=True)
class Estimate:
    """A mean over random surfaces, and how well it is known."""

    # (m, k), mean on each grid, coarse to fine: partial sums, all with the surfaces of the first.
    levels: np.ndarray
    # (m, k), what each grid contributes to the variance of the last mean, a_l / n_l.
    parts: np.ndarray
    freedom: np.ndarray  # (k,), degrees of freedom of the variance (Welch and Satterthwaite)
    counts: np.ndarray  # (m, k), surfaces that each term is a mean over
    # Per load step: what is missing for a mean or for its bar; "" where nothing is.
    missing: tuple[str, ...]

    @property
    def mean(self) -> np.ndarray:
        """Mean on the finest grid, (k,)."""
        return self.levels[-1]

    @property
    def half_width(self) -> np.ndarray:
        """95 % half-width of the mean, (k,); NaN where the scatter is not known."""
        variance = self.parts.sum(axis=0)
        with np.errstate(invalid="ignore"):
            return special.stdtrit(self.freedom, 0.975) * np.sqrt(variance)

    def differing(self, level: int) -> np.ndarray:
        """Return the 95 % half-width of the mean on the finest grid less that on another, (k,).

        Both have the same surfaces of the coarser grids, which drop out.
        """
        if level == len(self.levels) - 1:
            return np.zeros(self.levels.shape[1])
        parts, counts = self.parts[level + 1 :], self.counts[level + 1 :]
        freedom = _freedom(parts, counts)
        with np.errstate(invalid="ignore"):
            return special.stdtrit(freedom, 0.975) * np.sqrt(parts.sum(axis=0))


def estimate(values: Sequence[np.ndarray]) -> Estimate:
    """Return the mean on the finest of several grids, of values (n_l, k) coarse to fine.

    Row i is the same surface on all grids. NaN where a solve was lost: the surface then takes part
    in no difference that needs it. Surfaces that a coarser grid does not have count on no finer
    one.

    >>> coarse = np.array([[1.0], [2.0], [3.0], [6.0]])
    >>> known = estimate([coarse, coarse[:2] + 0.5])
    >>> float(known.mean[0]), known.counts[:, 0].tolist(), known.missing
    (3.5, [4, 2], ('',))
    """
    terms = _terms(values)
    means, counts = (np.array(term) for term in zip(*map(_mean, terms), strict=True))
    levels = np.where(counts > 0, np.cumsum(np.nan_to_num(means), axis=0), np.nan)
    parts = np.where(counts > 0, [_part(terms, level) for level in range(len(terms))], 0.0)
    parts[-1, counts[-1] == 0] = np.nan
    # Rounding may leave less than nothing of a variance that covariances cancel.
    parts = np.where(parts.sum(axis=0) < 0, np.maximum(parts, 0.0), parts)
    missing = []  # at each load step, where a grid has too few surfaces
    for numbers in counts.T:
        alone = (numbers > 0) & (numbers < FEWEST)
        if numbers[-1] == 0:
            missing.append(f"no surface has an answer on grid {len(counts)} of {len(counts)}")
        elif alone.any():
            grid = f"grid {int(np.argmax(alone)) + 1} of {len(counts)}"
            missing.append(f"one surface on {grid}: how it scatters is not known")
        else:
            missing.append("")
    return Estimate(levels, parts, _freedom(parts, counts), counts, tuple(missing))


def variances(values: Sequence[np.ndarray]) -> np.ndarray:
    """Return a_l of each grid and load step, (m, k): the mean's variance is sum of a_l / n_l."""
    terms = _terms(values)
    counts = np.array([_mean(term)[1] for term in terms])
    return np.array([_part(terms, level) for level in range(len(terms))]) * counts


def allocate(variance: np.ndarray, cost: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Return how many surfaces on each grid know all means well enough, at the least cost.

    Minimises sum n_l c_l under sum a_lj / n_l <= allowed_j for all j, with the costs c (m,) of a
    surface in any unit and the variances a (m, j). For one mean that is n_l = sqrt(a_l / c_l) sum
    sqrt(a_m c_m) / allowed (Giles, eq. 1.6); for several the same with sum over j of w_j a_lj, the
    weights w grown where a mean is known too badly, shrunk where it is known better than asked. The
    numbers do not increase.

    >>> allocate(np.array([[1.0], [0.01]]), np.array([1.0, 4.0]), np.array([0.01])).tolist()
    [120, 6]
    """
    variance, cost, allowed = (
        np.asarray(array, dtype=float) for array in (variance, cost, allowed)
    )
    if not (np.isfinite(variance).all() and np.isfinite(cost).all() and (cost > 0).all()):
        raise ValueError("variances and costs must be finite, and costs positive")
    if not (allowed > 0).all():
        raise ValueError("no number of surfaces knows a mean without any error")
    # Covariances may take away from a grid more than its own variance: it then needs no surfaces.
    shares = np.maximum(variance, 0.0) / allowed
    weights = np.full(shares.shape[1], 1.0 / shares.shape[1])
    numbers = np.zeros(len(cost))
    for _ in range(_ROUNDS):
        weighted = shares @ weights
        numbers = np.sqrt(weighted / cost) * np.sqrt(weighted * cost).sum()
        reached = (shares / np.maximum(numbers, 1e-300)[:, None]).sum(axis=0)
        if reached.max() <= 0:
            break
        weights *= reached / reached.max()
        weights /= weights.sum()
    numbers = numbers * max(reached.max(), 0.0)
    counts = np.maximum(np.ceil(numbers * (1 - 1e-9)), FEWEST)
    # The surfaces of a finer grid are among those of the coarser ones.
    return np.maximum.accumulate(counts[::-1])[::-1].astype(int)


def within_budget(numbers: np.ndarray, cost: np.ndarray, budget: float) -> np.ndarray:
    """Return numbers in the same proportion that cost no more than a budget, at least FEWEST.

    >>> within_budget(np.array([400, 40]), np.array([1.0, 5.0]), 300.0).tolist()
    [200, 20]
    """
    total = float(numbers @ cost)
    if total <= budget:
        return numbers
    needed = FEWEST * float(cost.sum())
    if needed > budget:
        raise ValueError(
            f"a budget of {budget:.3g} is too small: {FEWEST} surfaces on each grid, the fewest "
            f"that know how much they scatter, cost {needed:.3g}"
        )
    scaled = np.maximum(np.floor(numbers * (budget / total)), FEWEST).astype(int)
    while float(scaled @ cost) > budget:  # what the fewest of one grid take is saved on the first
        scaled[np.argmax(scaled > FEWEST)] -= 1
    return scaled


def in_words(numbers: Sequence[int], resolutions: Sequence[int], noun: str = "surface") -> str:
    """Return how many surfaces, or lines, were solved on which grid.

    >>> in_words([450, 38, 9], [64, 128, 256])
    '450 surfaces at 64, 38 at 128, 9 at 256'
    """
    first, *rest = [f"{n} at {grid}" for n, grid in zip(numbers, resolutions, strict=True)]
    plural = noun if numbers[0] == 1 else f"{noun}s"
    return ", ".join([first.replace(" at", f" {plural} at", 1), *rest])


def ensemble_text(method: str, numbers: Sequence[int], resolutions: Sequence[int]) -> str:
    """Return how many surfaces or lines a method solves on which grid; "" where it is no matter."""
    if not numbers:
        return ""
    return in_words(numbers, resolutions, "line" if METHODS[method].dimension == 1 else "surface")


def _terms(values: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return Y_l, (k, n_l) each: the difference to the next coarser grid that has any answer."""
    # by load step: sums along contiguous rows take a fifth of the time
    grids = [np.array(np.asarray(answers, dtype=float).T, order="C") for answers in values]
    if not grids:
        raise ValueError("a mean needs at least one grid")
    terms, below = [], np.zeros_like(grids[0])
    for whole in grids:
        grid = whole[:, : below.shape[1]]
        below = below[:, : grid.shape[1]]
        terms.append(grid - below)
        below = np.where(np.isfinite(grid).any(axis=1, keepdims=True), grid, below)
    return terms


def _mean(term: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and number of the surfaces that have an answer, (k,) each."""
    known = np.isfinite(term)
    count = known.sum(axis=1)
    with np.errstate(invalid="ignore"):
        return np.where(known, term, 0.0).sum(axis=1) / count, count


def _part(terms: Sequence[np.ndarray], level: int) -> np.ndarray:
    """Return what a term adds to the variance: its own, and twice its covariances with finer ones.

    The covariance of two means is that of the surfaces, times the number of surfaces that they
    share, over the numbers of both.
    """
    total = np.zeros(len(terms[0]))
    for finer, term in enumerate(terms[level:], level):
        pair = terms[level][:, : term.shape[1]], term
        shared = np.isfinite(pair[0]) & np.isfinite(pair[1])
        number = shared.sum(axis=1)
        counts = [np.isfinite(terms[index]).sum(axis=1) for index in (level, finer)]
        with np.errstate(invalid="ignore", divide="ignore"):
            means = [np.where(shared, t, 0.0).sum(axis=1) / number for t in pair]
            first, second = (t - mean[:, None] for t, mean in zip(pair, means, strict=True))
            product = np.where(shared, first * second, 0.0).sum(axis=1)
            covariance = product / (number - 1) * number / counts[0] / counts[1]
        if finer > level:  # without a shared pair nothing is known to be common
            total += 2 * np.where(number >= FEWEST, covariance, 0.0)
        else:
            total += np.where(number >= FEWEST, covariance, np.nan)
    return total


def _freedom(parts: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return the degrees of freedom of a sum of variances, by Welch and Satterthwaite."""
    with np.errstate(invalid="ignore", divide="ignore"):
        spread = (parts**2 / np.maximum(counts - 1, 1)).sum(axis=0)
        freedom = parts.sum(axis=0) ** 2 / spread
    return np.where(spread > 0, np.maximum(freedom, 1.0), np.maximum(counts[-1] - 1, 1))
