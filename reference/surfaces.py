"""Rough surfaces as periodic height maps: synthesis (19.22)-(19.23), refinement, summits."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike
from scipy import fft

from reference.arrays import Array, Indices, Modes
from reference.errors import positive_faults, refuse

Pair = tuple[float, float]

# Modes that are made at once.
_PIECE = 2**20


@dataclass(frozen=True)
class SelfAffine:
    """A self-affine spectrum: C2D ~ q^-power up to the short cutoff, constant for long waves."""

    # exactly one: C2D ~ q^(-2(1 + hurst)), hurst in [0, 1], or C2D ~ q^(-power)
    hurst: float | None = None
    power: float | None = None
    # exactly one: h' = sqrt(<|grad h|^2>) = sqrt(sum |q|^2 B^2), or sqrt(<h^2>) = sqrt(sum B^2)
    rms_slope: float | None = None
    rms_height: float | None = None
    long_cutoff: float | None = None  # roll-off wavelength. Default: no plateau.
    short_cutoff: float | None = None  # circular in q. Default two cells (the larger one).

    def __post_init__(self) -> None:
        faults = []
        for name, alternative in (("hurst", "power"), ("rms_slope", "rms_height")):
            pair = getattr(self, name), getattr(self, alternative)
            if (pair[0] is None) == (pair[1] is None):
                faults.append(f"give exactly one of {name} and {alternative}, not {pair!r}")
        names = ("rms_slope", "rms_height", "long_cutoff", "short_cutoff")
        amplitudes = {name: getattr(self, name) for name in names}
        faults += positive_faults(**{k: v for k, v in amplitudes.items() if v is not None})
        if self.power is not None and not (np.isfinite(self.power) and self.power >= 0):
            faults.append(f"power must be finite and not negative, not {self.power!r}")
        if self.hurst is not None and not 0 <= self.hurst <= 1:
            faults.append(f"hurst must lie in [0, 1], not {self.hurst!r}")
        refuse(faults)

    @property
    def exponent(self) -> float:
        """The power of C2D."""
        return 2 * (1 + (self.hurst or 0.0)) if self.power is None else self.power


def self_affine(
    points: int | tuple[int, int],
    size: float | Pair,
    spectrum: SelfAffine,
    *,
    seed: int,
    realisation: int,
    stream: int = 0,
) -> Array:
    r"""Periodic height map with a prescribed spectrum and random phases, (19.22).

        h(x) = sum over q of B(q) exp(i (q.x + phi(q))),  B(-q) = B(q),  phi(-q) = -phi(q)

    The amplitudes B are fixed by `amplitude_spectrum` (so every realisation has the same rms height
    and slope), the phases uniform on [0, 2 pi). The stream of surface k is
    ``SeedSequence(seed, spawn_key=(stream, k))``; one uniform number is drawn for every mode of the
    full grid, in C order, of which the modes of a real FFT are used. `points` and `size` are (nx,
    ny) and (Lx, Ly), or one for both. Heights are positive towards the half-space.

    >>> h = self_affine(32, 1.0, SelfAffine(hurst=0.8, rms_slope=0.1), seed=1, realisation=0)
    >>> h.shape, round(rms_gradient_spectral(h, (1 / 32, 1 / 32)), 12)
    ((32, 32), 0.1)
    """
    shape, _ = _grid(points, size)
    key = np.random.SeedSequence(seed, spawn_key=(stream, realisation))
    random = np.random.default_rng(key)
    half = shape[1] // 2 + 1
    modes = np.empty((shape[0], half), dtype=complex)
    for part in _rows(shape):
        phases = random.uniform(0, 2 * np.pi, (part.stop - part.start, shape[1]))[:, :half]
        amplitudes = amplitude_spectrum(points, size, spectrum, part)
        modes[part] = amplitudes[:, :half] * np.exp(1j * phases)
    # Both signs of q_x are stored in the columns q_y = 0 and, on an even grid, q_y at Nyquist.
    whole = (shape[0] - 1) // 2
    for column in (0, -1) if shape[1] % 2 == 0 else (0,):
        modes[shape[0] - whole :, column] = modes[1 : whole + 1, column][::-1].conj()
    return fft.irfft2(modes, s=shape, norm="forward", workers=1, overwrite_x=True)


def _rows(shape: tuple[int, int]) -> list[slice]:
    """Return rows of a grid in pieces: temporary arrays of a large one would be many times it."""
    step = max(1, _PIECE // shape[1])
    return [slice(start, min(start + step, shape[0])) for start in range(0, shape[0], step)]


def amplitude_spectrum(
    points: int | tuple[int, int],
    size: float | Pair,
    spectrum: SelfAffine,
    rows: slice = slice(None),
) -> Array:
    """Amplitudes B(q) = (2 pi/L) sqrt(C2D(q)), (19.23), on the modes of a full 2-D FFT.

    For the rows that are wanted; sum(B^2) = <h^2> and sum(|q|^2 B^2) = <|grad h|^2>. The power law
    holds between the roll-off wavelength and the short cutoff, both circular in q (the modes on the
    cutoff circle are kept); q = 0 and the modes that are their own conjugates at the Nyquist
    frequency are zero, because their phase cannot be random.

    >>> B = amplitude_spectrum(16, 1.0, SelfAffine(power=4.0, rms_height=2.0))
    >>> round(float((B**2).sum()), 12), round(float(B[1, 0] / B[2, 0]), 12)
    (4.0, 4.0)
    """
    shape, lengths = _grid(points, size)
    factor = _amplitude_factor(shape, lengths, spectrum)
    amplitudes, _ = _relative_amplitudes(shape, lengths, spectrum, rows)
    return amplitudes * factor


def _shortest(shape: tuple[int, int], lengths: Pair, spectrum: SelfAffine) -> float:
    return spectrum.short_cutoff or 2 * max(lengths[0] / shape[0], lengths[1] / shape[1])


@lru_cache(maxsize=8)
def _amplitude_factor(shape: tuple[int, int], lengths: Pair, spectrum: SelfAffine) -> float:
    """Return what gives relative amplitudes the rms slope or height of the spectrum."""
    present = 0.0
    for part in _rows(shape):
        amplitude, wavenumber = _relative_amplitudes(shape, lengths, spectrum, part)
        weight = wavenumber if spectrum.rms_slope is not None else 1.0
        present += float(((weight * amplitude) ** 2).sum())
    if present == 0:
        shortest = _shortest(shape, lengths, spectrum)
        raise ValueError(
            f"no mode of a {shape[0]} x {shape[1]} grid lies below the short cutoff {shortest!r}"
        )
    target = spectrum.rms_height if spectrum.rms_slope is None else spectrum.rms_slope
    return float(target / np.sqrt(present))


def _relative_amplitudes(
    shape: tuple[int, int], lengths: Pair, spectrum: SelfAffine, part: slice
) -> tuple[Array, Array]:
    """Return amplitudes of some rows of modes in an unit of their own, and their wavenumbers."""
    spacing = (lengths[0] / shape[0], lengths[1] / shape[1])
    waves = [2 * np.pi * fft.fftfreq(n, step) for n, step in zip(shape, spacing, strict=True)]
    wavenumber = np.hypot(waves[0][part, None], waves[1][None, :])
    # a relative hair on the circle keeps modes that lie on it whatever the units round to
    shortest = _shortest(shape, lengths, spectrum)
    inside = (wavenumber > 0) & (wavenumber <= 2 * np.pi / shortest * (1 + 1e-12))
    # modes equal to their own conjugate: q = 0 and the corners at Nyquist
    own = [(2 * np.arange(n)) % n == 0 for n in shape]
    inside &= ~(own[0][part, None] & own[1])
    plateau = 2 * np.pi / spectrum.long_cutoff if spectrum.long_cutoff else 0.0
    amplitude = np.zeros(wavenumber.shape)
    # relative to the largest, so that the power law does not see the unit of length
    largest = np.hypot(*(np.abs(along).max() for along in waves))
    relative = np.maximum(wavenumber[inside], plateau) / largest
    amplitude[inside] = relative ** (-spectrum.exponent / 2)
    return amplitude, wavenumber


def refine(height: ArrayLike, factor: int, axes: tuple[int, ...] = (0, 1)) -> Array:
    """Fourier interpolation of a periodic map onto a grid `factor` times finer.

    The map is the band-limited function through its points; the values at the original points are
    kept, ``refine(h, f)[::f, ::f] == h`` to rounding. A Nyquist component is split evenly between
    its two signs, the interpolant of least slope.

    >>> h = np.cos(2 * np.pi * np.arange(8) / 8)[:, None] * np.ones(8)
    >>> fine = refine(h, 3)
    >>> bool(np.allclose(fine[:, 0], np.cos(2 * np.pi * np.arange(24) / 24)))
    True
    """
    return _refined(height, factor, 0.0, axes)


def subdivide(height: ArrayLike, factor: int) -> Array:
    """Fourier interpolation at the centres of cells, `factor` by `factor` in a cell of the map.

    The cells of the map are those about its points, so the finer cells cover the same area; on the
    points themselves (`refine`) it would move by up to half a cell. An odd factor keeps the points.

    >>> h = np.cos(2 * np.pi * np.arange(8) / 8)[:, None] * np.ones(8)
    >>> fine = subdivide(h, 2)
    >>> bool(np.allclose(fine[:, 0], np.cos(2 * np.pi * (np.arange(16) - 0.5) / 16)))
    True
    """
    return _refined(height, factor, (1 / factor - 1) / 2 if factor else 0.0, (0, 1))


def _refined(height: ArrayLike, factor: int, start: float, axes: tuple[int, ...]) -> Array:
    """Return a map on a finer grid whose first point lies `start` of a cell from the map's."""
    fine: Array = np.asarray(height, dtype=float)
    if fine.ndim != 2 or not np.isfinite(fine).all():
        raise ValueError(f"height must be a finite 2-D map, not of shape {fine.shape}")
    if int(factor) != factor or factor < 1:
        raise ValueError(f"factor must be a positive integer, not {factor!r}")
    for axis in axes if factor > 1 else ():
        points = fine.shape[axis]
        spectrum = np.moveaxis(fft.rfft(fine, axis=axis, norm="forward", workers=1), axis, 0)
        if points % 2 == 0:
            spectrum[-1] /= 2
        if start:
            moved = np.exp(2j * np.pi * start / points * np.arange(len(spectrum)))
            spectrum *= moved[:, None]
        fine = fft.irfft(spectrum, n=points * int(factor), axis=0, norm="forward", workers=1)
        del spectrum  # as large as the map
        fine = np.moveaxis(fine, 0, axis)
    return fine


def highest(height: ArrayLike) -> float:
    """Highest value of the band-limited function through a periodic map.

    The map's own maximum is lower, by a tenth of the rms height where the shortest wave has two
    points (H = 0.5).

    >>> x = (np.arange(8) + 0.3) / 8
    >>> h = np.cos(2 * np.pi * x)[:, None] + np.cos(2 * np.pi * x)
    >>> round(highest(h), 12)
    2.0
    """
    height, starts = np.asarray(height, dtype=float), 5
    # the highest local maxima of the finer grid, in pieces
    rows = refine(height, 2, axes=(0,))
    shape = len(rows), 2 * rows.shape[1]
    values, indices = [], []
    for part in _rows(shape):
        wrapped = np.arange(part.start - 1, part.stop + 1) % len(rows)
        fine = refine(rows[wrapped], 2, axes=(1,))
        inside, above = fine[1:-1], np.maximum(fine[:-2], fine[2:])
        nearby = np.maximum(inside, above)
        nearby = np.max([np.roll(nearby, j, 1) for j in (-1, 0, 1)], axis=0)
        peaks = np.flatnonzero((inside >= nearby).ravel())
        peaks = peaks[np.argsort(inside.ravel()[peaks])[-starts:]]
        values.append(inside.ravel()[peaks])
        indices.append(peaks + part.start * shape[1])
    heights, index = np.concatenate(values), np.concatenate(indices)
    chosen = index[np.argsort(heights)[-starts:]]
    del rows  # as large as the modes

    def waves(points: int, at: float) -> tuple[Modes, ...]:
        """All modes of a real FFT's grid at a place, and their first and second derivatives."""
        wave = 2 * np.pi * fft.fftfreq(points, 1 / points)
        values = np.exp(1j * wave * at)
        first, second = 1j * wave * values, -(wave**2) * values
        if points % 2 == 0:  # the Nyquist component is split evenly between its two signs
            half = points // 2
            even, odd = np.cos(wave[half] * at), np.sin(wave[half] * at)
            values[half], first[half] = even, -wave[half] * odd
            second[half] = -(wave[half] ** 2) * even
        return values, first, second

    # Newton's iterations to the stationary point near each, at places in shares of the period
    modes = fft.fft2(height, norm="forward", workers=1)
    best = float(heights.max())
    for place in np.column_stack(np.unravel_index(chosen, shape)) / shape:
        value = -np.inf
        for _ in range(4):
            (f, fx, fxx), (g, gy, gyy) = map(waves, modes.shape, place)
            along = modes @ g
            here = float((f @ along).real)
            if here < value:  # a step too far
                break
            value = here
            slope = np.array([(fx @ along).real, (f @ (modes @ gy)).real])
            mixed = (fx @ (modes @ gy)).real
            bend = np.array([[(fxx @ along).real, mixed], [mixed, (f @ (modes @ gyy)).real]])
            if not np.linalg.det(bend) > 0:
                break
            place = place - np.linalg.solve(bend, slope)
        best = max(best, value)
    return best


def rms_gradient_spectral(height: ArrayLike, spacing: Pair) -> float:
    """Root mean square of the full gradient of a periodic map, sqrt(sum |q|^2 |B|^2) over modes.

    >>> x = np.arange(16) / 16
    >>> h = np.sin(2 * np.pi * x)[:, None] * np.ones(16)
    >>> round(rms_gradient_spectral(h, (1 / 16, 1 / 16)) / (2 * np.pi) * 2**0.5, 12)
    1.0
    """
    height = np.asarray(height, dtype=float)
    amplitude = np.abs(fft.fft2(height, norm="forward", workers=1))
    qx, qy = (2 * np.pi * fft.fftfreq(n, d) for n, d in zip(height.shape, spacing, strict=True))
    return float(np.sqrt(((np.hypot(qx[:, None], qy) * amplitude) ** 2).sum()))


def rms_gradient_differences(height: ArrayLike, spacing: Pair) -> float:
    """Root mean square of the full gradient of a measured map, not periodic, by differences.

    sqrt(<(dh/dx)^2> + <(dh/dy)^2>) with forward differences, each mean over its own
    (nx - 1) ny or nx (ny - 1) of them; undefined points must have been filled.

    >>> x = np.arange(4.0)
    >>> rms_gradient_differences(3 * x[:, None] + 4 * x[None, :], (1.0, 1.0))
    5.0
    """
    height = np.asarray(height, dtype=float)
    squares = [
        np.mean((np.diff(height, axis=axis) / step) ** 2)
        for axis, step in enumerate(spacing)
        if height.shape[axis] > 1
    ]
    return float(np.sqrt(sum(squares)))


def _grid(points: int | tuple[int, int], size: float | Pair) -> tuple[tuple[int, int], Pair]:
    nx, ny = (int(n) for n in np.broadcast_to(points, 2))
    length, width = (float(side) for side in np.broadcast_to(size, 2))
    faults = positive_faults(size=min(length, width))
    if min(nx, ny) < 2:
        faults.append(f"points must be at least 2 per side, not {(nx, ny)!r}")
    refuse(faults)
    return (nx, ny), (length, width)


class Summits(NamedTuple):
    """Local maxima of a map: grid indices (m, 2) and principal curvatures (m, 2), larger first.

    Curvatures are positive for a convex summit.
    """

    places: Indices
    curvatures: Array


def hessian(height: ArrayLike, spacing: Pair) -> tuple[Array, ...]:
    """Return second derivatives (hxx, hyy, hxy) of a periodic map, exact for band-limited ones.

    Spectral: h^ times -qx^2, -qy^2, -qx qy. The Nyquist component has no mixed derivative.

    >>> x = np.arange(16) / 16
    >>> h = np.cos(2 * np.pi * x)[:, None] * np.ones(16)
    >>> hxx, hyy, hxy = hessian(h, (1 / 16, 1 / 16))
    >>> bool(np.allclose(hxx, -4 * np.pi**2 * h)), bool(np.allclose(hyy, 0)), hxy.shape
    (True, True, (16, 16))
    """
    height = np.asarray(height, dtype=float)
    if height.ndim != 2 or not np.isfinite(height).all():
        raise ValueError(f"height must be a finite 2-D map, not of shape {height.shape}")
    shape = height.shape
    qx = 2 * np.pi * fft.fftfreq(shape[0], spacing[0])[:, None]
    qy = 2 * np.pi * fft.rfftfreq(shape[1], spacing[1])[None, :]
    spectrum = fft.rfft2(height, workers=1)
    mixed = qx * qy
    if shape[0] % 2 == 0:
        mixed[shape[0] // 2, :] = 0.0
    if shape[1] % 2 == 0:
        mixed[:, -1] = 0.0
    factors = (qx**2, qy**2, mixed)
    return tuple(fft.irfft2(-factor * spectrum, s=shape, workers=1) for factor in factors)


def summits(height: ArrayLike, spacing: Pair) -> Summits:
    """Return the local maxima of a periodic map, higher than their eight neighbours.

    Curvatures are the eigenvalues of minus the Hessian at the grid point, those of the summit to
    O(dx^2). Points that are no summits of the band-limited surface are omitted.

    >>> x = 2 * np.pi * np.arange(32) / 32
    >>> h = np.cos(x)[:, None] + np.cos(x)[None, :]
    >>> peaks = summits(h, (2 * np.pi / 32,) * 2)
    >>> peaks.places.tolist(), np.round(peaks.curvatures, 12).tolist()
    ([[0, 0]], [[1.0, 1.0]])
    """
    height = np.asarray(height, dtype=float)
    hxx, hyy, hxy = hessian(height, spacing)
    ring = np.ones((3, 3), dtype=bool)
    ring[1, 1] = False
    places = np.argwhere(height > scipy.ndimage.maximum_filter(height, footprint=ring, mode="wrap"))
    xx, yy, xy = (derivative[tuple(places.T)] for derivative in (hxx, hyy, hxy))
    mean, half = -(xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    convex = mean > half
    return Summits(places[convex], np.stack([mean + half, mean - half], axis=1)[convex])
