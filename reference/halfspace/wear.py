"""A rigid shape that wears on the half-space by Archard's law, in sliding or in an oscillation.

A cell of the shape loses k p ds, p its pressure and ds its slip (Archard 1953, locally). Steps
are explicit (Heun's) and as long as cells allow: k E* ds is half their side at most.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse
from reference.contact.press import Contact
from reference.errors import ConvergenceError
from reference.halfspace import fft
from reference.halfspace.solution import Press
from reference.loads import Load

Field = NDArray[np.float64]

# k E* ds/dx of a step: the shortest wave then loses 0.7 of itself, and swings from twice that on.
_STEP = 0.5
MOST_STEPS = 20_000


@dataclass(frozen=True)
class Oscillation:
    """A small tangential oscillation under constant normal load, with Coulomb's friction.

    Where normal and tangential displacements do not act on each other the tangential traction is
    mu (p - p*), p* the pressure of the same shape at d - lag (Ciavarella 1998, Jaeger 1998). Its
    contact sticks; elsewhere the surfaces slip by amplitude/lag times its gap, four times a cycle.

    Parameters
    ----------
    amplitude : float
        U, of the displacement.
    lag : float
        G* U/(mu E*).
    """

    amplitude: float
    lag: float

    def __post_init__(self) -> None:
        refuse(positive_faults(amplitude=self.amplitude, lag=self.lag))

    @property
    def slip(self) -> float:
        """Distance slipped in a cycle per gap left at d - lag."""
        return 4 * self.amplitude / self.lag


@dataclass(frozen=True)
class WornContact:
    """A worn shape in contact.

    Attributes
    ----------
    contact : Contact
        Its initial gap is that of the worn shape, its penetration counts from first touch of the
        unworn one.
    depth : ndarray
        Lost by every cell.
    volume : float
    sticking : ndarray of bool
        Cells that do not slip; none in sliding.
    steps : int
        From the start on.
    iterations : int
        Of all contacts from the start on.
    """

    contact: Contact
    depth: Field
    volume: float
    sticking: NDArray[np.bool_]
    steps: int
    iterations: int


def wear(
    press: Press,
    load: Load,
    coefficient: float,
    distances: Field,
    oscillation: Oscillation | None = None,
    *,
    tolerance: float = 1e-8,
) -> Iterator[WornContact]:
    """Wear a shape under a constant load.

    Parameters
    ----------
    press : Press
        The unworn shape over the half-space.
    load : Load
        Penetration or force, one value.
    coefficient : float
        k, volume lost per force and distance.
    distances : ndarray
        Sliding distances, strictly increasing; with an oscillation, numbers of cycles.
    oscillation : Oscillation, optional
        Of a shape on the free half-space.
    tolerance : float
        Of every contact, as of `fft.solve`.

    Yields
    ------
    WornContact
        One per distance.

    Raises
    ------
    ValueError
        Lists all invalid arguments.
    ConvergenceError
        If a contact fails or is lost, or the distance takes too many steps.
    """
    refuse(positive_faults(coefficient=coefficient))
    Load("distances", distances)  # raises where they are none
    load.one_of("penetration", "force")
    load.single()
    if oscillation is not None and press.operator.periodic:
        raise ValueError("an oscillation takes a free half-space, on which gaps have a datum")
    return _Wear(press, load, oscillation, tolerance).along(coefficient, distances)


class _Wear:
    def __init__(
        self, press: Press, load: Load, oscillation: Oscillation | None, tolerance: float
    ) -> None:
        self.press, self.load, self.oscillation = press, load, oscillation
        self.tolerance = tolerance
        self.contact: Contact | None = None
        self.inner: Contact | None = None
        self.iterations = 0

    def along(self, coefficient: float, distances: Field) -> Iterator[WornContact]:
        """Yield the states at the distances."""
        operator = self.press.operator
        farthest = 1.0 if self.oscillation is None else 4 * self.oscillation.amplitude
        stiff = coefficient * operator.effective_modulus * farthest
        longest = _STEP * min(operator.spacing) / stiff
        needed = float(distances[-1]) / longest
        if not needed <= MOST_STEPS:
            raise ConvergenceError(f"the wear takes {needed:.3g} steps, more than {MOST_STEPS}")
        depth, at, steps = np.zeros(operator.shape), 0.0, 0
        rate = self._rate(depth)
        for distance in distances:
            count = int(np.ceil((distance - at) / longest))
            k = coefficient * (distance - at) / count
            for _ in range(count):
                ahead = self._rate(depth + k * rate)
                depth = depth + 0.5 * k * (rate + ahead)
                rate = self._rate(depth)
            at, steps = float(distance), steps + count
            assert self.contact is not None
            volume = float(depth.sum() * operator.cell_area)
            sticking = self._sticking()
            yield WornContact(self.contact, depth, volume, sticking, steps, self.iterations)

    def _rate(self, depth: Field) -> Field:
        """Return pressure times slip where so much is worn; keeps the contact."""
        worn = Press(self.press.operator, self.press.gap + depth)
        if self.load.control == "penetration" and worn.lowest >= self.load.single():
            raise ConvergenceError("worn so far that nothing touches any more")
        self.contact = self._solve(worn, self.load, self.contact)
        if self.oscillation is None:
            return self.contact.pressure
        inner = self.contact.penetration - self.oscillation.lag
        if inner > worn.lowest:
            self.inner = self._solve(worn, Load("penetration", inner), self.inner)
            left = np.maximum(self.inner.gap, 0.0)
            left[self.inner.mask] = 0.0
        else:
            self.inner, left = None, worn.gap - inner
        inside = self.contact.mask
        rate = np.zeros(left.shape)
        rate[inside] = self.oscillation.slip * self.contact.pressure[inside] * left[inside]
        return rate

    def _solve(self, press: Press, load: Load, start: Contact | None) -> Contact:
        contact = fft.solve(press, load, tolerance=self.tolerance, start=start)
        self.iterations += contact.iterations
        return contact

    def _sticking(self) -> NDArray[np.bool_]:
        if self.inner is None:
            return np.zeros(self.press.operator.shape, dtype=bool)
        return self.inner.mask
