"""Flat punches whose outline cuts through cells: area fractions and one extra compliance.

Whole cells see an oblique or curved outline as a staircase: the face gains and loses cells, and the
stiffness jumps. Here every cell with a share phi of its area under the face carries a pressure, and
a cell at the outline is softer under its own pressure:

u_i + c (dx/E*) (1/phi_i - 1) p_i = d  on all cells with phi_i > 0,   u = K p,

p_i the force on the cell over the whole area of the cell. The law of the extra compliance is no
fit: for a straight edge along the grid and c = 1.7243 the face acts, at every phi, as one whose
edge lies 0.17465 dx inside the true one, which is where whole cells put the edge of a face that
ends between two cells (phi = 1). Both numbers are limits of wide strips (2-D, Toeplitz matrices of
50 to 1600 cells; `tests/reference/test_halfspace_edge_cells.py` derives them again). As the edge
is short by the same share of a cell everywhere, the caller moves it outwards by that share
(`EDGE_OFFSET` dx) before it counts areas, and the first-order error, -17 % dx/a of the stiffness,
is gone. What is left is the difference of oblique edges and of corners.

Measured on 32, 64, 128 cells across, any angle and offset of the grid: disc 1e-4, 9e-5, 5e-5;
ellipse 2:1 6e-5, 9e-5, 7e-5; square 2e-4, 2e-4, 5e-5; equilateral triangle 6e-4, 2e-4, 1e-4.
Extrapolating these once more in the cell size gains nothing: it multiplies their scatter, which is
as large as their trend.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.errors import ConvergenceError
from reference.halfspace import kernels
from reference.halfspace.operators import FreeOperator

Field = NDArray[np.float64]

# Extra compliance of an edge cell in units of (1/phi - 1) dx/E*, and where it puts the edge.
EDGE_COMPLIANCE = 1.7243
EDGE_OFFSET = 0.17465
# How well that is known for edges at any angle and place, in cells (95 %): from the measurements
# above, of which the worst was 0.006 dx/a of the stiffness.
EDGE_SCATTER = 0.01
# Own compliance of a cell, 4 ln(1 + sqrt 2)/pi dx/E*: the preconditioner's scale.
_UNIT_CELL = 4 * np.log(1 + np.sqrt(2)) / np.pi
# Slivers below this share of a cell carry nothing: (1/phi) would only cost digits.
_LEAST = 1e-9


@dataclass(frozen=True)
class FaceResponse:
    """Answer of the half-space to a flat face that is pushed in by one.

    Attributes
    ----------
    pressure : ndarray, shape (nx, ny)
        Force on each cell over the area of the cell, per unit of penetration.
    stiffness : float
        Its integral, F/d.
    iterations : int
    residual : float
        Largest error of the displacement, relative to the penetration.
    """

    pressure: Field
    stiffness: float
    iterations: int
    residual: float


def extra_compliance(fraction: ArrayLike, spacing: float, effective_modulus: float) -> Field:
    """Return c (dx/E*) (1/phi - 1) of cells with phi > 0.

    >>> extra_compliance([0.5, 1.0], 1.0, 1.0).tolist()
    [1.7243, 0.0]
    """
    return EDGE_COMPLIANCE * (spacing / effective_modulus) * (1 / np.asarray(fraction) - 1)


def respond(
    operator: FreeOperator,
    fraction: ArrayLike,
    tolerance: float = 1e-9,
    max_iterations: int = 5000,
) -> FaceResponse:
    """Push a flat face in by one, by conjugate gradients.

    Parameters
    ----------
    operator : FreeOperator
        Square cells.
    fraction : array_like, shape (nx, ny)
        Share phi of each cell under the face, 0 to 1.
    tolerance : float
        Largest error of the displacement, relative.
    max_iterations : int

    Returns
    -------
    FaceResponse

    Raises
    ------
    ValueError
        If the cells are not square, the shapes differ, or the fractions are no fractions.
    ConvergenceError
        With the residuals, if the tolerance is not reached.

    Examples
    --------
    One cell that is covered whole, k = pi E* dx/(4 ln(1 + sqrt 2)):

    >>> K = FreeOperator((1, 1), (1.0, 1.0), 1.0)
    >>> bool(np.isclose(respond(K, [[1.0]]).stiffness, np.pi / (4 * np.log(1 + np.sqrt(2)))))
    True
    """
    mask, extra = _covered(operator, fraction)
    cell_compliance = _UNIT_CELL * (operator.spacing[0] / operator.effective_modulus)
    scale = np.where(mask, 1 / (cell_compliance + extra), 0.0)
    pressure = np.zeros(operator.shape)
    residual = mask.astype(float)
    direction = scaled = scale * residual
    power = float((residual * scaled).sum())
    history: list[float] = []
    for _ in range(max_iterations):
        # Where nothing lies under the face the residual has no meaning: scale is 0 there.
        image = np.where(mask, operator.apply(direction) + extra * direction, 0.0)
        length = power / float((direction * image).sum())
        pressure = pressure + length * direction
        residual = residual - length * image
        history.append(float(np.abs(residual).max()))
        if history[-1] <= tolerance:
            break
        scaled = scale * residual
        before, power = power, float((residual * scaled).sum())
        direction = scaled + power / before * direction
    response = _response(operator, mask, extra, pressure, len(history))
    if not response.residual <= 2 * tolerance:  # the residual of the recursion drifts
        message = f"a flat face stopped at a residual of {response.residual:.1e}"
        raise ConvergenceError(message, history)
    return response


def respond_dense(operator: FreeOperator, fraction: ArrayLike) -> FaceResponse:
    """Push a flat face in by one, by a Cholesky factor of all its cells.

    Arguments and errors as for `respond`; work grows as the cube of the number of cells.

    >>> K = FreeOperator((3, 3), (1.0, 1.0), 1.0)
    >>> face = [[0.2, 0.7, 0.0], [0.5, 1.0, 0.4], [0.0, 0.6, 0.1]]
    >>> bool(np.isclose(respond_dense(K, face).stiffness, respond(K, face).stiffness, rtol=1e-9))
    True
    """
    mask, extra = _covered(operator, fraction)
    rows, columns = np.nonzero(mask)
    nx, ny = operator.shape
    table = kernels.love(
        np.arange(nx)[:, None], np.arange(ny), operator.spacing, operator.effective_modulus
    )
    matrix = table[np.abs(rows[:, None] - rows), np.abs(columns[:, None] - columns)]
    matrix[np.diag_indices_from(matrix)] += extra[mask]
    # In units of a power of two, so that the roots in the factor round alike in all units.
    unit = 2.0 ** np.round(np.log2(table[0, 0]))
    pressure = np.zeros(operator.shape)
    pressure[mask] = cho_solve(cho_factor(matrix / unit, lower=True), np.ones(len(rows))) / unit
    return _response(operator, mask, extra, pressure, 1)


def _response(
    operator: FreeOperator, mask: NDArray[np.bool_], extra: Field, pressure: Field, count: int
) -> FaceResponse:
    """Evaluate the residual anew, and the stiffness."""
    residual = float(np.abs(1 - operator.apply(pressure) - extra * pressure)[mask].max())
    return FaceResponse(pressure, float(pressure.sum()) * operator.cell_area, count, residual)


def _covered(operator: FreeOperator, fraction: ArrayLike) -> tuple[NDArray[np.bool_], Field]:
    """Return the cells under the face, and their extra compliance (0 elsewhere)."""
    fraction = np.asarray(fraction, dtype=float)
    faults = []
    if abs(operator.spacing[0] / operator.spacing[1] - 1) > 1e-12:
        faults.append(f"cells must be square, not {operator.spacing!r}")
    if fraction.shape != operator.shape:
        faults.append(f"fraction has shape {fraction.shape}, the operator {operator.shape}")
    elif not ((fraction >= 0) & (fraction <= 1)).all():
        faults.append("fractions must lie between 0 and 1")
    elif not (fraction > _LEAST).any():
        faults.append("no cell lies under the face")
    if faults:
        raise ValueError("; ".join(faults))
    mask = fraction > _LEAST
    carrying = np.where(mask, fraction, 1.0)
    return mask, extra_compliance(carrying, operator.spacing[0], operator.effective_modulus)
