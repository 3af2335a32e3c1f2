"""Problem 1 from a measured map, or a spectrum, to the friction of rubber over speed."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from reduced.arguments import count_faults, positive_faults, refuse
from reduced.memory.materials import Prony
from reduced.rough.ensemble import Ensemble, lines
from reduced.rough.line_spectrum import LineSpectrum, SumRules, line_of, sum_rules
from reduced.rough.surface_spectrum import measured
from reduced.rubber.printed import PrintedSliding, slide_as_printed
from reduced.rubber.steady import SteadySliding, slide

QUANTITIES = (
    "friction_coefficient",
    "tangential_force",
    "penetration",
    "contact_area",
    "contact_length",
    "contact_count",
    "energy_error",
)


def friction(
    spectrum: LineSpectrum,
    points: int,
    realisations: int,
    material: Prony,
    speed: Sequence[float] | np.ndarray,
    force: float | Sequence[float] | np.ndarray,
    *,
    length: float | None = None,
    seed: int = 0,
    workers: int = 1,
) -> Ensemble:
    """Steady friction of many rough lines over speed, steps 5 to 14 of Problem 1 as corrected.

    Parameters
    ----------
    spectrum : LineSpectrum
        Amplitudes, see `line_spectrum`.
    points, realisations : int
        Points of each line, and number of lines m.
    material, speed, force
        As for `steady.slide`; the force is on each line.
    length, seed : float, int
        As for `ensemble.press_ensemble`: line k is the same line there.
    workers : int
        Threads.

    Returns
    -------
    Ensemble
        ``["friction_coefficient"]`` has mean, standard error and quantiles over the lines by speed.

    Raises
    ------
    ValueError
        If an argument is out of range.
    ConvergenceError
        If a force could not be met.

    Examples
    --------
    >>> from reduced.rough.line_spectrum import prescribed
    >>> from reduced.memory.materials import kelvin_voigt
    >>> line = prescribed(64, 1.0, hurst=0.8, rms_slope=0.1)
    >>> found = friction(line, 256, 10, kelvin_voigt(1.0, 1.0), [1e-5, 1e-4], 1e-3)
    >>> mean = found["friction_coefficient"].mean
    >>> bool(abs(mean[1] / mean[0] - 10) < 0.1)  # proportional to the speed while it is slow
    True
    """
    refuse(count_faults(realisations=realisations, workers=workers))
    period = spectrum.length if length is None else length

    def one(k: int) -> SteadySliding:
        heights = lines(spectrum, points, [k], seed=seed, length=length)
        return slide(heights, period / points, material, speed, force)

    with ThreadPoolExecutor(workers) as pool:
        found = list(pool.map(one, range(realisations)))
    samples = {name: np.concatenate([getattr(f, name) for f in found]) for name in QUANTITIES}
    return Ensemble(samples, np.array([0.05, 0.25, 0.5, 0.75, 0.95]))


@dataclass(frozen=True)
class MapFriction:
    """Friction of a rubber on a measured surface; k speeds.

    Attributes
    ----------
    speed : ndarray, shape (k,)
    line : LineSpectrum
        Step 4.
    sums : SumRules
        Step 6: rms height, slope and curvature of surface and line.
    ensemble : Ensemble
        All lines: friction coefficient with its standard error, contact area, ...
    """

    speed: np.ndarray
    line: LineSpectrum
    sums: SumRules
    ensemble: Ensemble


def friction_of_map(
    height: np.ndarray,
    size: float | tuple[float, float],
    material: Prony,
    speed: Sequence[float] | np.ndarray,
    force: float,
    *,
    realisations: int = 100,
    refinement: int = 8,
    periodic: bool = False,
    seed: int = 0,
    workers: int = 1,
) -> MapFriction:
    """Problem 1 as corrected, from a prepared map to mu(v): steps 2 to 14.

    The line is as long as the map's longer side and carries the force of the map. Isotropic
    roughness is assumed by (19.26); the line's slope is that of the full gradient, sqrt 2 times
    that of a cut along the sliding direction.

    Parameters
    ----------
    height, size, realisations, periodic, seed, workers
        As for `procedure.calculate`.
    material : Prony
        Rubber.
    speed : array_like, shape (k,)
    force : float
        On the map.
    refinement : int
        Points of the line per point of the map's longer side.

    Returns
    -------
    MapFriction

    Raises
    ------
    ValueError
        If an argument is out of range, or the map is level.
    ConvergenceError
        If a force could not be met.
    """
    refuse(count_faults(refinement=refinement) + positive_faults(force=force))
    surface = measured(height, size, periodic)
    line = line_of(surface)
    if not np.any(line.power > 0):
        raise ValueError("the map is level: it has no power to make a line of")
    points = max(
        refinement * max(surface.power.shape), 2 * int(np.flatnonzero(line.power)[-1] + 1) + 2
    )
    found = friction(line, points, realisations, material, speed, force, seed=seed, workers=workers)
    return MapFriction(np.atleast_1d(speed), line, sum_rules(surface, line), found)


def printed_friction_of_map(
    height: np.ndarray,
    size: float | tuple[float, float],
    shear_modulus: float,
    viscosity: float,
    speed: float,
    force: float,
    *,
    realisations: int = 100,
    steps: int | None = None,
    periodic: bool = False,
    seed: int = 0,
) -> list[PrintedSliding]:
    """Problem 1 as printed, from a prepared map: all steps by the letter, one result per line.

    C1D = pi q C2D of ring averages (19.26) sampled at the modes, lines on the map's own spacing,
    3 rms of distance in the beginning, and four periods unless `steps` says otherwise. Arguments
    as for `friction_of_map`.
    """
    refuse(count_faults(realisations=realisations))
    surface = measured(height, size, periodic)
    line = line_of(surface, "printed")
    highest = int(np.flatnonzero(line.power > 0)[-1]) + 1
    points = max(*surface.power.shape, 2 * highest + 1)
    return [
        slide_as_printed(
            *(heights, line.length / points, shear_modulus, viscosity, speed, force),
            steps=4 * points if steps is None else steps,
        )
        for heights in lines(line, points, range(realisations), seed=seed)
    ]
