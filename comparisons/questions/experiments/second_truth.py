"""Finite elements and half-space below the same rough surfaces: whether they agree."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from comparisons.judging.uncertainty import Kind, combined, share_uncertainty
from comparisons.questions.experiments.experiment import Above, OneOf, Share, experiment, share_of
from comparisons.questions.experiments.rough_ensemble import SEED, Surface
from reference.contact.press import press
from reference.fem import Material
from reference.fem.columns import Element
from reference.fem.grid_body import FreeBody, PeriodicBody
from reference.halfspace import Contact, FreeOperator, PeriodicOperator, areas
from reference.halfspace.areas import located_area
from reference.loads import Load

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
    """A rough contact on several grids by both solvers, under one force.

    Attributes
    ----------
    resolutions : tuple of int
        Points a side.
    elements, half_space : dict of ndarray
        Values of every quantity on these grids.
    periodic : bool
    pressure : float
        Relative difference of the pressures on the finest grid, in the L2 norm.
    pressure_changes : (float, float)
        What it was between the finest grid and the one before, of elements and half-space; means
        over the coarser cells.
    seconds : (float, float, float)
        Processor time on the finest grid: set-up of the elements, elements, half-space.
    """

    resolutions: tuple[int, ...]
    elements: dict[str, Array]
    half_space: dict[str, Array]
    periodic: bool
    pressure: float
    pressure_changes: tuple[float, float]
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
    elements, half_space = (_curves(contacts) for contacts in solved)
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


def _curves(contacts: list[Contact]) -> dict[str, Array]:
    rows = [
        {
            "contact_area": located_area(contact, patch=True),
            "penetration": contact.penetration,
            "mean_gap": contact.mean_gap,
            "stiffness": areas.contact_stiffness(contact.operator, contact.mask),
        }
        for contact in contacts
    ]
    return {name: np.array([row[name] for row in rows]) for name in QUANTITIES}


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
        surface = Surface.of(POINTS, hurst, roll_off, shortest, run % 2 == 0)
        nu = float(rng.choice(RATIOS))
        load = float(np.exp(rng.uniform(*np.log(LOADS))))
        maps = [surface.heights(run, factor) for factor in FACTORS]
        material = Material(1 - nu**2, nu)
        periodic = surface.periodic
        results.append(
            two_truths(maps, (1.0, 1.0), material, load, periodic=periodic, element=element)
        )
    return tuple(results)


@experiment(
    "second-truth",
    "Share of random rough contacts on which elements and half-space differ beyond both bars",
    "runs",
    "number of contacts",
)
def second_truth(
    effort: str,
    *,
    quantity: Annotated[str, OneOf(*QUANTITIES)] = "contact_area",
    runs: Annotated[float, Above(0)] = 200,
    element: Element = "splines",
) -> Share:
    """Measure the share of random rough contacts on which both differ by more than both bars."""
    count = int(runs) if effort == "full" else min(int(runs), FEW)
    cases = drawn(count, element)
    ratios = np.array([abs(case.difference(quantity)) / case.bar(quantity) for case in cases])
    differences = np.abs([case.difference(quantity) for case in cases])
    details: dict[str, float | str] = {
        "contacts": float(count),
        "difference, median": float(np.median(differences)),
        "difference, largest": float(differences.max()),
        "difference over both bars, median": float(np.median(ratios)),
        "difference over both bars, largest": float(ratios.max()),
    }
    return share_of(int((ratios > 1).sum()), count, details)
