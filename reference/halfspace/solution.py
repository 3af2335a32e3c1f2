"""What a half-space solver is asked (one kind of load) and what it answers (`Contact`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.halfspace.operators import HalfSpace

Field = NDArray[np.float64]


@dataclass(frozen=True)
class Contact:
    """One converged load step of a rigid shape on a half-space.

    Attributes
    ----------
    penetration : float
        Rigid approach d after first touch; contact means displacement = d - gap.
    force : float
        Sum of pressure times cell area.
    pressure : ndarray, shape (nx, ny)
        Cell values, not negative.
    iterations : int
        Iterations of the method that found it (all stages on the grid itself).
    violation : float
        Largest distance from the contact conditions, relative to the penetration: the overlap of
        cells without pressure or the remaining gap (of either sign) of cells with pressure,
        whichever is larger; evaluated anew in double precision on the final pressure.
    operator, initial_gap
        The half-space and the gap of the problem.
    history : list of float
        The violation at each iteration.
    convolutions : (int, int)
        Convolutions of the FFT solver on its grid, in single and in double precision.

    Displacement and gaps of the whole grid are evaluated when they are asked for.
    """

    penetration: float
    force: float
    pressure: Field
    iterations: int
    violation: float
    operator: HalfSpace = field(repr=False)
    initial_gap: Field = field(repr=False)
    history: list[float] = field(default_factory=list, repr=False)
    convolutions: tuple[int, int] = (0, 0)

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Cells in contact, pressure > 0."""
        return self.pressure > 0

    @cached_property
    def displacement(self) -> Field:
        """Displacement of all cells, positive into the half-space."""
        return self.operator.apply(self.pressure)

    @property
    def gap(self) -> Field:
        """Remaining gap of all cells; infinite where the shape has no material."""
        return self.initial_gap - self.penetration + self.displacement

    @cached_property
    def mean_gap(self) -> float:
        """Mean of the remaining gap over the cells where it is finite."""
        finite = np.isfinite(self.initial_gap)
        if self.operator.periodic and finite.all():
            # the mean displacement is zero
            return float(self.initial_gap.mean()) - self.penetration
        return float(self.gap[finite].mean())


def from_first_touch(contact: Contact, gap: Field) -> Contact:
    """Return the contact of a gap from that of ``gap - gap.min()``; its history stays as it was.

    Depths are solved for from the first touch of a cell: a shape far away, or forces that indent
    by less than the round-off of the distance, cost no digits of the overlap.
    """
    lowest = float(gap.min())
    share = contact.penetration / (contact.penetration + lowest)
    moved = replace(
        contact,
        penetration=contact.penetration + lowest,
        violation=contact.violation * share,
        initial_gap=gap,
    )
    if "displacement" in vars(contact):
        vars(moved)["displacement"] = contact.displacement
    return moved


def assemble(
    operator: HalfSpace,
    gap: Field,
    pressure: Field,
    penetration: float,
    iterations: int,
    history: Sequence[float],
) -> Contact:
    """Evaluate force and violation of a final pressure on the whole grid."""
    displacement = operator.apply(pressure)
    finite = np.isfinite(gap)
    clearance = np.where(finite, gap, 0.0) - penetration + displacement
    worst = violation(clearance, pressure > 0, finite, penetration)
    return contact_of(
        operator, gap, pressure, penetration, worst, iterations, history, displacement
    )


def contact_of(
    operator: HalfSpace,
    gap: Field,
    pressure: Field,
    penetration: float,
    violation: float,
    iterations: int,
    history: Sequence[float],
    displacement: Field | None = None,
    convolutions: tuple[int, int] = (0, 0),
) -> Contact:
    """Return the answer, with the displacement where it is known already."""
    contact = Contact(
        penetration=float(penetration),
        force=float(pressure.sum() * operator.cell_area),
        pressure=pressure,
        iterations=int(iterations),
        violation=float(violation),
        operator=operator,
        initial_gap=gap,
        history=list(history),
        convolutions=convolutions,
    )
    if displacement is not None:
        vars(contact)["displacement"] = displacement
    return contact


def violation(
    clearance: Field,
    mask: NDArray[np.bool_],
    finite: NDArray[np.bool_],
    penetration: float,
) -> float:
    """Largest |clearance| in contact or overlap outside it, relative to the penetration."""
    inside = np.abs(clearance[mask]).max(initial=0.0)
    outside = -clearance[finite & ~mask].min(initial=0.0)
    worst = max(inside, outside)
    return float(worst / penetration) if worst > 0 else 0.0


def check_gap(operator: HalfSpace, gap: ArrayLike) -> Field:
    """Return the gap as a double array, or raise ValueError listing what is wrong with it."""
    gap = np.asarray(gap, dtype=float)
    faults = []
    if gap.shape != operator.shape:
        faults.append(f"gap has shape {gap.shape}, the operator {operator.shape}")
    if np.isnan(gap).any():
        faults.append(f"gap has {int(np.isnan(gap).sum())} undefined (NaN) points")
    if (gap < 0).any():
        faults.append(f"gap must not be negative, its minimum is {np.nanmin(gap)!r}")
    if not np.isfinite(gap).any():
        faults.append("gap is infinite everywhere: nothing can touch")
    if faults:
        raise ValueError("; ".join(faults))
    return gap


def check_load(**loads: float | ArrayLike | None) -> tuple[str, NDArray[np.float64]]:
    """Return (kind, values) of the one load given; values are positive and strictly increasing.

    A zero mean gap is full contact, which does not set the force, and is refused like any zero.
    """
    given = {kind: value for kind, value in loads.items() if value is not None}
    if len(given) != 1:
        raise ValueError(
            f"give exactly one of {', '.join(loads)}; came: {', '.join(given) or 'none'}"
        )
    ((kind, value),) = given.items()
    values = np.atleast_1d(np.asarray(value, dtype=float))
    faults = []
    if values.ndim != 1 or values.size == 0:
        faults.append(f"{kind} must be a number or a non-empty list, not shape {values.shape}")
    elif not (np.isfinite(values).all() and (values > 0).all()):
        faults.append(f"{kind} must be positive and finite, not {value!r}")
    elif not (np.diff(values) > 0).all():
        faults.append(f"{kind} must be strictly increasing, not {value!r}")
    if faults:
        raise ValueError("; ".join(faults))
    return kind, values


def check_control(tolerance: float, max_iterations: int) -> None:
    """Raise ValueError unless the tolerance and the iteration limit make sense."""
    faults = []
    if not 0 < tolerance < 1:
        faults.append(f"tolerance must lie between 0 and 1, not {tolerance!r}")
    if max_iterations < 1:
        faults.append(f"max_iterations must be at least 1, not {max_iterations!r}")
    if faults:
        raise ValueError("; ".join(faults))
