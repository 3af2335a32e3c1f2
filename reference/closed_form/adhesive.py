"""Short-range adhesion of axisymmetric bodies: Johnson, Kendall & Roberts, Kendall, and others.

A contact of radius a is the sum of that without adhesion, d0(a) and F0(a), and a flat punch pulled
up by l(a) = sqrt(2 pi a w/E*) (Johnson 1958; Johnson, Kendall & Roberts 1971; for any body of
revolution Maugis & Barquins 1983):

    d = d0(a) - sqrt(2 pi a w/E*),   F = F0(a) - sqrt(8 pi E* w a^3).

As dF0 = 2 E* a dd0 without adhesion, the contact is lost when sqrt(a) d0'(a) has decreased to 3
sqrt(pi w/(2 E*)) under force control, and to a third of that under penetration control.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import poch

from reference.closed_form.form import Array, require_positive
from reference.closed_form.numerics import minus_arctan

__all__ = [
    "AdhesiveForm",
    "AdhesivePath",
    "cone",
    "cylinder",
    "paraboloid",
    "power_law",
    "rounded_punch",
    "sphere",
]

Law = Callable[[Array], Array]


@dataclass(frozen=True)
class AdhesivePath:
    """An adhesive contact along a path of loads; arrays of shape (k,).

    Attributes
    ----------
    contact_radius, penetration, force : ndarray
        Zero radius and force without contact; zero penetration if a prescribed tensile force has no
        equilibrium.
    largest_pull : float
        Largest tensile force along the path, also between loads; zero if there was none.
    """

    contact_radius: Array
    penetration: Array
    force: Array
    largest_pull: float


@dataclass(frozen=True)
class AdhesiveForm:
    """Equilibria of an adhesive contact with a half-space, by contact radius.

    Attributes
    ----------
    name, source : str
        The shape and the source of its solution.
    effective_modulus, work : float
        E* and the work of adhesion w.
    depth, load, rate : callable
        d0(a), F0(a) and d0'(a) of the contact without adhesion.
    smallest, largest : float
        Limits of the contact radii with increasing d0, between which equilibria exist.
    scale : float
        A length to start searches.
    """

    name: str
    source: str
    effective_modulus: float
    work: float
    depth: Law
    load: Law
    rate: Law
    smallest: float
    largest: float
    scale: float

    def penetration(self, radius: ArrayLike) -> Array:
        """Return d(a), stable under penetration control where it increases."""
        a = self._checked(radius)
        return self.depth(a) - np.sqrt(2 * np.pi * self.work / self.effective_modulus * a)

    def force(self, radius: ArrayLike) -> Array:
        """Return F(a), stable under force control where it increases."""
        a = self._checked(radius)
        return self.load(a) - np.sqrt(
            8 * np.pi * (self.effective_modulus * a) * (self.work * a * a)
        )

    def pull_off(self, control: str = "force") -> float:
        """Return the contact radius at which the contact is lost under decreasing load."""
        if control not in ("force", "penetration"):
            raise ValueError(f"control must be 'force' or 'penetration', not {control!r}")
        if self.smallest == self.largest:
            return self.largest
        level = np.sqrt(np.pi * self.work / (2 * self.effective_modulus))
        level *= 3 if control == "force" else 1
        return self._root(lambda a: float(np.sqrt(a) * self.rate(np.asarray(a))) - level)

    def snap_in(self, control: str = "penetration") -> float:
        """Return the contact radius to which the contact jumps at first touch, d = 0 or F = 0."""
        law = self.force if control == "force" else self.penetration
        if self.smallest == self.largest:
            return self.largest
        return self._root(lambda a: float(law(a)))

    def follow(self, control: str, loads: ArrayLike) -> AdhesivePath:
        """Return the contact along a path of penetrations or forces of either sign.

        Contact begins at first touch, d = 0 or F = 0, and ends when the load decreases below the
        fold of `pull_off`; in between, it is the stable equilibrium.
        """
        strongest, lost = self.pull_off("force"), self.pull_off(control)
        law = self.force if control == "force" else self.penetration
        lowest = float(law(lost))
        states: list[tuple[float, float, float]] = []
        radius, pull = 0.0, 0.0
        for load in np.asarray(loads, dtype=float):
            widest = radius
            if radius == 0 and load >= 0:
                widest = self.snap_in(control)
                pull = max(pull, -self._state(control, 0.0, widest)[2])
            radius = self._stable(law, load, lost) if widest > 0 and load >= lowest else 0.0
            if widest >= strongest > radius:
                pull = max(pull, -float(self.force(strongest)))
            states.append(self._state(control, load, radius))
            pull = max(pull, -states[-1][2])
        depth, force, radius = np.array(states).T
        return AdhesivePath(depth, force, radius, pull)

    def _stable(self, law: Law, load: float, lost: float) -> float:
        """Return the contact radius beyond a fold at which a law is the load."""
        if self.smallest == self.largest:
            return self.largest
        high = lost
        while float(law(np.asarray(high))) < load:
            high = min(2 * high, 0.5 * (high + self.largest))
        if high == lost:
            return lost
        return float(brentq(lambda a: float(law(a)) - load, lost, high, xtol=1e-300, rtol=8.9e-16))

    def _state(self, control: str, load: float, radius: float) -> tuple[float, float, float]:
        """Return a, d and F; a punch with a sharp edge can carry more than its equilibrium load."""
        if radius == 0:
            return 0.0, load if control == "penetration" else 0.0, 0.0
        if self.smallest < self.largest:
            equilibrium = float(self.force(radius)), float(self.penetration(radius))
            return (
                (radius, load, equilibrium[0])
                if control == "penetration"
                else (radius, equilibrium[1], load)
            )
        stiffness = 2 * self.effective_modulus * radius
        if control == "penetration":
            return radius, load, stiffness * load
        return radius, load / stiffness, load

    def _root(self, function: Callable[[float], float]) -> float:
        """Return the root of a function that is negative below and positive above it."""
        low = high = float(np.clip(self.scale, self.smallest, self.largest))
        while function(low) > 0 and low > self.smallest:
            low = max(low / 2, self.smallest)
        while function(high) < 0:
            # from below towards a largest radius that is excluded
            high = min(2 * high, 0.5 * (high + self.largest))
        return float(brentq(function, low, high, xtol=1e-300, rtol=8.9e-16))

    def _checked(self, radius: ArrayLike) -> Array:
        a = np.asarray(radius, dtype=float)
        if not ((a > 0) & (a <= self.largest)).all():
            raise ValueError(f"contact radius must be in (0, {self.largest}], not {radius!r}")
        return a


def paraboloid(radius: float, effective_modulus: float, work: float) -> AdhesiveForm:
    """Paraboloid of radius R: Johnson, Kendall & Roberts (Proc. R. Soc. A 324 (1971) 301).

    d0 = a^2/R, F0 = 4 E* a^3/(3 R); pull-off at -(3/2) pi w R and -(5/6) pi w R.

    Examples
    --------
    >>> ball = paraboloid(1.0, 1.0, 0.1)
    >>> round(float(ball.force(ball.pull_off()) / (math.pi * 0.1)), 12)
    -1.5
    """
    return _power("paraboloid", "Johnson, Kendall & Roberts 1971", 2.0, 0.5 / radius, locals())


def cone(slope: float, effective_modulus: float, work: float) -> AdhesiveForm:
    """Cone of slope s: d0 = (pi/2) s a, F0 = (pi/2) E* s a^2 (Maugis & Barquins 1981).

    Examples
    --------
    >>> tip = cone(0.3, 1.0, 0.01)
    >>> a = tip.pull_off()  # 18 w/(pi s^2 E*)
    >>> round(a * math.pi * 0.3**2 / (18 * 0.01), 12)
    1.0
    """
    return _power("cone", "Maugis & Barquins 1981", 1.0, slope, locals())


def power_law(
    exponent: float, coefficient: float, effective_modulus: float, work: float
) -> AdhesiveForm:
    """Power law f = c r^n, n > 1/2 (Zheng & Yu, Langmuir 23 (2007) 6075).

    d0 = kappa_n c a^n, F0 = 2 E* n/(n+1) kappa_n c a^(n+1); below n = 1/2 adhesion cannot hold the
    tip: d(a) increases from a = 0 on.
    """
    return _power("power_law", "Zheng & Yu 2007", exponent, coefficient, locals())


def _power(
    name: str, source: str, n: float, c: float, parameters: dict[str, float]
) -> AdhesiveForm:
    require_positive(name, **parameters)
    if n <= 0.5:
        raise ValueError(f"{name}: exponent must be above 1/2, not {n!r}")
    E, w = float(parameters["effective_modulus"]), float(parameters["work"])
    factor = 0.5 * math.sqrt(math.pi) * n / poch(0.5 * n, 0.5) * c
    return AdhesiveForm(
        name,
        source,
        E,
        w,
        depth=lambda a: factor * a**n,
        load=lambda a: 2 * E * n / (n + 1) * factor * a ** (n + 1),
        rate=lambda a: n * factor * a ** (n - 1),
        smallest=0.0,
        largest=math.inf,
        scale=(math.sqrt(w / E) / factor) ** (1 / (n - 0.5)),
    )


def sphere(radius: float, effective_modulus: float, work: float) -> AdhesiveForm:
    """Sphere f = R - sqrt(R^2 - r^2) (Maugis, Langmuir 11 (1995) 679).

    d0 = a artanh(a/R), F0 = E* [(R^2 + a^2) artanh(a/R) - a R].
    """
    require_positive("sphere", radius=radius, effective_modulus=effective_modulus, work=work)
    R, E = float(radius), float(effective_modulus)
    return AdhesiveForm(
        "sphere",
        "Maugis 1995",
        E,
        float(work),
        depth=lambda a: a * np.arctanh(a / R),
        load=lambda a: E * ((R * R + a * a) * np.arctanh(a / R) - a * R),
        rate=lambda a: np.arctanh(a / R) + a * R / ((R - a) * (R + a)),
        smallest=0.0,
        largest=R,
        scale=min(0.5 * R, float(np.cbrt(R * R * work / E))),
    )


def cylinder(radius: float, effective_modulus: float, work: float) -> AdhesiveForm:
    """Flat circular punch of radius b: lost as a whole at -sqrt(8 pi E* w b^3) (Kendall 1971).

    Examples
    --------
    >>> punch = cylinder(1.0, 1.0, 0.5)
    >>> round(float(punch.force(punch.pull_off())) ** 2 / math.pi, 12)
    4.0
    """
    require_positive("cylinder", radius=radius, effective_modulus=effective_modulus, work=work)
    zero = np.zeros_like
    form = float(effective_modulus), float(work), zero, zero, zero
    return AdhesiveForm("cylinder", "Kendall 1971", *form, *(float(radius),) * 3)


def rounded_punch(
    flat_radius: float, edge_radius: float, effective_modulus: float, work: float
) -> AdhesiveForm:
    """Flat to b, then f = (r - b)^2/(2 R) (Popov, Hess & Willert 2019, chapter 3).

    With t = sqrt(a^2 - b^2)/b: d0 = (a b/R) (t - arctan t),
    F0 = (E* b^3/R) [t^3/3 + (1 + t^2)(t - arctan t)], d0' = (b/R)(2 t - arctan t).
    """
    arguments = {"flat_radius": flat_radius, "edge_radius": edge_radius}
    require_positive("rounded_punch", **arguments, effective_modulus=effective_modulus, work=work)
    b, R, E = float(flat_radius), float(edge_radius), float(effective_modulus)

    def outer(a: Array) -> Array:
        return np.sqrt(np.maximum(a - b, 0.0) * (a + b)) / b

    def load(a: Array) -> Array:
        t = outer(a)
        return E * b**3 / R * (t**3 / 3 + (1 + t * t) * minus_arctan(t))

    return AdhesiveForm(
        "rounded_punch",
        "Popov, Hess & Willert 2019, chapter 3",
        E,
        float(work),
        depth=lambda a: a * b / R * minus_arctan(outer(a)),
        load=load,
        rate=lambda a: b / R * (outer(a) + minus_arctan(outer(a))),
        smallest=b,
        largest=math.inf,
        scale=b,
    )
