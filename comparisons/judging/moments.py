"""Means and scatter of curves that arrive block by block, in memory that does not grow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass
class Moments:
    """Number, mean, scatter and extremes of everything that was added, per entry.

    Blocks are joined by the formula of Chan, Golub & LeVeque (1979): with n, m, S the number, mean
    and sum of squared deviations of each, d the difference of the means,

    S = S_1 + S_2 + d² n_1 n_2/(n_1 + n_2),   m = m_1 + d n_2/(n_1 + n_2).

    NaN is not counted.

    Examples
    --------
    >>> import numpy as np
    >>> moments = Moments.of([np.array([[1.0], [3.0]]), np.array([[5.0], [np.nan]])])
    >>> moments.count.tolist(), moments.mean.tolist(), moments.standard_deviation.tolist()
    ([3], [3.0], [2.0])
    """

    count: np.ndarray
    mean: np.ndarray
    squares: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def of(cls, blocks: Iterable[np.ndarray]) -> Moments:
        """Return those of all blocks along their first axis; no block at all: of nothing."""
        moments: Moments | None = None
        for values in blocks:
            block = cls._of_one(values)
            moments = block if moments is None else moments._with(block)
        return cls._of_one(np.zeros((0, 0))) if moments is None else moments

    @classmethod
    def _of_one(cls, values: np.ndarray) -> Moments:
        known = np.isfinite(values)
        count = known.sum(axis=0)
        mean = np.where(known, values, 0.0).sum(axis=0) / np.maximum(count, 1)
        deviations = np.where(known, values - mean, 0.0)
        low = np.where(known, values, np.inf).min(axis=0, initial=np.inf)
        high = np.where(known, values, -np.inf).max(axis=0, initial=-np.inf)
        return cls(count, mean, (deviations**2).sum(axis=0), low, high)

    def _with(self, other: Moments) -> Moments:
        count = self.count + other.count
        change = other.mean - self.mean
        share = other.count / np.maximum(count, 1)
        return Moments(
            count,
            self.mean + change * share,
            self.squares + other.squares + change**2 * self.count * share,
            np.minimum(self.low, other.low),
            np.maximum(self.high, other.high),
        )

    @property
    def standard_deviation(self) -> np.ndarray:
        """Of one surface; 0 of a single one."""
        return np.sqrt(self.squares / np.maximum(self.count - 1, 1))

    @property
    def standard_error(self) -> np.ndarray:
        """Of the mean."""
        return self.standard_deviation / np.sqrt(np.maximum(self.count, 1))
