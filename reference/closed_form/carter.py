"""Rolling of a cylinder with friction and creep (Carter 1926; Johnson 1985, sec. 8.3).

The tractions are those of full sliding less those of a strip at the leading edge that sticks:

    q(x) = mu p0 [sqrt(1 - x^2/a^2) - (c/a) sqrt(1 - (x - a + c)^2/c^2)],
    Q/(mu P) = 1 - (c/a)^2,   xi = (mu a/R) (1 - c/a),

2 c the length of the strip and R the radius of a rigid cylinder, or 1/R the sum of the curvatures.
Exact without coupling of normal and tangential displacements: bodies of equal constants, or
nu = 1/2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import positive_faults, refuse

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Carter:
    """A cylinder that rolls along its circumference.

    Parameters
    ----------
    half_width : float
        a of the contact.
    radius : float
        R.
    friction : float
        mu.

    Raises
    ------
    ValueError
        Lists all arguments that are not positive.

    Examples
    --------
    CONTACT's example: a 1 mm, R 500 mm, mu 0.3, and a strip of 0.6 a that sticks.

    >>> cylinder = Carter(1.0, 500.0, 0.3)
    >>> round(float(cylinder.traction(2.4e-4)), 12), round(float(cylinder.stick_share(2.4e-4)), 12)
    (0.64, 0.6)
    """

    half_width: float
    radius: float
    friction: float

    def __post_init__(self) -> None:
        refuse(
            positive_faults(half_width=self.half_width, radius=self.radius, friction=self.friction)
        )

    @property
    def full_creep(self) -> float:
        """Creep from which on nothing sticks, mu a/R."""
        return self.friction * self.half_width / self.radius

    def stick_share(self, creep: ArrayLike) -> Array:
        """Return c/a, the part of the contact that sticks."""
        share: Array = np.maximum(1 - np.abs(creep) / self.full_creep, 0.0)
        return share

    def traction(self, creep: ArrayLike) -> Array:
        """Return Q/(mu P), of the sign of the creep."""
        away = np.minimum(np.abs(creep) / self.full_creep, 1.0)
        traction: Array = np.sign(creep) * away * (2 - away)
        return traction

    def creep(self, traction: ArrayLike) -> Array:
        """Return the creep for Q/(mu P), the smallest one where it is 1.

        Raises
        ------
        ValueError
            If |Q|/(mu P) is above 1.

        Examples
        --------
        >>> round(float(Carter(1.0, 500.0, 0.3).creep(0.64)), 15)
        0.00024
        """
        size = np.abs(traction)
        if not (size <= 1).all():
            raise ValueError(f"traction must lie in [-1, 1], not {traction!r}")
        creep: Array = np.sign(traction) * self.full_creep * size / (1 + np.sqrt(1 - size))
        return creep

    def shear(self, x: ArrayLike, creep: float) -> Array:
        """Return q/(mu p0) at places along the contact; material enters at x = a."""
        x = np.asarray(x) / self.half_width
        stick = float(self.stick_share(creep))
        sliding = np.sqrt(np.maximum(1 - x**2, 0.0))
        strip = np.maximum(stick**2 - (x - 1 + stick) ** 2, 0.0)
        shear: Array = np.sign(creep) * (sliding - np.sqrt(strip))
        return shear
