"""A rigid shape that wears on the half-space by Archard's law, in sliding or in an oscillation.

A cell of the shape loses k p ds, p its pressure and ds its slip (Archard 1953, locally). Steps
are explicit (Heun's) and as long as cells allow: k E* ds is half their side at most.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array, Mask
from reference.contact.body import ElasticBody
from reference.contact.press import Contact, check_gap, press
from reference.errors import ConvergenceError, positive_faults, refuse
from reference.loads import Load

# k E* ds/dx of a step: the shortest wave then loses 0.7 of itself, and swings from twice that on.
_STEP = 0.5
MOST_STEPS = 20_000


@dataclass(frozen=True)
class Oscillation:
    """A small tangential oscillation under constant normal load, with Coulomb's friction.

    Where normal and tangential displacements do not act on each other the tangential traction is
    mu (p - p*), p* the pressure of the same shape at d - lag (Ciavarella 1998, Jaeger 1998). Its
    contact sticks; elsewhere the surfaces slip by amplitude/lag times its gap, four times a cycle.
    """

    amplitude: float  # U, of the displacement
    lag: float  # G* U/(mu E*)

    def __post_init__(self) -> None:
        refuse(positive_faults(amplitude=self.amplitude, lag=self.lag))

    @property
    def slip(self) -> float:
        """Distance slipped in a cycle per gap left at d - lag."""
        return 4 * self.amplitude / self.lag


@dataclass(frozen=True)
class WornContact:
    """A worn shape in contact."""

    # its initial gap is that of the worn shape, its penetration counts from first touch of the
    # unworn one
    contact: Contact
    depth: Array  # lost by every cell
    volume: float
    sticking: Mask  # cells that do not slip; none in sliding
    steps: int  # from the start on
    iterations: int  # of all contacts from the start on


def wear(
    operator: ElasticBody,
    gap: ArrayLike,
    load: Load,
    coefficient: float,
    distances: Array,
    oscillation: Oscillation | None = None,
    *,
    tolerance: float = 1e-8,
) -> Iterator[WornContact]:
    """Wear a shape under a constant load.

    The load is one penetration or force, `coefficient` is k, the volume lost per force and
    distance. Sliding distances increase strictly; with an oscillation, which takes the free
    half-space, they are numbers of cycles. Yields the state at each.
    """
    refuse(positive_faults(coefficient=coefficient))
    Load("distances", distances)  # raises where they are none
    load.one_of("penetration", "force")
    load.single()
    if oscillation is not None and operator.periodic:
        raise ValueError("an oscillation takes a free half-space, on which gaps have a datum")
    unworn = check_gap(operator, gap)

    def worn_at() -> Iterator[WornContact]:
        farthest = 1.0 if oscillation is None else 4 * oscillation.amplitude
        stiff = coefficient * operator.effective_modulus * farthest
        longest = _STEP * min(operator.spacing) / stiff
        needed = float(distances[-1]) / longest
        if not needed <= MOST_STEPS:
            raise ConvergenceError(f"the wear takes {needed:.3g} steps, more than {MOST_STEPS}")
        # the contact, the one that sticks inside it, and the iterations of all
        contact: Contact | None = None
        inner: Contact | None = None
        iterations = 0

        def rate(depth: Array) -> Array:
            """Return pressure times slip where so much is worn."""
            nonlocal contact, inner, iterations
            worn = unworn + depth
            lowest = float(worn.min())
            if load.control == "penetration" and lowest >= load.single():
                raise ConvergenceError("worn so far that nothing touches any more")
            contact = press(operator, worn, load, tolerance=tolerance, start=contact)
            iterations += contact.iterations
            if oscillation is None:
                return contact.pressure
            sticks = contact.penetration - oscillation.lag
            if sticks > lowest:
                sticking = Load("penetration", sticks)
                inner = press(operator, worn, sticking, tolerance=tolerance, start=inner)
                iterations += inner.iterations
                left = np.maximum(inner.gap, 0.0)
                left[inner.mask] = 0.0
            else:
                inner, left = None, worn - sticks
            slipped = np.zeros(worn.shape)
            inside = contact.mask
            slipped[inside] = oscillation.slip * contact.pressure[inside] * left[inside]
            return slipped

        depth, at, steps = np.zeros(operator.shape), 0.0, 0
        now = rate(depth)
        for distance in distances:
            count = int(np.ceil((distance - at) / longest))
            k = coefficient * (distance - at) / count
            for _ in range(count):
                ahead = rate(depth + k * now)
                depth = depth + 0.5 * k * (now + ahead)
                now = rate(depth)
            at, steps = float(distance), steps + count
            assert contact is not None
            volume = float(depth.sum() * operator.cell_area)
            sticking = np.zeros(operator.shape, dtype=bool) if inner is None else inner.mask
            yield WornContact(contact, depth, volume, sticking, steps, iterations)

    return worn_at()
