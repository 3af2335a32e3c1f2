"""Paths of loads on an elastic-plastic half-space, in the units of the caller."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arguments import count_faults, positive_faults, refuse
from reference.loads import LoadPath
from reference.plastic.elements import Elements
from reference.plastic.indentation import Indentation, PlasticState, elastic_work
from reference.plastic.j2 import PlasticMaterial

Array = NDArray[np.float64]

# A rising load goes in steps whose logarithms are so many elements over a radius at its end, and
# the longer the further from it (by this power: what lies before is soon forgotten) from a share of
# the load on. Round contacts: as fine as their energies need to balance to 1e-4 on nine elements.
_STEP, _BLOCK_STEP = 0.1, 0.5
_POWER, _FIRST = 0.75, 1 / 32
# Steps of a stretch that falls.
_FALLING = 3


@dataclass(frozen=True)
class DentMoment:
    """A contact at one load of a path.

    `counted_area` of contact lies between the points that touch: to a part of an element. `work` of
    the force and plastic dissipation are those so far, `iterations` Newton's steps so far,
    `residual` the unbalanced forces over the largest force.
    """

    penetration: float
    force: float
    counted_area: float
    work: float
    elastic: float
    dissipated: float
    iterations: int
    residual: float
    state: PlasticState


class Walk:
    """An indentation that is led along a path.

    Parameters
    ----------
    shape : callable
        The gap at first touch, f(r) or f(x, y).
    radius : float or (float, float)
        Contact radius at the largest load, roughly: contacts of up to 1.25 times that fit. Two
        half-widths, in x and y: elements in three dimensions below f(x, y).
    smallest : float
        Radius at the smallest load that shall be resolved, of round contacts.
    per_radius : int
        Elements per contact radius, or half-width.
    even : (bool, bool)
        Whether x = 0, and y = 0, is a plane of symmetry of f(x, y).

    Attributes
    ----------
    step : float
        Of the logarithm of a rising load, at its end.

    Examples
    --------
    Elastic, it is Hertz's contact:

    >>> from reference.elasticity import Material
    >>> steel = PlasticMaterial(Material(0.91, 0.3), np.inf)
    >>> ball = Walk(steel, lambda r: r**2 / 2, 0.1, per_radius=4)
    >>> (moment,) = ball.along(LoadPath("penetration", 0.01))
    >>> abs(moment.force / (4 / 3 * 0.01**1.5) - 1) < 1e-3
    True
    """

    def __init__(
        self,
        material: PlasticMaterial,
        shape: Callable[..., Array],
        radius: float | tuple[float, float],
        *,
        smallest: float | None = None,
        per_radius: int = 8,
        even: tuple[bool, bool] = (True, True),
    ) -> None:
        faults = count_faults(2, per_radius=per_radius)
        sides = np.broadcast_to(np.asarray(radius, dtype=float), 2)
        faults += positive_faults(radius=min(sides))
        length = float(np.sqrt(sides[0] * sides[1])) if min(sides) > 0 else 1.0
        least = 1.0 if smallest is None else smallest / length
        if not 0 < least <= 1 + 1e-12:
            faults.append(f"smallest must lie in (0, radius], not {smallest!r}")
        refuse(faults)
        nu = material.elastic.poisson_ratio
        if np.ndim(radius) == 0:
            mesh = Elements.section(least, 1.0, per_radius, nu)
        else:
            mesh = Elements.block((sides[0] / length, sides[1] / length), per_radius, nu, even)
        self.length, self.modulus = length, material.elastic.youngs_modulus
        self.indentation = Indentation(
            material.scaled(self.modulus),
            lambda *at: np.asarray(shape(*(x * length for x in at))) / length,
            mesh,
        )
        self.step = (_STEP if mesh.hoop else _BLOCK_STEP) / per_radius

    def along(self, path: LoadPath) -> Iterator[DentMoment]:
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
        state, energy = self.indentation.virgin, self.modulus * self.length**3
        unit = self.length if control == "penetration" else self.modulus * self.length**2
        for load in (path.values / unit).tolist():
            now = state.penetration if control == "penetration" else state.force
            if load <= max(now, 0.0):
                count = _FALLING if 0 <= load < now else 1
                values = np.linspace(now, load, count + 1)[1:]
            else:
                shares = [1.0]
                while shares[-1] > _FIRST:
                    shares.append(shares[-1] * np.exp(-self.step / shares[-1] ** _POWER))
                values = load * np.array(shares[::-1])
                values = values[values > now * (1 + 1e-9)]
            for value in values:
                if control == "penetration":
                    state = self.indentation.press(state, value)
                else:
                    state = self.indentation.push(state, value)
            yield DentMoment(
                penetration=state.penetration * self.length,
                force=state.force * self.modulus * self.length**2,
                counted_area=self.indentation.counted_area(state) * self.length**2,
                work=state.work * energy,
                elastic=state.elastic * energy,
                dissipated=state.dissipated * energy,
                iterations=state.iterations,
                residual=state.residual,
                state=state,
            )

    def contact_area(self, moment: DentMoment) -> float:
        """Return the area of contact: of round ones from the stiffness of unloading."""
        return self.indentation.contact_area(moment.state) * self.length**2

    def residual_depth(self, moment: DentMoment) -> float:
        """Return the depth that remains if the indenter is lifted off from here."""
        if not moment.state.points.amount.any():
            return 0.0
        state = moment.state
        left = self.indentation.push(state, 0.0) if state.force > 0 else state
        return self.length * self.indentation.residual_depth(left.unknowns)

    def given_back(self, moment: DentMoment, steps: int = 6) -> float:
        """Return the work that the body gives back if the indenter is lifted off from here."""
        state, work = moment.state, 0.0
        for share in 1 - np.arange(1, steps + 1) / steps:
            lifted = self.indentation.push(state, moment.state.force * share**1.5)
            risen = state.penetration - lifted.penetration
            work += elastic_work(risen, (state.force, lifted.force))
            state = lifted
        return float(work * self.modulus * self.length**3)

    def surface(self, moment: DentMoment) -> tuple[Array, Array]:
        """Return places on the surface (1 or 2, n), and how far it has gone into the body there."""
        surface = self.indentation.mesh.surface
        place, sunk = surface.place, surface.sunk(moment.state.unknowns)
        return place.reshape(len(place), -1) * self.length, sunk.ravel() * self.length
