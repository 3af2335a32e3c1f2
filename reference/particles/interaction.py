r"""Forces between automata: pair strains, and a mean stress that depends on all neighbours.

An automaton i has a displacement u and a rotation theta. With n from i to its neighbour j, lengths
in units of the spacing,

    eps   = (u_j - u_i) . n
    gamma = (u_j - u_i) - eps n - (theta_i + theta_j)/2 x n
    tr_i  = sum_j eps / 4
    sigma = 2 G eps + lambda (tr_i + tr_j)/2,   tau = 2 G gamma

(S. G. Psakhie et al., Phys. Mesomech. 14 (2011) 224: with sigma_m = K tr their sigma = 2 G eps +
(1 - 2 G/(3 K)) (sigma_m,i + sigma_m,j)/2 is this). The pair pulls with the force S (sigma n + tau)
and turns both with S/2 n x tau. A homogeneous strain gives Hooke's stress exactly: over the twelve
directions sum n n = 4, and normal and tangential parts have the same modulus.

All of it is the derivative of an energy,

    W = sum_pairs (V/2) G (eps^2 + gamma^2) + sum_i (V/2) lambda tr_i^2,

so that the stiffness is symmetric; it is positive wherever the bulk modulus is. Automata that the
surface cuts in half have V/2, half a face to each other, and tr = (sum_level eps + 2 sum_below
eps)/4: that of the strain again.

Automata that have flowed have a plastic strain e each, without change of volume; a bond has the
mean of both ends, so that eps n + gamma becomes eps n + gamma - (e_i + e_j)/2 n.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.arguments import poisson_faults, refuse
from reference.halfspace import pieces
from reference.particles.packing import DIRECTIONS, FACE, LEVEL, VOLUME, Packing

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

# Plastic strains of automata none of which has flowed.
UNFLOWED = np.empty((0, 3, 3))
# Automata in a piece that threads share (`reference.halfspace.pieces`).
PIECE = 2**13
# The order of `fem.recovery`.
ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@dataclass(frozen=True)
class Elastic:
    """Moduli of an isotropic elastic material in units of Young's modulus.

    Raises
    ------
    ValueError
        If nu is not in (-1, 0.5): the mean stress follows the strain, which incompressible
        automata would not have.
    """

    poisson_ratio: float

    def __post_init__(self) -> None:
        faults = poisson_faults(self.poisson_ratio)
        if self.poisson_ratio == 0.5:
            faults = [
                "poisson_ratio must be below 0.5: mean stress follows from a change of volume"
            ]
        refuse(faults)

    @property
    def shear(self) -> float:
        """G/E = 1/(2 (1 + nu))."""
        return 0.5 / (1 + self.poisson_ratio)

    @property
    def lame(self) -> float:
        """lambda/E = nu/((1 + nu)(1 - 2 nu))."""
        return self.poisson_ratio / ((1 + self.poisson_ratio) * (1 - 2 * self.poisson_ratio))


@dataclass(frozen=True, eq=False)
class Automata:
    """A packing of one elastic material: forces that follow from displacements.

    Lengths are in units of the spacing, forces of E r0^2.
    """

    packing: Packing
    material: Elastic

    def strains(self, moved: Floats, traces: Floats) -> None:
        """Write the relative changes of volume of the automata that may move.

        Parameters
        ----------
        moved : (n, 6) ndarray
            Displacements and rotations of all automata.
        traces : (n,) ndarray
            Of those that are held they are given, because their neighbours outside are not there.
        """
        near, surface, _ = self._bonds
        free = self.packing.free
        _shared(free, lambda *part: _strains(part, moved, near, surface, traces))

    def forces(
        self, moved: Floats, traces: Floats, out: Floats, flowed: Floats = UNFLOWED
    ) -> Floats:
        """Write and return forces and torques (free, 6) on the automata that may move.

        Parameters
        ----------
        moved, traces : ndarray
            As for `strains`, which is called first.
        out : (free, 6) ndarray
        flowed : (n, 3, 3) ndarray
            Plastic strains.
        """
        self.strains(moved, traces)
        state, bonds = (moved, traces, flowed), self._bonds
        _shared(len(out), lambda *part: _forces(part, state, bonds, out))
        return out

    def stresses(self, moved: Floats, traces: Floats, flowed: Floats = UNFLOWED) -> Floats:
        """Return the stress tensors (free, 3, 3) in units of E.

        The mean of what pulls at the faces, sum n (force) r0/(2 V): of a homogeneous strain it is
        Hooke's stress.
        """
        out = np.empty((self.packing.free, 3, 3))
        state, bonds = (moved, traces, flowed), self._bonds
        _shared(len(out), lambda *part: _stresses(part, state, bonds, out))
        return out

    @property
    def _bonds(self) -> tuple[Integers, int, tuple[float, float]]:
        moduli = self.material.shear, self.material.lame
        return self.packing.neighbours, self.packing.surface, moduli


def components(stresses: Floats) -> Floats:
    """Return xx, yy, zz, yz, xz, xy (n, 6) of the symmetric parts of tensors (n, 3, 3).

    >>> components(np.arange(9.0).reshape(1, 3, 3)).tolist()
    [[0.0, 4.0, 8.0, 6.0, 4.0, 2.0]]
    """
    symmetric = 0.5 * (stresses + np.swapaxes(stresses, 1, 2))
    return np.stack([symmetric[:, a, b] for a, b in ENTRIES], axis=1)


def _shared(count: int, work: Callable[[int, int], None]) -> None:
    """Let threads share automata: each is written by one of them, from what none of them writes."""
    pieces.over(count, PIECE, lambda part: work(part.start, part.stop))


@njit(cache=True, nogil=True, error_model="numpy")
def _strains(
    part: tuple[int, int], moved: Floats, neighbours: Integers, surface: int, out: Floats
) -> None:
    for i in range(*part):
        total = 0.0
        for k in range(12):
            j = neighbours[i, k]
            if j < 0:
                continue
            share = 0.5 if i < surface and k >= LEVEL else 0.25
            for axis in range(3):
                total += share * (moved[j, axis] - moved[i, axis]) * DIRECTIONS[k, axis]
        out[i] = total


@njit(cache=True, error_model="numpy", inline="always")
def _pull(
    moved: Floats, flowed: Floats, i: int, j: int, k: int
) -> tuple[float, float, float]:  # pragma: no cover - compiled
    """Return eps n + gamma of a bond: all relative motion but the common rotation and flow."""
    nx, ny, nz = DIRECTIONS[k, 0], DIRECTIONS[k, 1], DIRECTIONS[k, 2]
    rx = 0.5 * (moved[j, 3] + moved[i, 3])
    ry = 0.5 * (moved[j, 4] + moved[i, 4])
    rz = 0.5 * (moved[j, 5] + moved[i, 5])
    x = moved[j, 0] - moved[i, 0] - (ry * nz - rz * ny)
    y = moved[j, 1] - moved[i, 1] - (rz * nx - rx * nz)
    z = moved[j, 2] - moved[i, 2] - (rx * ny - ry * nx)
    if len(flowed) > 0:
        for b in range(3):
            share = 0.5 * DIRECTIONS[k, b]
            x -= share * (flowed[i, 0, b] + flowed[j, 0, b])
            y -= share * (flowed[i, 1, b] + flowed[j, 1, b])
            z -= share * (flowed[i, 2, b] + flowed[j, 2, b])
    return x, y, z


@njit(cache=True, nogil=True, error_model="numpy")
def _forces(
    part: tuple[int, int],
    state: tuple[Floats, Floats, Floats],
    bonds: tuple[Integers, int, tuple[float, float]],
    out: Floats,
) -> None:
    (moved, traces, flowed), (neighbours, surface, moduli) = state, bonds
    shear, lame = 2.0 * moduli[0] * FACE, 0.5 * moduli[1] * FACE
    for i in range(*part):
        fx = fy = fz = mx = my = mz = 0.0
        for k in range(12):
            j = neighbours[i, k]
            if j < 0:
                continue
            share = 0.5 if i < surface and k < LEVEL else 1.0
            gx, gy, gz = _pull(moved, flowed, i, j, k)
            gx, gy, gz = share * shear * gx, share * shear * gy, share * shear * gz
            mean = share * lame * (traces[i] + traces[j])
            nx, ny, nz = DIRECTIONS[k, 0], DIRECTIONS[k, 1], DIRECTIONS[k, 2]
            fx += gx + mean * nx
            fy += gy + mean * ny
            fz += gz + mean * nz
            mx += ny * gz - nz * gy
            my += nz * gx - nx * gz
            mz += nx * gy - ny * gx
        out[i, 0], out[i, 1], out[i, 2] = fx, fy, fz
        out[i, 3], out[i, 4], out[i, 5] = 0.5 * mx, 0.5 * my, 0.5 * mz


@njit(cache=True, nogil=True, error_model="numpy")
def _stresses(
    part: tuple[int, int],
    state: tuple[Floats, Floats, Floats],
    bonds: tuple[Integers, int, tuple[float, float]],
    out: Floats,
) -> None:
    (moved, traces, flowed), (neighbours, surface, moduli) = state, bonds
    shear, lame = 2.0 * moduli[0] * FACE, 0.5 * moduli[1] * FACE
    for i in range(*part):
        volume = 0.5 * VOLUME if i < surface else VOLUME
        out[i] = 0.0
        for k in range(12):
            j = neighbours[i, k]
            if j < 0:
                continue
            share = (0.5 if i < surface and k < LEVEL else 1.0) * 0.5 / volume
            pull = _pull(moved, flowed, i, j, k)
            mean = share * lame * (traces[i] + traces[j])
            for a in range(3):
                for b in range(3):
                    force = share * shear * pull[b] + mean * DIRECTIONS[k, b]
                    out[i, a, b] += DIRECTIONS[k, a] * force
