r"""Position of the contact line inside cells, and a contact area of second order.

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

describes to 0.02 cells (rms) for Love's cells: fitted to Hertz contacts of 12 to 40 cells radius at
any offset from the grid. The centre of a contact cell may therefore be up to 0.15 cells outside.
Pressures through the cells' values and finite elements answer a wave of a few cells by more or
less than cells do, and the same law puts their rim a few hundredths of a cell too far out or in:
every operator knows how far (`rim_excess`, measured on Hertz likewise), and that is taken away.

Where contact reaches the rim of a free patch, `on_whole_patch` says how much of the cells there is
not counted; on rough patches it is half and more of the error otherwise left.

The shift of the rim from cell edges to this position, for an outline with curvature, changes the
area by a sum over the crossings and a constant per closed outline, 0.41 h^2 (Hertz contacts of 1 to
12 cells radius), outlines of holes counting negative: by the Gauss-Bonnet theorem the total
curvature of any outline is 2 pi. The remaining errors (mean and scatter) of Hertz contacts anywhere
on the grid are: 3 cells radius 0.0 +- 0.6 %, 8 cells 0.03 +- 0.12 %, 20 cells 0.02 +- 0.03 %;
for counted areas with perimeter correction -1.8 +- 3.8, -0.8 +- 0.9, -0.4 +- 0.2 %.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import special

from reference.contact.press import Contact
from reference.halfspace.areas import Response
from reference.halfspace.edge_cells import EDGE_COMPLIANCE, EDGE_OFFSET

Field = NDArray[np.float64]
Mask = NDArray[np.bool_]

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

    Parameters
    ----------
    contact : Contact
        A solved contact of either solver.
    hardness : float
        Pressure at which the body yields.
    patch : bool
        Whether the grid is a patch of a rough surface, whose rim cuts contacts off. The rim of
        another grid is the end of the material.

    Examples
    --------
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
    # gaps are needed beside the rim only: on large grids a map of them would be the largest field
    heights = contact.initial_gap, contact.displacement, contact.penetration
    grid = operator.spacing, periodic, operator.effective_modulus, float(hardness)
    fields = mask, contact.pressure, heights, grid
    shift, rim, located, crossings = np.sum(
        [_shift(*fields, (axis, side)) for axis in (0, 1) for side in (1, -1)], axis=0
    )
    # the law does not apply to ends of the material or the patch
    outlines = euler_characteristic(mask, periodic) * located / max(crossings, 1)
    shift -= operator.rim_excess * rim
    if patch and not periodic:
        shift -= uncounted_cells(contact, hardness)
    area = max(cells + shift + OUTLINE * outlines, _LEAST_SHARE * cells)
    return float(area) * contact.operator.cell_area


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
def _shift(mask, pressure, heights, grid, way):
    """Return the area, in cells, between cell edges and contact line on one side of all cells.

    Also the length of the rim there, in cells, the number of crossings included, and of all
    crossings. The heights are initial gap, displacement and penetration, the grid is spacing,
    periodicity, effective modulus and hardness, the way an axis and a direction.
    """
    initial, displacement, penetration = heights
    spacing, periodic, modulus, hardness = grid
    axis, side = way
    total, rim, located, crossings = 0.0, 0.0, 0, 0
    size = mask.shape[axis]
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
            if _rising(pressure[i, j], inner, innermost):
                continue
            located += 1
            steep = (
                _slope(mask, (i, j), axis, periodic) + _slope(mask, beside, axis, periodic)
            ) / spacing[axis]
            across = (
                _slope(mask, (i, j), 1 - axis, periodic) + _slope(mask, beside, 1 - axis, periodic)
            ) / spacing[1 - axis]
            square = steep**2 / max(steep**2 + across**2, _TINY)
            cosine = max(np.sqrt(square), _LEAST_COSINE)
            ratio = modulus * opening / spacing[axis] / pressure[i, j]
            total += square * (place(ratio, cosine) - 0.5)
            rim += square / cosine
    return total, rim, located, crossings


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


@njit(cache=True, nogil=True, error_model="numpy")
def _rising(pressure, inner, innermost):
    """Tell whether the pressure increases over three cells towards one side, as at a sharp edge.

    Under an edge sharper than the grid it does not vanish at the contact line, and does not
    determine its position. Symmetric cells have the same pressure but for rounding, which is no
    increase.
    """
    return pressure > _MORE * inner and inner > _MORE * innermost and innermost > 0


# Share of the mean displacement of a load that it does not give where the strip carries it.
HELD = 0.85


@dataclass(frozen=True)
class WholePatch:
    """Quantities with the load on the strip."""

    penetration: float
    force: float
    mean_gap: float
    contact_area: float


def reaches_rim(mask: NDArray[np.bool_]) -> bool:
    """Whether contact reaches the rim of a grid."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())


def uncounted_cells(contact: Contact, hardness: float = np.inf) -> float:
    """Return the cells by which counting is too many, at a given load.

    The load of the strip is carried elsewhere, where the area grows with it: as many times d ln
    A/d ln F of the strip are not counted. Cells under the hardness have no singular pressure.
    """
    ends = contact.mask & (contact.pressure < hardness)
    number = sum(np.count_nonzero(ends[at]) for at, _ in _sides(contact))
    return EDGE_OFFSET * _growth(contact.mask) * number


def on_whole_patch(contact: Contact, response: Response, control: str, area: float) -> WholePatch:
    r"""Return the contact with the load on the strip that whole cells leave out at the rim.

    Pressure does not fall to zero there, it is singular as at the edge of a flat face, and
    whole cells act as a face whose edge is e = 0.175 cells inside theirs
    (`edge_cells.EDGE_OFFSET`). At the same depth the patch carries the load of that strip
    besides. An edge with p = K / sqrt(2 pi t) gains elastic energy K^2/(2 E*) as it moves by a
    unit of length; the mean pressure p_r of a cell h wide there stands for K^2 = 2 c h p_r^2, c
    = 1.724 (`edge_cells.EDGE_COMPLIANCE`). Differentiated along the load:

        dF = (e c/E*) sum over the rim of h^2 l p_r x_r,    x = dp/dd,

    with l the length of a cell along the rim, x the response of the fixed contact to a unit of
    depth, and a cell in a corner counted half for either side. No number is fitted. At the same
    load the penetration is less by dF/k, with k the stiffness: that is all of the first order
    in h that penetrations of free patches have. Patches of 16 to 32 points on grids of 4 and 8
    cells to a point then err by .10 and .035 % (median of fifty, loads of .002 to .2 E* A0 h'),
    with the strip left out by .23 and .11 %.

    Of the mean gap at the same depth the load on the strip adds little, for beside it the
    surface is held by contact and beyond it the patch has ended: (1 - 0.85) of what as much
    load spread over the contact would. That share is measured, on fifty patches, and leaves a
    third of the first order at the heaviest loads, where a tenth of the surface is open.

    Parameters
    ----------
    contact : Contact
        Elastic, of a free patch.
    response : Response
        Of its contact cells to a unit of depth.
    control : {"force", "penetration", "mean_gap"}
        What was prescribed, and stays.
    area : float
        Its area, at its force.
    """
    extra = 0.0
    for at, across in _sides(contact):
        product = contact.pressure[at] * response.pressure[at]
        extra += across * float(product.sum() - (product[0] + product[-1]) / 2)
    operator = contact.operator
    extra *= EDGE_OFFSET * EDGE_COMPLIANCE * operator.cell_area / operator.effective_modulus
    depth, spread = extra / response.stiffness, response.mean_displacement
    # at the same depth, then along the curve to what was prescribed
    opened = (1 - HELD) * spread * depth
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


def _growth(mask: NDArray[np.bool_]) -> float:
    """Return d ln A/d ln F: 1 at light loads, 0 at full contact.

    Of random surfaces, A/A0 = erf(x), x in proportion to F (B. N. J. Persson, J. Chem. Phys. 115
    (2001) 3840).
    """
    share = np.count_nonzero(mask) / mask.size
    x = special.erfinv(share)
    return float(2 / np.sqrt(np.pi) * x * np.exp(-(x**2)) / share) if share < 1 else 0.0


def _sides(contact: Contact) -> Iterator[tuple[Any, float]]:
    """Yield where the cells along each side of a grid are, and their size across it."""
    across, along = contact.operator.spacing
    yield from ((np.s_[0], across), (np.s_[-1], across))
    yield from ((np.s_[:, 0], along), (np.s_[:, -1], along))
