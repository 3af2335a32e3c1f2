"""The ensemble that others solved and tabulated: Xu, Zhou, Müser et al. (2024), by GFMD.

Green's function molecular dynamics of periodic rough surfaces: E* = 1, waves of 1e4 to 1e6 /m with
C(q) = C0 q^(-2 - 2H), H = 0.8, rms height 6 um; no plateau. Mean gap and area at five pressures.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from scipy import fft as transforms

from comparisons.judging.uncertainty import combined, ratio_of_means, share_uncertainty
from comparisons.questions.experiments.experiment import Above, Finding, OneOf, experiment
from comparisons.questions.experiments.rough_ensemble import SEED, compare
from comparisons.solving.shared import shared
from reference import surfaces
from reference.contact.press import sweep
from reference.halfspace import PeriodicOperator
from reference.halfspace.areas import located_area
from reference.loads import Load

Array = np.ndarray

LONGEST, SHORTEST, HURST, RMS = 1e4, 1e6, 0.8, 6e-6
# 2.4 points to the shortest wave on the coarsest grid.
POINTS_PER_ROLL_OFF, FACTORS = 240, (1, 2, 4)
PRESSURES = (1e-4, 0.001, 0.005, 0.010, 0.025)
# Mean gap over rms height, area over A0 on their finest set, and the area of their table.
PUBLISHED = {
    "mean_gap": (2.629, 1.883, 1.181, 0.8540, 0.4398),
    "area_finest": (0.000826, 0.007822, 0.037911, 0.074426, 0.177695),
    "area_tabulated": (0.000861, 0.008272, 0.039935, 0.077927, 0.185244),
}


def heights(roll_offs: int, number: int) -> np.ndarray:
    """Return a surface: amplitudes fixed, phases random; of the waves on the rim q0 one half.

    The sum over modes stands for an integral over |q| > q0: half the cell of a mode on the rim
    lies outside.
    """
    points, side = POINTS_PER_ROLL_OFF * roll_offs, _side(roll_offs)
    wave = 2 * np.pi * transforms.fftfreq(points, side / points)
    q = np.maximum(np.hypot(wave[:, None], wave), LONGEST / 1e3)
    exponent = 2 * HURST
    density = RMS**2 * exponent / (2 * np.pi * (LONGEST**-exponent - SHORTEST**-exponent))
    amplitude = np.sqrt(density) * q ** (-1 - HURST) * 2 * np.pi / side
    amplitude[(q < LONGEST * (1 - 1e-9)) | (q > SHORTEST)] = 0
    amplitude[np.isclose(q, LONGEST)] *= np.sqrt(0.5)
    noise = np.random.default_rng([SEED, number]).standard_normal((points, points))
    phases = transforms.fft2(noise)
    return np.asarray(transforms.ifft2(amplitude * phases / np.abs(phases)).real * points**2)


def _side(roll_offs: int) -> float:
    return roll_offs * 2 * np.pi / LONGEST


def _pressed(surface: np.ndarray, side: float) -> np.ndarray:
    """Return mean gap over rms height and located area over A0 at all pressures, (2, pressures)."""
    spacing = (side / len(surface),) * 2
    operator = PeriodicOperator(surface.shape, spacing, 1.0)
    load = Load("force", np.array(PRESSURES) * side**2)
    contacts = sweep(operator, surface.max() - surface, load)
    rows = [(c.mean_gap / surface.std(), located_area(c) / side**2) for c in contacts]
    return np.array(rows).T


@shared(maxsize=8)
def _solved(roll_offs: int, factor: int, count: int) -> np.ndarray:
    """Return what `_pressed` gives on grids so many times finer, (surfaces, 2, pressures)."""
    drawn = (surfaces.subdivide(heights(roll_offs, k), factor) for k in range(count))
    return np.array([_pressed(surface, _side(roll_offs)) for surface in drawn])


@experiment(
    "published-ensemble",
    "Mean gap and area that Xu, Zhou, Müser et al. (2024) publish, against our own surfaces",
    "row",
    "row of their table, from the lightest load",
)
def published_ensemble(
    effort: str,
    *,
    row: float = 1,
    quantity: Annotated[str, OneOf(*PUBLISHED)] = "mean_gap",
    roll_offs: Annotated[float, Above(1)] = 4,
    realisations: Annotated[float, Above(3)] = 8,
) -> Finding:
    """Compare one published value with the mean over surfaces of our own.

    The means are those of patches of several roll-offs on the coarsest grid, scaled by what finer
    grids change on patches of one. Quick effort: half the side, half as many, two grids for three.
    """
    if row not in range(1, len(PRESSURES) + 1):
        raise ValueError(f"row must be a whole number from 1 to {len(PRESSURES)}, not {row!r}")
    step, full = int(row) - 1, effort == "full"
    share = 1 if full else 2
    side, count = int(roll_offs) // share, int(realisations) // share
    index, kind = (0, "mean_gap") if quantity == "mean_gap" else (1, "contact_area")
    factors = FACTORS if full else FACTORS[:2]
    # Finest over coarsest grid, and the grids' 95 % bar, both (pressures,), on small patches: what
    # a finer grid changes is local, and scatters less than the values.
    levels = [_solved(1, factor, 6 if full else 4)[:, index] for factor in factors]
    ratio, scatter = ratio_of_means(levels[-1], levels[0], paired=True)
    means = np.array([level.mean(axis=0) for level in levels])
    grid = combined(scatter, share_uncertainty(np.array(factors), means, (kind, "periodic")))
    values = _solved(side, FACTORS[0], count)[:, index, step] * ratio[step]
    details: dict[str, float | str] = {
        "p/E*": PRESSURES[step],
        "surfaces": float(count),
        "roll-offs a side": float(side),
    }
    return compare([PUBLISHED[quantity][step]], values, float(grid[step]), details)
