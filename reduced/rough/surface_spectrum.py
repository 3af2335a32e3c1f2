"""Power spectra of surfaces, measured or prescribed: the input of the two-to-one-dimensional rule.

A surface is h(x) = sum_q B2D(q) exp(i (q x + phi)) over all modes of its rectangle (19.22), with
C2D = Lx Ly/(2 pi)^2 |B2D|^2 (19.23), so that <h^2> = sum |B2D|^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft

from reduced.arguments import count_faults, positive_faults, refuse

# Relative rounding of |q| L/(2 pi): what lies this near to a limit lies on it. Sides come from
# files, some in single precision (6e-8). On a square the modes next to a limit k + 1/2 are 1/(8 k)
# away from it: outside of this up to ring 1100.
ROUNDING = 1e-7


@dataclass(frozen=True)
class RadialAverage:
    """C2D over circles: mean, number and spread of the modes in each ring.

    Attributes
    ----------
    wavenumber : ndarray, shape (m,)
        q_k = 2 pi k/L, k = 1 ... m, L the longer side; ring k holds the modes nearest to q_k.
    density : ndarray, shape (m,)
        Mean of C2D over the ring; 0 for an empty ring.
    count : ndarray, shape (m,)
        Modes in the ring; those midway between two rings count half in each.
    spread : ndarray, shape (m,)
        Standard deviation of C2D within the ring: about the mean itself for a measured map (a
        periodogram does not average out), the anisotropy and the width of the ring otherwise.
    """

    wavenumber: np.ndarray
    density: np.ndarray
    count: np.ndarray
    spread: np.ndarray


@dataclass(frozen=True)
class SurfaceSpectrum:
    """Two-dimensional power spectrum.

    Attributes
    ----------
    power : ndarray, shape (nx, ny)
        |B2D|^2 of every mode, in the order of the FFT; the mean has none.
    size : (float, float)
        Sides Lx, Ly.
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
        return _magnitude(self.power.shape, self.size)

    @property
    def density(self) -> np.ndarray:
        """C2D(q) = Lx Ly/(2 pi)^2 |B2D|^2 of every mode (19.23)."""
        return self.size[0] * self.size[1] / (4 * np.pi**2) * self.power

    @property
    def rms_height(self) -> float:
        """Root mean square height sqrt<h^2>."""
        return self._moment(0)

    @property
    def rms_slope(self) -> float:
        """Root mean square of the full gradient, sqrt<|grad h|^2>."""
        return self._moment(1)

    @property
    def rms_curvature(self) -> float:
        """Root mean square of the laplacian, sqrt<(lap h)^2>."""
        return self._moment(2)

    @property
    def whole_rings(self) -> int:
        """Number of rings below the Nyquist wavenumber of the coarser direction: complete ones."""
        pairs = zip(self.power.shape, self.size, strict=True)
        ends = (n / 2 * self.length / side * (1 - ROUNDING) for n, side in pairs)
        return min(int(np.ceil(end)) for end in ends) - 1

    @property
    def place(self) -> np.ndarray:
        """|q| L/(2 pi) of every mode: its place among the rings 1, 2, ... of the longer side."""
        return self.magnitude * (self.length / (2 * np.pi))

    @property
    def rings(self) -> np.ndarray:
        """Two rings of every mode, each of which it counts half in: the nearest one twice.

        A mode midway between two rings is as near to both. There are such modes where the sides are
        as an odd number to an even one (at 3 : 2 every odd wave along the shorter side), and none
        on a square, where (|q| L/2 pi)^2 is a whole number. Midway is told to `ROUNDING`, far
        above the error of |q|, so that no ring hangs on how a side was rounded.

        Returns
        -------
        ndarray of int, shape (2, nx ny)
        """
        place = self.place.ravel()
        below = np.floor(place)
        midway = np.abs(place - below - 0.5) <= ROUNDING * place
        inner = np.where(midway, below, np.rint(place)).astype(np.int64)
        return np.stack([inner, inner + midway])

    def ring_sums(self, values: np.ndarray) -> np.ndarray:
        """Sum values of the modes over rings 0, 1, 2, ...; (2, nx ny) gives `rings` one each."""
        rings = self.rings
        count = int(rings.max()) + 1
        inner, outer = np.broadcast_to(values.reshape(-1, rings.shape[1]), rings.shape)
        return 0.5 * (np.bincount(rings[0], inner, count) + np.bincount(rings[1], outer, count))

    def radial_average(self) -> RadialAverage:
        """C2D averaged over rings of width 2 pi/L (step 3 of the chapter's Problem 1).

        Examples
        --------
        >>> h = np.cos(2 * np.pi * np.arange(8) / 8)[:, None] * np.ones(8)
        >>> average = measured(h, 1.0, periodic=True).radial_average()
        >>> average.count[:2]  # (1, 0) and (1, 1) with their signs; then (2, 0), (2, 1)
        array([ 8., 12.])
        """
        density = self.density.ravel()
        count = self.ring_sums(np.ones_like(density))
        safe = np.maximum(count, 0.5)
        mean = self.ring_sums(density) / safe
        spread = np.sqrt(self.ring_sums((density - mean[self.rings]) ** 2) / safe)
        wavenumber = 2 * np.pi / self.length * np.arange(1, count.size)
        return RadialAverage(wavenumber, mean[1:], count[1:], spread[1:])

    def _moment(self, order: int) -> float:
        return float(np.sqrt(np.sum(self.magnitude ** (2 * order) * self.power)))


def measured(
    height: np.ndarray, size: float | tuple[float, float], periodic: bool = False
) -> SurfaceSpectrum:
    """Power spectrum of a height map.

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
    SurfaceSpectrum

    Raises
    ------
    ValueError
        If the map is not 2-D, has fewer than 2 points in a direction or is not finite, or a side
        is not positive.
    """
    h = np.asarray(height, dtype=float)
    sides = pair(size, "size")
    wrong = positive_faults(size=sides[0]) or positive_faults(size=sides[1])
    if h.ndim != 2 or min(h.shape) < 2:
        wrong.append(f"height must be a 2-D map of at least 2 x 2 points, got shape {h.shape}")
    elif not np.all(np.isfinite(h)):
        wrong.append("height must be finite: fill undefined points first")
    refuse(wrong)
    h = h - h.mean()
    if not periodic:
        h = _hann(h)
    power = np.abs(scipy.fft.fft2(h, norm="forward")) ** 2
    power[0, 0] = 0.0
    return SurfaceSpectrum(power, sides)


def self_affine(
    points: int | tuple[int, int],
    size: float | tuple[float, float],
    *,
    hurst: float | None = None,
    power: float | None = None,
    rms_slope: float | None = None,
    rms_height: float | None = None,
    long_cutoff: float | None = None,
    short_cutoff: float | None = None,
) -> SurfaceSpectrum:
    """Prescribed spectrum of a synthetic self-affine surface; parameters as for `line_spectrum`.

    See `line_spectrum.prescribed` for parameters and errors.
    """
    shape, sides = pair(points, "points"), pair(size, "size")
    refuse(
        self_affine_faults(
            shape, sides, hurst, power, rms_slope, rms_height, long_cutoff, short_cutoff
        )
    )
    shape = (int(shape[0]), int(shape[1]))
    exponent = float(power) if hurst is None else 2 * (1 + float(hurst))
    low, high = cutoffs(shape, sides, long_cutoff, short_cutoff)
    magnitude = _magnitude(shape, sides)
    square = power_law(magnitude, exponent, low, high)
    for axis, n in enumerate(shape):
        if n % 2 == 0:
            square[(slice(None),) * axis + (n // 2,)] = 0.0
    target, weight = (rms_slope, magnitude**2) if rms_height is None else (rms_height, 1.0)
    total = float(np.sum(weight * square))
    if not total > 0:
        raise ValueError(f"no mode lies between the cutoffs {long_cutoff!r} and {short_cutoff!r}")
    return SurfaceSpectrum(target**2 / total * square, sides)


def cutoffs(
    shape: tuple[int, int],
    sides: tuple[float, float],
    long_cutoff: float | None,
    short_cutoff: float | None,
) -> tuple[float, float]:
    """Wavenumbers of roll-off (0 without one) and of the end, two cells by default."""
    cell = max(side / n for side, n in zip(sides, shape, strict=True))
    return 2 * np.pi / long_cutoff if long_cutoff else 0.0, 2 * np.pi / (short_cutoff or 2 * cell)


def power_law(q: np.ndarray, exponent: float, low: float, high: float) -> np.ndarray:
    """q^-exponent with a plateau below `low` and nothing above `high` or at q = 0."""
    # The circle itself belongs to the spectrum, whatever the rounding of |q|.
    kept = (q > 0) & (q <= high * (1 + 1e-10))
    return np.where(kept, (np.maximum(np.where(kept, q, high), low) / high) ** -exponent, 0.0)


def _hann(h: np.ndarray) -> np.ndarray:
    """Map times the Hann window, mean removed, rescaled to the mean square of the map."""
    x, y = (np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 for n in h.shape)
    window = x[:, None] * y
    windowed = window * (h - np.sum(window * h) / np.sum(window))
    mean_square = np.mean(windowed**2)
    return windowed * np.sqrt(np.mean(h**2) / mean_square) if mean_square > 0 else windowed


def _magnitude(shape: tuple[int, ...], sides: tuple[float, float]) -> np.ndarray:
    """|q| of every mode of a map, in the order of the FFT."""
    qx, qy = (2 * np.pi * np.fft.fftfreq(n, side / n) for n, side in zip(shape, sides, strict=True))
    return np.hypot(qx[:, None], qy)


def pair(value, name: str) -> tuple:
    """Turn a number into a pair, or leave a pair."""
    if np.shape(value) not in ((), (1,), (2,)):
        raise ValueError(f"{name} must be one number or two, got {value!r}")
    return tuple(np.broadcast_to(np.asarray(value), 2).tolist())


def self_affine_faults(
    shape, sides, hurst, power, rms_slope, rms_height, long_cutoff, short_cutoff
) -> list[str]:
    """List everything that is wrong with the parameters of `self_affine`."""
    wrong = [*count_faults(2, points=shape[0]), *positive_faults(size=sides[0])]
    if shape[1] != shape[0]:
        wrong += count_faults(2, points=shape[1])
    if sides[1] != sides[0]:
        wrong += positive_faults(size=sides[1])
    for names, values in (
        ("hurst and power", (hurst, power)),
        ("rms_slope and rms_height", (rms_slope, rms_height)),
    ):
        if (values[0] is None) == (values[1] is None):
            wrong.append(f"give exactly one of {names}, got {values[0]!r} and {values[1]!r}")
    named = {
        "hurst": hurst,
        "rms_slope": rms_slope,
        "rms_height": rms_height,
        "long_cutoff": long_cutoff,
        "short_cutoff": short_cutoff,
    }
    wrong += positive_faults(**{k: v for k, v in named.items() if v is not None})
    if power is not None and not np.isfinite(power):
        wrong.append(f"power must be finite, got {power!r}")
    return wrong
