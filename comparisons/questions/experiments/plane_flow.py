r"""Oil between nominally flat rough bodies: what roughness makes of its flow along the gap.

The gap h is periodic and zero where the bodies touch. Pressure that falls along x, and a smooth
plane that slides along x at U over the other body, which is at rest, drive

    div(h^3 grad p/(12 eta)) = U/2 dh/dx,
    <flow along x> = -phi_p <h>^3/(12 eta) <dp/dx> + phi_U <h> U/2,

with the factors of Patir & Cheng (J. Lubr. Technol. 100 (1978) 12; 101 (1979) 220), in terms of
the mean gap: theirs of shear flow is (1 - phi_U) <h>/h_rms for a rough body at rest. There is no
cavity: pressures are above the vapour's, or slopes of the gap small.

One solution has both. Let p fall by one per length, and psi be the pressure that sliding makes;
each tested with the other's equation, <h^3 dpsi/dx> = <h (1 + dp/dx)>, so that
phi_U = -<h dp/dx>/<h>.

**Formulas** for heights of rms s times the mean gap whose waves have <cos^2> = c with the flow. To
second order (Elrod 1979, Tripp 1983): phi_p = 1 + 3 s^2 (1 - 3 c), phi_U = 1 - 3 s^2 c. From
div h^3 grad p = 0 with h = 1 + d, p = -x + p1: p1 = -3i q_x d/q^2, and
<h^3 dp/dx> = -(1 + 3 <d^2> - 9 <d^2 cos^2>). A fit, isotropic: 1 - 0.90 exp(-0.56/s) (Patir & Cheng
1978). An effective medium of conductances h^3, which closes where half of the area touches:
<(h^3 - K)/(h^3 + K)> = 0 (Bruggeman 1935).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.optimize import brentq
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.sparse.linalg import splu

from reference.arrays import Array, Mask
from reference.errors import ConvergenceError, positive_faults, refuse

# Of what the widest cell lets through: factors are judged to parts in a hundred.
_BALANCED = 1e-8


@dataclass(frozen=True)
class PlaneFlow:
    """The flow along x through a rough gap.

    `pressure_factor` is phi_p, `shear_factor` phi_U: zero where spots of contact close every way
    through, and the gap is not `open`. `flow` (nx, ny) is that of oil through the face behind each
    cell along x, under a pressure that falls by one per length, times 12 eta. `imbalance` is the
    largest one of mass in a cell, relative to the flow through the widest one.
    """

    pressure_factor: float
    shear_factor: float
    open: bool
    flow: Array = field(repr=False)
    imbalance: float


def plane_flow(gap: ArrayLike) -> PlaneFlow:
    """Return what a periodic gap on square cells lets through along x.

    Between the centres of two cells the gap is that of either, a half each: flow across stripes is
    by the mean of h^-3, along them by that of h^3. The gap, zero in contact, has at least 3 cells
    along both axes.

    Stripes along the flow, of gaps 1 and 3: the mean of the cubes is 14, the cube of the mean 8.

    >>> stripes = np.ones((4, 1)) * np.array([1.0, 1.0, 3.0, 3.0])
    >>> round(plane_flow(stripes).pressure_factor, 6)
    1.75
    """
    h = np.asarray(gap, dtype=np.float64)
    faults = []
    if h.ndim != 2 or min(h.shape, default=0) < 3:
        faults.append(f"gap must have two axes of at least 3 cells, not shape {h.shape}")
    elif not (np.isfinite(h).all() and (h >= 0).all()):
        faults.append("gap must be finite and not negative")
    elif not h.any():
        faults.append("gap must be open somewhere")
    refuse(faults)
    mean = float(h.mean())
    # a gap of any unit has cubes near one
    h = h / mean
    ways = _ways_through(h > 0)
    if not ways.any():
        return PlaneFlow(0.0, 0.0, False, np.zeros(h.shape), 0.0)
    h = np.where(ways, h, 0.0)
    # flows factor * (p before - p after) out of the open cells
    conductance = _between(h, 0, 3), _between(h, 1, 3)
    open_cells = np.flatnonzero(h)
    size = open_cells.size
    index = np.arange(h.size).reshape(h.shape)
    cells, matrix = sparse.eye_array(h.size, format="csr"), sparse.csr_array((size, size))
    for axis in (0, 1):
        factor = conductance[axis].ravel()
        faces = np.flatnonzero(factor)
        steps = (cells[np.roll(index, -1, axis).ravel()] - cells)[faces][:, open_cells]
        matrix += steps.T @ sparse.diags_array(factor[faces]) @ steps
    right = (np.roll(conductance[0], 1, 0) - conductance[0]).ravel()[open_cells]
    # pressure, beside the mean one -x, is known but for a constant in every connected piece
    _, labels = connected_components(matrix, directed=False)
    held = np.unique(labels, return_index=True)[1]
    free = np.setdiff1d(np.arange(size), held)
    reduced = matrix[free][:, free].tocsc()
    # so sparse columns are not worth gathering into panels, which take twice as long
    factors = splu(
        reduced, permc_spec="MMD_AT_PLUS_A", panel_size=1, options={"SymmetricMode": True}
    )
    solution = np.zeros(h.size)
    solution[open_cells[free]] = factors.solve(right[free])
    pressure = solution.reshape(h.shape)
    along, aside = (np.roll(pressure, -1, axis) - pressure for axis in (0, 1))
    flow, across = conductance[0] * (1 - along), -conductance[1] * aside
    kept = flow - np.roll(flow, 1, 0) + across - np.roll(across, 1, 1)
    imbalance = float(np.abs(kept).max() / (conductance[0] + conductance[1]).max())
    if not imbalance <= _BALANCED:
        raise ConvergenceError(f"cells keep {imbalance:.1e} of the flow; the gap varies too widely")
    # half of the way on either side: a sliding plane carries <h^-2>/<h^-3> through a face
    thick = _between(h, 0, 2)
    carried = np.divide(conductance[0], thick, out=np.zeros(h.shape), where=thick > 0)
    return PlaneFlow(
        # what is dissipated, equal to <flow> but second order in errors of pressure: behind a
        # narrow neck what flows is below the round-off of what a wide gap lets through
        pressure_factor=float((flow * (1 - along) - across * aside).mean()),
        shear_factor=float((carried * (1 - along)).mean()),
        open=True,
        flow=flow * mean**3,
        imbalance=imbalance,
    )


def _between(h: Array, axis: int, power: int) -> Array:
    """Return one over the mean of h^-power of every cell and the next; zero beside contact."""
    # beyond the largest number, flow through a gap is none
    with np.errstate(divide="ignore", over="ignore"):
        inverse = h ** -float(power)
        return 2 / (inverse + np.roll(inverse, -1, axis))


def _ways_through(open_cells: Mask) -> Mask:
    """Return the open cells from which a way along x leads to their own image a period on.

    Along a tree through the cells each has a period in which it lies; a face whose cells disagree
    closes a loop around the torus.
    """
    index = np.arange(open_cells.size).reshape(open_cells.shape)
    before, after, winding = [], [], []
    for axis in (0, 1):
        both = open_cells & np.roll(open_cells, -1, axis)
        before.append(index[both])
        after.append(np.roll(index, -1, axis)[both])
        seam = (index // open_cells.shape[1] == open_cells.shape[0] - 1) & (axis == 0)
        winding.append(seam[both].astype(int))
    start, end, wound = (np.concatenate(parts) for parts in (before, after, winding))
    size = open_cells.size
    graph = sparse.coo_matrix((np.ones(start.size), (start, end)), shape=(size, size))
    _, labels = connected_components(graph, directed=False)
    # how many periods along x lie between each cell and the root of its tree; a root of all roots,
    # so that one search reaches every cell
    roots = np.unique(labels, return_index=True)[1]
    rows = np.concatenate([start, np.full(roots.size, size)])
    columns = np.concatenate([end, roots])
    shape = size + 1, size + 1
    joined = sparse.coo_matrix((np.ones(rows.size), (rows, columns)), shape=shape).tocsr()
    _, parent = breadth_first_order(joined, size, directed=False)
    up = np.where((parent[:size] < 0) | (parent[:size] == size), np.arange(size), parent[:size])
    step = np.arange(size) // open_cells.shape[1] - up // open_cells.shape[1]
    # only across the seam is a neighbour farther than a row
    period = np.where(np.abs(step) == open_cells.shape[0] - 1, -np.sign(step), 0)
    while (up[up] != up).any():
        period = period + period[up]
        up = up[up]
    loops = period[start] + wound != period[end]
    leaking = np.isin(labels, np.unique(labels[start[loops]]))
    return leaking.reshape(open_cells.shape) & open_cells


def second_order_factors(roughness: float) -> tuple[float, float]:
    """Return the flow factors of pressure and of sliding, to second order in the heights.

    Isotropic; `roughness` is rms height over mean gap.
    """
    refuse([] if 0 <= roughness < np.inf else ["roughness must be finite and not negative"])
    return 1 - 1.5 * roughness**2, 1 - 1.5 * roughness**2


def patir_cheng_factor(roughness: float) -> float:
    """Return the pressure factor of an isotropic Gaussian surface of rms up to twice the gap."""
    refuse(positive_faults(roughness=roughness))
    return 1 - 0.90 * float(np.exp(-0.56 / roughness))


def effective_medium_factor(gaps: ArrayLike) -> float:
    """Return the pressure factor of gaps of equal areas that lie beside each other at random.

    Half closed is closed; without contact the mean is between those of h^-3 and of h^3.

    >>> effective_medium_factor([0.0, 1.0])
    0.0
    >>> round(effective_medium_factor([1.0, 3.0]), 4)
    0.6495
    """
    h = np.asarray(gaps, dtype=np.float64)
    valid = h.size > 0 and bool((np.isfinite(h) & (h >= 0)).all())
    refuse([] if valid else ["gaps must be finite and not negative, one at least"])
    if not h.any():
        return 0.0
    cubes = (h / h.mean()) ** 3
    if 2 * np.count_nonzero(cubes) <= h.size:
        return 0.0

    def excess(conductance: float) -> float:
        return float(((cubes - conductance) / (cubes + conductance)).mean())

    most = float(cubes.max())
    least = float(cubes[cubes > 0].min()) * np.finfo(float).eps
    return float(brentq(excess, least, most, xtol=least, rtol=1e-12))
