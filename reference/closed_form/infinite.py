"""Closed forms for the point force and the wavy half-plane."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from reference.arguments import poisson_faults, refuse
from reference.closed_form.form import checked_load, require_positive


def boussinesq(force: float, distance: ArrayLike, effective_modulus: float) -> Any:
    """Return the normal displacement u = F/(pi E* r) of a point force.

    (Boussinesq 1885; Johnson 1985, section 3.2.) The far field of every contact on a half-space.

    Parameters
    ----------
    force, effective_modulus : float
        F and E*, positive, in consistent units.
    distance : array_like
        r, positive.

    Raises
    ------
    ValueError
        For values that are not finite and positive; r = 0 is the point of the force.

    Examples
    --------
    >>> round(float(boussinesq(force=1.0, distance=2.0, effective_modulus=1.0)), 12)
    0.159154943092
    """
    require_positive("boussinesq", force=force, effective_modulus=effective_modulus)
    r = checked_load("distance", distance)
    if (r == 0).any():
        raise ValueError("boussinesq: distance must be positive, not 0")
    return force / (math.pi * effective_modulus) / r


def boussinesq_energy(
    force: float, distance: ArrayLike, effective_modulus: float, poisson_ratio: float
) -> Any:
    """Return the elastic energy of a point force farther than r from it.

    U = s F^2/(2 E* r) with s = (2/3 + 5 nu/3 - 2 nu^2 + (1 - 2 nu)^2 ln 2)/(pi (1 - nu)): the
    energy density of Boussinesq's field (Johnson 1985, (3.18) and (3.19)) integrated over the
    half-space outside a hemisphere. For r >> D, a flat punch of diameter D therefore has the
    fraction s D/r of its energy E* D d^2/2 farther than r.

    Parameters
    ----------
    force, effective_modulus : float
        F and E*, positive, in consistent units.
    distance : array_like
        r, positive.
    poisson_ratio : float
        ``-1 < nu <= 0.5``.

    Raises
    ------
    ValueError
        For values out of range.

    Examples
    --------
    >>> round(float(boussinesq_energy(1.0, 1.0, 1.0, 0.5)), 12) == round(1 / math.pi, 12)
    True
    """
    require_positive("boussinesq_energy", force=force, effective_modulus=effective_modulus)
    refuse([f"boussinesq_energy: {fault}" for fault in poisson_faults(poisson_ratio)])
    r = checked_load("distance", distance)
    if (r == 0).any():
        raise ValueError("boussinesq_energy: distance must be positive, not 0")
    nu = poisson_ratio
    share = (2 / 3 + 5 / 3 * nu - 2 * nu**2 + (1 - 2 * nu) ** 2 * math.log(2)) / math.pi / (1 - nu)
    return share * force**2 / (2 * effective_modulus) / r


@dataclass(frozen=True)
class WavyForm:
    """The exact solution of a periodic line contact, as functions of the mean pressure.

    Attributes
    ----------
    source : str
        The primary source.
    full_contact_pressure : float
        Mean pressure of full contact.
    contact_fraction : callable
        A/A0 as a function of the mean pressure.
    penetration : callable
        Approach after first touch with the mean surface displacement zero.
    mean_gap : callable
        Mean gap of the surfaces: amplitude - penetration.
    pressure : callable
        ``pressure(x, mean_pressure)``, x from a crest.
    """

    source: str
    full_contact_pressure: float
    contact_fraction: Callable[[ArrayLike], Any]
    penetration: Callable[[ArrayLike], Any]
    mean_gap: Callable[[ArrayLike], Any]
    pressure: Callable[[ArrayLike, ArrayLike], Any]


def westergaard(amplitude: float, wavelength: float, effective_modulus: float) -> WavyForm:
    """Contact of the wavy surface h = D cos(2 pi x/l) with a half-space, in plane strain.

    p* = pi E* D/l,  A/A0 = (2/pi) arcsin sqrt(s),  s = p/p* <= 1,
    p(x) = (2 p cos(psi)/sin(psi_a)^2) sqrt(sin(psi_a)^2 - sin(psi)^2),  psi = pi x/l,
    penetration = D s (1 - ln s)

    (Westergaard 1939; Johnson 1985, section 13.2). The penetration follows from integration of the
    stiffness of the row of flat strips, dp/d(penetration) = -pi E*/(2 l ln sin(psi_a)). In full
    contact the pressure is p + p* cos(2 psi).

    Parameters
    ----------
    amplitude, wavelength, effective_modulus : float
        D, l and E*, positive, in consistent units.

    Examples
    --------
    >>> wave = westergaard(amplitude=0.01, wavelength=1.0, effective_modulus=1.0)
    >>> round(float(wave.contact_fraction(0.5 * wave.full_contact_pressure)), 12)
    0.5
    """
    require_positive(
        "westergaard",
        amplitude=amplitude,
        wavelength=wavelength,
        effective_modulus=effective_modulus,
    )
    full = math.pi * effective_modulus * (amplitude / wavelength)

    def share(mean_pressure: ArrayLike) -> Any:
        return np.minimum(checked_load("mean_pressure", mean_pressure) / full, 1.0)

    def penetration(mean_pressure: ArrayLike) -> Any:
        s = share(mean_pressure)
        return amplitude * s * (1 - np.log(np.where(s > 0, s, 1.0)))

    def pressure(x: ArrayLike, mean_pressure: ArrayLike) -> Any:
        s = share(mean_pressure)
        excess = np.asarray(mean_pressure) - full * s
        psi = np.pi * np.asarray(x, float) / wavelength
        # 2 p/sin(psi_a)^2 is 2 p*, as sin(psi_a)^2 = p/p*; cos is even about every crest.
        root = np.sqrt(np.maximum(s - np.sin(psi) ** 2, 0.0))
        return 2 * full * np.abs(np.cos(psi)) * root + excess

    return WavyForm(
        source="Westergaard 1939; Johnson 1985, section 13.2",
        full_contact_pressure=full,
        contact_fraction=lambda p: 2 / np.pi * np.arcsin(np.sqrt(share(p))),
        penetration=penetration,
        mean_gap=lambda p: amplitude - penetration(p),
        pressure=pressure,
    )
