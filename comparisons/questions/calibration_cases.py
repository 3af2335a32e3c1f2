"""What a calibration collects: bars beside the true errors that they must cover.

Bars are shares of the changes between grids, which are fitted here on the fitting halves.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import pandas as pd

from comparisons.facts.quantities.rows import ENCLOSED
from comparisons.judging.metrics import rms_and_maximum
from comparisons.judging.truth import missed_by
from comparisons.judging.uncertainty import (
    SHARES,
    Calibrated,
    Kind,
    Share,
    Shares,
    combined,
    discretisation,
    line_uncertainty,
)

# Why a bar has no interval beside it.
NO_QUANTITY = "of a quantity that no theorem encloses"
NOT_SHOWN = "at loads of which the bounds prove nothing"


@dataclass(frozen=True)
class Case:
    """A bar and the true error that it must cover, for a quantity of one series of resolutions."""

    half: str
    shape: str
    method: str
    control: str
    quantity: str
    kind: Kind | None
    resolutions: tuple[int, ...]
    errors: np.ndarray  # (steps,)
    curves: np.ndarray  # (levels, steps)
    bars_beside_grid: np.ndarray  # (steps,), of other sources
    beyond: np.ndarray | None = None  # (steps,), relative distance from the proved interval, or NaN
    unproved: str = ""  # why there is none at all
    areas: np.ndarray | None = None  # (steps,), of contact
    apparent: float = float("nan")
    shares: Shares = field(default_factory=lambda: SHARES)
    counted: np.ndarray | None = None  # (steps,), areas of cells on the finest grid
    widened: float = 1.0  # times that the grid's bar is taken

    @property
    def rough(self) -> bool:
        """Whether it is of a rough surface."""
        return self.kind in ("free", "periodic")

    @cached_property
    def bars(self) -> np.ndarray:
        """Estimated 95 % half-widths at the load steps, by the rule, (steps,)."""
        known = self.quantity, self.kind
        grid = discretisation(
            np.array(self.resolutions),
            self.curves,
            known,
            shares=self.shares,
            areas=self.areas,
            apparent=self.apparent,
        )
        if self.counted is not None:
            sides, periodic = (self.resolutions[-1],) * 2, self.kind == "periodic"
            line = line_uncertainty(self.curves[-1], self.counted, sides, periodic=periodic)
            grid = combined(grid, line)
        return combined(self.widened * grid, self.bars_beside_grid)

    @property
    def missed(self) -> int | None:
        """Load steps whose bar misses the proved interval; None if there is no such interval."""
        return None if self.beyond is None else int(np.count_nonzero(self.beyond > self.bars))

    @property
    def refuted(self) -> bool:
        """Whether the bar misses the proved interval as a whole: in the rms over the loads."""
        return self.beyond is not None and rms_and_maximum(np.nan_to_num(self.beyond))[0] > self.bar

    @property
    def excess(self) -> float:
        """By which share of the bar it is too narrow at worst to reach the proved interval."""
        if self.beyond is None:
            return 0.0
        return max(0.0, float(np.max(np.nan_to_num(self.beyond) / self.bars)) - 1)

    @property
    def in_words(self) -> str:
        """Which series of resolutions it is."""
        levels = ", ".join(map(str, self.resolutions))
        return f"{self.shape}, {self.method} {levels}, {self.quantity} at given {self.control}"

    @property
    def error(self) -> float:
        """True error, rms over the load steps."""
        return rms_and_maximum(self.errors)[0]

    @property
    def bar(self) -> float:
        """Estimated 95 % half-width, rms over the load steps."""
        return rms_and_maximum(self.bars)[0]


@dataclass(frozen=True)
class Summary:
    """How many bars, the share that covers the true error, and the median of bar over error."""

    count: int
    coverage: float
    width: float


def summary(cases: Iterable[Case], *, at_loads: bool = False) -> Summary:
    """Return the coverage and median width of the bars in the rms over the loads, or at each."""
    pairs = [(c.errors, c.bars) if at_loads else ([c.error], [c.bar]) for c in cases]
    errors, bars = (np.concatenate(column) for column in zip(*pairs, strict=True))
    # Round-off errors are covered by any bar and say nothing about widths.
    real = errors > 1e-13
    return Summary(
        count=len(errors),
        coverage=float(np.mean((errors <= bars) | ~real)),
        width=float(np.median(bars[real] / errors[real])),
    )


@dataclass(frozen=True)
class Held:
    """Bars beside a proved interval, how many miss it, and why others are without one, counted."""

    bars: int
    missed: int
    without: Mapping[str, int] = field(default_factory=dict)

    def __str__(self) -> str:
        others = [f"{count} {reason}" for reason, count in self.without.items()]
        sentence = (
            f"{self.bars} bars stand beside an interval that a theorem gives; "
            f"{self.missed} do not reach it"
        )
        return sentence + (f". Without one: {'; '.join(others)}" if others else "")


def held(cases: Iterable[Case]) -> Held:
    """Return how many bars, of single load steps, there are to hold against a theorem."""
    bars, missed, without = 0, 0, Counter[str]()
    for case in cases:
        if case.beyond is None:
            without[case.unproved or NO_QUANTITY] += case.bars.size
            continue
        count = int(np.isfinite(case.beyond).sum())
        bars, missed = bars + count, missed + (case.missed or 0)
        if count < case.bars.size:
            without[NOT_SHOWN] += case.bars.size - count
    return Held(bars, missed, dict(without))


def held_against(sides: Mapping[str, np.ndarray] | str, case: Case) -> Case:
    """Return the case with its distance from the proved interval, or why there is none."""
    if case.quantity not in ENCLOSED:
        return replace(case, unproved=NO_QUANTITY)
    if isinstance(sides, str):
        return replace(case, unproved=sides)
    lower, upper = (sides[f"{case.quantity}_{side}"] for side in ("lower", "upper"))
    return replace(case, beyond=missed_by(case.curves[-1], np.zeros(len(lower)), lower, upper))


def table(cases: list[Case]) -> pd.DataFrame:
    """Return the cases as rows."""
    return pd.DataFrame(
        {
            "half": case.half,
            "shape": case.shape,
            "method": case.method,
            "control": case.control,
            "quantity": case.quantity,
            "resolutions": " ".join(map(str, case.resolutions)),
            "error": case.error,
            "bar": case.bar,
            "misses_proof": case.missed,
        }
        for case in cases
    )


# Coverage that is required at every load on the fitting half, and by how much factors are raised
# then. Theorems enclose force, penetration and stiffness of single contacts, whose bars are to be
# too narrow rarely; the area they do not, and 95 % it is. Raised until no bar of the quick suite
# misses what is proved (stiffness on cells), and references that agree there do not seem to differ
# (elements, of which there are some fourteen cases). Of rough surfaces, of which there are some
# thirty cases of small ones, 95 %, raised by a tenth.
ROUGH = 0.95, 1.1
SINGLE: dict[Calibrated, tuple[float, float]] = {
    ("force", "cells"): (0.99, 1.0),
    ("penetration", "cells"): (0.99, 1.0),
    ("contact_area", "cells"): (0.95, 1.0),
    ("stiffness", "cells"): (0.99, 1.3),
    ("force", "elements"): (0.99, 1.25),
    ("contact_area", "elements"): (0.99, 2.0),
    ("stiffness", "elements"): (0.99, 1.15),
}
# The factors that are tried.
FACTORS = tuple(map(float, np.geomspace(0.01, 100, 2000)))


def fitted_shares(cases: Iterable[Case]) -> Shares:
    """Return the narrowest shares that cover enough of the fitting half.

    Every factor covers the required share at every load of its cases with three grids, `two` times
    as much that of those with two; factors are then raised. Areas are taken without the contact
    line.
    """
    fitting = [replace(case, counted=None) for case in cases if case.half == "fitting"]
    fitted: dict[Calibrated, Share] = {}
    for known, used in SHARES.items():
        own = [case for case in fitting if (case.quantity, case.kind) == known]
        three = [case for case in own if len(case.resolutions) > 2]
        two = [case for case in own if len(case.resolutions) == 2]
        least, raised = SINGLE.get(known, ROUGH)
        tried = {f: {known: used._replace(factor=f)} for f in FACTORS}
        factor = _narrowest(three, tried, used.factor / raised, least)
        tried = {f: {known: used._replace(factor=factor, two=f)} for f in FACTORS}
        wider = _narrowest(two, tried, used.two, least)
        fitted[known] = used._replace(factor=round(raised * factor, 2), two=wider)
    return fitted


def _narrowest(
    cases: list[Case], tried: Mapping[float, Shares], other: float, least: float
) -> float:
    """Return the first of some numbers whose shares cover enough of the cases; else another one."""
    numbers = list(tried)

    def covers(number: float) -> bool:
        made = [replace(case, shares=tried[number]) for case in cases]
        return summary(made, at_loads=True).coverage >= least

    # the larger the number, the wider all bars
    first = bisect_left(numbers, True, key=covers) if cases else len(numbers)
    return numbers[first] if first < len(numbers) else other
