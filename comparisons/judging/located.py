"""Bars of areas with a located contact line, on rough surfaces.

What is left of the error is that of cells at the contact line. How many these are is known: counted
areas are too large by half a cell along the line. Of that excess x = A_counted/A - 1 the located
area errs by some 0.25 x^(3/2): its order on rough surfaces, where spots of a few cells and narrow
gaps are always there. The change from the last grid says less, because it is the error of the
coarser one: on maps with waves of two points it is three to six times the error that is left.

On the rim of a free patch the line lies a known part of a cell inside (`areas`) that depends
on how the area grows with the load: all of that strip is taken as not known. On periodic surfaces
half as much is, for near full contact the narrow gaps that are left have few cells on their line.

The factor was chosen on parts of three measured maps and on random surfaces, for 95 % of cases and
more; `docs/examples/map_bars.py` prints what it covers on them and on others.
"""

from __future__ import annotations

import numpy as np

from reference.halfspace.punches import EDGE_OFFSET

# Bar per x^ORDER, and the least share of the last change: some more than what that order leaves.
FACTOR, ORDER, CHANGE = 0.45, 1.5, 0.5


def located_uncertainty(
    areas: np.ndarray, counted: np.ndarray, sides: tuple[float, float], *, periodic: bool
) -> np.ndarray:
    """Return the relative uncertainty of the area on the finest of several grids, per load, (k,).

    Parameters
    ----------
    areas : ndarray, shape (m, k)
        Located areas on grids, coarse to fine.
    counted : ndarray, shape (k,)
        Area of the cells in contact on the finest.
    sides : (float, float)
        Cells to the sides of that.
    periodic : bool
        Whether the surface has no rim.

    Returns
    -------
    ndarray, shape (k,)
        NaN with one grid, and where an area is lost or zero.

    Examples
    --------
    >>> areas = np.array([[1.02], [1.0]])
    >>> bar = located_uncertainty(areas, np.array([1.06]), (512, 512), periodic=True)
    >>> round(float(bar[0]), 4)
    0.01
    """
    areas = np.asarray(areas, dtype=float)
    areas = areas[np.isfinite(areas).any(axis=1)]
    if len(areas) < 2:
        return np.full(areas.shape[1], np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        excess = np.where(areas[-1] > 0, np.maximum(counted / areas[-1] - 1, 0.0), np.nan)
        change = np.abs(areas[-2] / areas[-1] - 1)
    rim = (1 if periodic else 2) * EDGE_OFFSET * (1 / sides[0] + 1 / sides[1])
    return np.fmax(
        FACTOR * excess**ORDER + rim, np.where(np.isnan(excess), np.nan, CHANGE * change)
    )
