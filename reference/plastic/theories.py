"""Closed forms of a ball that dents a half-space: a cavity's pressure, and rebounds.

- Johnson (1985, 6.3): the core below the contact presses like a fluid into a spherical cavity, p_m
  its pressure and (2/3) Y; between first and full yield.
- Thornton (1997): Hertz's pressure cut off at that of first yield, unloading along Hertz's law of
  the flattened ball.
- Johnson (1985, 11.4): full yield at a constant pressure from the first touch, Hertz on unloading.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import refuse

Array = NDArray[np.float64]


def cavity_pressure(strain: ArrayLike, poisson_ratio: float) -> Array:
    """Return p_m/Y of the contact by the expanding cavity.

    p_m/Y = (2/3) (2 + ln((E a/(Y R) + 4 (1 - 2 nu))/(6 (1 - nu)))).

    Parameters
    ----------
    strain : array_like
        E a/(Y R) of a rigid ball.
    poisson_ratio : float

    Examples
    --------
    >>> round(float(cavity_pressure(40.0, 0.5)), 2)
    3.06
    """
    core = (np.asarray(strain, dtype=float) + 4 * (1 - 2 * poisson_ratio)) / (
        6 * (1 - poisson_ratio)
    )
    return np.asarray(2 / 3 * (2 + np.log(core)))


def thornton_restitution(speed: ArrayLike) -> Array:
    """Return the coefficient of restitution at a speed over that of first yield.

    With w = d/d_y the largest force is f = 1 + (3/2)(w - 1) and the work on loading
    l = 2/5 + (w - 1) + (3/4)(w - 1)^2, in units of first yield; (v/v_y)^2 = (5/2) l, and of it
    e^2 = (2/5) f^2/(sqrt(w) l) is given back: 1.18 (v_y/v)^(1/4) at last.

    Raises
    ------
    ValueError
        If a speed is not positive.

    Examples
    --------
    >>> thornton_restitution([0.5, 1.0, 1e4]).round(4).tolist()
    [1.0, 1.0, 0.1185]
    """
    speeds = np.asarray(speed, dtype=float)
    refuse([] if (speeds > 0).all() else [f"speed must be positive, got {speed!r}"])
    work = 0.4 * np.maximum(speeds, 1.0) ** 2
    # (3/4) x^2 + x = l - 2/5
    beyond = (np.sqrt(1 + 3 * (work - 0.4)) - 1) * 2 / 3
    force = 1 + 1.5 * beyond
    return np.asarray(np.sqrt(0.4 * force**2 / (np.sqrt(1 + beyond) * work)))


def johnson_restitution(energy: ArrayLike, softness: float, hardness: float = 3.0) -> Array:
    """Return the coefficient of restitution of a ball in full yield from the first touch.

    F = pi a^2 p with a^2 = 2 R d takes the energy W = pi a^4 p/(4 R), and 3 F^2/(10 E* a) of it is
    given back: e^2 = (6 pi/5) (p/E*) (R/a), 3.7 (Y/E*)^(1/2) (W/(Y R^3))^(-1/8) at p = 3 Y.

    Parameters
    ----------
    energy : array_like
        W/(Y R^3).
    softness : float
        Y/E*.
    hardness : float
        p/Y.

    Examples
    --------
    >>> round(float(johnson_restitution(1.0, 1e-4)), 4)
    0.0374
    """
    radius = (4 * np.asarray(energy, dtype=float) / (np.pi * hardness)) ** 0.25
    return np.asarray(np.sqrt(1.2 * np.pi * hardness * softness / radius))
