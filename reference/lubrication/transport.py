"""What drives the flow of a film besides pressure: surfaces that entrain it, or an approach."""

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
    separation : float
        Height that is added to the gap of the undeformed bodies at first touch.
    displacement : ndarray
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
    separation: float
    displacement: Field = field(repr=False)
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
    """Derivatives of the balance by s, by the displacement of each cell, and by the separation."""

    s: sparse.csr_matrix
    displacement: sparse.csr_matrix
    separation: Field


class Transport(Protocol):
    """What drives the flow besides pressure."""

    def balance(self, film: Film, state: State) -> Field:
        """Return the volume of oil that leaves each cell per time."""

    def slopes(self, film: Film, state: State) -> Slopes:
        """Return its derivatives."""

    def carried(self, film: Film, state: State) -> Field:
        """Return the flow that the balance of each cell is compared with."""

    def admits(self, separation: float) -> bool:
        """Whether this flow is possible at this separation."""


@dataclass(frozen=True)
class Entrainment:
    """Surfaces that draw the film along x at the mean speed U: L = 12 eta U."""

    speed: float

    def balance(self, film: Film, state: State) -> Field:
        """Return the volume of oil that leaves each cell per time."""
        return film.balance(state.s, state.separation, state.displacement, self.speed)

    def slopes(self, film: Film, state: State) -> Slopes:
        """Return its derivatives."""
        by_s, by_displacement = film.derivatives(
            state.s, state.separation, state.displacement, self.speed
        )
        return Slopes(by_s, by_displacement, np.asarray(by_displacement.sum(axis=1)).ravel())

    def carried(self, film: Film, state: State) -> Field:
        """Return what is carried through a face of each cell."""
        return (
            self.speed * film.cells.widths[1] * film.thickness(state.separation, state.displacement)
        )

    def admits(self, separation: float) -> bool:
        """Return True: it is possible at any separation."""
        return True


@dataclass(frozen=True)
class Approach:
    """Bodies that approach at a speed V, L = 12 eta V: one step in time.

    The separation is the clock: it falls by V dt. Its derivative is a backward difference of second
    order on steps of any size (of first order where only one earlier film is known).

    Attributes
    ----------
    speed : float
    before : State
        The film one step ago.
    earlier : State, optional
        The film two steps ago.
    """

    speed: float
    before: State
    earlier: State | None = None

    def balance(self, film: Film, state: State) -> Field:
        """Return the volume of oil that leaves each cell per time, and what it stores."""
        flow = film.balance(state.s, state.separation, state.displacement, 0.0)
        fall = self.before.separation - state.separation
        own, *others = self._weights(fall)
        kept = own * _oil(film, state)
        for weight, past in zip(others, (self.before, self.earlier), strict=False):
            assert past is not None
            kept = kept + weight * _oil(film, past)
        return flow + self.speed * film.cells.area / film.cells.copies * kept

    def slopes(self, film: Film, state: State) -> Slopes:
        """Return its derivatives; that by the separation includes the weights of the difference."""
        by_s, by_displacement = film.derivatives(state.s, state.separation, state.displacement, 0.0)
        fall = self.before.separation - state.separation
        step = 1e-6 * fall
        area = (self.speed * film.cells.area / film.cells.copies).ravel()
        own, *_ = self._weights(fall)
        oil = [_oil(film, past) for past in (state, self.before, self.earlier) if past is not None]
        later, sooner = self._weights(fall + step), self._weights(fall - step)
        turned = sum((a - b) / (2 * step) * q for a, b, q in zip(later, sooner, oil, strict=True))
        by_oil = area * own
        empty = (state.s <= 0).ravel()
        thickness = film.thickness(state.separation, state.displacement).ravel()
        by_s = by_s + sparse.diags(np.where(empty, by_oil * thickness, 0.0))
        stored = sparse.diags(by_oil * (1 - state.vapour).ravel())
        by_displacement = by_displacement + stored
        by_separation = np.asarray(by_displacement.sum(axis=1)).ravel() - area * np.ravel(turned)
        return Slopes(by_s.tocsr(), by_displacement.tocsr(), by_separation)

    def carried(self, film: Film, state: State) -> Field:
        """Return the volume that the approach displaces from each cell per time."""
        return np.broadcast_to(self.speed * film.cells.area / film.cells.copies, film.gap.shape)

    def admits(self, separation: float) -> bool:
        """Whether the bodies have come closer."""
        return separation < self.before.separation

    def _weights(self, fall: float) -> tuple[float, ...]:
        """Return the weights of this film and earlier ones in d(oil)/dt over V."""
        if self.earlier is None:
            return 1 / fall, -1 / fall
        last = self.earlier.separation - self.before.separation
        both = fall + last
        return (fall + both) / (fall * both), -both / (fall * last), fall / (last * both)


def _oil(film: Film, state: State) -> Field:
    """Return the thickness of oil in each cell."""
    return (1 - state.vapour) * film.thickness(state.separation, state.displacement)
