"""Short-range adhesion on a grid: cells detach at a mesh-dependent tension.

The tension at the edge of an adhesive contact is singular, p = -K/sqrt(2 pi s), and the edge is
stable up to K^2 = 2 E* w (Johnson, Kendall & Roberts 1971; Maugis 1992). A cell of side dx at the
edge carries a finite tension c K/sqrt(dx) instead: it detaches at c sqrt(2 E* w/dx). There are two
values of c:

- ``"edge"``: 0.76153, the limit of a wide strip with straight edges along the grid (Toeplitz
  matrices of 50 to 1600 cells; verified by tests): exact for such an edge.
- ``"printed"``: R. Pohrt and V. L. Popov, Facta Universitatis Mech. Eng. 13 (2015) 3, compare the
  energy 0.473201 p^2 dx^3/E* of a single loaded cell with w dx^2: p = sqrt(E* w/(0.473201 dx)),
  that is c = 1.0279.

On a fixed set of cells the pressures are linear in the penetration, so that the next cell to detach
and its load are known exactly, also on unstable parts of the path.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array, Indices
from reference.contact.body import ElasticBody
from reference.contact.press import check_gap
from reference.errors import ConvergenceError, choice_faults, positive_faults, refuse
from reference.halfspace.punches import on_cells

RULES = {"edge": 0.76153, "printed": float(1 / np.sqrt(2 * 0.473201))}
"""Tension of detachment, in units of sqrt(2 E* w/dx)."""

# Cells within this fraction of the last step of the load detach together: mirror images differ only
# by the residual of the solver.
_TOGETHER = 1e-6

_MOST = 2000  # limit of iterations for the pressures of one set


@dataclass(frozen=True)
class Peeling:
    """Detachment of an adhesive contact cell by cell; arrays have shape (k,).

    Set k of cells is the contact while the load decreases from the previous detachment to
    `penetration[k]`, `force[k]`, the next one.
    """

    # loads at which the set loses its next cell. Where they increase again, the contact is unstable
    # under that load.
    penetration: Array
    force: Array
    cells: Indices  # number of cells in contact
    # F = stiffness * d - offset for the set
    stiffness: Array
    offset: Array
    tension: float  # tension at which a cell detaches
    cell_area: float

    @property
    def area(self) -> Array:
        """Area of the cells in contact."""
        return np.asarray(self.cells * self.cell_area, dtype=np.float64)

    def pull_off(self, control: str = "force") -> int:
        """Return the index of the set at pull-off under the prescribed load, the lowest."""
        return int(np.argmin(self._loads(control)))

    def at(self, load: float, control: str) -> int:
        """Return the index of the set that carries a load on unloading, or the number of sets."""
        carrying = self._loads(control) <= load
        return int(np.argmax(carrying)) if carrying.any() else carrying.size

    def _loads(self, control: str) -> Array:
        refuse(choice_faults("control", control, ("force", "penetration")))
        return self.force if control == "force" else self.penetration


def peel(
    operator: ElasticBody,
    gap: ArrayLike,
    mask: ArrayLike,
    work: float,
    *,
    rule: str = "printed",
    tolerance: float = 1e-7,
    until: float = 0.0,
) -> Peeling:
    """Return the detachment of an adhesive contact from a set of cells to the last one.

    The operator is a free one of square cells; `mask` has the cells of a contact pressed wider
    than stable. `rule` calibrates the tension, see the module; the tolerance is the relative
    residual of the displacement. The path ends at the fraction `until` of the cells, in [0, 1).

    >>> from reference.halfspace import FreeOperator
    >>> K = FreeOperator((1, 1), (1.0, 1.0), 1.0)
    >>> cell = peel(K, [[0.0]], [[True]], 1.0)
    >>> round(cell.tension, 4), bool(np.isclose(cell.force[0], -cell.tension))
    (1.4537, True)
    """
    gap, contact = check_gap(operator, gap), np.asarray(mask, dtype=bool)
    faults = []
    if operator.periodic or abs(operator.spacing[0] / operator.spacing[1] - 1) > 1e-12:
        faults.append("detachment needs a free half-space with square cells")
    if contact.shape != operator.shape:
        faults.append(f"mask has shape {contact.shape}, the operator {operator.shape}")
    elif not contact.any() or not np.isfinite(gap[contact]).all():
        faults.append("expected at least one cell in contact, all with finite gaps")
    faults += positive_faults(work=work) + choice_faults("rule", rule, tuple(RULES))
    if not 0 <= until < 1:
        faults.append(f"until must lie in [0, 1), not {until!r}")
    refuse(faults)
    released = 2 * operator.effective_modulus * work / operator.spacing[0]
    tension = RULES[rule] * float(np.sqrt(released))
    per_depth, from_shape = np.zeros(gap.shape), np.zeros(gap.shape)

    def pressures(target: Array, start: Array) -> Array:
        goal = tolerance * float(np.abs(target).max())
        found, history = on_cells(operator, contact, target, goal, _MOST, start=start)
        if history[-1] > goal:
            raise ConvergenceError("the pressures of an adhesive contact were not found", history)
        return found

    rows: list[tuple[float, float, int, float, float]] = []
    last = until * np.count_nonzero(contact)
    while np.count_nonzero(contact) > last:
        per_depth = pressures(contact.astype(float), per_depth)
        from_shape = pressures(np.where(contact, gap, 0.0), from_shape)
        # p = d per_depth - from_shape reaches -tension
        turn = np.where(
            contact, (from_shape - tension) / np.where(contact, per_depth, 1.0), -np.inf
        )
        depth = float(turn.max())
        stiffness, offset = (float(p.sum()) * operator.cell_area for p in (per_depth, from_shape))
        rows.append((depth, stiffness * depth - offset, int(contact.sum()), stiffness, offset))
        near = tension / float(per_depth[contact].max())
        contact = contact & (turn < depth - _TOGETHER * near)
    depths, forces, cells, stiffnesses, offsets = (
        np.array(part) for part in zip(*rows, strict=True)
    )
    return Peeling(depths, forces, cells, stiffnesses, offsets, tension, operator.cell_area)
