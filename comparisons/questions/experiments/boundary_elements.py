"""Boundary elements of the chapter: (19.3) against Love's, the iteration (19.5)-(19.8).

And whether they and finite elements agree below the same rough surfaces.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from comparisons.judging.metrics import relative_error
from comparisons.judging.uncertainty import Kind, combined, share_uncertainty
from comparisons.questions.experiments.experiment import (
    Count,
    Details,
    Finding,
    Positive,
    Share,
    experiment,
    number_of,
    one_of,
    share_of,
)
from comparisons.questions.experiments.rough_ensemble import SEED, Surface
from reference.contact.press import assemble, press
from reference.errors import ConvergenceError
from reference.fem import Material
from reference.fem.columns import Element
from reference.fem.grid_body import FreeBody, PeriodicBody
from reference.halfspace import Contact, FreeOperator, PeriodicOperator, areas, kernels
from reference.halfspace.areas import located_area
from reference.loads import Load


def printed_kernel(i: np.ndarray, j: np.ndarray, reading: str) -> np.ndarray:
    """Return K of (19.3) for unit spacing and modulus, offsets i, j >= 0 in cells.

    ``"letter"``: the chapter's two slips, the root sqrt(a^2+b^2) in the first term and the bracket
    that closes before the last two terms, so that these lack the factor dx/(pi E*).
    ``"bracket"``: with the bracket corrected. ``"corrected"``: with both, Love's formula.
    """
    a, b, c, d = i + 0.5, i - 0.5, j + 0.5, j - 0.5
    root = np.hypot(a, d) if reading == "corrected" else np.hypot(a, b)
    first = a * np.log((c + np.hypot(a, c)) / (d + root))
    first += b * np.log((d + np.hypot(b, d)) / (c + np.hypot(b, c)))
    edges = c * np.log((a + np.hypot(a, c)) / (b + np.hypot(c, b)))
    edges += d * np.log((b + np.hypot(b, d)) / (a + np.hypot(a, d)))
    return (first / np.pi + edges) if reading == "letter" else (first + edges) / np.pi


@experiment("influence-coefficient", "largest offset in cells")
def influence_coefficient(
    effort: str,
    *,
    offset: Annotated[int, Field(strict=False, ge=0, le=4096)] = 63,
    reading: Literal["letter", "bracket", "corrected"] = "letter",
) -> Finding:
    """Influence coefficient (19.3) against Love's, over the offsets of a grid.

    Measure the largest error for all pairs of cells up to `offset` apart in both directions. One
    quadrant suffices by symmetry. Love's coefficients are accurate to 1e-13
    (tests/reference/test_halfspace_kernels.py), which is the bar.
    """
    reach = np.arange(offset + 1)
    i, j = np.meshgrid(reach, reach, indexing="ij")
    true = kernels.love(i, j, (1.0, 1.0), 1.0)
    stated = printed_kernel(i, j, reading)
    error = relative_error(stated, true)
    worst = np.unravel_index(np.argmax(np.abs(error)), error.shape)
    near = np.abs(error[: min(2, len(reach)), : min(2, len(reach))])
    details: Details = {
        "worst offset": f"({worst[0]}, {worst[1]})",
        "median error": float(np.median(np.abs(error))),
        "largest error of neighbours": float(near.max()),
        "own cell": float(error[0, 0]),
    }
    if reach[-1] >= 7:
        details["error at (5, 7)"] = float(error[5, 7])
    bar = 1e-13 * (1 + abs(float(error[worst])))
    return Finding(float(stated[worst]), float(true[worst]), bar, details)


_MOST_CELLS = 10_000


@experiment("active-set", "share of the patch in geometric overlap")
def active_set(
    effort: str,
    *,
    share: Annotated[float, Field(gt=0, le=1)] = 0.1,
    start: Literal["overlap", "random", "summit"] = "overlap",
    rounds: Positive = 7,
    surface: Surface = Surface(32),
    runs: Count = 200,
    limit: float = 1e-12,
) -> Share:
    """Rough patches on which the iteration of (19.5)-(19.8) does not end properly.

    A patch is pressed until its geometric overlap covers the fraction `share`. Convergence means no
    tension (guaranteed by the dense solver) and a largest overlap below `limit` times the
    penetration, within `rounds` rounds and without the solver's fallback to single changes, which
    the chapter lacks.
    """
    if share * surface.points**2 > _MOST_CELLS:
        raise ValueError(
            f"points {surface.points}: the matrix of more than {_MOST_CELLS} cells is too large"
        )
    count = number_of(runs, effort, 100)
    operator = surface.operator()
    assert isinstance(operator, FreeOperator)
    rng = np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(3,)))
    # rounds and relative overlap of every patch, infinite without convergence
    lengths, violations = np.empty(count), np.full(count, np.inf)
    for k in range(count):
        heights = surface.heights(k)
        gap = heights.max() - heights
        depth = float(np.quantile(gap, share)) + np.finfo(float).tiny
        begin = None
        if start != "overlap":  # "to begin, a contact area is assumed"
            area = gap == gap.min()
            if start == "random":
                area |= (gap < depth) & (rng.random(gap.shape) < 0.5)
            begin = assemble(operator, gap, area.astype(float), depth, 0, [])
        try:
            contact = press(operator, gap, Load("penetration", depth), start=begin, by="pivot")
            lengths[k], violations[k] = contact.iterations, contact.violation
        except ConvergenceError as fault:
            lengths[k] = len(fault.history)
    failed = (lengths > rounds) | (violations > limit)
    details = {
        "runs": float(count),
        "failures": float(failed.sum()),
        "rounds, median": float(np.median(lengths)),
        "rounds, most": float(lengths.max()),
        "overlap over penetration, largest": float(min(violations.max(), 1.0)),
    }
    return share_of(int(failed.sum()), count, details)


Array = NDArray[np.float64]

QUANTITIES = ("contact_area", "penetration", "mean_gap", "stiffness")
POINTS, FACTORS = 16, (1, 2, 4)
# What is drawn: Hurst exponents, cells to the shortest wave, long waves to a side, Poisson's
# ratios, loads over E* A0 h'.
HURST, CUTOFFS, ROLL_OFFS = (0.3, 0.9), (2.0, 4.0), (1.0, 3.0)
RATIOS, LOADS = (0.0, 0.2, 0.3, 0.45, 0.5), (0.002, 0.2)
FEW = 60


@dataclass(frozen=True)
class TwoTruths:
    """A rough contact on several grids by both solvers, under one force."""

    resolutions: tuple[int, ...]  # points a side
    elements: dict[str, Array]  # values of every quantity on these grids
    half_space: dict[str, Array]
    periodic: bool
    pressure: float  # relative difference of the pressures on the finest grid, in the L2 norm
    # What it was between the finest grid and the one before, of elements and half-space; means over
    # the coarser cells.
    pressure_changes: tuple[float, float]
    # Processor time on the finest grid: set-up of the elements, elements, half-space.
    seconds: tuple[float, float, float]

    def difference(self, quantity: str) -> float:
        """Return the value of the elements over that of the half-space, less one; finest grid."""
        return float(self.elements[quantity][-1] / self.half_space[quantity][-1] - 1)

    def bar(self, quantity: str) -> float:
        """Return the combined bar of both."""
        kinds: tuple[Kind, Kind] = ("free", "periodic" if self.periodic else "free")
        grids = np.array(self.resolutions)
        bars = (
            share_uncertainty(grids, values[quantity][:, None], (quantity, kind))
            for values, kind in zip((self.elements, self.half_space), kinds, strict=True)
        )
        return float(combined(*bars)[0])


def two_truths(
    maps: Sequence[Array],
    size: tuple[float, float],
    material: Material,
    force: float,
    *,
    periodic: bool,
    element: Element = "splines",
) -> TwoTruths:
    """Press one surface, given on finer and finer grids, on elements and on the half-space."""
    top = max(float(heights.max()) for heights in maps)
    modulus = material.youngs_modulus / (1 - material.poisson_ratio**2)
    solved: tuple[list[Contact], list[Contact]] = [], []
    for heights in maps:
        shape = heights.shape
        spacing = size[0] / shape[0], size[1] / shape[1]
        kinds = (PeriodicBody, PeriodicOperator) if periodic else (FreeBody, FreeOperator)
        bodies = kinds[0](shape, spacing, material, element), kinds[1](shape, spacing, modulus)
        times = [time.process_time()]
        bodies[0].convolution(np.float64)
        times.append(time.process_time())
        for contacts, body in zip(solved, bodies, strict=True):
            contacts.append(press(body, top - heights, Load("force", force)))
            times.append(time.process_time())
    elements, half_space = (
        {
            "contact_area": np.array([located_area(c, patch=True) for c in contacts]),
            "penetration": np.array([c.penetration for c in contacts]),
            "mean_gap": np.array([c.mean_gap for c in contacts]),
            "stiffness": np.array([areas.contact_stiffness(c.operator, c.mask) for c in contacts]),
        }
        for contacts in solved
    )
    pressures = [[contact.pressure for contact in contacts] for contacts in solved]
    return TwoTruths(
        tuple(len(heights) for heights in maps),
        elements,
        half_space,
        periodic,
        _apart(pressures[0][-1], pressures[1][-1]),
        (_change(pressures[0]), _change(pressures[1])),
        (times[1] - times[0], times[2] - times[1], times[3] - times[2]),
    )


def _apart(first: Array, second: Array) -> float:
    return float(np.linalg.norm(first - second) / np.linalg.norm(second))


def _change(pressures: list[Array]) -> float:
    """Return by how much the last grid changed the pressure; NaN for one grid."""
    if len(pressures) < 2:
        return float("nan")
    coarse, fine = pressures[-2:]
    rows, columns = coarse.shape
    means = fine.reshape(rows, len(fine) // rows, columns, -1).mean(axis=(1, 3))
    return _apart(coarse, means)


@lru_cache(maxsize=4)
def drawn(runs: int, element: Element = "splines") -> tuple[TwoTruths, ...]:
    """Return contacts of random surfaces, periodic and free in turn, with a fixed seed."""
    rng = np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(15,)))
    results = []
    for run in range(runs):
        hurst, shortest, roll_off = (float(rng.uniform(*r)) for r in (HURST, CUTOFFS, ROLL_OFFS))
        surface = Surface(POINTS, hurst, roll_off, shortest, run % 2 == 0)
        nu = float(rng.choice(RATIOS))
        load = float(np.exp(rng.uniform(*np.log(LOADS))))
        maps = [surface.heights(run, factor) for factor in FACTORS]
        material = Material(1 - nu**2, nu)
        periodic = surface.periodic
        results.append(
            two_truths(maps, (1.0, 1.0), material, load, periodic=periodic, element=element)
        )
    return tuple(results)


@experiment("second-truth", "number of contacts")
def second_truth(
    effort: str,
    *,
    runs: Count = 200,
    quantity: Annotated[str, one_of(*QUANTITIES)] = "contact_area",
) -> Share:
    """Share of random rough contacts on which elements and half-space differ beyond both bars."""
    count = number_of(runs, effort, FEW)
    cases = drawn(count)
    ratios = np.array([abs(case.difference(quantity)) / case.bar(quantity) for case in cases])
    differences = np.abs([case.difference(quantity) for case in cases])
    details = {
        "contacts": float(count),
        "difference, median": float(np.median(differences)),
        "difference, largest": float(differences.max()),
        "difference over both bars, median": float(np.median(ratios)),
        "difference over both bars, largest": float(ratios.max()),
    }
    return share_of(int((ratios > 1).sum()), count, details)
