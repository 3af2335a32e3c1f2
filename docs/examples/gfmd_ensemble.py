"""The ensemble of Xu, Zhou, Mueser et al. (2024) by FFT BEM: mean gap and area at their loads.

    python docs/examples/gfmd_ensemble.py [surfaces] [roll-offs]

E* = 1; waves of 1e4 to 1e6 /m, C(q) = C0 q^(-2 - 2H), H = 0.8, rms height 6 um over the ensemble.
Some 10 s for a surface of four roll-offs on the coarser grid, 40 s on the finer one.
"""

from __future__ import annotations

import sys

import numpy as np
from scipy import fft as transforms

from reference import surfaces
from reference.halfspace import PeriodicOperator, fft
from reference.halfspace.areas import raw_area
from reference.halfspace.contact_line import located_area
from reference.halfspace.solution import Press
from reference.loads import Load

LONGEST, SHORTEST, HURST, RMS = 1e4, 1e6, 0.8, 6e-6
# Two points and a half to the shortest wave on the coarser grid, twice as many on the finer one.
POINTS_PER_ROLL_OFF, FACTORS = 240, (1, 2)
PRESSURES = np.array([1e-4, 0.001, 0.005, 0.010, 0.025])
GAP = np.array([2.629, 1.883, 1.181, 0.8540, 0.4398])
FINEST = np.array([0.000826, 0.007822, 0.037911, 0.074426, 0.177695])
TABULATED = np.array([0.000861, 0.008272, 0.039935, 0.077927, 0.185244])


def heights(roll_offs: int, number: int) -> np.ndarray:
    """Return a surface: amplitudes fixed, phases random; of the waves on the rim q0 one half."""
    points, side = POINTS_PER_ROLL_OFF * roll_offs, roll_offs * 2 * np.pi / LONGEST
    wave = 2 * np.pi * transforms.fftfreq(points, side / points)
    q = np.maximum(np.hypot(wave[:, None], wave), LONGEST / 1e3)
    exponent = 2 * HURST
    density = RMS**2 * exponent / (2 * np.pi * (LONGEST**-exponent - SHORTEST**-exponent))
    amplitude = np.sqrt(density) * q ** (-1 - HURST) * 2 * np.pi / side
    amplitude[(q < LONGEST * (1 - 1e-9)) | (q > SHORTEST)] = 0
    amplitude[np.isclose(q, LONGEST)] *= np.sqrt(0.5)
    noise = np.random.default_rng([1, number]).standard_normal((points, points))
    phases = transforms.fft2(noise)
    return transforms.ifft2(amplitude * phases / np.abs(phases)).real * points**2


def pressed(surface: np.ndarray, side: float) -> np.ndarray:
    """Return mean gap over rms height, counted and located area over A0, (3, loads)."""
    spacing = (side / len(surface),) * 2
    operator = PeriodicOperator(surface.shape, spacing, 1.0)
    contacts = fft.sweep(
        Press(operator, surface.max() - surface), Load("force", PRESSURES * side**2)
    )
    rows = [
        (
            c.mean_gap / surface.std(),
            raw_area(c.pressure > 0, spacing) / side**2,
            located_area(c) / side**2,
        )
        for c in contacts
    ]
    return np.array(rows).T


def main() -> None:
    """Print the differences from the published values, in per cent, with standard errors."""
    count, roll_offs = (int(text) for text in (*sys.argv[1:], "4", "4")[:2])
    side = roll_offs * 2 * np.pi / LONGEST
    for factor in FACTORS:
        values = np.array(
            [pressed(surfaces.subdivide(heights(roll_offs, k), factor), side) for k in range(count)]
        )
        mean, error = values.mean(axis=0), values.std(axis=0, ddof=1) / np.sqrt(count)
        print(
            f"{count} surfaces, {2.4 * factor:.1f} points to the shortest wave, loads {PRESSURES}"
        )
        named = {"gap": (0, GAP), "counted area / tabulated": (1, TABULATED)}
        for name, (row, known) in (named | {"located area / finest": (2, FINEST)}).items():
            parts = zip(100 * (mean[row] / known - 1), 100 * error[row] / known, strict=True)
            print(f"  {name}: {', '.join(f'{e:+.1f} +- {s:.1f}' for e, s in parts)} %")


if __name__ == "__main__":
    main()
