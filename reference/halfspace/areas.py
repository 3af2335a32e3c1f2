"""Contact areas, patches, stiffness and energy of a solved half-space contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from reference.arguments import refuse, spacing_faults
from reference.contact.body import ElasticBody
from reference.contact.descent import descend

# Yastrebov, Anciaux & Molinari (2017): mean excess of counted area per cell edge of the rim
_PERIMETER_FACTOR = (np.pi - 1 + np.log(2)) / 24


@dataclass(frozen=True)
class Patches:
    """Connected contact patches: label map (0 = no contact), their number and areas."""

    labels: NDArray[np.int_]
    count: int
    areas: NDArray[np.float64]


def _checked(mask: ArrayLike, spacing: tuple[float, float]) -> NDArray[np.bool_]:
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

    Parameters
    ----------
    mask : array_like of bool, shape (nx, ny)
        Cells in contact.
    spacing : (float, float)
        Cell sides.
    periodic : bool
        Whether opposite rims are adjacent.

    Examples
    --------
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

    Parameters
    ----------
    mask : array_like of bool, shape (nx, ny)
        Cells in contact.
    spacing : (float, float)
        Cell sides; by default the areas are numbers of cells.
    periodic : bool
        Whether patches continue across opposite rims.

    Examples
    --------
    >>> spots = patches([[1, 0, 1], [0, 0, 1], [1, 0, 0]], periodic=True)
    >>> spots.count, spots.areas.tolist()
    (1, [4.0])
    """
    labels, count = ndimage.label(_checked(mask, spacing))
    if periodic and count:
        # labels that meet across opposite rims are one patch
        first = np.concatenate([labels[0, :], labels[:, 0]])
        last = np.concatenate([labels[-1, :], labels[:, -1]])
        meet = (first > 0) & (last > 0)
        pairs = (np.ones(meet.sum()), (first[meet], last[meet]))
        graph = coo_array(pairs, shape=(count + 1, count + 1))
        _, component = connected_components(graph, directed=False)
        # label 0 (no contact) has no neighbours and is the first component
        labels, count = component[labels], int(component.max())
    cells = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    return Patches(labels, int(count), np.asarray(cells * float(spacing[0] * spacing[1]), float))


@dataclass(frozen=True)
class Response:
    """Response of a fixed contact set to a unit of depth.

    Attributes
    ----------
    stiffness : float
        dF/dd; infinite where a whole period touches.
    pressure : ndarray, shape (nx, ny)
        dp/dd, of either sign.
    mean_displacement : float
        Of all cells.
    """

    stiffness: float
    pressure: NDArray[np.float64]
    mean_displacement: float


def contact_response(operator: ElasticBody, mask: ArrayLike, tolerance: float = 1e-6) -> Response:
    """Return the response of a fixed contact set to a unit of depth.

    K_CC x = 1 on the contact cells, dF/dd = sum(x) cell area, by conjugate gradients. Of an x that
    is not quite there sum(2 x - x K x) is taken: this functional is stationary at the solution, the
    stiffness its largest value, so that an error of x counts as its square. On the free
    half-space this is the stiffness of the flat punch of the same outline; on a uniform grid its
    error is about -34 %/n for n cells across, of order O(1/n), so it should be extrapolated.

    Parameters
    ----------
    operator : FreeOperator or PeriodicOperator
        The half-space.
    mask : array_like of bool, shape (nx, ny)
        Cells in contact.
    tolerance : float
        Largest relative error of the unit displacement in contact. On rough surfaces of 64 to 256
        points a side the stiffness errs by less than its square, from 1e-3 to 1e-6.

    Raises
    ------
    ValueError
        If the mask has another shape.
    ConvergenceError
        If conjugate gradients do not reach the tolerance.
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
    """Return the stiffness dF/dd of a fixed contact set.

    Arguments and errors as of `contact_response`.

    Examples
    --------
    A single cell, stiffness pi E* dx/(4 ln(1 + sqrt 2)):

    >>> from reference.halfspace.operators import FreeOperator
    >>> K = FreeOperator((1, 1), (1.0, 1.0), 1.0)
    >>> bool(np.isclose(contact_stiffness(K, [[True]]), np.pi / (4 * np.log(1 + np.sqrt(2)))))
    True
    """
    return contact_response(operator, mask, tolerance).stiffness


def elastic_energy(operator: ElasticBody, pressure: ArrayLike) -> float:
    """Return the elastic energy of a pressure, 1/2 sum p u cell area (per period if periodic).

    >>> from reference.halfspace.operators import FreeOperator
    >>> K = FreeOperator((1, 1), (1.0, 1.0), 1.0)
    >>> round(elastic_energy(K, [[2.0]]), 6)  # 1/2 * 2 * 2 * 4 ln(1 + sqrt 2)/pi
    2.244399
    """
    pressure = np.asarray(pressure, dtype=float)
    return float(0.5 * (pressure * operator.apply(pressure)).sum() * operator.cell_area)
