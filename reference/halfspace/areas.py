r"""Contact areas, patches, stiffness and energy of a solved half-space contact.

Counted cells give the area to first order: every cell at the rim counts fully or not at all. But
the solution contains the position of the contact line inside the cell. At a distance t inside a
smooth contact line the pressure is C sqrt(t), at a distance t outside the gap is (4/3) (C/E*)
t^(3/2) (K. L. Johnson, Contact Mechanics, 1985, ch. 4 and 5, Hertz; locally valid for any smooth
line). Along a grid line that crosses the rim at an angle to its normal, between the centres of the
last cell in contact and the first free one, h apart, the ratio of the two

    rho = gap E*/(p h) = (4/3) cos (1 - s)^(3/2) / s^(1/2)

gives the position s h of the line beyond the last centre, without C. With pressures uniform on
cells, and conditions at their centres, the ratio is slightly different, which

    (1 - s)^(3/2) / (s + 0.151) = 0.734 rho cos^(-0.82)

describes to 0.02 cells (rms) for Love's cells, fitted to Hertz contacts; other operators know by
how much it puts their rim too far out (`rim_excess`).

The shift of the rim from cell edges to this position, for an outline with curvature, changes the
area by a sum over the crossings and a constant per closed outline, 0.41 h^2 (Hertz contacts of 1 to
12 cells radius), outlines of holes counting negative: by the Gauss-Bonnet theorem the total
curvature of any outline is 2 pi. `tests/reference/test_halfspace_contact_line.py` has what is left.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy import special
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from reference.arrays import Array, Mask
from reference.contact.body import ElasticBody
from reference.contact.descent import descend
from reference.contact.press import Contact
from reference.errors import refuse, spacing_faults
from reference.halfspace.punches import EDGE_COMPLIANCE, EDGE_OFFSET

# Yastrebov, Anciaux & Molinari (2017): mean excess of counted area per cell edge of the rim
_PERIMETER_FACTOR = (np.pi - 1 + np.log(2)) / 24


@dataclass(frozen=True)
class Patches:
    """Connected contact patches: their number, their areas, and which cells are of which."""

    count: int
    areas: Array
    labels: NDArray[np.int32]  # k in the cells of areas[k - 1]; 0: no contact


def _checked(mask: ArrayLike, spacing: tuple[float, float]) -> Mask:
    """Return the mask as booleans, or raise ValueError with all errors."""
    values = np.asarray(mask)
    faults = []
    if values.ndim != 2:
        faults.append(f"mask must have two dimensions, not shape {values.shape}")
    if values.dtype.kind == "f" and np.isnan(values).any():
        faults.append(f"mask has {int(np.isnan(values).sum())} undefined (NaN) cells")
    faults += spacing_faults(spacing)
    refuse(faults)
    return values.astype(bool)


def raw_area(mask: ArrayLike, spacing: tuple[float, float]) -> float:
    """Return the area of the counted cells, 25-35 % too large for rough contacts at low load.

    >>> raw_area([[True, False], [True, True]], (1.0, 2.0))
    6.0
    """
    mask = _checked(mask, spacing)
    return float(np.count_nonzero(mask) * spacing[0] * spacing[1])


def corrected_area(mask: ArrayLike, spacing: tuple[float, float], periodic: bool = False) -> float:
    r"""Return the contact area with the perimeter correction of Yastrebov, Anciaux & Molinari.

        A = A_cells - ((pi - 1 + ln 2)/24) S dx,

    S the perimeter counted along cell edges (V. A. Yastrebov, G. Anciaux and J.-F. Molinari,
    Tribol. Int. 114 (2017) 161). For rectangular cells an edge counts as its length times the cell
    size transverse to it, so that S dx becomes (number of edges) dx dy. Edges on the rim of a free
    patch are not counted, because the contact ends exactly there. A cell has at most four edges, so
    the result is at least 0.52 of the raw area. Contacts with a given outline, like flat punches,
    are not overestimated by counting and must not be corrected.

    >>> mask = np.zeros((5, 5), dtype=bool)
    >>> mask[2, 2] = True
    >>> round(corrected_area(mask, (1.0, 1.0)), 4)
    0.5275
    """
    mask = _checked(mask, spacing)
    edges = 0
    for axis in (0, 1):
        edges += int(np.count_nonzero(np.diff(mask, axis=axis)))
        if periodic:
            edges += int(np.count_nonzero(mask.take(0, axis) != mask.take(-1, axis)))
    return raw_area(mask, spacing) - float(_PERIMETER_FACTOR * edges * spacing[0] * spacing[1])


def patches(
    mask: ArrayLike, spacing: tuple[float, float] = (1.0, 1.0), periodic: bool = False
) -> Patches:
    """Return the connected contact patches; cells are adjacent across an edge, not a corner.

    With the default spacing areas are numbers of cells; periodic patches continue across opposite
    rims.

    >>> spots = patches([[1, 0, 1], [0, 0, 1], [1, 0, 0]], periodic=True)
    >>> spots.count, spots.areas.tolist()
    (1, [4.0])
    """
    mask = _checked(mask, spacing)
    labels, count = scipy.ndimage.label(mask)
    # of the contact alone: most of a large map is open
    cells = np.bincount(labels[mask], minlength=count + 1)
    if periodic and count:
        # labels that meet across opposite rims are one patch
        first = np.concatenate([labels[0, :], labels[:, 0]])
        last = np.concatenate([labels[-1, :], labels[:, -1]])
        meet = (first > 0) & (last > 0)
        pairs = (np.ones(meet.sum()), (first[meet], last[meet]))
        graph = coo_array(pairs, shape=(count + 1, count + 1))
        _, component = connected_components(graph, directed=False)
        # label 0 (no contact) has no neighbours and is the first component
        cells, count = np.bincount(component, weights=cells), int(component.max())
        labels = component[labels]
    areas = np.asarray(cells[1:] * float(spacing[0] * spacing[1]), float)
    return Patches(int(count), areas, labels)


@dataclass(frozen=True)
class Response:
    """Response of a fixed contact set to a unit of depth."""

    stiffness: float  # dF/dd; infinite where a whole period touches
    pressure: Array  # (nx, ny): dp/dd, of either sign
    mean_displacement: float  # of all cells


def contact_response(operator: ElasticBody, mask: ArrayLike, tolerance: float = 1e-6) -> Response:
    """Return the response of a fixed contact set to a unit of depth.

    K_CC x = 1 on the contact cells, dF/dd = sum(x) cell area, by conjugate gradients to a largest
    relative error of the unit displacement. Of an x that is not quite there sum(2 x - x K x) is
    taken: this functional is stationary at the solution, the stiffness its largest value, so that
    an error of x counts as its square. On the free half-space this is the stiffness of the flat
    punch of the same outline; on a uniform grid its error is about -34 %/n for n cells across, of
    order O(1/n), so it should be extrapolated.
    """
    mask = _checked(mask, operator.spacing)
    if mask.shape != operator.shape:
        raise ValueError(f"mask has shape {mask.shape}, the operator {operator.shape}")
    if not mask.any():
        return Response(0.0, np.zeros(mask.shape), 0.0)
    if mask.all() and operator.periodic and not operator.sinks:  # it only moves as a whole
        return Response(np.inf, np.full(mask.shape, np.inf), 1.0)
    # of either sign, on the mask; displaces its cells by one
    state = descend(
        operator,
        np.where(mask, 0.0, np.inf),
        np.zeros(operator.shape),
        "penetration",
        1.0,
        unilateral=False,
        tolerance=tolerance,
        max_iterations=2000,
    )
    stiffness = float((state.pressure * (2 - state.displacement)).sum() * operator.cell_area)
    return Response(stiffness, state.pressure, float(state.displacement.mean()))


def contact_stiffness(operator: ElasticBody, mask: ArrayLike, tolerance: float = 1e-6) -> float:
    """Return the stiffness dF/dd of a fixed contact set: see `contact_response`.

    A single cell has pi E* dx/(4 ln(1 + sqrt 2)).
    """
    return contact_response(operator, mask, tolerance).stiffness


def elastic_energy(operator: ElasticBody, pressure: ArrayLike) -> float:
    """Return the elastic energy of a pressure, 1/2 sum p u cell area (per period if periodic).

    >>> from reference.halfspace.kernels import FreeOperator
    >>> K = FreeOperator((1, 1), (1.0, 1.0), 1.0)
    >>> round(elastic_energy(K, [[2.0]]), 6)  # 1/2 * 2 * 2 * 4 ln(1 + sqrt 2)/pi
    2.244399
    """
    pressure = np.asarray(pressure, dtype=float)
    return float(0.5 * (pressure * operator.apply(pressure)).sum() * operator.cell_area)


# (1 - s)^(3/2) / (s + BEYOND) = RATIO rho cos^(-ANGLE); area per closed outline in cells
RATIO, BEYOND, ANGLE = 0.734, 0.151, 0.82
OUTLINE = 0.41
# Grid lines nearly tangential to the rim carry little information: they are weighted by the square
# of the cosine, and the law is not used beyond this angle.
_LEAST_COSINE = 0.3
# Smallest fraction of their cells that counts for single-cell spots, whose size is not resolved.
_LEAST_SHARE = 0.1
# Pressures are taken as different from here on, well above what a solver leaves of an error.
_MORE = 1 + 1e-6
_TINY = float(np.finfo(float).tiny)
# The law inverted: positions, and the values of its left side.
_PLACES = np.linspace(1.0, -BEYOND, 4001)[:-1]
_VALUES = (1 - _PLACES) ** 1.5 / (_PLACES + BEYOND)


def located_area(contact: Contact, hardness: float = np.inf, *, patch: bool = False) -> float:
    """Return the area inside the contact line, which is located inside cells.

    Of second order on smooth surfaces. At the end of the material, at edges sharper than the grid
    and beside cells under the hardness, contact ends between two cells; on the rim of a rough free
    patch, but under the hardness, a known part of a cell inside. Only without adhesion, because the
    pressure must vanish at the line.

    `hardness` is the pressure at which the body yields: less than F/hardness carries no force. A
    `patch` is one of a rough surface, whose rim cuts contacts off; the rim of another grid is the
    end of the material.

    Hertz, pi a^2 with a = 6.3 cells, within half a per cent:

    >>> from reference.contact.press import press
    >>> from reference.halfspace import FreeOperator
    >>> from reference.loads import Load
    >>> x = np.arange(16) - 7.3
    >>> K = FreeOperator((16, 16), (1.0, 1.0), 1.0)
    >>> gap = (x[:, None] ** 2 + x**2) / 200
    >>> hertz = press(K, gap, Load("penetration", 6.3**2 / 100))
    >>> bool(abs(located_area(hertz) / (np.pi * 6.3**2) - 1) < 5e-3)
    True
    """
    mask, periodic = contact.mask, contact.operator.periodic
    cells = float(np.count_nonzero(mask))
    if not mask.any() or mask.all():
        return cells * contact.operator.cell_area
    operator = contact.operator
    # gaps are needed beside the rim only: on large grids a map of them would be the largest field.
    # Those of interpolated surfaces are in another order of memory, for which the loop would be
    # compiled once more, in the middle of a solve that is timed
    initial = np.ascontiguousarray(contact.initial_gap)
    shift, rim, located, crossings = _shift(
        *(mask, contact.pressure, initial, contact.displacement, contact.penetration),
        *(operator.spacing, operator.effective_modulus, float(hardness), periodic),
    )
    # the law does not apply to ends of the material or the patch
    outlines = euler_characteristic(mask, periodic) * located / max(crossings, 1)
    shift -= operator.rim_excess * rim
    if patch and not periodic:
        # the load of the strip is carried elsewhere, where the area grows with it: as many times
        # d ln A/d ln F of the strip are not counted. Under the hardness no pressure is singular
        ends = mask & (contact.pressure < hardness)
        number = sum(np.count_nonzero(ends[at]) for at, _ in _sides(contact))
        shift -= EDGE_OFFSET * _growth(mask) * number
    least = max(_LEAST_SHARE * cells, float(contact.pressure.sum()) / hardness)
    return float(max(cells + shift + OUTLINE * outlines, least)) * contact.operator.cell_area


@njit(cache=True, nogil=True, error_model="numpy")
def place(ratio, cosine=1.0):
    """Return the position of the contact line beyond the last centre, in cells, from rho and angle.

    >>> [round(place(ratio), 2) for ratio in (0.0, 0.9, 1e9)]
    [1.0, 0.46, -0.15]
    """
    value, low, high = RATIO * ratio * cosine**-ANGLE, 0, _VALUES.size - 1
    if value >= _VALUES[high]:
        return _PLACES[high]
    # as np.interp, which Numba takes longer to compile than the rest of this file
    while high - low > 1:
        middle = (low + high) // 2
        if _VALUES[middle] <= value:
            low = middle
        else:
            high = middle
    slope = (_PLACES[high] - _PLACES[low]) / (_VALUES[high] - _VALUES[low])
    return slope * (value - _VALUES[low]) + _PLACES[low]


def euler_characteristic(mask: Mask, periodic: bool) -> int:
    """Return the number of patches (neighbours across edges) minus that of holes.

    >>> ring = np.ones((3, 3), dtype=bool)
    >>> ring[1, 1] = False
    >>> euler_characteristic(np.pad(ring, 1), periodic=False)
    0
    """
    if periodic:
        mask = np.pad(mask, ((0, 1), (0, 1)), mode="wrap")
    beside, above = mask[1:] & mask[:-1], mask[:, 1:] & mask[:, :-1]
    squares = beside[:, 1:] & beside[:, :-1]
    if periodic:  # cells repeated at the seam are counted once
        mask, beside, above = mask[:-1, :-1], beside[:, :-1], above[:-1]
    counts = [int(np.count_nonzero(part)) for part in (mask, beside, above, squares)]
    return counts[0] - counts[1] - counts[2] + counts[3]


@njit(cache=True, nogil=True, error_model="numpy")
def _shift(
    mask, pressure, initial, displacement, penetration, spacing, modulus, hardness, periodic
):
    """Return the area, in cells, between the edges of cells and the contact line.

    Also the length of the rim, in cells, the number of crossings included, and of all crossings.
    """
    shift, length, located, crossings = 0.0, 0.0, 0, 0
    for axis in range(2):
        size = mask.shape[axis]
        for side in (1, -1):
            total, rim = 0.0, 0.0
            for i in range(mask.shape[0]):
                for j in range(mask.shape[1]):
                    if not mask[i, j]:
                        continue
                    own = i if axis == 0 else j
                    beside = _along(i, j, axis, side, size)
                    if not periodic and (own + side < 0 or own + side >= size):
                        crossings += 1  # the rim of the patch is an end
                        continue
                    if mask[beside]:
                        continue
                    crossings += 1
                    inner = pressure[_along(i, j, axis, -side, size)]
                    innermost = pressure[_along(i, j, axis, -2 * side, size)]
                    opening = max(initial[beside] - penetration + displacement[beside], 0.0)
                    if not np.isfinite(opening) or pressure[i, j] >= hardness:
                        continue
                    # Rising over three cells towards one side: an edge sharper than the grid, under
                    # which the pressure does not vanish. Symmetric cells differ by rounding, which
                    # is no rise.
                    rising = pressure[i, j] > _MORE * inner and inner > _MORE * innermost
                    if rising and innermost > 0:
                        continue
                    located += 1
                    steep, across = 0.0, 0.0
                    for cell in ((i, j), beside):
                        steep += _slope(mask, cell, axis, periodic)
                        across += _slope(mask, cell, 1 - axis, periodic)
                    steep, across = steep / spacing[axis], across / spacing[1 - axis]
                    square = steep**2 / max(steep**2 + across**2, _TINY)
                    cosine = max(np.sqrt(square), _LEAST_COSINE)
                    ratio = modulus * opening / spacing[axis] / pressure[i, j]
                    total += square * (place(ratio, cosine) - 0.5)
                    rim += square / cosine
            shift += total
            length += rim
    return shift, length, located, crossings


@njit(cache=True, nogil=True, error_model="numpy")
def _along(i, j, axis, steps, size):
    """Return the cell some steps along an axis, across the seam."""
    return ((i + steps) % size, j) if axis == 0 else (i, (j + steps) % size)


@njit(cache=True, nogil=True, error_model="numpy")
def _slope(mask, cell, axis, periodic):
    """Return the gradient of the mask, in cells (Sobel filter), along the normal of the rim."""
    total = 0.0
    for step in (-1, 0, 1):
        for side in (-1, 1):
            row, column = (side, step) if axis == 0 else (step, side)
            row, column = cell[0] + row, cell[1] + column
            if periodic:
                row, column = row % mask.shape[0], column % mask.shape[1]
            else:
                row = min(max(row, 0), mask.shape[0] - 1)
                column = min(max(column, 0), mask.shape[1] - 1)
            if mask[row, column]:
                total += side * (2.0 - abs(step))
    return total


# Share of the mean displacement of a load that it does not give where the strip carries it.
HELD = 0.85


@dataclass(frozen=True)
class WholePatch:
    """Quantities with the load on the strip."""

    penetration: float
    force: float
    mean_gap: float
    contact_area: float


def reaches_rim(mask: Mask) -> bool:
    """Whether contact reaches the rim of a grid."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())


def on_whole_patch(contact: Contact, response: Response, control: str, area: float) -> WholePatch:
    r"""Return the contact with the load on the strip that whole cells leave out at the rim.

    Pressure is singular there as at the edge of a flat face, and whole cells act as a face whose
    edge is e = 0.175 cells inside theirs (`punches.EDGE_OFFSET`). An edge with p = K/sqrt(2 pi t)
    gains elastic energy K^2/(2 E*) as it moves by a unit of length; the mean pressure p_r of a cell
    h wide there stands for K^2 = 2 c h p_r^2, c = 1.724 (`punches.EDGE_COMPLIANCE`). Differentiated
    along the load, the strip carries at the same depth

        dF = (e c/E*) sum over the rim of h^2 l p_r x_r,    x = dp/dd,

    l the length of a cell along the rim, a cell in a corner counted half for either side. At the
    same load the penetration is less by dF/k, k the stiffness. The mean gap at the same depth gains
    (1 - 0.85), measured, of what as much load spread over the contact would add to the open share.

    The contact is elastic, on a free patch; the response is that of its contact cells to a unit of
    depth, `control` what was prescribed, and stays: "force", "penetration" or "mean_gap".
    """
    extra = 0.0
    for at, across in _sides(contact):
        product = contact.pressure[at] * response.pressure[at]
        extra += across * float(product.sum() - (product[0] + product[-1]) / 2)
    operator = contact.operator
    extra *= EDGE_OFFSET * EDGE_COMPLIANCE * operator.cell_area / operator.effective_modulus
    depth, spread = extra / response.stiffness, response.mean_displacement
    # at the same depth, then along the curve to what was prescribed
    opened = (1 - HELD) * (1 - float(contact.mask.mean())) * spread * depth
    further = -depth if control == "force" else 0.0
    if control == "mean_gap":
        further = opened / (1 - spread)
    more = extra + response.stiffness * further if control != "force" else 0.0
    return WholePatch(
        penetration=contact.penetration + further,
        force=contact.force + more,
        mean_gap=contact.mean_gap + opened - (1 - spread) * further,
        contact_area=area * (1 + _growth(contact.mask) * more / contact.force),
    )


def _growth(mask: Mask) -> float:
    """Return d ln A/d ln F: 1 at light loads, 0 at full contact."""
    # A/A0 = erf(x), x in proportion to F (B. N. J. Persson, J. Chem. Phys. 115 (2001) 3840)
    share = np.count_nonzero(mask) / mask.size
    x = special.erfinv(share)
    return float(2 / np.sqrt(np.pi) * x * np.exp(-(x**2)) / share) if share < 1 else 0.0


def _sides(contact: Contact) -> Iterator[tuple[Any, float]]:
    """Yield where the cells along each side of a grid are, and their size across it."""
    across, along = contact.operator.spacing
    yield from ((np.s_[0], across), (np.s_[-1], across))
    yield from ((np.s_[:, 0], along), (np.s_[:, -1], along))
