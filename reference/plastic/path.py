"""Paths of loads on an elastic-plastic half-space, in the units of the caller."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse
from reference.loads import LoadPath
from reference.plastic.indentation import Indentation, State
from reference.plastic.materials import PlasticMaterial

Array = NDArray[np.float64]

# A rising load goes in steps in which a contact grows by a quarter of an element over its last
# part, the factor _FINE; what lies before is soon forgotten, and goes by _COARSE from 1/_FIRST.
_FINE, _COARSE, _FIRST = 2.0, 2.0, 32.0
_GROWTH = 0.25
# Steps of a stretch that falls.
_FALLING = 3


@dataclass(frozen=True)
class Moment:
    """A round contact at one load of a path.

    Attributes
    ----------
    penetration, force, contact_radius : float
    work, elastic, dissipated : float
        Work of the force, elastic energy, plastic dissipation so far.
    iterations : int
        Newton steps so far.
    residual : float
        Unbalanced forces over the largest force.
    """

    penetration: float
    force: float
    contact_radius: float
    work: float
    elastic: float
    dissipated: float
    iterations: int
    residual: float
    state: State


class Walk:
    """An indentation that is led along a path.

    Parameters
    ----------
    material : PlasticMaterial
    shape : callable
        f(r), the gap at first touch.
    radius : float
        Contact radius at the largest load, roughly: contacts of up to 1.25 times that fit.
    smallest : float
        That at the smallest load that shall be resolved.
    per_radius : int
        Elements per contact radius.

    Raises
    ------
    ValueError
        Lists all invalid arguments.

    Examples
    --------
    Elastic, it is Hertz's contact:

    >>> from reference.fem.elasticity import Material
    >>> steel = PlasticMaterial(Material(0.91, 0.3), np.inf)
    >>> ball = Walk(steel, lambda r: r**2 / 2, 0.1, per_radius=4)
    >>> (moment,) = ball.along(LoadPath("penetration", 0.01))
    >>> abs(moment.force / (4 / 3 * 0.01**1.5) - 1) < 1e-3
    True
    """

    def __init__(
        self,
        material: PlasticMaterial,
        shape: Callable[[Array], Array],
        radius: float,
        *,
        smallest: float | None = None,
        per_radius: int = 8,
    ) -> None:
        refuse(positive_faults(radius=radius))
        self.length = radius
        self.modulus = material.elastic.youngs_modulus
        self.indentation = Indentation(
            material.scaled(self.modulus),
            lambda r: np.asarray(shape(r * radius)) / radius,
            per_radius=per_radius,
            smallest=1.0 if smallest is None else smallest / radius,
        )
        self._per_radius = per_radius

    def along(self, path: LoadPath) -> Iterator[Moment]:
        """Yield the contact at each load of a path of penetrations or forces.

        Raises
        ------
        ValueError
            If the control is another one, or a force is negative.
        ConvergenceError
            If a step does not come to balance.
        """
        control = path.one_of("penetration", "force")
        if control == "force" and (path.values < 0).any():
            raise ValueError("force must not be negative: nothing holds the indenter")
        unit = self.length if control == "penetration" else self.modulus * self.length**2
        state = self.indentation.virgin
        for load in path.values / unit:
            state = self._led(state, control, float(load))
            yield self._moment(state)

    def residual_depth(self, moment: Moment) -> float:
        """Return the depth that remains if the indenter is lifted off from here."""
        if not moment.state.points.amount.any():
            return 0.0
        state = moment.state
        left = self.indentation.push(state, 0.0) if state.force > 0 else state
        return self.length * self.indentation.residual_depth(left)

    def given_back(self, moment: Moment, steps: int = 6) -> float:
        """Return the work that the body gives back if the indenter is lifted off from here.

        F^(2/3) is taken as linear in the penetration within a step: exact for a ball on an elastic
        surface, which what is dented nearly is.
        """
        state, work = moment.state, 0.0
        for share in 1 - np.arange(1, steps + 1) / steps:
            lifted = self.indentation.push(state, moment.state.force * share**1.5)
            high, low = state.force ** (2 / 3), lifted.force ** (2 / 3)
            risen = state.penetration - lifted.penetration
            work += 0.4 * risen * (high**2.5 - low**2.5) / (high - low)
            state = lifted
        return float(work * self.modulus * self.length**3)

    def surface(self, moment: Moment) -> tuple[Array, Array]:
        """Return radii, and how far the surface there has gone into the body."""
        radius, sunk = self.indentation.surface_shape(moment.state)
        return radius * self.length, sunk * self.length

    def _led(self, state: State, control: str, load: float) -> State:
        now = state.penetration if control == "penetration" else state.force
        act = self.indentation.press if control == "penetration" else self.indentation.push
        for value in self._steps(now, load):
            state = act(state, value)
        return state

    def _steps(self, now: float, load: float) -> Array:
        """Return the loads between one and the next, with the last of them."""
        if load <= max(now, 0.0):
            count = _FALLING if 0 <= load < now else 1
            return np.linspace(now, load, count + 1)[1:]
        fine = int(np.ceil(np.log(_FINE) * self._per_radius / (2 * _GROWTH)))
        shares = np.exp(-np.log(_FINE) * np.arange(fine, -1, -1) / fine)
        coarse = shares[0] / _COARSE ** np.arange(int(np.log2(_FIRST)), 0, -1)
        values = load * np.concatenate([coarse, shares])
        return values[values > now * (1 + 1e-9)]

    def _moment(self, state: State) -> Moment:
        energy = self.modulus * self.length**3
        return Moment(
            penetration=state.penetration * self.length,
            force=state.force * self.modulus * self.length**2,
            contact_radius=self.indentation.contact_radius(state) * self.length,
            work=state.work * energy,
            elastic=state.elastic * energy,
            dissipated=state.dissipated * energy,
            iterations=state.iterations,
            residual=state.residual,
            state=state,
        )
