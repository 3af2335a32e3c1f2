"""Flat faces whose outlines cut through cells.

With whole cells, an oblique or curved outline is a staircase: the face gains and loses cells, and
the stiffness jumps. Here every cell with a fraction phi of its area under the face carries a
pressure, and cells at the outline are more compliant under their own pressure:

u_i + c (dx/E*) (1/phi_i - 1) p_i = d  on all cells with phi_i > 0,   u = K p,

p_i the force on the cell over the whole area of the cell. For a straight edge along the grid and
c = 1.7243 the face acts, at every phi, as one whose edge is 0.17465 dx inside the true one: limits
of wide strips (2-D, Toeplitz matrices; `tests/reference/test_halfspace_punches.py`). The caller
moves the outline outwards by that fraction of a cell (`EDGE_OFFSET`) before computing areas, which
removes the first-order error, -17 % dx/a of the stiffness. Oblique edges and corners leave 2e-4
(docs/half-space.md) with so much scatter that extrapolation does not help.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_factor, cho_solve

from reference.arrays import Array, Mask
from reference.contact.body import ElasticBody
from reference.contact.pivot import pairs
from reference.errors import ConvergenceError, refuse
from reference.halfspace import kernels
from reference.halfspace.kernels import FreeOperator

# Extra compliance of an edge cell in units of (1/phi - 1) dx/E*, and the resulting edge offset.
EDGE_COMPLIANCE = 1.7243
EDGE_OFFSET = 0.17465
# Uncertainty of the offset for edges at any angle and position, in cells (95 %): discs, ellipses,
# squares and triangles err by 0.006 dx/a of the stiffness at most.
EDGE_SCATTER = 0.01
# The same of ellipses, whose outlines have all angles: 240 of aspects 1 to 3.2, of 6 to 40 cells to
# sqrt(ab), half of them turned and shifted, err by less than 0.0035 dx/sqrt(ab) in 95 %, by 0.006
# at most.
SMOOTH_SCATTER = 0.004
# Compliance of a single cell, 4 ln(1 + sqrt 2)/pi dx/E*, the scale of the preconditioner.
_UNIT_CELL = 4 * np.log(1 + np.sqrt(2)) / np.pi
# Slivers below this fraction of a cell are ignored, as (1/phi) would lose digits.
_LEAST = 1e-9


@dataclass(frozen=True)
class FaceResponse:
    """Response of the half-space to a flat face at unit penetration."""

    pressure: Array  # (nx, ny): force on the cells over the cell area, per unit of penetration
    stiffness: float  # integral of the pressure, F/d
    iterations: int
    residual: float  # largest error of the displacement, relative to the penetration


def on_cells(
    operator: ElasticBody,
    mask: Mask,
    target: Array,
    goal: float,
    limit: int,
    *,
    start: Array | None = None,
    extra: Array | float = 0.0,
    scale: Array | float = 1.0,
) -> tuple[Array, list[float]]:
    """Return the pressures on the mask for which u + extra p is the target there, and residuals.

    Conjugate gradients, preconditioned by `scale`, until the largest residual is below the goal or
    the limit of iterations is reached.
    """
    pressure = np.zeros(mask.shape) if start is None else np.where(mask, start, 0.0)
    moved = 0.0 if start is None else operator.apply(pressure) + extra * pressure
    residual = np.where(mask, target - moved, 0.0)
    direction = scaled = scale * residual
    power = float((residual * scaled).sum())
    history = [float(np.abs(residual).max())]
    while history[-1] > goal and len(history) <= limit:
        image = np.where(mask, operator.apply(direction) + extra * direction, 0.0)
        length = power / float((direction * image).sum())
        pressure = pressure + length * direction
        residual = residual - length * image
        history.append(float(np.abs(residual).max()))
        scaled = scale * residual
        before, power = power, float((residual * scaled).sum())
        direction = scaled + power / before * direction
    return pressure, history


def respond(
    operator: FreeOperator, fraction: ArrayLike, tolerance: float = 1e-9, max_iterations: int = 5000
) -> FaceResponse:
    """Return the response to a flat face at unit penetration, by conjugate gradients.

    The operator has square cells, of which the fraction phi (nx, ny) lies under the face, 0 to
    1. The tolerance is the largest relative error of the displacement.

    One fully covered cell, k = pi E* dx/(4 ln(1 + sqrt 2)):

    >>> K = FreeOperator((1, 1), (1.0, 1.0), 1.0)
    >>> bool(np.isclose(respond(K, [[1.0]]).stiffness, np.pi / (4 * np.log(1 + np.sqrt(2)))))
    True
    """
    mask, extra = _covered(operator, fraction)
    cell_compliance = _UNIT_CELL * (operator.spacing[0] / operator.effective_modulus)
    scale = np.where(mask, 1 / (cell_compliance + extra), 0.0)
    pressure, (_, *history) = on_cells(
        operator, mask, np.ones(mask.shape), tolerance, max_iterations, extra=extra, scale=scale
    )
    response = _response(operator, mask, extra, pressure, len(history))
    if not response.residual <= 2 * tolerance:  # the residual of the recursion drifts
        message = f"a flat face stopped at a residual of {response.residual:.1e}"
        raise ConvergenceError(message, history)
    return response


def respond_dense(operator: FreeOperator, fraction: ArrayLike) -> FaceResponse:
    """Return the response to a flat face at unit penetration, by a Cholesky factor of its cells.

    The cost grows as the cube of the number of cells.
    """
    mask, extra = _covered(operator, fraction)
    rows, columns = np.ascontiguousarray(np.nonzero(mask))  # as `tabulated` has them, compiled once
    nx, ny = operator.shape
    table = kernels.love(
        np.arange(nx)[:, None], np.arange(ny), operator.spacing, operator.effective_modulus
    )
    # In units of a power of two, so that the roots in the factor round equally in all units.
    unit = 2.0 ** np.round(np.log2(table[0, 0]))
    matrix = pairs(rows, columns, rows, columns, table / unit)
    matrix[np.diag_indices_from(matrix)] += extra[mask] / unit
    # transposed, the symmetric matrix has LAPACK's order and is overwritten, not copied
    factor = cho_factor(matrix.T, lower=True, overwrite_a=True)
    pressure = np.zeros(operator.shape)
    pressure[mask] = cho_solve(factor, np.ones(len(rows))) / unit
    return _response(operator, mask, extra, pressure, 1)


def _response(
    operator: FreeOperator, mask: Mask, extra: Array, pressure: Array, count: int
) -> FaceResponse:
    """Return the response with recomputed residual and stiffness."""
    residual = float(np.abs(1 - operator.apply(pressure) - extra * pressure)[mask].max())
    return FaceResponse(pressure, float(pressure.sum()) * operator.cell_area, count, residual)


def _covered(operator: FreeOperator, fraction: ArrayLike) -> tuple[Mask, Array]:
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
    refuse(faults)
    mask = fraction > _LEAST
    scale = EDGE_COMPLIANCE * (operator.spacing[0] / operator.effective_modulus)
    return mask, scale * (1 / np.where(mask, fraction, 1.0) - 1)
