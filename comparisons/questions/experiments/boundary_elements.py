"""Boundary elements of the chapter: (19.3) against Love's, and the iteration (19.5)-(19.8)."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.judging.metrics import relative_error
from comparisons.questions.experiments.experiment import (
    Above,
    Finding,
    OneOf,
    Share,
    experiment,
    share_of,
)
from comparisons.questions.experiments.rough_ensemble import SEED, Surface
from reference.contact.press import assemble, press
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator, kernels
from reference.loads import Load

READINGS = ("letter", "bracket", "corrected")


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


@experiment(
    "influence-coefficient",
    "Influence coefficient (19.3) against Love's, over the offsets of a grid",
    "offset",
    "largest offset in cells",
)
def influence_coefficient(
    effort: str,
    *,
    offset: Annotated[int, Above(-1)] = 63,
    reading: Annotated[str, OneOf(*READINGS)] = "letter",
) -> Finding:
    """Measure the largest error for all pairs of cells up to `offset` apart in both directions.

    One quadrant suffices by symmetry. Love's coefficients are accurate to 1e-13
    (tests/reference/test_halfspace_kernels.py), which is the bar.
    """
    reach = np.arange(int(offset) + 1)
    i, j = np.meshgrid(reach, reach, indexing="ij")
    true = kernels.love(i, j, (1.0, 1.0), 1.0)
    stated = printed_kernel(i, j, reading)
    error = relative_error(stated, true)
    worst = np.unravel_index(np.argmax(np.abs(error)), error.shape)
    near = np.abs(error[: min(2, len(reach)), : min(2, len(reach))])
    details: dict[str, float | str] = {
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
STARTS = ("overlap", "random", "summit")


@experiment(
    "active-set",
    "Rough patches on which the iteration of (19.5)-(19.8) does not end properly",
    "share",
    "share of the patch in geometric overlap",
)
def active_set(
    effort: str,
    *,
    share: float = 0.1,
    start: Annotated[str, OneOf(*STARTS)] = "overlap",
    rounds: Annotated[float, Above(0)] = 7,
    points: float = 32,
    hurst: float = 0.8,
    runs: Annotated[float, Above(0)] = 200,
    limit: float = 1e-12,
) -> Share:
    """Measure the fraction of rough patches for which the iteration does not converge in `rounds`.

    A patch is pressed until its geometric overlap covers the fraction `share`. Convergence means no
    tension (guaranteed by the dense solver) and a largest overlap below `limit` times the
    penetration, within `rounds` rounds and without the solver's fallback to single changes, which
    the chapter lacks.
    """
    if not 0 < share <= 1:
        raise ValueError(f"share must lie in (0, 1], not {share!r}")
    if share * points**2 > _MOST_CELLS:
        raise ValueError(
            f"points {points!r}: the matrix of more than {_MOST_CELLS} cells is too large"
        )
    surface = Surface.of(points, hurst, 1.0, 2.0, False)
    count = int(runs) if effort == "full" else min(int(runs), 100)
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
    details: dict[str, float | str] = {
        "runs": float(count),
        "failures": float(failed.sum()),
        "rounds, median": float(np.median(lengths)),
        "rounds, most": float(lengths.max()),
        "overlap over penetration, largest": float(min(violations.max(), 1.0)),
    }
    return share_of(int(failed.sum()), count, details)
