r"""Stress and displacement inside a half-space or layers, under pressures on a grid of cells.

Each wave of pressure makes a state (U, W, T, S) of every depth (`stack`), from which

    s_nn = G q (2 U/(1 - nu) + nu/(1 - nu) S),  s_tt = nu (s_nn + s_zz),  s_zz = G q S,
    s_nz = G q T,

n along the wave and t across it. On the way down, as on the way up, nothing grows: with the
compliance R of what lies below, the tractions at the bottom of a slice are

    (T, S)_bottom = (E21 R + E22)^-1 (T, S)_top.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from reference.arguments import refuse, spacing_faults
from reference.elasticity import Material, von_mises
from reference.halfspace import kernels
from reference.layered.stack import Stack, half_space, shear_modulus, slice_matrix

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Waves over 2 pi that a field decays over before it is nothing.
_REACH = 24.0
# Lengths of waves that differ by less than this part of the largest are the same.
_DIGITS = 2.0**45


@dataclass(frozen=True)
class Inside:
    """Fields at one depth below the cells, tension positive.

    Attributes
    ----------
    depth : float
    displacement : ndarray, shape (3, nx, ny)
    stress : ndarray, shape (6, nx, ny)
        xx, yy, zz, yz, xz, xy.
    """

    depth: float
    displacement: Array
    stress: Array

    def cut(self, nx: int, ny: int) -> Inside:
        """Return the fields below the first cells of either side."""
        return Inside(
            self.depth,
            self.displacement[:, :nx, :ny].copy(),
            self.stress[:, :nx, :ny].copy(),
        )

    @property
    def von_mises(self) -> Array:
        """Return the equivalent stress of von Mises."""
        return von_mises(np.moveaxis(self.stress, 0, -1))


def inside(
    body: Stack, pressure: ArrayLike, spacing: tuple[float, float], depths: ArrayLike
) -> Iterator[Inside]:
    """Yield the fields at increasing depths under a pressure that repeats with its grid.

    A patch that does not repeat is given with empty cells around it.

    Parameters
    ----------
    body : Stack
    pressure : array_like, shape (nx, ny)
        At the centres of cells; the function through it is band-limited.
    spacing : (float, float)
    depths : array_like
        Positive and strictly increasing; those below a rigid base are left out.

    Examples
    --------
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
    waves = _Waves.of(pressure, spacing)
    lengths, wave = _different(waves.length)
    parts = _cut(body, depths)
    matrices, below = _upwards(body, parts, lengths)
    traction = np.zeros((lengths.size, 2))
    traction[:, 1] = -1.0  # of unit pressure
    for (_, material, depth), matrix, compliance in zip(parts, matrices, below, strict=True):
        traction = (matrix @ traction[:, :, None])[:, :, 0]
        if depth in depths:
            moved = (compliance @ traction[:, :, None])[:, :, 0]
            yield waves.fields(depth, material, traction[wave], moved[wave])


def _different(lengths: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the lengths that differ, and for each of all the place of its like.

    Bodies are isotropic, so that waves of one length have one state: some seventh of a square grid.
    """
    keys = np.rint(lengths * (_DIGITS / lengths.max()))
    _, first, wave = np.unique(keys, return_index=True, return_inverse=True)
    return lengths[first], wave


@dataclass(frozen=True)
class _Waves:
    """Transform of a pressure: amplitudes, wavenumbers and directions of all waves but the mean."""

    shape: tuple[int, int]
    amplitude: Complex
    length: Array
    along: Array
    across: Array

    @classmethod
    def of(cls, pressure: Array, spacing: tuple[float, float]) -> _Waves:
        qx, qy = np.broadcast_arrays(*kernels.wavenumbers(pressure.shape, spacing))
        length = np.hypot(qx, qy).ravel()
        # the mean has no direction; as a wave it counts with the shortest
        safe = np.where(length > 0, length, length.max() or 1.0)
        directions = [q.ravel() / safe for q in (qx, qy)]
        amplitude = fft.rfft2(pressure, workers=1).ravel()
        return cls(pressure.shape, amplitude, safe, *directions)

    def fields(
        self, depth: float, material: Material, traction: Array, displacement: Array
    ) -> Inside:
        """Return the fields of states of unit pressure; displacements in units of 1/(G q)."""
        nu, modulus = material.poisson_ratio, shear_modulus(material)
        moved = displacement / (modulus * self.length[:, None])
        shear, normal = traction.T.copy()
        stretch = modulus * self.length * moved[:, 0]
        along = 2 * stretch / (1 - nu) + nu / (1 - nu) * normal
        across = nu * (along + normal)
        # the mean is squeezed, and nothing moves sideways
        along[0] = across[0] = -nu / (1 - nu)
        normal[0], shear[0], moved[0] = -1.0, 0.0, 0.0
        c, s = self.along, self.across
        c[0], s[0] = 1.0, 0.0
        stress = (
            c**2 * along + s**2 * across,
            s**2 * along + c**2 * across,
            normal,
            -1j * s * shear,
            -1j * c * shear,
            c * s * (along - across),
        )
        shift = (-1j * c * moved[:, 0], -1j * s * moved[:, 0], moved[:, 1])
        return Inside(depth, self._back(shift), self._back(stress))

    def _back(self, factors: Sequence[NDArray[Any]]) -> Array:
        half = self.shape[0], self.shape[1] // 2 + 1
        fields = np.empty((len(factors), *self.shape))
        for field, part in zip(fields, factors, strict=True):
            field[:] = fft.irfft2((self.amplitude * part).reshape(half), self.shape, workers=1)
        return fields


Part = tuple[float, Material, float]


def _cut(body: Stack, depths: Array) -> list[Part]:
    """Return slices of one material down to the deepest depth, and where each of them ends."""
    ends, materials = np.cumsum(body.thicknesses), list(body.materials)
    bottom = depths[-1] if body.base is not None else min(depths[-1], body.total)
    every = np.unique(np.concatenate([ends[ends < bottom], depths[depths <= bottom]]))
    if body.base is not None:
        materials.append(body.base)
    starts = np.append(0.0, every[:-1])
    layers = np.searchsorted(ends, (starts + every) / 2)
    return [
        (float(end - start), materials[layer], float(end))
        for start, end, layer in zip(starts, every, layers, strict=True)
    ]


def _upwards(body: Stack, parts: list[Part], q: Array) -> tuple[list[Array], list[Array]]:
    """Return what takes tractions down through each slice, and the compliance at its bottom.

    Both in units of 1/(G q) of the slice's material.
    """
    compliance, modulus = _under(body, parts, q)
    matrices: list[Array] = []
    below: list[Array] = []
    for thickness, material, _ in reversed(parts):
        compliance = compliance * (shear_modulus(material) / modulus)
        modulus = shear_modulus(material)
        below.append(compliance)
        matrix, compliance = _passed(compliance, q * thickness, material)
        matrices.append(matrix)
    return matrices[::-1], below[::-1]


def _under(body: Stack, parts: list[Part], q: Array) -> tuple[Array, float]:
    """Return the compliance of what lies below the slices, in units of 1/(G q), and G."""
    bottom = parts[-1][2]
    modulus, compliance = 1.0, np.zeros((q.size, 2, 2))
    if body.base is not None:
        modulus, compliance = shear_modulus(body.base), compliance + half_space(body.base)
    ends = np.cumsum(body.thicknesses)
    for thickness, material, end in reversed(
        list(zip(body.thicknesses, body.materials, ends, strict=True))
    ):
        left = min(thickness, end - bottom)
        if left <= 1e-12 * thickness:
            break
        compliance = compliance * (shear_modulus(material) / modulus)
        modulus = shear_modulus(material)
        _, compliance = _passed(compliance, q * left, material)
    return compliance, modulus


def _passed(below: Array, depth: Array, material: Material) -> tuple[Array, Array]:
    """Return what takes tractions down through a slice of thickness q t, and the compliance above.

    Where the slice is so thick that nothing comes through, the first is zero.
    """
    hidden = depth > _REACH
    slices = np.ceil(np.minimum(depth, _REACH)).astype(int)
    compliance = np.where(hidden[:, None, None], half_space(material), below)
    down = np.where(hidden[:, None, None], 0.0, np.eye(2))
    for count in range(1, int(slices.max(initial=0)) + 1):
        active = (slices >= count) & ~hidden
        matrix = slice_matrix(depth[active] / slices[active], material)
        known = compliance[active]
        rows = matrix[:, :2, :2] @ known + matrix[:, :2, 2:]
        inverse = np.linalg.inv(matrix[:, 2:, :2] @ known + matrix[:, 2:, 2:])
        moved = rows @ inverse
        compliance[active] = (moved + moved.transpose(0, 2, 1)) / 2
        down[active] = down[active] @ inverse
    return down, compliance
