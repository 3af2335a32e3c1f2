r"""Automata: their dense packings, pair strains, and a mean stress that depends on all neighbours.

Automata of equal size fill a body in face-centred cubic order, each with twelve neighbours at the
distance r0, the length unit of this package. A square net of automata makes the surface z = 0, z
into the body; each further layer lies 1/sqrt(2) deeper, half a spacing to the side.

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

Units: the spacing, Young's modulus and the density; times are in r0 sqrt(rho/E). An automaton has
the mass V and, as a ball of diameter r0, the moment of inertia V/10.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.arrays import Array, Modes
from reference.contact import pieces
from reference.errors import poisson_faults, positive_faults, refuse

# Constants, which functions compiled by numba use, too. Volume of an automaton and area of the face
# between two, in units of r0.
VOLUME, FACE = 1 / np.sqrt(2), 1 / (2 * np.sqrt(2))
LAYER = 1 / np.sqrt(2)
# Steps to the twelve neighbours in half spacings along x and y, and in layers. Bond k and k ^ 1 are
# opposite; the first four lie in a layer.
STEPS = np.array(
    [
        *([2, 0, 0], [-2, 0, 0], [0, 2, 0], [0, -2, 0]),
        *([1, 1, 1], [-1, -1, -1], [1, -1, 1], [-1, 1, -1]),
        *([-1, 1, 1], [1, -1, -1], [-1, -1, 1], [1, 1, -1]),
    ]
)
UNITS = np.array([0.5, 0.5, LAYER])
DIRECTIONS = STEPS * UNITS
LEVEL = 4
NONE = -1
# Plastic strains of automata none of which has flowed.
UNFLOWED = np.empty((0, 3, 3))
# Automata in a piece that threads share (`reference.contact.pieces`).
PIECE = 2**13
# Of an automaton: mass, and moment of inertia.
MASSES = VOLUME * np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])
# The order of `fem.recover`.
ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@dataclass(frozen=True, eq=False)
class Packing:
    """Automata in face-centred cubic order.

    `places` (n, 3) are centres in units of r0; those that move, `free` in number, come first, then
    those that are held. `neighbours` (n, 12) are in each of `DIRECTIONS`, `NONE` where there is
    none. The first `surface` automata lie at z = 0, which cuts them and the bonds between them in
    half: a homogeneous strain then pulls at each with the traction on r0^2 exactly.
    """

    places: Array
    neighbours: NDArray[np.int32]
    free: int
    surface: int = 0


@dataclass(frozen=True)
class Domain:
    """Sizes of a body of automata in units of their spacing.

    Half-widths of the region that may be loaded, and the automata around and below it.
    """

    loaded: tuple[float, float]
    margin: float

    def __post_init__(self) -> None:
        half_x, half_y = self.loaded
        refuse(positive_faults(loaded_x=half_x, loaded_y=half_y, margin=self.margin))

    @property
    def half_widths(self) -> tuple[float, float, float]:
        """Semi-axes of the half ellipsoid."""
        half_x, half_y = self.loaded
        return half_x + self.margin, half_y + self.margin, np.sqrt(half_x * half_y) + self.margin

    @property
    def count(self) -> float:
        """Number of automata, about.

        >>> round(Domain((4.5, 4.5), 10.5).count / 1000)
        12
        """
        x, y, z = (half + 1.0 for half in self.half_widths)
        return float(np.sqrt(2) * 2 / 3 * np.pi * x * y * z)


def half_space_packing(half_widths: tuple[float, float, float]) -> Packing:
    """Return half an ellipsoid below the surface, in a shell of automata that are held.

    Semi-axes in units of r0, at least two. The shell consists of all automata outside that have a
    neighbour inside. An automaton lies at the centre of the surface.
    """
    axes = np.asarray(half_widths, dtype=float)
    if axes.shape != (3,) or not (np.isfinite(axes).all() and (axes >= 2).all()):
        refuse([f"half_widths must be three numbers of at least 2 spacings, not {half_widths!r}"])
    # the sites within a box below the surface: even numbers along x and y in even layers, else odd
    half_x, half_y, depth = np.ceil((axes + 1.5) / UNITS).astype(int)
    layers = []
    for layer in range(depth + 1):
        x, y = (np.arange(-n - (n + layer) % 2, n + 2, 2) for n in (half_x, half_y))
        net = np.stack(np.meshgrid(x, y, [layer], indexing="ij"), axis=-1)
        layers.append(net.reshape(-1, 3).astype(np.int32))
    nodes = np.concatenate(layers)
    # their neighbours
    corner = nodes.min(axis=0) - 2
    number = np.full(nodes.max(axis=0) - corner + 3, NONE, dtype=np.int32)
    number[tuple((nodes - corner).T)] = np.arange(len(nodes))
    near = np.empty((len(nodes), len(STEPS)), dtype=np.int32)
    for k, step in enumerate(STEPS - corner):
        near[:, k] = number[tuple((nodes + step).T)]
    # those inside, then the shell
    inside = ((nodes * UNITS / axes) ** 2).sum(axis=1) <= 1
    touched = np.zeros(len(nodes) + 1, dtype=bool)  # the last one stands for "none"
    touched[near[inside]] = True
    keep = np.concatenate([np.flatnonzero(inside), np.flatnonzero(touched[:-1] & ~inside)])
    number = np.full(len(nodes) + 1, NONE, dtype=np.int32)
    number[keep] = np.arange(len(keep), dtype=np.int32)
    surface = int((inside & (nodes[:, 2] == 0)).sum())
    return Packing(nodes[keep] * UNITS, number[near[keep]], int(inside.sum()), surface)


def periodic_packing(counts: tuple[int, int, int]) -> Packing:
    """Return a block of `counts` spacings along x and y, and pairs of layers, without a surface.

    It repeats itself in all directions: every automaton has twelve neighbours and may move. At
    least two along each.
    """
    if min(counts) < 2:
        refuse([f"counts must be at least 2, not {counts!r}"])
    first = 2 * np.indices(counts, dtype=np.int32).reshape(3, -1).T
    nodes = np.concatenate([first, first + 1])
    period = 2 * np.array(counts)
    number = np.full(period, NONE, dtype=np.int32)
    number[tuple(nodes.T)] = np.arange(len(nodes))
    neighbours = [number[tuple(((nodes + step) % period).T)] for step in STEPS]
    return Packing(nodes * UNITS, np.stack(neighbours, axis=1), len(nodes))


def moduli(poisson_ratio: float) -> tuple[float, float]:
    """Return lambda/E = nu/((1 + nu)(1 - 2 nu)) and G/E = 1/(2 (1 + nu)); nu = 1/2 has none."""
    if poisson_ratio == 0.5:
        refuse(["poisson_ratio must be below 0.5: mean stress follows from a change of volume"])
    refuse(poisson_faults(poisson_ratio))
    shear = 0.5 / (1 + poisson_ratio)
    return 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio), shear


class Automata:
    """A packing of one elastic material: forces that follow from displacements.

    Lengths are in units of the spacing, moduli of E, forces of E r0^2.
    """

    def __init__(self, packing: Packing, poisson_ratio: float) -> None:
        self.packing, self.poisson_ratio = packing, poisson_ratio
        self.lame, self.shear = moduli(poisson_ratio)

    def strains(self, moved: Array, traces: Array) -> None:
        """Write the relative changes of volume (n,) of the automata that may move.

        From displacements and rotations (n, 6) of all; those of held automata are given.
        """
        near, surface = self.packing.neighbours, self.packing.surface
        pieces.over(
            self.packing.free,
            PIECE,
            lambda part: _strains(part.start, part.stop, moved, near, surface, traces),
        )

    def forces(self, moved: Array, traces: Array, out: Array, flowed: Array = UNFLOWED) -> Array:
        """Write and return forces and torques (free, 6) on the automata that may move.

        Changes of volume as for `strains`, which is called first; `flowed` (n, 3, 3) are plastic
        strains.
        """
        self.strains(moved, traces)
        return self._over(_forces, moved, traces, flowed, out)

    def stresses(self, moved: Array, traces: Array, flowed: Array = UNFLOWED) -> Array:
        """Return the stress tensors (free, 3, 3) in units of E.

        The mean of what pulls at the faces, sum n (force) r0/(2 V): of a homogeneous strain it is
        Hooke's stress.
        """
        return self._over(_stresses, moved, traces, flowed, np.empty((self.packing.free, 3, 3)))

    def _over(self, compiled: Callable, *fields: Array) -> Array:
        """Let threads share automata: each writes to the last of the fields, reads the others."""
        *read, out = fields
        near, surface = self.packing.neighbours, self.packing.surface
        given = *read, near, surface, self.shear, self.lame, out
        pieces.over(len(out), PIECE, lambda part: compiled(part.start, part.stop, *given))
        return out


def components(stresses: Array) -> Array:
    """Return xx, yy, zz, yz, xz, xy (n, 6) of the symmetric parts of tensors (n, 3, 3).

    >>> components(np.arange(9.0).reshape(1, 3, 3)).tolist()
    [[0.0, 4.0, 8.0, 6.0, 4.0, 2.0]]
    """
    symmetric = 0.5 * (stresses + np.swapaxes(stresses, 1, 2))
    return np.stack([symmetric[:, a, b] for a, b in ENTRIES], axis=1)


def wave_stiffness(poisson_ratio: float, wave: Array) -> Modes:
    """Return the (6, 6) Hermitian stiffness of an automaton in a plane wave of the packing.

    From the energy, bond by bond.
    """
    lame, shear = moduli(poisson_ratio)
    total = np.zeros((6, 6), dtype=complex)
    volume = np.zeros(3, dtype=complex)
    for normal in DIRECTIONS:
        there = np.exp(1j * wave @ normal)
        volume += 0.25 * (there - 1) * normal
        # relative displacement less the common rotation: eps n + gamma
        cross = np.array(
            [
                [0.0, -normal[2], normal[1]],
                [normal[2], 0.0, -normal[0]],
                [-normal[1], normal[0], 0.0],
            ]
        )
        strain = np.hstack([(there - 1) * np.eye(3), 0.5 * (there + 1) * cross])
        # each bond belongs to two automata, and has 2 G of V/4 in its face
        total += shear * FACE * strain.conj().T @ strain
    total[:3, :3] += VOLUME * lame * np.outer(volume.conj(), volume)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _strains(first, end, moved, neighbours, surface, out):
    for i in range(first, end):
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
def _pull(moved, flowed, i, j, k):  # pragma: no cover - compiled
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
    first, end, moved, traces, flowed, neighbours, surface, shear_modulus, lame_modulus, out
):
    shear, lame = 2.0 * shear_modulus * FACE, 0.5 * lame_modulus * FACE
    for i in range(first, end):
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
    first, end, moved, traces, flowed, neighbours, surface, shear_modulus, lame_modulus, out
):
    shear, lame = 2.0 * shear_modulus * FACE, 0.5 * lame_modulus * FACE
    for i in range(first, end):
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
