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

Where contact reaches the rim of a free patch, `patch_rim` says how much of the cells there is not
counted; on rough patches it is half and more of the error otherwise left.

The shift of the rim from cell edges to this position, for an outline with curvature, changes the
area by a sum over the crossings and a constant per closed outline, 0.41 h^2 (Hertz contacts of 1 to
12 cells radius), outlines of holes counting negative: by the Gauss-Bonnet theorem the total
curvature of any outline is 2 pi. The remaining errors (mean and scatter) of Hertz contacts anywhere
on the grid are: 3 cells radius 0.0 +- 0.6 %, 8 cells 0.03 +- 0.12 %, 20 cells 0.02 +- 0.03 %;
for counted areas with perimeter correction -1.8 +- 3.8, -0.8 +- 0.9, -0.4 +- 0.2 %.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.contact.press import Contact
from reference.halfspace.patch_rim import uncounted_cells

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
