"""Counted contact areas of free 64 x 64 patches (H = 0.8), by how the surfaces are made.

The tables of docs/half-space.md::

    python docs/examples/raw_areas.py --surfaces 4000
"""

# %%
import argparse
from collections.abc import Callable

import numpy as np

from reference import surfaces
from reference.contact.press import sweep
from reference.halfspace import FreeOperator
from reference.loads import Load

POINTS = 64
# Over E* A0 h'.
LOADS = np.array([0.0025, 0.005, 0.02, 0.2])
SPECTRUM = surfaces.SelfAffine(hurst=0.8, rms_slope=1.0)
OPERATOR = FreeOperator((POINTS, POINTS), (1 / POINTS, 1 / POINTS), 1.0)


def fixed_amplitudes(seed: int, number: int) -> np.ndarray:
    """Return a surface as in the suite: random phases alone."""
    return surfaces.self_affine(POINTS, 1.0, SPECTRUM, seed=seed, realisation=number)


def random_amplitudes(seed: int, number: int) -> np.ndarray:
    """Return a surface of a Gaussian process with the same spectrum: white noise, filtered."""
    white = np.random.default_rng((seed, number)).standard_normal((POINTS, POINTS))
    amplitudes = surfaces.amplitude_spectrum(POINTS, 1.0, SPECTRUM)
    modes = np.fft.rfft2(white) / POINTS * amplitudes[:, : POINTS // 2 + 1]
    return np.asarray(np.fft.irfft2(modes, s=(POINTS, POINTS), norm="forward"))


def counted(heights: np.ndarray) -> list[float]:
    """Return the share of loaded cells at every load."""
    contacts = sweep(OPERATOR, heights.max() - heights, Load("force", LOADS), tolerance=1e-6)
    return [float(np.mean(contact.pressure > 0)) for contact in contacts]


def row(name: str, make: Callable[[int, int], np.ndarray], seed: int, number: int) -> None:
    """Print mean and standard error of the areas."""
    areas = np.array([counted(make(seed, k)) for k in range(number)])
    means = areas.mean(axis=0)
    errors = areas.std(axis=0, ddof=1) / np.sqrt(number) / means
    texts = [f"{100 * m:.3f} ± {100 * e:.1f} %" for m, e in zip(means, errors, strict=True)]
    print("|", " | ".join([name, *texts]), "|", flush=True)


# %%
if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--surfaces", type=int, default=450)
    number = parser.parse_args().surfaces
    print("| surfaces |", " | ".join(f"{load:g}" for load in LOADS), "|")
    for seed in (1, 2):
        row(f"fixed amplitudes, seed {seed}", fixed_amplitudes, seed, number)
        row(f"random amplitudes, seed {seed}", random_amplitudes, seed, number)
