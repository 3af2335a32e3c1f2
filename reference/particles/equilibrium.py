"""Relaxation of automata to equilibrium above a floor that some of them may not fall below.

The energy W(x) - b x is least where x >= floor: projected conjugate gradients with proportioning
(Z. Dostal, Optimal Quadratic Programming Algorithms, Springer 2009, ch. 5: MPRGP). Steps follow
conjugate gradients while the contact set stays; a step that would cross the floor stops there and
is followed by one of fixed length, projected; automata that are pulled leave the floor when their
pull outweighs all other imbalance. Each step lowers the energy, and the contact set is found in a
finite number of steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError

Floats = NDArray[np.float64]
Resist = Callable[[Floats], Floats]

# A projected gradient step shorter than 2 / |K| lowers the energy; a norm from power iteration is a
# little too small.
STEP, MARGIN = 1.9, 1.05
POWERS = 40
MOST_STEPS = 20_000


@dataclass(frozen=True, eq=False)
class Floor:
    """Least values of some unknowns, by their numbers; -inf where there is none."""

    numbers: NDArray[np.int64]
    values: Floats


@dataclass(frozen=True, eq=False)
class Rest:
    """A state of equilibrium.

    Attributes
    ----------
    moved : ndarray
        The unknowns.
    reactions : ndarray
        Forces of the floor on the unknowns that may touch it, >= 0.
    active : ndarray of bool
        Which of them touch.
    steps : int
        How often forces were computed.
    history : list of float
        Imbalance by step: the norm of what is not in balance over that of the reactions.
    """

    moved: Floats
    reactions: Floats
    active: NDArray[np.bool_]
    steps: int
    history: list[float] = field(default_factory=list)


def largest_stiffness(resist: Resist, size: int) -> float:
    """Return the largest eigenvalue of the stiffness, a few per cent too large at most.

    >>> round(largest_stiffness(lambda x: np.array([1.0, 3.0]) * x, 2), 2)
    3.15
    """
    vector = np.random.default_rng(0).normal(size=size)
    largest = 0.0
    for _ in range(POWERS):
        vector = resist(vector / np.linalg.norm(vector))
        largest = float(np.linalg.norm(vector))
    return MARGIN * largest


def relax(
    resist: Resist, load: Floats, floor: Floor, start: Floats, *, tolerance: float, stiffest: float
) -> Rest:
    """Return the equilibrium above a floor.

    Parameters
    ----------
    resist : callable
        Forces K x that hold displacements x.
    load : ndarray
        Forces b that act beside the floor.
    floor : Floor
    start : ndarray
        Displacements to begin with.
    tolerance : float
        Largest imbalance: norm of the forces that nothing balances over that of the reactions.
    stiffest : float
        Largest eigenvalue of K, or more.

    Raises
    ------
    ConvergenceError
        With the history of the imbalance, if it does not fall below the tolerance.
    """
    state = _State(resist, load, floor, start)
    while state.imbalance() > tolerance:
        if state.steps > MOST_STEPS or not np.isfinite(state.history[-1]):
            raise ConvergenceError(
                f"no equilibrium of the automata after {state.steps} steps: what is not balanced "
                f"is {state.history[-1]:.1e} of the reactions, more than {tolerance:.0e}",
                state.history,
            )
        if state.pulled @ state.pulled > state.unbalanced:
            state.release()
        else:
            state.conjugate_step(STEP / stiffest)
    reactions = np.where(state.active, state.gradient[floor.numbers], 0.0)
    return Rest(state.moved, reactions, state.active, state.steps, state.history)


class _State:
    """Displacements, the gradient K x - b and its parts, and the direction of search."""

    def __init__(self, resist: Resist, load: Floats, floor: Floor, start: Floats) -> None:
        self.resist, self.load, self.floor = resist, load, floor
        self.moved = start.copy()
        self.steps = 0
        self.history: list[float] = []
        self._project()
        self._begin_anew()

    def imbalance(self) -> float:
        """Return and remember what is not balanced, relative to the reactions (else the loads)."""
        held = self.gradient[self.floor.numbers[self.active]]
        acting = np.linalg.norm(np.maximum(held, 0.0)) or np.linalg.norm(self.load)
        missing = np.sqrt(self.unbalanced + self.pulled @ self.pulled)
        self.history.append(float(missing / acting) if missing else 0.0)
        return self.history[-1]

    def conjugate_step(self, fixed: float) -> None:
        """Follow conjugate gradients, as far as no automaton crosses the floor."""
        response = self._response(self.direction)
        curvature = float(self.direction @ response)
        length = float(self.gradient @ self.direction) / curvature
        most = self._way_to_floor()
        self._advance(min(length, most), response)
        if length < most:
            free = response.copy()
            free[self.floor.numbers[self.active]] = 0.0
            self.direction *= -float(self.free_gradient @ free) / curvature
            self.direction += self.free_gradient
            return
        self.moved -= fixed * self.free_gradient
        self._project()
        self._begin_anew()

    def release(self) -> None:
        """Let go of the automata that are pulled."""
        way = np.zeros_like(self.moved)
        way[self.floor.numbers] = self.pulled
        response = self._response(way)
        self.direction = way
        self._advance(float(self.gradient @ way) / float(way @ response), response)
        self.direction = self.free_gradient.copy()

    def _advance(self, length: float, response: Floats) -> None:
        self.moved -= length * self.direction
        self.gradient -= length * response
        self._split()

    def _begin_anew(self) -> None:
        self.gradient = self._response(self.moved) - self.load
        self._split()
        self.direction = self.free_gradient.copy()

    def _split(self) -> None:
        """Split the gradient: free automata, and those on the floor that are pulled."""
        numbers = self.floor.numbers
        self.active = self.moved[numbers] <= self.floor.values
        self.free_gradient = self.gradient.copy()
        self.free_gradient[numbers[self.active]] = 0.0
        self.unbalanced = float(self.free_gradient @ self.free_gradient)
        self.pulled = np.where(self.active, np.minimum(self.gradient[numbers], 0.0), 0.0)

    def _way_to_floor(self) -> float:
        numbers, falls = self.floor.numbers, self.direction[self.floor.numbers]
        room = self.moved[numbers] - self.floor.values
        return float(np.min(room[falls > 0] / falls[falls > 0], initial=np.inf))

    def _project(self) -> None:
        numbers = self.floor.numbers
        self.moved[numbers] = np.maximum(self.moved[numbers], self.floor.values)

    def _response(self, way: Floats) -> Floats:
        self.steps += 1
        return self.resist(way)
