"""The half-space under a point force, and under a wavy surface."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array
from reference.closed_form.form import checked_load, keep_positive, require_positive
from reference.errors import poisson_faults, refuse


def boussinesq(force: float, distance: ArrayLike, effective_modulus: float) -> Any:
    """Return the normal displacement u = F/(pi E* r) of a point force, for distances r > 0.

    (Boussinesq 1885; Johnson 1985, section 3.2.) The far field of every contact on a half-space.

    >>> round(float(boussinesq(force=1.0, distance=2.0, effective_modulus=1.0)), 12)
    0.159154943092
    """
    require_positive("boussinesq", force=force, effective_modulus=effective_modulus)
    return force / (math.pi * effective_modulus) / _away("boussinesq", distance)


def boussinesq_energy(
    force: float, distance: ArrayLike, effective_modulus: float, poisson_ratio: float
) -> Any:
    """Return the elastic energy of a point force farther than r from it.

    U = s F^2/(2 E* r) with s = (2/3 + 5 nu/3 - 2 nu^2 + (1 - 2 nu)^2 ln 2)/(pi (1 - nu)): the
    energy density of Boussinesq's field (Johnson 1985, (3.18) and (3.19)) integrated over the
    half-space outside a hemisphere. For r >> D, a flat punch of diameter D therefore has the
    fraction s D/r of its energy E* D d^2/2 farther than r.
    """
    require_positive("boussinesq_energy", force=force, effective_modulus=effective_modulus)
    refuse([f"boussinesq_energy: {fault}" for fault in poisson_faults(poisson_ratio)])
    nu = poisson_ratio
    share = (2 / 3 + 5 / 3 * nu - 2 * nu**2 + (1 - 2 * nu) ** 2 * math.log(2)) / math.pi / (1 - nu)
    return share * force**2 / (2 * effective_modulus) / _away("boussinesq_energy", distance)


def _away(name: str, distance: ArrayLike) -> Array:
    """Return distances, none of which is that of the force itself."""
    r = checked_load("distance", distance)
    if (r == 0).any():
        raise ValueError(f"{name}: distance must be positive, not 0")
    return r


@dataclass(frozen=True)
class Westergaard:
    """Contact of the wavy surface h = D cos(2 pi x/l) with a half-space, in plane strain.

    p* = pi E* D/l,  A/A0 = (2/pi) arcsin sqrt(s),  s = p/p* <= 1,
    p(x) = (2 p cos(psi)/sin(psi_a)^2) sqrt(sin(psi_a)^2 - sin(psi)^2),  psi = pi x/l,
    penetration = D s (1 - ln s)

    (Westergaard 1939; Johnson 1985, section 13.2). The penetration follows from integration of the
    stiffness of the row of flat strips, dp/d(penetration) = -pi E*/(2 l ln sin(psi_a)). In full
    contact the pressure is p + p* cos(2 psi).

    >>> wave = Westergaard(amplitude=0.01, wavelength=1.0, effective_modulus=1.0)
    >>> round(float(wave.contact_fraction(0.5 * wave.full_contact_pressure)), 12)
    0.5
    """

    # D, l and E*
    amplitude: float
    wavelength: float
    effective_modulus: float

    source = "Westergaard 1939; Johnson 1985, section 13.2"

    def __post_init__(self) -> None:
        keep_positive("westergaard", vars(self))

    @property
    def full_contact_pressure(self) -> float:
        """Mean pressure p* of full contact."""
        return math.pi * self.effective_modulus * (self.amplitude / self.wavelength)

    def contact_fraction(self, mean_pressure: ArrayLike) -> Any:
        """A/A0 at a mean pressure."""
        return 2 / np.pi * np.arcsin(np.sqrt(self._share(mean_pressure)))

    def penetration(self, mean_pressure: ArrayLike) -> Any:
        """Approach after first touch with the mean surface displacement zero."""
        s = self._share(mean_pressure)
        return self.amplitude * s * (1 - np.log(np.where(s > 0, s, 1.0)))

    def mean_gap(self, mean_pressure: ArrayLike) -> Any:
        """Mean gap of the surfaces: amplitude less penetration."""
        return self.amplitude - self.penetration(mean_pressure)

    def pressure(self, x: ArrayLike, mean_pressure: ArrayLike) -> Any:
        """Pressure at places x from a crest."""
        s, full = self._share(mean_pressure), self.full_contact_pressure
        excess = np.asarray(mean_pressure) - full * s
        psi = np.pi * np.asarray(x, float) / self.wavelength
        # 2 p/sin(psi_a)^2 is 2 p*, as sin(psi_a)^2 = p/p*; cos is even about every crest.
        root = np.sqrt(np.maximum(s - np.sin(psi) ** 2, 0.0))
        return 2 * full * np.abs(np.cos(psi)) * root + excess

    def _share(self, mean_pressure: ArrayLike) -> Any:
        pressure = checked_load("mean_pressure", mean_pressure)
        return np.minimum(pressure / self.full_contact_pressure, 1.0)
