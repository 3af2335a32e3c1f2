"""Worn bodies in closed form: a flat punch that slides, and the end of fretting.

A place loses k p ds (Archard's law, locally).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import eigh
from scipy.special import gammaln

from reference.arrays import Array
from reference.closed_form.form import ClosedForm, keep_positive, require_positive

# Polynomials: penetration and force are known to 1e-6 or better from k E* s/b = 1e-3 on.
_MODES = 200


@dataclass(frozen=True)
class WornPunch:
    """A flat circular punch of radius b that slides on a half-space and wears by the coefficient k.

    The pressure below it decays mode by mode to the uniform one (Galin; Goryacheva 1998, ch. 7):
    with u = K p the displacement, K dp/ds + k p = dd/ds. In p = sum_n c_n P_n(2 r^2/b^2 - 1), whose
    transforms are Bessel functions, K is a table of Weber and Schafheitlin's integrals, and the
    first polynomial alone carries force.

    The uniform pressure of the end is as if the half-space were softer by 32/(3 pi^2):

    >>> punch = WornPunch(1.0, 1.0, 1.0)
    >>> depth, _, _ = punch.under_force(1.0, 50.0)
    >>> round(float(depth - 50.0 / np.pi) * 3 * np.pi**2 / 16, 7)
    1.0
    """

    radius: float
    effective_modulus: float
    coefficient: float

    def __post_init__(self) -> None:
        keep_positive("worn punch", vars(self))

    @property
    def area(self) -> float:
        """Area of the face."""
        return np.pi * self.radius**2

    @property
    def _unit(self) -> float:
        """Length per pressure of the tables."""
        return 2 * self.radius / self.effective_modulus

    def under_force(self, force: float, distance: float) -> tuple[float, float, float]:
        """Return penetration, force and volume lost.

        The penetration grows by the mean pressure's wear; the modes that carry no force decay.
        """
        mean = force / self.area
        part = np.full(_MODES - 1, mean)
        decay, _ = self._decayed(1, part, distance)
        change = _tables()[0][0, 1:] @ (decay - part) * 2 * self._unit
        worn = self.coefficient * mean * distance
        depth = force / (2 * self.effective_modulus * self.radius)
        return float(depth + change + worn), force, float(worn * self.area)

    def at_penetration(self, penetration: float, distance: float) -> tuple[float, float, float]:
        """Return penetration, force and volume lost: all modes decay."""
        mean = 2 * self.effective_modulus * self.radius * penetration / self.area
        decay, lost = self._decayed(0, np.full(_MODES, mean), distance)
        return penetration, float(decay[0] * self.area), float(lost[0] * self.area)

    def _decayed(self, first: int, start: Array, distance: float) -> tuple[Array, Array]:
        """Return coefficients of the pressure after a distance, and of the depth lost."""
        values, vectors = _modes(first)
        rates = self.coefficient * distance / (self._unit * values)
        amplitude = vectors.T @ (_tables()[1][first:] * start)
        decay = vectors @ (amplitude * np.exp(-rates))
        lost = vectors @ (amplitude * -np.expm1(-rates) * values) * self._unit
        return decay, lost


@lru_cache(maxsize=1)
def _tables() -> tuple[Array, Array]:
    """Return <P_m, K P_n> and <P_m, P_m>, in units of b, E*/2 and the mean pressure.

    <f, g> is the integral of f g r dr, and int_0^1 P_n(2 r^2 - 1) J_0(q r) r dr =
    (-1)^n J_(2n+1)(q)/q.
    """
    n = np.arange(_MODES)
    both, apart = n[:, None] + n, n[:, None] - n
    gammas = np.exp(gammaln(both + 0.5) - gammaln(both + 2.5))
    return gammas / (np.pi * (1 - 4 * apart**2)), 1 / (2 * (2 * n + 1))


@lru_cache(maxsize=2)
def _modes(first: int) -> tuple[Array, Array]:
    """Return the modes of K from a polynomial on: K v = value M v, v M v = 1."""
    compliance, weights = _tables()
    values, vectors = eigh(compliance[first:, first:], np.diag(weights[first:]))
    return values, vectors


class FrettingLimit:
    """The state in which small oscillations at constant penetration leave a round body.

    They wear it outside its stick circle until no pressure is left there: its line is then g(x) for
    x < c and d beyond (Popov 2014), whatever k is.

    The unworn `form` is pressed by the penetration d; `lag` is G* U/(mu E*) < d, U the amplitude,
    else all of the contact slips. The circle of the `stick_radius` c stays unworn.

    A parabola g = x^2 pressed by 1 that sticks up to c = 1/2:

    >>> from reference.closed_form import paraboloid
    >>> limit = FrettingLimit(paraboloid(1.0, 1.0), 1.0, 0.75)
    >>> round(limit.stick_radius, 12), round(limit.force, 12)  # 2 (c - c^3/3)
    (0.5, 0.916666666667)
    """

    def __init__(self, form: ClosedForm, penetration: float, lag: float) -> None:
        require_positive("fretting limit", penetration=penetration, lag=lag)
        if form.contact_radius is None:
            raise ValueError(f"{form.name}: the stick area is no circle")
        if lag >= penetration:
            raise ValueError("all of the contact slips: nothing of it is left in the end")
        stuck = penetration - lag
        self.stick_radius = float(form.semi_axes(stuck)[0])
        # F = 2 E* int_0^c (d - g) dx: the stick circle's own, and a flat punch on top of it
        self.force = float(form.force(stuck) + form.stiffness(stuck) * lag)
