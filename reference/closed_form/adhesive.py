"""Adhesion of axisymmetric bodies: short range (Johnson, Kendall & Roberts), and any (Maugis).

At short range a contact of radius a is the sum of that without adhesion, d0(a) and F0(a), and a
flat punch pulled up by l(a) = sqrt(2 pi a w/E*) (Johnson 1958; Johnson, Kendall & Roberts 1971; for
any body of revolution Maugis & Barquins 1983):

    d = d0(a) - sqrt(2 pi a w/E*),   F = F0(a) - sqrt(8 pi E* w a^3).

As dF0 = 2 E* a dd0 without adhesion, the contact is lost when sqrt(a) d0'(a) has decreased to 3
sqrt(pi w/(2 E*)) under force control, and to a third of that under penetration control.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from reference.arrays import Array
from reference.closed_form.form import ByRadius, ClosedForm, require_positive
from reference.errors import choice_faults, refuse


@dataclass(frozen=True)
class AdhesivePath:
    """An adhesive contact along a path of loads; arrays of shape (k,)."""

    # zero radius and force without contact; penetration and force are NaN if a prescribed pull has
    # no equilibrium
    contact_radius: Array
    penetration: Array
    force: Array
    # largest tensile force along the path, also between loads; zero if there was none
    largest_pull: float
    pull_off: float  # the force at which it lets go under a falling one


_TO_ROUNDING = {"xtol": 1e-300, "rtol": 8.9e-16}


class AdhesiveEquilibria(ABC):
    """Equilibria of an adhesive contact along their path, by contact radius where it touches.

    They are stable under penetration or force control where that load increases with the place.
    """

    effective_modulus: float
    source: str
    # a punch with a sharp edge has one radius, and carries more than its equilibrium load
    _fixed = False
    _touch = 0.0  # penetration at which attraction begins
    _close = 1e-300  # error of a place, beside rounding

    @abstractmethod
    def penetration(self, place: ArrayLike) -> Array:
        """Return d."""

    @abstractmethod
    def force(self, place: ArrayLike) -> Array:
        """Return F."""

    @abstractmethod
    def pull_off(self, control: str = "force") -> float:
        """Return the place at which the contact is lost under decreasing load."""

    @abstractmethod
    def _further(self, place: float) -> float:
        """Return a place in more compression."""

    def follow(self, control: str, loads: ArrayLike) -> AdhesivePath:
        """Return the contact along a path of penetrations or forces of either sign.

        Contact begins at first touch, or F = 0, and ends when the load decreases below the fold of
        `pull_off`; in between, it is the stable equilibrium.
        """
        strongest, lost = self.pull_off("force"), self.pull_off(control)
        depth_given = control == "penetration"
        law, touch = (self.penetration, self._touch) if depth_given else (self.force, 0.0)
        lowest, weakest = float(law(lost)), float(self.force(strongest))

        def stable(load: float) -> float:
            # the place beyond the fold at which the law is the load
            high = lost
            while not self._fixed and float(law(high)) < load:
                high = self._further(high)
            if high == lost:
                return lost
            close = _TO_ROUNDING | {"xtol": self._close}
            return float(brentq(lambda place: float(law(place)) - load, lost, high, **close))

        def state(load: float, place: float) -> tuple[float, float, float]:
            # a, d and F
            if place == -np.inf:
                return (0.0, load, 0.0) if depth_given else (0.0, np.nan, np.nan)
            radius = max(place, 0.0)
            stiffness = 2 * self.effective_modulus * radius
            if depth_given:
                force = stiffness * load if self._fixed else float(self.force(place))
                return radius, load, force
            depth = load / stiffness if self._fixed else float(self.penetration(place))
            return radius, depth, load

        states: list[tuple[float, float, float]] = []
        place, pull = -np.inf, 0.0
        for load in np.asarray(loads, dtype=float):
            widest = place
            if place == -np.inf and load >= touch:
                widest = stable(touch)
                pull = max(pull, -state(touch, widest)[2])
            place = stable(load) if widest > -np.inf and load >= lowest else -np.inf
            if widest >= strongest > place:
                pull = max(pull, -weakest)
            states.append(state(load, place))
            pull = max(pull, -states[-1][2])
        radii, depths, forces = np.array(states).T
        return AdhesivePath(radii, depths, forces, pull, weakest)


class AdhesiveForm(AdhesiveEquilibria):
    """Equilibria of an adhesive contact with a half-space, by contact radius.

    `form` is the contact without adhesion, round; `source` that of the adhesive solution.

    Pull-off at -(3/2) pi w R of a ball, at -sqrt(8 pi E* w b^3) of a flat punch:

    >>> from reference.closed_form import cylinder, paraboloid
    >>> ball, punch = AdhesiveForm(paraboloid(1.0, 1.0), 0.1), AdhesiveForm(cylinder(1.0, 1.0), 0.5)
    >>> round(float(ball.force(ball.pull_off()) / (math.pi * 0.1)), 12)
    -1.5
    >>> round(float(punch.force(punch.pull_off())) ** 2 / math.pi, 12)
    4.0
    """

    def __init__(self, form: ClosedForm, work: float) -> None:
        if form.by_radius is None:
            raise ValueError(f"{form.name}: adhesion is known of round contacts only")
        require_positive(form.name, work=work)
        if form.by_radius.refused:
            raise ValueError(f"{form.name}: {form.by_radius.refused}")
        self.name, self.source = form.name, form.by_radius.source
        self.effective_modulus, self.work = form.effective_modulus, float(work)
        self._laws: ByRadius = form.by_radius
        self._fixed = self._laws.smallest == self._laws.largest

    def penetration(self, radius: ArrayLike) -> Array:
        """Return d(a), stable under penetration control where it increases."""
        a = self._checked(radius)
        return self._laws.depth(a) - np.sqrt(2 * np.pi * self.work / self.effective_modulus * a)

    def force(self, radius: ArrayLike) -> Array:
        """Return F(a), stable under force control where it increases."""
        a = self._checked(radius)
        pull = np.sqrt(8 * np.pi * (self.effective_modulus * a) * (self.work * a * a))
        return self._laws.load(a) - pull

    def pull_off(self, control: str = "force") -> float:
        """Return the contact radius at which the contact is lost under decreasing load."""
        refuse(choice_faults("control", control, ("force", "penetration")))
        smallest, largest = self._laws.smallest, self._laws.largest
        if self._fixed:
            return largest
        level = np.sqrt(np.pi * self.work / (2 * self.effective_modulus))
        level *= 3 if control == "force" else 1

        def excess(a: float) -> float:
            return float(np.sqrt(a) * self._laws.rate(np.asarray(a))) - level

        scale = self._laws.scale(self.work / self.effective_modulus)
        low = high = float(np.clip(scale, smallest, largest))
        while excess(low) > 0 and low > smallest:
            low = max(low / 2, smallest)
        while excess(high) < 0:
            high = self._further(high)
        return float(brentq(excess, low, high, **_TO_ROUNDING))

    def _further(self, place: float) -> float:
        # from below towards a largest radius that is excluded
        return min(2 * place, 0.5 * (place + self._laws.largest))

    def _checked(self, radius: ArrayLike) -> Array:
        a, largest = np.asarray(radius, dtype=float), self._laws.largest
        if not ((a > 0) & (a <= largest)).all():
            raise ValueError(f"contact radius must be in (0, {largest}], not {radius!r}")
        return a


def maugis_parameter(
    radius: float, effective_modulus: float, work: float, strength: float
) -> float:
    """Return lambda = 2 sigma0 (R/(pi w K^2))^(1/3), K = 4 E*/3.

    >>> round(maugis_parameter(1.0, 0.75, 1 / math.pi, 0.5), 12)
    1.0
    """
    stiffness = 4 / 3 * effective_modulus
    return 2 * strength * float(np.cbrt(radius / (math.pi * work * stiffness**2)))


def strength_of(radius: float, effective_modulus: float, work: float, parameter: float) -> float:
    """Return the tension sigma0 for a Maugis parameter."""
    return parameter / maugis_parameter(radius, effective_modulus, work, 1.0)


class MaugisForm(AdhesiveEquilibria):
    """Equilibria of a paraboloid by contact radius a, with a constant tension.

    D. Maugis, J. Colloid Interface Sci. 150 (1992) 243: the constant tension sigma0 (`strength`)
    acts where the gap is below w/sigma0, w the `work` of adhesion; K = 4 E*/3. The only parameter
    is lambda (`maugis_parameter`): where it is large, the contact is that of Johnson, Kendall &
    Roberts, where it is small that of Derjaguin, Muller & Toporov (pull-off at -2 pi w R). In
    Maugis' `units`, a in (pi w R^2/K)^(1/3), F in pi w R, d in (pi^2 w^2 R/K^2)^(1/3), with m = c/a
    for the edge of the tension, s = sqrt(m^2 - 1), q = arctan s:

        (lambda a^2/2) [s + (m^2 - 2) q] + (4 lambda^2 a/3) [s q - m + 1] = 1,
        F = a^3 - lambda a^2 [s + m^2 q],   d = a^2 - (4/3) lambda a s.

    A place c - c0 below zero is attraction across the gap, with c0 the edge at a = 0: a uniform
    tension on a disc of radius c, whose edge it draws up by (8/(3 pi)) lambda c, so that

        F = -(pi/2) lambda c^2,   d = c^2/2 - (8/(3 pi)) lambda c - 2/(pi lambda).
    """

    source = "Maugis 1992"

    def __init__(
        self, radius: float, effective_modulus: float, work: float, strength: float
    ) -> None:
        R, E, w, sigma = require_positive(
            "maugis",
            radius=radius,
            effective_modulus=effective_modulus,
            work=work,
            strength=strength,
        )
        self.effective_modulus, self.parameter = E, maugis_parameter(R, E, w, sigma)
        length = float(np.cbrt(math.pi * w / (4 / 3 * E) * R * R))
        # of contact radius, force and penetration
        self.units = length, math.pi * w * R, length / R * length
        self._touch, self._close = -w / sigma, 1e-15 * length
        self._bridge = self._edge(0.0)

    def force(self, place: ArrayLike) -> Array:
        """Return F(a)."""
        a, c, s = self._scaled(place)
        return self.units[1] * (a**3 - self.parameter * (a * s + c * c * np.arctan2(s, a)))

    def penetration(self, place: ArrayLike) -> Array:
        """Return d(a)."""
        a, c, s = self._scaled(place)
        across = c * c / 2 - 8 / (3 * np.pi) * self.parameter * c - 2 / (np.pi * self.parameter)
        held = a**2 - 4 / 3 * self.parameter * s
        return self.units[2] * np.where(np.asarray(place) < 0, across, held)

    def pull_off(self, control: str = "force") -> float:
        """Return the place at minimum force or penetration, below zero without contact."""
        law, length = {"force": self.force, "penetration": self.penetration}[control], self.units[0]
        across = 8 / (3 * math.pi) * self.parameter - self._bridge
        if control == "penetration" and across < 0:
            return across * length
        radii = length * np.linspace(0.0, 2.5, 251)
        lowest = int(np.argmin(law(radii)))
        around = radii[max(lowest - 1, 0)], radii[lowest + 1]
        options = {"xatol": 1e-9 * length}
        return float(minimize_scalar(law, bounds=around, method="bounded", options=options).x)

    def _further(self, place: float) -> float:
        return 2 * max(place, 0.0) + self.units[0]

    def _edge(self, a: float) -> float:
        """Return c, in Maugis' units, whose condition increases with c from -1 at c = a."""
        strength = self.parameter

        def excess(c: float) -> float:
            s = math.sqrt((c - a) * (c + a))
            q = math.atan2(s, a)
            near = 0.5 * strength * (a * s + (c * c - 2 * a * a) * q)
            return near + 4 / 3 * strength**2 * (s * q - c + a) - 1

        high = max(2 * a, 1.0)
        while excess(high) < 0:
            high *= 2
        return float(brentq(excess, a, high, **_TO_ROUNDING))

    def _scaled(self, place: ArrayLike) -> tuple[Array, Array, Array]:
        """Return a, c and sqrt(c^2 - a^2) in Maugis' units."""
        scaled = np.asarray(place, dtype=float) / self.units[0]
        if not (scaled >= -self._bridge).all():
            raise ValueError(f"no equilibrium of the contact has the place {place!r}")
        a = np.maximum(scaled, 0.0)
        edges = np.vectorize(self._edge, otypes=[float])(a)
        c = np.where(scaled < 0, self._bridge + scaled, edges)
        return a, c, np.sqrt(np.maximum(c - a, 0.0) * (c + a))
