"""What makes a film flow: surfaces that draw it along, or bodies that approach each other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from reference.lubrication.reynolds import Film

Field = NDArray[np.float64]


@dataclass(frozen=True)
class State:
    """A film: pressure and vapour, and the gap.

    Attributes
    ----------
    s : ndarray
        p where positive, -theta where negative.
    lift : float
        Height that is added to the gap of the undeformed bodies at first touch.
    bent : ndarray
        Displacement of the surface.
    error : float
        Largest imbalance: of mass in a cell, relative to what is carried through its faces, or of
        forces, relative to the load.
    rounds : int
        Of Newton's method.
    history : list of float
        The errors.
    """

    s: Field = field(repr=False)
    lift: float
    bent: Field = field(repr=False)
    error: float = np.inf
    rounds: int = 0
    history: list[float] = field(default_factory=list, repr=False)

    @property
    def pressure(self) -> Field:
        """Pressure in the cells."""
        return np.maximum(self.s, 0.0)

    @property
    def vapour(self) -> Field:
        """Share of the gap that vapour fills."""
        return np.maximum(-self.s, 0.0)


class Slopes(NamedTuple):
    """Derivatives of the balance by s, by the displacement of each cell, and by the lift."""

    s: sparse.csr_matrix
    bent: sparse.csr_matrix
    lift: Field


class Transport(Protocol):
    """What moves the oil beside its pressure."""

    def balance(self, film: Film, state: State) -> Field:
        """Return what leaves each cell per time."""

    def slopes(self, film: Film, state: State) -> Slopes:
        """Return its derivatives."""

    def carried(self, film: Film, state: State) -> Field:
        """Return the flow that the balance of each cell is compared with."""

    def admits(self, lift: float) -> bool:
        """Whether there is such a flow with such a lift."""


@dataclass(frozen=True)
class Entrainment:
    """Surfaces that draw the film along x at the mean speed U: L = 12 eta U."""

    speed: float

    def balance(self, film: Film, state: State) -> Field:
        """Return what leaves each cell per time."""
        return film.balance(state.s, state.lift, state.bent, self.speed)

    def slopes(self, film: Film, state: State) -> Slopes:
        """Return its derivatives."""
        by_s, by_bent = film.derivatives(state.s, state.lift, state.bent, self.speed)
        return Slopes(by_s, by_bent, np.asarray(by_bent.sum(axis=1)).ravel())

    def carried(self, film: Film, state: State) -> Field:
        """Return what is carried through a face of each cell."""
        return self.speed * film.cells.widths[1] * film.thickness(state.lift, state.bent)

    def admits(self, lift: float) -> bool:
        """Whether there is such a flow with such a lift: always."""
        return True


@dataclass(frozen=True)
class Approach:
    """Bodies that approach at a speed V, L = 12 eta V: a step from earlier films to the next.

    The lift is the clock: it falls by V dt. Its derivative is a backward difference of second order
    on steps of any size (of first order where only one earlier film is known).

    Attributes
    ----------
    speed : float
    before : State
        The film of the step before.
    earlier : State, optional
        That before it.
    """

    speed: float
    before: State
    earlier: State | None = None

    def balance(self, film: Film, state: State) -> Field:
        """Return what leaves each cell per time: what flows, and what the thicker film keeps."""
        flow = film.balance(state.s, state.lift, state.bent, 0.0)
        fall = self.before.lift - state.lift
        own, *others = self._weights(fall)
        kept = own * _oil(film, state)
        for weight, past in zip(others, (self.before, self.earlier), strict=False):
            assert past is not None
            kept = kept + weight * _oil(film, past)
        return flow + self.speed * film.cells.area / film.cells.copies * kept

    def slopes(self, film: Film, state: State) -> Slopes:
        """Return its derivatives; that by the lift includes the weights of the difference."""
        by_s, by_bent = film.derivatives(state.s, state.lift, state.bent, 0.0)
        fall = self.before.lift - state.lift
        step = 1e-6 * fall
        area = (self.speed * film.cells.area / film.cells.copies).ravel()
        own, *_ = self._weights(fall)
        oil = [_oil(film, past) for past in (state, self.before, self.earlier) if past is not None]
        later, sooner = self._weights(fall + step), self._weights(fall - step)
        turned = sum((a - b) / (2 * step) * q for a, b, q in zip(later, sooner, oil, strict=True))
        by_oil = area * own
        empty = (state.s <= 0).ravel()
        thickness = film.thickness(state.lift, state.bent).ravel()
        by_s = by_s + sparse.diags(np.where(empty, by_oil * thickness, 0.0))
        stored = sparse.diags(by_oil * (1 - state.vapour).ravel())
        by_bent = by_bent + stored
        by_lift = np.asarray(by_bent.sum(axis=1)).ravel() - area * np.ravel(turned)
        return Slopes(by_s.tocsr(), by_bent.tocsr(), by_lift)

    def carried(self, film: Film, state: State) -> Field:
        """Return what the approach presses out of each cell."""
        return np.broadcast_to(self.speed * film.cells.area / film.cells.copies, film.gap.shape)

    def admits(self, lift: float) -> bool:
        """Whether the bodies have come closer."""
        return lift < self.before.lift

    def _weights(self, fall: float) -> tuple[float, ...]:
        """Return the weights of this film and earlier ones in d(oil)/dt over V."""
        if self.earlier is None:
            return 1 / fall, -1 / fall
        last = self.earlier.lift - self.before.lift
        both = fall + last
        return (fall + both) / (fall * both), -both / (fall * last), fall / (last * both)


def _oil(film: Film, state: State) -> Field:
    """Return the thickness of oil in each cell."""
    return (1 - state.vapour) * film.thickness(state.lift, state.bent)
