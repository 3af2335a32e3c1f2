"""Power spectra of surfaces, measured or prescribed: the input of the rules for lines.

A surface is h(x) = sum_q B2D(q) exp(i (q x + phi)) over all modes of its rectangle (19.22), with
C2D = Lx Ly/(2 pi)^2 |B2D|^2 (19.23), so that <h^2> = sum |B2D|^2.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import ArrayLike

from reduced.errors import count_faults, positive_faults, refuse

# Relative rounding of |q| L/(2 pi): modes this close to a limit count as on it. Sides come from
# files, some in single precision (6e-8). On a square the modes next to a limit k + 1/2 are 1/(8 k)
# away from it, which exceeds this up to ring 1100.
ROUNDING = 1e-7


@dataclass(frozen=True)
class RadialAverage:
    """C2D over circles: mean and number of the modes by ring, shape (m,).

    Ring k = 1 ... m holds the modes nearest to q_k = 2 pi k/L, L the longer side; those midway
    between two rings count half in both. The density of an empty ring is 0.
    """

    wavenumber: np.ndarray
    density: np.ndarray
    count: np.ndarray


class Spectrum(ABC):
    """Root mean squares of what has a spectrum; those of the line equal those of the surface."""

    @abstractmethod
    def mean_square(self, order: int) -> float:
        """Sum of q^(2 order) times the power of all modes."""

    @property
    def rms_height(self) -> float:
        """sqrt<h^2>."""
        return math.sqrt(self.mean_square(0))

    @property
    def rms_slope(self) -> float:
        """sqrt<h'^2> of a line, of a surface sqrt<|grad h|^2>, of the full gradient."""
        return math.sqrt(self.mean_square(1))

    @property
    def rms_curvature(self) -> float:
        """sqrt<h''^2> of a line, of a surface sqrt<(lap h)^2>."""
        return math.sqrt(self.mean_square(2))


@dataclass(frozen=True)
class SurfaceSpectrum(Spectrum):
    """Two-dimensional power spectrum on sides Lx, Ly.

    `power` is |B2D|^2 of every mode, (nx, ny), in the order of the FFT; zero for the mean.
    """

    power: np.ndarray
    size: tuple[float, float]

    @property
    def length(self) -> float:
        """Longer side L."""
        return max(self.size)

    @property
    def magnitude(self) -> np.ndarray:
        """|q| of every mode."""
        pairs = zip(self.power.shape, self.size, strict=True)
        qx, qy = (2 * np.pi * np.fft.fftfreq(n, side / n) for n, side in pairs)
        return np.hypot(qx[:, None], qy)

    @property
    def density(self) -> np.ndarray:
        """C2D(q) = Lx Ly/(2 pi)^2 |B2D|^2 of every mode (19.23)."""
        return self.size[0] * self.size[1] / (4 * np.pi**2) * self.power

    @property
    def cell(self) -> float:
        """Side of a cell of the map, the longer one."""
        return max(side / n for side, n in zip(self.size, self.power.shape, strict=True))

    @property
    def whole_rings(self) -> int:
        """Number of complete rings, below the Nyquist wavenumber of the coarser direction."""
        pairs = zip(self.power.shape, self.size, strict=True)
        ends = (n / 2 * self.length / side * (1 - ROUNDING) for n, side in pairs)
        return min(int(np.ceil(end)) for end in ends) - 1

    @property
    def place(self) -> np.ndarray:
        """|q| L/(2 pi) of every mode: its position among the rings 1, 2, ... of the longer side."""
        return self.magnitude * (self.length / (2 * np.pi))

    @property
    def rings(self) -> np.ndarray:
        """Two rings per mode, (2, nx ny), in which it counts half; usually both are the nearest.

        Modes midway, to `ROUNDING`, belong to both. They occur if the ratio of the sides is odd to
        even (at 3 : 2 every odd wave along the shorter side), but not on a square, where (|q| L/2
        pi)^2 is an integer.
        """
        place = self.place.ravel()
        below = np.floor(place)
        midway = np.abs(place - below - 0.5) <= ROUNDING * place
        inner = np.where(midway, below, np.rint(place)).astype(np.int64)
        return np.stack([inner, inner + midway])

    def ring_sums(self, values: np.ndarray) -> np.ndarray:
        """Return sums of values (nx ny,) over rings 0, 1, 2, ..."""
        inner, outer = self.rings
        count, values = int(outer.max()) + 1, values.ravel()
        return 0.5 * (np.bincount(inner, values, count) + np.bincount(outer, values, count))

    def radial_average(self) -> RadialAverage:
        """Return C2D averaged over rings of width 2 pi/L (step 3 of the chapter's Problem 1).

        >>> h = np.cos(2 * np.pi * np.arange(8) / 8)[:, None] * np.ones(8)
        >>> average = measured(h, 1.0, periodic=True).radial_average()
        >>> average.count[:2]  # (1, 0) and (1, 1) with their signs; then (2, 0), (2, 1)
        array([ 8., 12.])
        """
        density = self.density.ravel()
        count = self.ring_sums(np.ones_like(density))
        mean = self.ring_sums(density) / np.maximum(count, 0.5)
        wavenumber = 2 * np.pi / self.length * np.arange(1, count.size)
        return RadialAverage(wavenumber, mean[1:], count[1:])

    def mean_square(self, order: int) -> float:
        """Sum over all modes."""
        return float(np.sum(self.magnitude ** (2 * order) * self.power))


def measured(
    height: np.ndarray, size: float | tuple[float, float], periodic: bool = False
) -> SurfaceSpectrum:
    """Return the power spectrum of a height map (nx, ny) without its mean.

    Pixels need not be square. A map that is not periodic (a measured one) gets a Hann window in
    both directions, without the windowed mean and rescaled to the <h^2> of the map, so that the
    jump between opposite sides does not fill the spectrum.
    """
    h = np.asarray(height, dtype=float)
    sides = _pair(size, "size")
    wrong = positive_faults(size=sides[0]) or positive_faults(size=sides[1])
    if h.ndim != 2 or min(h.shape) < 2:
        wrong.append(f"height must be a 2-D map of at least 2 x 2 points, got shape {h.shape}")
    elif not np.all(np.isfinite(h)):
        wrong.append("height must be finite: fill undefined points first")
    refuse(wrong)
    h = h - h.mean()
    if not periodic:
        # Hann window, without mean, rescaled to the map's mean square
        x, y = (np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 for n in h.shape)
        window = x[:, None] * y
        windowed = window * (h - np.sum(window * h) / np.sum(window))
        mean_square = np.mean(windowed**2)
        h = windowed * np.sqrt(np.mean(h**2) / mean_square) if mean_square > 0 else windowed
    power = np.abs(scipy.fft.fft2(h, norm="forward")) ** 2
    power[0, 0] = 0.0
    return SurfaceSpectrum(power, sides)


@dataclass(frozen=True)
class SelfAffineLaw:
    """Self-affine roughness: C2D ~ q^-power for q_l <= q <= q_s, a plateau below q_l.

    q_l = 2 pi/long_cutoff and q_s = 2 pi/short_cutoff; C2D is zero beyond q_s. Cutoffs are circles
    in q, and modes on a circle are kept. By default the power law extends to the longest mode, and
    to two cells (of the coarser direction). Exactly one of `hurst`, H in [0, 1] with power = 2 (1 +
    H), and `power` is given, and one of `rms_slope`, of the full gradient, and `rms_height`.
    """

    hurst: float | None = None
    power: float | None = None
    rms_slope: float | None = None
    rms_height: float | None = None
    long_cutoff: float | None = None
    short_cutoff: float | None = None

    def __post_init__(self) -> None:
        wrong = []
        for name, alternative in (("hurst", "power"), ("rms_slope", "rms_height")):
            values = getattr(self, name), getattr(self, alternative)
            if (values[0] is None) == (values[1] is None):
                wrong.append(
                    f"give exactly one of {name} and {alternative}, "
                    f"got {values[0]!r} and {values[1]!r}"
                )
        if self.hurst is not None and not 0 <= self.hurst <= 1:
            wrong.append(f"hurst must lie in [0, 1], got {self.hurst!r}")
        names = ("rms_slope", "rms_height", "long_cutoff", "short_cutoff")
        amplitudes = {name: getattr(self, name) for name in names}
        wrong += positive_faults(**{k: v for k, v in amplitudes.items() if v is not None})
        if self.power is not None and not np.isfinite(self.power):
            wrong.append(f"power must be finite, got {self.power!r}")
        refuse(wrong)

    def law(self, cell: float) -> Callable[[np.ndarray], np.ndarray]:
        """Return the power law as a function of q, up to a factor; for cells of this side."""
        if self.hurst is not None:
            exponent = 2 * (1 + float(self.hurst))
        else:
            exponent = float(self.power if self.power is not None else np.nan)
        low = 2 * np.pi / self.long_cutoff if self.long_cutoff else 0.0
        high = 2 * np.pi / (self.short_cutoff or 2 * cell)

        def law(q: np.ndarray) -> np.ndarray:
            # The circle belongs to the spectrum, independent of the rounding of |q|.
            resolved = (q > 0) & (q <= high * (1 + 1e-10))
            rise = np.maximum(np.where(resolved, q, high), low) / high
            return np.where(resolved, rise**-exponent, 0.0)

        return law


def self_affine(
    points: int | tuple[int, int], size: float | tuple[float, float], roughness: SelfAffineLaw
) -> SurfaceSpectrum:
    """Return the spectrum of a synthetic self-affine surface, with zero Nyquist modes.

    The rms slope is that of the full gradient summed over the modes of the surface.
    """
    shape, sides = _pair(points, "points"), _pair(size, "size")
    wrong = [fault for n in dict.fromkeys(shape) for fault in count_faults(2, points=n)]
    wrong += [fault for side in dict.fromkeys(sides) for fault in positive_faults(size=side)]
    refuse(wrong)
    shape = int(shape[0]), int(shape[1])
    empty = SurfaceSpectrum(np.zeros(shape), sides)
    magnitude = empty.magnitude
    square = roughness.law(empty.cell)(magnitude)
    for axis, n in enumerate(shape):
        if n % 2 == 0:
            square[(slice(None),) * axis + (n // 2,)] = 0.0
    target, weight = roughness.rms_height, np.ones(())
    if target is None:
        target, weight = roughness.rms_slope or 0.0, magnitude**2
    total = float(np.sum(weight * square))
    if not total > 0:
        cutoffs = f"{roughness.long_cutoff!r} and {roughness.short_cutoff!r}"
        raise ValueError(f"no mode lies between the cutoffs {cutoffs}")
    return SurfaceSpectrum(target**2 / total * square, sides)


def _pair(value: ArrayLike, name: str) -> tuple:
    """Return a pair from a number or a pair."""
    if np.shape(value) not in ((), (1,), (2,)):
        raise ValueError(f"{name} must be one number or two, got {value!r}")
    return tuple(np.broadcast_to(np.asarray(value), 2).tolist())
