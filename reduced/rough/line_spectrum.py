"""Power spectra of surfaces and of their equivalent rough lines.

Conventions of the chapter (19.22)-(19.25): a line is h(x) = sum_q B(q) exp(i (q x + phi)) over
positive and negative q, so <h^2> = 2 sum_k B_k^2 over the positive modes q_k = 2 pi k/L.

The rule of the chapter is C1D(q) = pi q C2D(q) (19.26). In the continuum it conserves <h^2>
((19.27) = (19.28)) and therefore <h'^2>_1D = <|grad h|^2> and <h''^2>_1D = <(laplacian h)^2>; the
chapter's footnote 7 speaks of the product of the principal curvatures, whose mean is zero. On a
finite surface it does not: C1D of a power law sampled at the modes increases the rms height by 4-10
%, and C2D averaged over rings, as in the chapter's Problem 1, decreases it as much. The sum over
rings of modes, B1D(k)^2 = (1/2) sum_ring |B2D|^2, conserves <h^2> exactly and is the default.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.fft

from reduced.errors import choice_faults, positive_faults, refuse
from reduced.rough.surface_spectrum import (
    ROUNDING,
    SelfAffineLaw,
    Spectrum,
    SurfaceSpectrum,
    self_affine,
)

RULES = ("rings", "split", "printed")


@dataclass(frozen=True)
class LineSpectrum(Spectrum):
    """Spectrum of a rough line of period L, positive modes only, arrays of shape (m,).

    `wavenumber` is q_k = 2 pi k/L, k = 1 ... m, and `power` B1D(q_k)^2, the squared amplitude of
    one mode of the pair +-q_k: <h^2> = 2 sum power.
    """

    wavenumber: np.ndarray
    power: np.ndarray
    length: float

    @property
    def density(self) -> np.ndarray:
        """C1D(q_k) = L/(2 pi) B1D^2 (19.25)."""
        return self.length / (2 * np.pi) * self.power

    def mean_square(self, order: int) -> float:
        """Sum over positive and negative modes."""
        return float(2 * np.sum(self.wavenumber ** (2 * order) * self.power))


@dataclass(frozen=True)
class SumRules:
    """Root mean squares of surface and line under a rule: height, slope, curvature, shape (3,).

    Slope and curvature of the surface are those of the full gradient and the Laplacian.
    """

    surface: np.ndarray
    line: np.ndarray

    @property
    def ratio(self) -> np.ndarray:
        """line/surface: one for conserved quantities; in the continuum all are."""
        return self.line / np.where(self.surface > 0, self.surface, 1.0)


def sum_rules(surface: SurfaceSpectrum, line: LineSpectrum) -> SumRules:
    """Compare the moments of a surface with those of a line made from it.

    >>> surface = self_affine(64, 1.0, SelfAffineLaw(hurst=0.8, rms_slope=0.1))
    >>> for rule in ("rings", "split", "printed"):
    ...     print(rule, np.round(sum_rules(surface, line_of(surface, rule)).ratio, 3))
    rings [1.    0.981 0.997]
    split [1.    1.    1.001]
    printed [0.919 0.967 0.98 ]
    """
    names = ("rms_height", "rms_slope", "rms_curvature")
    return SumRules(
        *(np.array([getattr(spectrum, n) for n in names]) for spectrum in (surface, line))
    )


def line_of(surface: SurfaceSpectrum, rule: str = "rings") -> LineSpectrum:
    """Return the line spectrum of a surface.

    - ``"rings"``: B1D(k)^2 = (1/2) sum over ring k of |B2D|^2, ring k containing the modes
      nearest to q_k = 2 pi k/L, modes midway between two rings counting half. <h^2> is
      conserved exactly, the slope up to the rounding of |q|.
    - ``"split"``: each mode is shared between its two neighbours k <= |q| L/2 pi < k + 1 so
      that <h^2> and <|grad h|^2> are both conserved exactly; the curvature is high by O(1/k^2).
      Not in the chapter.
    - ``"printed"``: C1D = pi q C2D (19.26) with the ring average of C2D (Problem 1, steps 3 and
      4), at the modes whose rings are complete. <h^2> is not conserved.

    The period is the longer side L, in whose rings no mode is lost; corner modes are included.
    """
    refuse(choice_faults("rule", rule, RULES))
    if rule == "printed":
        rings = surface.whole_rings
        density = surface.radial_average().density[:rings]
        return _sample_rule(density, np.arange(1, rings + 1), surface.length)
    if rule == "rings":
        power = surface.ring_sums(surface.power / 2)
    else:
        place, half = surface.place.ravel(), surface.power.ravel() / 2
        # Rounding must not move a mode at q_k to the cell below.
        below = np.maximum(np.floor(place * (1 + ROUNDING)), 1.0)
        share = np.clip((place - below) * (place + below) / (2 * below + 1), 0.0, 1.0)
        index, count = below.astype(np.int64), int(below.max()) + 2
        power = np.bincount(index, (1 - share) * half, count)
        power += np.bincount(index + 1, share * half, count)
    wavenumber = 2 * np.pi / surface.length * np.arange(1, power.size)
    return LineSpectrum(wavenumber, power[1:], surface.length)


def prescribed(
    points: int | tuple[int, int],
    size: float | tuple[float, float],
    roughness: SelfAffineLaw,
    rule: str = "rings",
) -> LineSpectrum:
    """Return the line spectrum of a synthetic self-affine surface from its parameters.

    The rms slope of the line differs from that of `surface_spectrum.self_affine` by the rounding to
    rings (2 % low for 64 points without roll-off, where mode (1, 1) counts as ring 1). Rules as of
    `line_of`, but C1D = pi q C2D is sampled from the power law.
    """
    refuse(choice_faults("rule", rule, RULES))
    surface = self_affine(points, size, roughness)
    if rule != "printed":
        return line_of(surface, rule)
    law = roughness.law(surface.cell)
    mode = np.arange(1, surface.whole_rings + 1)
    # The factor of the law, from the sum over all modes of the surface.
    variance = law(surface.magnitude)[surface.power > 0].sum()
    density = law(2 * np.pi / surface.length * mode) * (surface.density.sum() / variance)
    return _sample_rule(density, mode, surface.length)


def synthesise(
    spectrum: LineSpectrum,
    points: int | None = None,
    rng: np.random.Generator | Iterable[np.random.Generator] | None = None,
    length: float | None = None,
) -> np.ndarray:
    """Return realisations of a rough line: fixed amplitudes, random phases (19.24).

    Heights at x = j length/points, mean zero, (points,), or (lines, points) from several
    generators; the digits of a line do not depend on the others. There are more points than twice
    the highest mode with power; by default the smallest such even number with a fast transform. One
    uniform number is drawn per mode, lowest mode first, so that more points from an equal generator
    resolve the same line better. For a period other than that of the spectrum the density C1D is
    kept and integrated over the new modes, which also conserves <h^2> (on a shorter line except for
    the waves that do not fit).
    """
    if length is not None and length != spectrum.length:
        spectrum = resample(spectrum, length)
    carrying = np.flatnonzero(spectrum.power > 0)
    highest = int(carrying[-1]) + 1 if carrying.size else 0
    if points is None:
        points = 2 * scipy.fft.next_fast_len(highest + 1, real=True)
    if int(points) != points or points <= 2 * highest:
        raise ValueError(
            f"points must be an integer above {2 * highest} for mode {highest}, got {points!r}"
        )
    streams: Iterable[object] = rng if isinstance(rng, Iterable) else [rng]

    def drawn(stream: object) -> np.ndarray:
        if not isinstance(stream, np.random.Generator):
            raise ValueError(f"rng must be a numpy.random.Generator, got {stream!r}")
        return stream.uniform(0.0, 2 * np.pi, spectrum.power.size)

    phase = np.stack([drawn(stream) for stream in streams])
    modes = np.zeros((len(phase), points // 2 + 1), dtype=complex)
    waves = modes[:, 1 : highest + 1]
    np.multiply(phase[:, :highest], 1j, out=waves)
    np.exp(waves, out=waves)
    waves *= np.sqrt(spectrum.power[:highest])
    # SciPy transforms several lines side by side, NumPy one after the other: no digit of a line
    # depends on the others.
    heights = np.fft.irfft(modes, n=int(points), norm="forward")
    return heights if isinstance(rng, Iterable) else heights[0]


def resample(spectrum: LineSpectrum, length: float) -> LineSpectrum:
    """Return a spectrum with the same density C1D on a line of another length.

    C1D is constant over bands of width 2 pi/L around the modes and is integrated over the bands
    of the new modes. Power in waves longer than the lowest band of the new line is omitted.
    """
    refuse(positive_faults(length=length))
    count = spectrum.power.size
    ratio = length / spectrum.length
    edges = np.arange(count + 1) + 0.5
    total = np.concatenate([[0.0], np.cumsum(spectrum.power)])
    new_count = int(np.ceil((count + 0.5) * ratio + 0.5))
    new_edges = (np.arange(new_count + 1) + 0.5) / ratio
    power = np.diff(np.interp(new_edges, edges, total))
    return LineSpectrum(2 * np.pi / length * np.arange(1, new_count + 1), power, float(length))


def _sample_rule(density: np.ndarray, mode: np.ndarray, length: float) -> LineSpectrum:
    """Return C1D = pi q C2D (19.26) sampled at the modes, with (19.25)."""
    wavenumber = 2 * np.pi / length * mode
    return LineSpectrum(wavenumber, 2 * np.pi / length * (np.pi * wavenumber * density), length)
