"""Power spectra of surfaces and of the rough lines that stand for them.

Conventions of the chapter (19.22)-(19.25): a line is h(x) = sum_q B(q) exp(i (q x + phi)) over
positive and negative q, so <h^2> = 2 sum_k B_k^2 over the positive modes q_k = 2 pi k/L.

The rule of the chapter is C1D(q) = pi q C2D(q) (19.26). In the continuum it keeps <h^2>
((19.27) = (19.28)) and with it <h'^2>_1D = <|grad h|^2> and <h''^2>_1D = <(laplacian h)^2>; the
chapter's footnote 7 speaks of the product of the principal curvatures, whose mean is zero. Sampled
at the modes, C1D inflates the rms height by 4-10 %; the sum over each ring of modes,
B1D(k)^2 = (1/2) sum_ring |B2D|^2, keeps <h^2> exactly and is the default.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft


@dataclass(frozen=True)
class LineSpectrum:
    """Spectrum of a rough line, positive modes only.

    Attributes
    ----------
    wavenumber : ndarray, shape (m,)
        q_k = 2 pi k/length, k = 1 ... m, in radians per unit length.
    power : ndarray, shape (m,)
        B1D(q_k)^2, the squared amplitude of one of the pair +-q_k: <h^2> = 2 sum power.
    length : float
        Period L of the line.
    """

    wavenumber: np.ndarray
    power: np.ndarray
    length: float

    @property
    def rms_height(self) -> float:
        """Root mean square height sqrt<h^2>."""
        return self._moment(0)

    @property
    def rms_slope(self) -> float:
        """Root mean square slope sqrt<h'^2>, the full gradient of the surface behind the line."""
        return self._moment(1)

    @property
    def rms_curvature(self) -> float:
        """Root mean square curvature sqrt<h''^2>, the laplacian of the surface behind the line."""
        return self._moment(2)

    @property
    def density(self) -> np.ndarray:
        """C1D(q_k) = L/(2 pi) B1D^2 (19.25)."""
        return self.length / (2 * np.pi) * self.power

    def _moment(self, order: int) -> float:
        return float(np.sqrt(2 * np.sum(self.wavenumber ** (2 * order) * self.power)))


def ring_sums(
    height: np.ndarray, size: float | tuple[float, float], periodic: bool = False
) -> LineSpectrum:
    """Line spectrum of a height map by ring sums, B1D(k)^2 = (1/2) sum over ring k of |B2D|^2.

    Ring k holds the modes whose |q| is nearest to 2 pi k/L, L the longer side: with the shorter
    side's wider rings, modes along the longer side would fall into the mean and be lost. All modes
    count, also those in the corners beyond the Nyquist wavenumber of one direction.

    Parameters
    ----------
    height : ndarray, shape (nx, ny)
        Heights; the mean is removed. Pixels need not be square.
    size : float or (float, float)
        Sides Lx, Ly.
    periodic : bool
        True for a map that continues itself. False (a measured map) applies a Hann window in both
        directions, removes the windowed mean and rescales the result to the <h^2> of the map, so
        that the jump between opposite sides does not fill the spectrum.

    Returns
    -------
    LineSpectrum
        <h^2> of the map is kept to rounding, the rms slope to the width of the rings.

    Raises
    ------
    ValueError
        If the map is not 2-D, has fewer than 2 points in a direction or is not finite, or a side
        is not positive.

    Examples
    --------
    >>> h = np.cos(2 * np.pi * np.arange(8) / 8)[:, None] * np.ones(8)
    >>> spectrum = ring_sums(h, 1.0, periodic=True)
    >>> np.round(2 * spectrum.power[:2], 12)  # <h^2> = 1/2, all in the first ring
    array([0.5, 0. ])
    """
    square, lengths = _map_power(height, size, periodic)
    return _sum_rings(square, _magnitude(square.shape, lengths), max(lengths))


def printed_rule(
    height: np.ndarray, size: float | tuple[float, float], periodic: bool = False
) -> LineSpectrum:
    """Line spectrum of a height map by the steps of Problem 1: ring averages, C1D = pi q C2D.

    C2D(q) is the mean over each ring of (L/2 pi)^2 |B2D|^2 and C1D is sampled at the modes, which
    does not keep <h^2>: a ring of k holds not 2 pi k modes but 8 for k = 1, and a steep spectrum
    varies across it. Modes end below the Nyquist wavenumber of the coarser direction, where rings
    cease to be complete.

    Parameters and errors are those of `ring_sums`.
    """
    square, lengths = _map_power(height, size, periodic)
    magnitude = _magnitude(square.shape, lengths)
    length = max(lengths)
    ring = np.rint(magnitude * (length / (2 * np.pi))).astype(np.int64).ravel()
    mean = np.bincount(ring, square.ravel()) / np.maximum(np.bincount(ring), 1)
    mode = np.arange(1, _whole_rings(square.shape, lengths) + 1)
    return _sample_rule(mean[mode] * (lengths[0] * lengths[1] / (4 * np.pi**2)), mode, length)


def prescribed(
    points: int | tuple[int, int],
    size: float | tuple[float, float],
    *,
    hurst: float | None = None,
    power: float | None = None,
    rms_slope: float | None = None,
    rms_height: float | None = None,
    long_cutoff: float | None = None,
    short_cutoff: float | None = None,
    rule: str = "rings",
) -> LineSpectrum:
    """Line spectrum of a synthetic self-affine surface, from its parameters alone.

    The surface has fixed amplitudes B2D with C2D ~ q^-power for q_l <= q <= q_s, a plateau below
    q_l = 2 pi/long_cutoff, nothing beyond q_s = 2 pi/short_cutoff, self-conjugate Nyquist modes
    zero; cutoffs are circles in q (a mode on the circle is kept). `rms_slope` is the rms of the
    full gradient summed over the modes of the surface; the line's own differs by what the rings
    round off (2 % low for 64 points without roll-off, where a mode (1, 1) counts as ring 1).

    Parameters
    ----------
    points : int or (int, int)
        Points of the surface per side.
    size : float or (float, float)
        Sides of the surface.
    hurst, power : float
        Exactly one: H with power = 2 (1 + H), or the exponent of C2D itself.
    rms_slope, rms_height : float
        Exactly one, positive.
    long_cutoff : float, optional
        Roll-off wavelength; without it the power law goes down to the longest mode.
    short_cutoff : float, optional
        Shortest wavelength; two cells (of the coarser direction) without it.
    rule : {"rings", "printed"}
        Ring sums, or C1D = pi q C2D (19.26) sampled at the modes below the Nyquist wavenumber.

    Returns
    -------
    LineSpectrum

    Raises
    ------
    ValueError
        Listing everything wrong, also if no mode is left between the cutoffs.
    """
    shape, lengths = _pair(points, int), _pair(size, float)
    exponent = _check_prescribed(
        shape, lengths, hurst, power, rms_slope, rms_height, long_cutoff, short_cutoff, rule
    )
    cell = max(side / n for side, n in zip(lengths, shape, strict=True))
    limits = (
        2 * np.pi / long_cutoff if long_cutoff else 0.0,
        2 * np.pi / (short_cutoff or 2 * cell),
    )
    magnitude = _magnitude(shape, lengths)
    square = _power_law(magnitude, exponent, *limits)
    for axis, n in enumerate(shape):
        if n % 2 == 0:
            square[(slice(None),) * axis + (n // 2,)] = 0.0
    target, weight = (rms_slope, magnitude**2) if rms_height is None else (rms_height, 1.0)
    total = float(np.sum(weight * square))
    if not total > 0:
        raise ValueError(f"no mode lies between the cutoffs {long_cutoff!r} and {short_cutoff!r}")
    scale = target**2 / total
    length = max(lengths)
    if rule == "rings":
        return _sum_rings(scale * square, magnitude, length)
    mode = np.arange(1, _whole_rings(shape, lengths) + 1)
    shape_of_density = _power_law(2 * np.pi / length * mode, exponent, *limits)
    area = lengths[0] * lengths[1]
    return _sample_rule(scale * shape_of_density * (area / (4 * np.pi**2)), mode, length)


def synthesise(
    spectrum: LineSpectrum,
    points: int | None = None,
    rng: np.random.Generator | None = None,
    length: float | None = None,
) -> np.ndarray:
    """One realisation of a rough line: fixed amplitudes, random phases (19.24).

    Parameters
    ----------
    spectrum : LineSpectrum
        Amplitudes.
    points : int, optional
        Points of the line, more than twice the highest mode that carries power; the smallest such
        even number with a fast transform without it.
    rng : numpy.random.Generator
        Source of the phases; one uniform number per mode, lowest mode first, so that lines with
        more points from an equal generator are the same line, better resolved.
    length : float, optional
        Period of the line, the spectrum's own without it. On another length the density C1D is
        kept and integrated over the new modes, so <h^2> is kept too (on a shorter line less the
        waves that do not fit into it).

    Returns
    -------
    ndarray, shape (points,)
        Heights at x = j length/points, mean zero.

    Raises
    ------
    ValueError
        If the points do not resolve the spectrum, or no generator is given.
    """
    if not isinstance(rng, np.random.Generator):
        raise ValueError(f"rng must be a numpy.random.Generator, got {rng!r}")
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
    phase = rng.uniform(0.0, 2 * np.pi, spectrum.power.size)[:highest]
    modes = np.zeros(points // 2 + 1, dtype=complex)
    modes[1 : highest + 1] = np.sqrt(spectrum.power[:highest]) * np.exp(1j * phase)
    return scipy.fft.irfft(modes, n=int(points), norm="forward")


def resample(spectrum: LineSpectrum, length: float) -> LineSpectrum:
    """Spectrum with the same density C1D on a line of another length.

    C1D is constant over the band of width 2 pi/L around each mode and is integrated over the bands
    of the new modes. Power in waves longer than the new line's lowest band is left out.
    """
    if not (np.isfinite(length) and length > 0):
        raise ValueError(f"length must be finite and positive, got {length!r}")
    count = spectrum.power.size
    ratio = length / spectrum.length
    edges = np.arange(count + 1) + 0.5
    total = np.concatenate([[0.0], np.cumsum(spectrum.power)])
    new_count = int(np.ceil((count + 0.5) * ratio + 0.5))
    new_edges = (np.arange(new_count + 1) + 0.5) / ratio
    power = np.diff(np.interp(new_edges, edges, total))
    return LineSpectrum(2 * np.pi / length * np.arange(1, new_count + 1), power, float(length))


def _sum_rings(square: np.ndarray, magnitude: np.ndarray, length: float) -> LineSpectrum:
    """Half the sum of |B2D|^2 over each ring of width 2 pi/length."""
    ring = np.rint(magnitude * (length / (2 * np.pi))).astype(np.int64)
    power = np.bincount(ring.ravel(), square.ravel())[1:] / 2
    return LineSpectrum(2 * np.pi / length * np.arange(1, power.size + 1), power, float(length))


def _sample_rule(density: np.ndarray, mode: np.ndarray, length: float) -> LineSpectrum:
    """C1D = pi q C2D (19.26) sampled at the modes, with (19.25)."""
    wavenumber = 2 * np.pi / length * mode
    return LineSpectrum(wavenumber, 2 * np.pi / length * (np.pi * wavenumber * density), length)


def _whole_rings(shape: tuple[int, int], lengths: tuple[float, float]) -> int:
    """Count the rings below the Nyquist wavenumber of the coarser direction."""
    length = max(lengths)
    return (
        min(int(np.ceil(n / 2 * length / side)) for n, side in zip(shape, lengths, strict=True)) - 1
    )


def _map_power(
    height: np.ndarray, size: float | tuple[float, float], periodic: bool
) -> tuple[np.ndarray, tuple[float, float]]:
    """|B2D|^2 of all modes of a map (mean removed, windowed if not periodic), and its sides."""
    h = np.asarray(height, dtype=float)
    lengths = _pair(size, float)
    wrong = [
        f"side must be finite and positive, got {s!r}"
        for s in lengths
        if not (np.isfinite(s) and s > 0)
    ]
    if h.ndim != 2 or min(h.shape) < 2:
        wrong.append(f"height must be a 2-D map of at least 2 x 2 points, got shape {h.shape}")
    elif not np.all(np.isfinite(h)):
        wrong.append("height must be finite: fill undefined points first")
    if wrong:
        raise ValueError("; ".join(wrong))
    h = h - h.mean()
    if not periodic:
        h = _hann(h)
    square = np.abs(scipy.fft.fft2(h, norm="forward")) ** 2
    square[0, 0] = 0.0
    return square, lengths


def _hann(h: np.ndarray) -> np.ndarray:
    """Map times the Hann window, mean removed, rescaled to the mean square of the map."""
    x, y = (np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 for n in h.shape)
    window = x[:, None] * y
    windowed = window * (h - np.sum(window * h) / np.sum(window))
    mean_square = np.mean(windowed**2)
    return windowed * np.sqrt(np.mean(h**2) / mean_square) if mean_square > 0 else windowed


def _magnitude(shape: tuple[int, int], lengths: tuple[float, float]) -> np.ndarray:
    """|q| of every mode of a map, in the order of the FFT."""
    qx, qy = (
        2 * np.pi * np.fft.fftfreq(n, side / n) for n, side in zip(shape, lengths, strict=True)
    )
    return np.hypot(qx[:, None], qy)


def _power_law(q: np.ndarray, exponent: float, low: float, high: float) -> np.ndarray:
    """q^-exponent with a plateau below `low` and nothing above `high` or at q = 0."""
    # The circle itself belongs to the spectrum, whatever the rounding of |q|.
    kept = (q > 0) & (q <= high * (1 + 1e-10))
    return np.where(kept, (np.maximum(np.where(kept, q, high), low) / high) ** -exponent, 0.0)


def _pair(value, kind: type) -> tuple:
    """Turn a number into a pair, or leave a pair."""
    return (kind(value), kind(value)) if np.ndim(value) == 0 else (kind(value[0]), kind(value[1]))


def _check_prescribed(
    shape, lengths, hurst, power, rms_slope, rms_height, long_cutoff, short_cutoff, rule
) -> float:
    """Exponent of C2D, or one ValueError for everything wrong."""
    wrong = []
    if min(shape) < 2:
        wrong.append(f"points must be at least 2 per side, got {shape}")
    if (hurst is None) == (power is None):
        wrong.append(f"give exactly one of hurst and power, got {hurst!r} and {power!r}")
    if (rms_slope is None) == (rms_height is None):
        wrong.append(
            f"give exactly one of rms_slope and rms_height, got {rms_slope!r} and {rms_height!r}"
        )
    named = {
        "rms_slope": rms_slope,
        "rms_height": rms_height,
        "long_cutoff": long_cutoff,
        "short_cutoff": short_cutoff,
        "size": min(lengths),
    }
    wrong += [
        f"{name} must be finite and positive, got {value!r}"
        for name, value in named.items()
        if value is not None and not (np.isfinite(value) and value > 0)
    ]
    if rule not in ("rings", "printed"):
        wrong.append(f"rule must be 'rings' or 'printed', got {rule!r}")
    if wrong:
        raise ValueError("; ".join(wrong))
    return float(power) if hurst is None else 2 * (1 + float(hurst))
