"""Relaxation of automata to equilibrium above a floor that some of them may not fall below.

MPRGP: the energy W(x) - b x is least where x >= floor: projected conjugate gradients with
proportioning (Z. Dostal, Optimal Quadratic Programming Algorithms, Springer 2009, ch. 5). Steps
follow conjugate gradients while the contact set stays; a step that would cross the floor stops
there and is followed by one of fixed length, projected; automata that are pulled leave the floor
when their pull outweighs all other imbalance. Each step lowers the energy, and the contact set is
found in a finite number of steps.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from reference.arrays import Array, Integers, Mask
from reference.errors import ConvergenceError

Resist = Callable[[Array], Array]

# A projected gradient step shorter than 2 / |K| lowers the energy; a norm from power iteration is a
# little too small.
STEP, MARGIN = 1.9, 1.05
MOST_STEPS = 20_000


@dataclass(frozen=True, eq=False)
class Rest:
    """A state of equilibrium.

    `reactions` >= 0 are forces of the floor on the unknowns that may touch it, `active` says which
    of them do, `steps` how often forces were computed. `history` is the imbalance by step: the norm
    of the forces that nothing balances over that of the reactions.
    """

    moved: Array
    reactions: Array
    active: Mask
    steps: int
    history: list[float] = field(default_factory=list)


def largest_stiffness(resist: Resist, size: int) -> float:
    """Return the largest eigenvalue of the stiffness, a few per cent too large at most.

    >>> round(largest_stiffness(lambda x: np.array([1.0, 3.0]) * x, 2), 2)
    3.15
    """
    vector = np.random.default_rng(0).normal(size=size)
    largest = 0.0
    for _ in range(40):
        vector = resist(vector / np.linalg.norm(vector))
        largest = float(np.linalg.norm(vector))
    return MARGIN * largest


def relax(
    resist: Resist,
    load: Array,
    numbers: Integers,
    floor: Array,
    start: Array,
    *,
    tolerance: float,
    stiffest: float,
) -> Rest:
    """Return the equilibrium above a floor of forces K x, which `resist` returns, and a load b.

    `floor` has the least values of the unknowns with these numbers. The tolerance is the largest
    imbalance, relative to the reactions; `stiffest` the largest eigenvalue of K, or more.
    """
    history: list[float] = []

    def split() -> tuple[Mask, Array, Array]:
        """Split the gradient K x - b: free automata, and those on the floor that are pulled."""
        active = moved[numbers] <= floor
        free = gradient.copy()
        free[numbers[active]] = 0.0
        return active, free, np.where(active, np.minimum(gradient[numbers], 0.0), 0.0)

    moved = start.copy()
    moved[numbers] = np.maximum(moved[numbers], floor)
    gradient, steps = resist(moved) - load, 1
    active, free, pulled = split()
    direction = free.copy()
    while True:
        held = gradient[numbers[active]]
        acting = np.linalg.norm(np.maximum(held, 0.0)) or np.linalg.norm(load)
        missing = np.sqrt(float(free @ free) + pulled @ pulled)
        history.append(float(missing / acting) if missing else 0.0)
        if history[-1] <= tolerance:
            reactions = np.where(active, gradient[numbers], 0.0)
            return Rest(moved, reactions, active, steps, history)
        if steps > MOST_STEPS or not np.isfinite(history[-1]):
            raise ConvergenceError(
                f"no equilibrium of the automata after {steps} steps: what is not balanced "
                f"is {history[-1]:.1e} of the reactions, more than {tolerance:.0e}",
                history,
            )
        if pulled @ pulled > float(free @ free):
            # proportioning: automata that are pulled leave the floor
            direction = np.zeros_like(moved)
            direction[numbers] = pulled
            response, steps = resist(direction), steps + 1
            length = float(gradient @ direction) / float(direction @ response)
            moved -= length * direction
            gradient -= length * response
            active, free, pulled = split()
            direction = free.copy()
            continue
        # conjugate gradients, as far as no automaton crosses the floor
        response, steps = resist(direction), steps + 1
        curvature = float(direction @ response)
        length = float(gradient @ direction) / curvature
        falls, room = direction[numbers], moved[numbers] - floor
        most = float(np.min(room[falls > 0] / falls[falls > 0], initial=np.inf))
        moved -= min(length, most) * direction
        gradient -= min(length, most) * response
        active, free, pulled = split()
        if length < most:
            response[numbers[active]] = 0.0
            direction *= -float(free @ response) / curvature
            direction += free
            continue
        # expansion: a step of fixed length, projected
        moved -= STEP / stiffest * free
        moved[numbers] = np.maximum(moved[numbers], floor)
        gradient, steps = resist(moved) - load, steps + 1
        active, free, pulled = split()
        direction = free.copy()
