"""Coulomb's law as a function of velocity (19.1), and its direct consequences.

(19.1) takes F_R = (2/pi) mu F_N arctan(v/v0) for the friction of a contact sliding at v, with a
characteristic speed v0 that "must be chosen so that it is significantly smaller than the
characteristic sliding velocity of the system". Under any load below mu F_N the contact creeps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from reduced.arguments import positive_faults, refuse

# Real stability limits: the largest h |lambda| on v' = -|lambda| v.
STABILITY_LIMITS = {
    "explicit_euler": 2.0,
    "semi_implicit_euler": 2.0,
    "runge_kutta_4": 2.785293563405282,  # 24 - 12 z + 4 z^2 - z^3 = 0
}


def friction(
    velocity: ArrayLike, limit: float | np.ndarray, characteristic_speed: float
) -> np.ndarray:
    """Return the friction force (2/pi) mu F_N arctan(v/v0) (19.1), of the sign of v.

    `limit` is mu F_N, below which it stays by (2/pi) v0/v of it where v >> v0.

    >>> float(friction(1.0, 2.0, 1.0))
    1.0
    """
    refuse(positive_faults(characteristic_speed=characteristic_speed) + _limit_faults(limit))
    return 2 / np.pi * limit * np.arctan(np.asarray(velocity) / characteristic_speed)


def creep_speed(load: ArrayLike, limit: float | np.ndarray, characteristic_speed: float):
    """Return the steady speed v0 tan(pi F/(2 mu F_N)) under a load below the limit.

    The inverse of (19.1): Coulomb's law predicts rest.

    >>> round(float(creep_speed(0.5, 1.0, 1e-3)), 12)
    0.001
    """
    wrong = positive_faults(characteristic_speed=characteristic_speed) + _limit_faults(limit)
    refuse(wrong or _load_faults(load, limit))
    return characteristic_speed * np.tan(np.pi / 2 * (np.asarray(load) / limit))


def missing_friction(speed: ArrayLike, characteristic_speed: float) -> np.ndarray:
    """Return the fraction of mu F_N missing in (19.1) at a sliding speed: (2/pi) arctan(v0/v).

    It decreases only as v0/v: 1 % needs v > 64 v0, 0.1 % needs v > 640 v0.

    >>> round(float(missing_friction(63.65674, 1.0)), 6)
    0.01
    """
    refuse(positive_faults(characteristic_speed=characteristic_speed))
    return 2 / np.pi * np.arctan(characteristic_speed / np.abs(np.asarray(speed)))


def stable_step(
    mass: float,
    limit: float,
    characteristic_speed: float,
    load: float = 0.0,
    scheme: str = "explicit_euler",
) -> float:
    """Return the largest stable step of an explicit scheme of `blocks` for a mass under a load.

    Linearised about the creep, m v' = -F_R'(v) v with F_R' = (2/pi) (mu F_N/v0) cos^2(pi F/(2 mu
    F_N)); Euler's step is stable for h F_R'/m < 2, that is h < pi m v0/(mu F_N) at rest. A spring
    shortens the step of the semi-implicit scheme to h F_R'/m + h^2 k/(2 m) < 2.

    >>> round(stable_step(1.0, 2.0, 1e-3) / np.pi, 12)
    0.0005
    """
    wrong = positive_faults(mass=mass, limit=limit, characteristic_speed=characteristic_speed)
    if scheme not in STABILITY_LIMITS:
        wrong.append(f"scheme must be one of {', '.join(STABILITY_LIMITS)}, got {scheme!r}")
    refuse(wrong or _load_faults(load, limit))
    slope = 2 / np.pi * (limit / characteristic_speed) * np.cos(np.pi / 2 * (load / limit)) ** 2
    return float(STABILITY_LIMITS[scheme] * mass / slope)


def _limit_faults(limit: float | np.ndarray) -> list[str]:
    values = np.asarray(limit, dtype=float)
    good = bool(np.all(np.isfinite(values)) and np.all(values > 0))
    return [] if good else [f"limit must be finite and positive, got {limit!r}"]


def _load_faults(load: ArrayLike, limit: float | np.ndarray) -> list[str]:
    below = bool(np.all(np.abs(np.asarray(load)) < limit))
    return [] if below else [f"the load must be below the limit {limit!r}, got {load!r}"]
