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

describes to 0.02 cells (rms) for Love's cells and for both periodic kernels: fitted to Hertz
contacts of 12 to 40 cells radius at any offset from the grid. The centre of a contact cell may
therefore be up to 0.15 cells outside.

The shift of the rim from cell edges to this position, for an outline with curvature, changes the
area by a sum over the crossings and a constant per closed outline, 0.41 h^2 (Hertz contacts of 1 to
12 cells radius), outlines of holes counting negative: by the Gauss-Bonnet theorem the total
curvature of any outline is 2 pi. The remaining errors (mean and scatter) of Hertz contacts anywhere
on the grid are: 3 cells radius 0.0 +- 0.6 %, 8 cells 0.03 +- 0.12 %, 20 cells 0.02 +- 0.03 %;
for counted areas with perimeter correction -1.8 +- 3.8, -0.8 +- 0.9, -0.4 +- 0.2 %.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.halfspace.solution import Contact

Field = NDArray[np.float64]
Mask = NDArray[np.bool_]
Cells = tuple[NDArray[np.intp], NDArray[np.intp]]

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


def located_area(contact: Contact) -> float:
    """Return the area inside the contact line, which is located inside cells.

    Of second order on smooth surfaces. At the end of the material, on the rim of a free patch, and
    at edges sharper than the grid, contact ends between two cells. Only without adhesion, because
    the pressure must vanish at the line.

    Parameters
    ----------
    contact : Contact
        A solved contact of either solver.

    Examples
    --------
    Hertz, pi a^2 with a = 6.3 cells, within half a per cent:

    >>> from reference.halfspace import FreeOperator, fft
    >>> from reference.halfspace.solution import Press
    >>> from reference.loads import Load
    >>> x = np.arange(16) - 7.3
    >>> K = FreeOperator((16, 16), (1.0, 1.0), 1.0)
    >>> gap = (x[:, None] ** 2 + x**2) / 200
    >>> hertz = fft.solve(Press(K, gap), Load("penetration", 6.3**2 / 100))
    >>> bool(abs(located_area(hertz) / (np.pi * 6.3**2) - 1) < 5e-3)
    True
    """
    mask, periodic = contact.mask, contact.operator.periodic
    cells = float(np.count_nonzero(mask))
    if not mask.any() or mask.all():
        return cells * contact.operator.cell_area
    shift, located, crossings = np.sum(
        [_shift(contact, mask, axis, side) for axis in (0, 1) for side in (1, -1)], axis=0
    )
    # the law does not apply to ends of the material or the patch
    outlines = euler_characteristic(mask, periodic) * located / max(crossings, 1)
    area = max(cells + shift + OUTLINE * outlines, _LEAST_SHARE * cells)
    return float(area) * contact.operator.cell_area


def place(ratio: Field, cosine: Field | float = 1.0) -> Field:
    """Return the position of the contact line beyond the last centre, in cells, from rho and angle.

    >>> place(np.array([0.0, 0.9, 1e9])).round(2).tolist()
    [1.0, 0.46, -0.15]
    """
    return np.interp(RATIO * ratio * np.asarray(cosine) ** -ANGLE, _VALUES, _PLACES)


_PLACES = np.linspace(1.0, -BEYOND, 4001)[:-1]
_VALUES = (1 - _PLACES) ** 1.5 / (_PLACES + BEYOND)


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


def _moved(cells: Cells, axis: int, steps: int, mask: Mask, *, wraps: bool) -> Cells:
    """Return the cells some steps along an axis: across the seam, or up to the rim."""
    rows, columns = cells
    size = mask.shape[axis]
    places = (rows, columns)[axis] + steps
    places = places % size if wraps else np.clip(places, 0, size - 1)
    return (places, columns) if axis == 0 else (rows, places)


def _normal(mask: Mask, cells: Cells, axis: int, spacing: float, *, wraps: bool) -> Field:
    """Return the gradient of the mask in some cells (Sobel filter), along the normal of the rim."""
    total = np.zeros(len(cells[0]))
    for step, weight in ((-1, 1.0), (0, 2.0), (1, 1.0)):
        beside = _moved(cells, 1 - axis, step, mask, wraps=wraps)
        for side in (1, -1):
            total += side * weight * mask[_moved(beside, axis, side, mask, wraps=wraps)]
    return total / spacing


def _shift(contact: Contact, mask: Mask, axis: int, side: int) -> tuple[float, int, int]:
    """Return the area, in cells, between cell edges and contact line on one side of all cells.

    Also the number of crossings included, and of all crossings of the rim.
    """
    operator = contact.operator
    last = mask & ~np.roll(mask, -side, axis)
    at_rim = 0
    if not operator.periodic:
        end = -1 if side > 0 else 0
        at_rim = int(np.count_nonzero(mask.take(end, axis)))
        last[(end, slice(None)) if axis == 0 else (slice(None), end)] = False
    rows, columns = np.nonzero(last)
    cells = rows, columns
    beside = _moved(cells, axis, side, mask, wraps=True)
    pressure = contact.pressure[cells]
    gap = contact.initial_gap[beside] - contact.penetration + contact.displacement[beside]
    gap = np.maximum(gap, 0.0)
    steep = [
        sum(
            _normal(mask, at, k, operator.spacing[k], wraps=operator.periodic)
            for at in (cells, beside)
        )
        for k in (0, 1)
    ]
    square = steep[axis] ** 2 / np.maximum(steep[0] ** 2 + steep[1] ** 2, np.finfo(float).tiny)
    scale = operator.effective_modulus / operator.spacing[axis]
    inner, innermost = (
        contact.pressure[_moved(cells, axis, -steps * side, mask, wraps=True)] for steps in (1, 2)
    )
    smooth = np.isfinite(gap) & ~_rising(pressure, inner, innermost)
    ratio, cosine = scale * gap / pressure, np.maximum(np.sqrt(square), _LEAST_COSINE)
    shift = square * np.where(smooth, place(ratio, cosine) - 0.5, 0.0)
    return float(shift.sum()), int(np.count_nonzero(smooth)), at_rim + len(gap)


def _rising(pressure: Field, inner: Field, innermost: Field) -> Mask:
    """Return where the pressure increases over three cells towards one side, as at a sharp edge.

    Under an edge sharper than the grid it does not vanish at the contact line, and does not
    determine its position. Symmetric cells have the same pressure but for rounding, which is no
    increase.
    """
    return np.asarray((pressure > _MORE * inner) & (inner > _MORE * innermost) & (innermost > 0))
