"""Adhesion of short range on a grid: cells let go at a tension that is calibrated to the mesh.

The tension at the edge of an adhesive contact is singular, p = -K/sqrt(2 pi s), and the edge holds
up to K^2 = 2 E* w (Johnson, Kendall & Roberts 1971; Maugis 1992). A cell of side dx at the edge
carries a finite tension c K/sqrt(dx) instead: it lets go at c sqrt(2 E* w/dx). Two numbers c:

- ``"edge"``: 0.76153, the limit of a wide strip with straight edges along the grid (Toeplitz
  matrices of 50 to 1600 cells; derived again in the tests): exact for such an edge.
- ``"printed"``: R. Pohrt and V. L. Popov, Facta Universitatis Mech. Eng. 13 (2015) 3, compare the
  energy 0.473201 p^2 dx^3/E* of a single loaded cell with w dx^2: p = sqrt(E* w/(0.473201 dx)),
  that is c = 1.0279.

On a fixed set of cells the pressures are linear in the penetration, so that the next cell to let go
and the load at which it does are known exactly, on unstable parts of the way too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import ConvergenceError
from reference.halfspace.operators import HalfSpace
from reference.halfspace.solution import Press

Field = NDArray[np.float64]
Mask = NDArray[np.bool_]

RULES = {"edge": 0.76153, "printed": float(1 / np.sqrt(2 * 0.473201))}
"""Tension of a cell that lets go, in units of sqrt(2 E* w/dx)."""

# Cells whose turn comes within this share of the last step of the load let go together: mirror
# images differ by the residual of the solver only.
_TOGETHER = 1e-6

_MOST = 2000  # iterations for the pressures of one set


@dataclass(frozen=True)
class Peeling:
    """An adhesive contact that is taken apart cell by cell; arrays have shape (k,).

    Set k of cells is the contact while the load falls from the one at which the last cell before
    it let go to `penetration[k]`, `force[k]`, at which the next one does.

    Attributes
    ----------
    penetration, force : ndarray
        Loads at which the set loses its next cell. Where they rise again, the contact cannot be
        held there by prescribing that load.
    cells : ndarray of int
        Number of cells in contact.
    stiffness, offset : ndarray
        F = stiffness * d - offset as long as the set lasts.
    tension : float
        Tension at which a cell lets go.
    cell_area : float
    """

    penetration: Field
    force: Field
    cells: NDArray[np.intp]
    stiffness: Field
    offset: Field
    tension: float
    cell_area: float

    @property
    def area(self) -> Field:
        """Area of the cells in contact."""
        return np.asarray(self.cells * self.cell_area, dtype=np.float64)

    def pull_off(self, control: str = "force") -> int:
        """Index of the set that is lost for good when the prescribed load falls: the lowest."""
        return int(np.argmin(self._loads(control)))

    def at(self, load: float, control: str) -> int:
        """Index of the set that carries a load on the way down; the number of sets: none does."""
        carrying = self._loads(control) <= load
        return int(np.argmax(carrying)) if carrying.any() else carrying.size

    def _loads(self, control: str) -> Field:
        if control not in ("force", "penetration"):
            raise ValueError(f"control must be 'force' or 'penetration', not {control!r}")
        return self.force if control == "force" else self.penetration


def letting_go(
    spacing: float, effective_modulus: float, work: float, rule: str = "printed"
) -> float:
    """Tension at which a cell of side `spacing` lets go.

    >>> round(letting_go(1.0, 1.0, 1.0, "printed"), 4)
    1.4537
    """
    if rule not in RULES:
        raise ValueError(f"rule must be one of {', '.join(RULES)}, not {rule!r}")
    return RULES[rule] * float(np.sqrt(2 * effective_modulus * work / spacing))


def peel(
    press: Press,
    mask: ArrayLike,
    work: float,
    *,
    rule: str = "printed",
    tolerance: float = 1e-7,
    until: float = 0.0,
) -> Peeling:
    """Take an adhesive contact apart, from a set of cells that hold to the last one.

    Parameters
    ----------
    press : Press
        The rigid body over a free half-space of square cells.
    mask : array_like of bool, shape (nx, ny)
        Cells in contact at first; a contact that was pressed wider than it will be held.
    work : float
        Work of adhesion w.
    rule : {"printed", "edge"}
        Calibration of the tension, see the module.
    tolerance : float
        Residual of the displacement relative to what it is solved for.
    until : float
        Share of the cells at which the way ends, in [0, 1).

    Returns
    -------
    Peeling

    Raises
    ------
    ValueError
        If the arguments make no problem; all faults are listed.
    ConvergenceError
        If the pressures of a set are not found.

    Examples
    --------
    >>> from reference.halfspace import FreeOperator
    >>> K = FreeOperator((1, 1), (1.0, 1.0), 1.0)
    >>> cell = peel(Press(K, [[0.0]]), [[True]], 1.0)
    >>> bool(np.isclose(cell.force[0], -cell.tension))
    True
    """
    operator, gap = press.operator, press.gap
    mask = _checked(press, mask, work, until)
    tension = letting_go(operator.spacing[0], operator.effective_modulus, work, rule)
    per_depth, from_shape = np.zeros(gap.shape), np.zeros(gap.shape)
    rows: list[tuple[float, float, int, float, float]] = []
    last = until * np.count_nonzero(mask)
    while np.count_nonzero(mask) > last:
        target = np.where(mask, gap, 0.0)
        per_depth = _press(operator, mask, mask.astype(float), per_depth, tolerance)
        from_shape = _press(operator, mask, target, from_shape, tolerance)
        # p = d per_depth - from_shape reaches -tension
        turn = np.where(mask, (from_shape - tension) / np.where(mask, per_depth, 1.0), -np.inf)
        depth = float(turn.max())
        stiffness, offset = (float(p.sum()) * operator.cell_area for p in (per_depth, from_shape))
        rows.append((depth, stiffness * depth - offset, int(mask.sum()), stiffness, offset))
        near = tension / float(per_depth[mask].max())
        mask = mask & (turn < depth - _TOGETHER * near)
    depths, forces, cells, stiffnesses, offsets = (
        np.array(part) for part in zip(*rows, strict=True)
    )
    return Peeling(depths, forces, cells, stiffnesses, offsets, tension, operator.cell_area)


def _press(operator: HalfSpace, mask: Mask, target: Field, start: Field, tolerance: float) -> Field:
    """Pressures on the mask that displace its cells by the target, by conjugate gradients."""
    pressure = np.where(mask, start, 0.0)
    goal = tolerance * float(np.abs(target).max())
    residual = np.where(mask, target - operator.apply(pressure), 0.0)
    direction, power = residual, float((residual * residual).sum())
    history = [float(np.abs(residual).max())]
    while history[-1] > goal:
        if len(history) > _MOST:
            raise ConvergenceError("the pressures of an adhesive contact were not found", history)
        image = np.where(mask, operator.apply(direction), 0.0)
        length = power / float((direction * image).sum())
        pressure = pressure + length * direction
        residual = residual - length * image
        history.append(float(np.abs(residual).max()))
        before, power = power, float((residual * residual).sum())
        direction = residual + power / before * direction
    return pressure


def _checked(press: Press, mask: ArrayLike, work: float, until: float) -> Mask:
    """Return the mask, or raise one ValueError for everything wrong."""
    operator, gap = press.operator, press.gap
    mask = np.asarray(mask, dtype=bool)
    faults = []
    if operator.periodic or abs(operator.spacing[0] / operator.spacing[1] - 1) > 1e-12:
        faults.append("detachment needs a free half-space with square cells")
    if mask.shape != operator.shape:
        faults.append(f"mask has shape {mask.shape}, the operator {operator.shape}")
    elif not mask.any() or not np.isfinite(gap[mask]).all():
        faults.append("the cells in contact must be some, with finite gaps")
    if not (np.isfinite(work) and work > 0):
        faults.append(f"work must be positive and finite, not {work!r}")
    if not 0 <= until < 1:
        faults.append(f"until must lie in [0, 1), not {until!r}")
    if faults:
        raise ValueError("; ".join(faults))
    return mask
