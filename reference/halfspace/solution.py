"""Input (`Press` and `Effort`) and output (`Contact`) of half-space solvers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import refuse
from reference.halfspace.operators import HalfSpace

Field = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Press:
    """A rigid shape over a half-space.

    Parameters
    ----------
    operator : FreeOperator or PeriodicOperator
        The half-space.
    gap : array_like, shape (nx, ny)
        Initial gap g >= 0 of the shape; +inf where contact is impossible.
    hardness : float
        Largest pressure that the half-space carries; cells that have it give way beyond their
        elastic displacement, and overlap (`fft` only).

    Raises
    ------
    ValueError
        Lists all errors in the gap, or says that the hardness is not positive.
    """

    operator: HalfSpace
    gap: Field
    hardness: float = np.inf

    def __post_init__(self) -> None:
        object.__setattr__(self, "gap", check_gap(self.operator, self.gap))
        if not self.hardness > 0:
            raise ValueError(f"hardness must be positive, not {self.hardness!r}")

    @property
    def lowest(self) -> float:
        """Gap at the point of first touch."""
        return float(self.gap.min())

    def touching(self) -> Press:
        """Return the shape moved to first touch."""
        return Press(self.operator, self.gap - self.lowest, self.hardness)


@dataclass(frozen=True)
class Effort:
    """Tolerance and limit of iterations of a solver.

    Parameters
    ----------
    tolerance : float
        Largest violation, relative to the penetration.
    max_iterations : int
        Limit for all stages together.
    """

    tolerance: float
    max_iterations: int

    def __post_init__(self) -> None:
        faults = []
        if not 0 < self.tolerance < 1:
            faults.append(f"tolerance must lie between 0 and 1, not {self.tolerance!r}")
        if self.max_iterations < 1:
            faults.append(f"max_iterations must be at least 1, not {self.max_iterations!r}")
        refuse(faults)


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
        Iterations of the solver (all stages on the finest grid).
    violation : float
        Largest distance from the contact conditions, relative to the penetration: the overlap of
        cells without pressure or the remaining gap (of either sign) of cells with pressure,
        whichever is larger; recomputed in double precision for the final pressure.
    operator, initial_gap
        The half-space and the gap of the problem.
    history : list of float
        Violations of the iterations.
    convolutions : (int, int)
        Convolutions of the FFT solver on its grid, in single and in double precision.

    Displacement and gaps of the whole grid are evaluated on demand.
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

    def forget_displacement(self) -> None:
        """Give its memory back; it is computed again when asked for, to the same digits."""
        vars(self).pop("displacement", None)

    @property
    def gap(self) -> Field:
        """Remaining gap of all cells; infinite outside the shape."""
        return self.initial_gap - self.penetration + self.displacement

    @cached_property
    def mean_gap(self) -> float:
        """Mean of the remaining gap over the cells where it is finite."""
        finite = np.isfinite(self.initial_gap)
        if self.operator.periodic and finite.all():
            mean = self.operator.mean_compliance * float(self.pressure.mean())
            return float(self.initial_gap.mean()) - self.penetration + mean
        return float(self.gap[finite].mean())


def from_first_touch(contact: Contact, gap: Field) -> Contact:
    """Return the contact of a gap from that of ``gap - gap.min()``, with the same history.

    Depths are computed from the first touch of a cell: for a distant shape, or penetrations below
    the round-off of the distance, the overlap loses no digits.
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
    press: Press, pressure: Field, penetration: float, iterations: int, history: Sequence[float]
) -> Contact:
    """Return the contact of a final pressure, with force and violation on the whole grid."""
    displacement = press.operator.apply(pressure)
    finite = np.isfinite(press.gap)
    clearance = np.where(finite, press.gap, 0.0) - penetration + displacement
    worst = violation(clearance, pressure > 0, finite, penetration)
    contact = contact_of(press, pressure, penetration, worst, iterations, history)
    vars(contact)["displacement"] = displacement
    return contact


def contact_of(
    press: Press,
    pressure: Field,
    penetration: float,
    violation: float,
    iterations: int,
    history: Sequence[float],
) -> Contact:
    """Return the contact of a solver with a known violation."""
    return Contact(
        penetration=float(penetration),
        force=float(pressure.sum() * press.operator.cell_area),
        pressure=pressure,
        iterations=int(iterations),
        violation=float(violation),
        operator=press.operator,
        initial_gap=press.gap,
        history=list(history),
    )


def violation(
    clearance: Field,
    mask: NDArray[np.bool_],
    finite: NDArray[np.bool_],
    penetration: float,
) -> float:
    """Return the largest |clearance| in contact or overlap outside, relative to the penetration."""
    inside = np.abs(clearance[mask]).max(initial=0.0)
    overlap = -clearance[finite & ~mask].min(initial=0.0)
    worst = max(inside, overlap)
    return float(worst / penetration) if worst > 0 else 0.0


def check_gap(operator: HalfSpace, gap: ArrayLike) -> Field:
    """Return the gap as a double array, or raise ValueError with all errors."""
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
    refuse(faults)
    return gap
