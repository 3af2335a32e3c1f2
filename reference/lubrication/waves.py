"""Rough balls: heights as a sum of waves, exact at every point of any grid."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse

Field = NDArray[np.float64]

# The shortest wave is one of the lattice whatever the unit of both lengths makes of their ratio.
_ROUNDED = 1e-12


@dataclass(frozen=True)
class Waves:
    """Heights sum a cos(k x + m y + phase), positive towards the other body.

    Parameters
    ----------
    heights, along, across, phases : ndarray, shape (n,)
        a, k, m (radians per length) and phases.

    Examples
    --------
    >>> float(waviness(1e-6, 1e-3).at(np.zeros((1, 1)), np.zeros((1, 1)))[0, 0])
    1e-06
    """

    heights: Field = field(repr=False)
    along: Field = field(repr=False)
    across: Field = field(repr=False)
    phases: Field = field(repr=False)

    @property
    def shortest(self) -> float:
        """The shortest wavelength."""
        return float(2 * np.pi / np.hypot(self.along, self.across).max())

    @property
    def even(self) -> bool:
        """Whether the heights are even in y."""
        return bool((self.across == 0).all() or ((self.along == 0) & (self.phases == 0)).all())

    def at(self, x: Field, y: Field) -> Field:
        """Return the heights on an open mesh: x of shape (nx, 1), y of shape (1, ny)."""
        along = self.heights * np.exp(1j * (np.outer(x, self.along) + self.phases))
        across = np.exp(1j * np.outer(self.across, y))
        return np.real(along @ across)


def waviness(amplitude: float, wavelength: float, crests: str = "across") -> Waves:
    """Return a single wave with a crest in the middle, across the flow (along y) or along it."""
    refuse(positive_faults(amplitude=amplitude, wavelength=wavelength))
    number = 2 * np.pi / wavelength
    along, across = (number, 0.0) if crests == "across" else (0.0, number)
    return Waves(*(np.array([v]) for v in (amplitude, along, across, 0.0)))


def self_affine(
    rms_height: float, hurst: float, longest: float, shortest: float, seed: int = 0
) -> Waves:
    """Return waves on a lattice of period `longest`, of height q^-(1 + H) and random phase."""
    refuse(positive_faults(rms_height=rms_height, longest=longest, shortest=shortest))
    ratio = longest / shortest * (1 + _ROUNDED)
    most = int(ratio)
    i, j = np.meshgrid(np.arange(0, most + 1), np.arange(-most, most + 1), indexing="ij")
    # one of each pair q, -q
    chosen = (i**2 + j**2 <= ratio**2) & ((i > 0) | (j > 0))
    i, j = i[chosen].astype(np.float64), j[chosen].astype(np.float64)
    refuse([] if i.size else [f"longest must be at least shortest = {shortest!r}, not {longest!r}"])
    heights = np.hypot(i, j) ** -(1 + hurst)
    heights *= rms_height / np.sqrt((heights**2).sum() / 2)
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, i.size)
    unit = 2 * np.pi / longest
    return Waves(heights, np.multiply(unit, i), np.multiply(unit, j), phases)


def faded(distance: Field) -> Field:
    """Return one up to l, falling smoothly to zero at 1.5 l, where the gap is wide.

    Farther out cells grow, and would not resolve the waves.
    """
    return 0.5 + 0.5 * np.cos(np.pi * np.clip(2 * distance - 2, 0, 1))
