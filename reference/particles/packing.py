"""Dense packings of automata: places, bonds, and what lies on the surface.

Automata of equal size fill a body in face-centred cubic order, each with twelve neighbours at the
distance r0, the length unit of this package. A square net of automata makes the surface z = 0, z
into the body; each further layer lies 1/sqrt(2) deeper, half a spacing to the side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse

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

Places = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Packing:
    """Automata in face-centred cubic order.

    `places` (n, 3) are centres in units of r0; those that move, `free` in number, come first, then
    those that are held. `neighbours` (n, 12) are in each of `DIRECTIONS`, `NONE` where there is
    none. The first `surface` automata lie at z = 0, which cuts them and the bonds between them in
    half: a homogeneous strain then pulls at each with the traction on r0^2 exactly.
    """

    places: Places
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
    neighbour inside. An automaton lies at the centre of the surface, so that a shape which has its
    first touch there touches it exactly.
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
