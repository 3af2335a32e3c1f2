r"""Stress and displacement inside a half-space or layers, under pressures on a grid of cells.

Each wave of pressure makes a state (U, W, T, S) of every depth (`stack`), from which

    s_nn = G q (2 U/(1 - nu) + nu/(1 - nu) S),  s_tt = nu (s_nn + s_zz),  s_zz = G q S,
    s_nz = G q T,

n along the wave and t across it. On the way down, as on the way up, nothing grows: with the
compliance R of what lies below, the tractions at the bottom of a slice are

    (T, S)_bottom = (E21 R + E22)^-1 (T, S)_top.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from reference.arrays import Array
from reference.elasticity import Material, von_mises
from reference.errors import refuse, spacing_faults
from reference.halfspace import kernels
from reference.layered.stack import Stack, half_space, through

# Lengths of waves that differ by less than this part of the largest are the same.
_DIGITS = 2.0**45
# A wave decays as exp(-q z): at this q z rounding hides it.
_DEAD = 40.0


@dataclass(frozen=True)
class Inside:
    """Fields at one depth below the cells, tension positive."""

    depth: float
    displacement: Array  # (3, nx, ny)
    stress: Array  # (6, nx, ny): xx, yy, zz, yz, xz, xy

    @property
    def von_mises(self) -> Array:
        """Return the equivalent stress of von Mises."""
        return von_mises(np.moveaxis(self.stress, 0, -1))


def inside(
    body: Stack,
    pressure: ArrayLike,
    spacing: tuple[float, float],
    depths: ArrayLike,
    kept: tuple[int, int] | None = None,
) -> Iterator[Inside]:
    """Yield the fields at increasing depths under a pressure that repeats with its grid.

    A patch that does not repeat is given with empty cells around it, and has the fields below the
    first cells of either side, as many as are `kept`.

    The function through the pressure at the centres of cells is band-limited. Depths increase
    strictly; those below a rigid base are left out.

    A wave on a half-space has s_zz = -p (1 + q z) exp(-q z):

    >>> x = 2 * np.pi * np.arange(16) / 16
    >>> p = np.broadcast_to(np.cos(x)[:, None], (16, 16))
    >>> steel = Stack([], [], Material(1.0, 0.3))
    >>> (field,) = inside(steel, p, (2 * np.pi / 16,) * 2, [1.0])
    >>> bool(np.allclose(field.stress[2], -2 / np.e * p))
    True
    """
    pressure, depths = np.asarray(pressure, dtype=float), np.asarray(depths, dtype=float)
    faults = spacing_faults(spacing)
    if pressure.ndim != 2 or not np.isfinite(pressure).all():
        faults.append("pressure must be a grid of finite numbers")
    if not (depths.size and (np.diff(depths) > 0).all() and depths[0] > 0):
        faults.append("depths must be positive and increase")
    refuse(faults)

    # Waves of the pressure. The mean has no direction; as a wave it counts with the shortest.
    qx, qy = np.broadcast_arrays(*kernels.wavenumbers(pressure.shape, spacing))
    lengths = np.hypot(qx, qy)
    lengths[0, 0] = lengths.max() or 1.0
    cosines, sines = qx / lengths, qy / lengths
    cosines[0, 0], sines[0, 0] = 1.0, 0.0
    amplitude = fft.rfft2(pressure, workers=1)
    # Bodies are isotropic, so that waves of one length have one state: a seventh of a square grid.
    keys = np.rint(lengths * (_DIGITS / lengths.max()))
    _, first, waves = np.unique(keys, return_index=True, return_inverse=True)
    q, waves = lengths.ravel()[first], waves.reshape(lengths.shape)

    # From the bottom up: the compliance below each slice, in units of 1/(G q) of its material, and
    # what takes tractions down through it.
    slices = _slices(body, depths)
    downs, belows = [], []
    below, modulus = np.zeros((q.size, 2, 2)), 1.0
    if body.base is not None:
        below, modulus = below + half_space(body.base), body.base.shear_modulus
    for thickness, material, _ in reversed(slices):
        below = below * (material.shear_modulus / modulus)
        modulus = material.shear_modulus
        belows.append(below)
        down = np.empty_like(below)
        below = through(below, q * thickness, material, down)
        downs.append(down)

    rows, columns = pressure.shape if kept is None else kept

    def back(*factors: NDArray[Any]) -> Array:
        fields = np.empty((len(factors), rows, columns))
        for field, factor in zip(fields, factors, strict=True):
            lines = fft.ifft(amplitude[:, :alive] * factor, axis=0, overwrite_x=True)[:rows]
            field[:] = fft.irfft(lines, pressure.shape[1], axis=1)[:, :columns]
        return fields

    # From the top down, tractions of unit pressure.
    traction = np.zeros((q.size, 2))
    traction[:, 1] = -1.0
    for (_, material, depth), down, below in zip(
        slices, reversed(downs), reversed(belows), strict=True
    ):
        traction = (down @ traction[:, :, None])[:, :, 0]
        if depth not in depths:
            continue
        nu, modulus = material.poisson_ratio, material.shear_modulus
        shear, normal = traction.T
        sideways, sunk = (below @ traction[:, :, None])[:, :, 0].T / (modulus * q)
        along = (2 * modulus * q * sideways + nu * normal) / (1 - nu)
        across = nu * (along + normal)
        alive = int(np.count_nonzero(qy[0] * depth < _DEAD))
        state = np.stack([along, across, normal, shear, sideways, sunk])
        state = np.take(state, waves[:, :alive], axis=1)
        # the mean is squeezed, and nothing moves sideways
        state[:, 0, 0] = -nu / (1 - nu), -nu / (1 - nu), -1.0, 0.0, 0.0, 0.0
        along, across, normal, shear, sideways, sunk = state
        cosine, sine = cosines[:, :alive], sines[:, :alive]
        stress = back(
            cosine**2 * along + sine**2 * across,
            sine**2 * along + cosine**2 * across,
            normal,
            -1j * sine * shear,
            -1j * cosine * shear,
            cosine * sine * (along - across),
        )
        yield Inside(depth, back(-1j * cosine * sideways, -1j * sine * sideways, sunk), stress)


def _slices(body: Stack, depths: Array) -> list[tuple[float, Material, float]]:
    """Cut a body into slices of one material: thicknesses, materials, and where each ends."""
    ends, materials = np.cumsum(body.thicknesses), list(body.materials)
    if body.base is not None:
        materials.append(body.base)
    else:
        depths = depths[depths <= body.total]
    every = np.unique(np.concatenate([ends, depths]))
    starts = np.append(0.0, every[:-1])
    layers = np.searchsorted(ends, (starts + every) / 2)
    return [
        (float(end - start), materials[layer], float(end))
        for start, end, layer in zip(starts, every, layers, strict=True)
    ]
