"""Rings of a round body, one for each spring: what wears the body, and what its line makes of it.

A body of revolution that loses w(r) changes its line by x int_0^x w'(r)/sqrt(x^2 - r^2) dr (Popov
& Hess 2015, ch. 3). Here w is straight between the outer rims of the rings, flat in the first, and
a spring feels the mean of the line over its own width. What the springs do against a small wear is
the work of the pressure against it, which makes the pressure: the exact one of the half-space but
for the width of the rings, and exactly as much force as the springs'.

What a ring does reaches its own spring and those further out; so springs that stick stay unworn.
"""

from __future__ import annotations

import numpy as np

from reduced.arguments import count_faults, positive_faults, refuse


class Rings:
    """Equal rings around an axis.

    Parameters
    ----------
    spacing : float
        Width of a ring and distance of the springs, dx.
    count : int
        Number of rings, two at least.

    Examples
    --------
    A parabola g = x^2 pressed by 1, below which Hertz's pressure is 2 sqrt(1 - r^2)/pi:

    >>> rings = Rings(0.01, 120)
    >>> pressure = rings.pressures(1 - rings.middles**2)
    >>> round(float(pressure @ rings.areas), 3), round(float(pressure[50]), 3)
    (1.333, 0.548)

    Attributes
    ----------
    radii : ndarray
        Outer rims of the rings, at which the worn depths are given.
    middles : ndarray
        Places of the springs.
    areas : ndarray
        What a worn depth is multiplied by for its volume.
    """

    def __init__(self, spacing: float, count: int) -> None:
        refuse(positive_faults(spacing=spacing) + count_faults(2, count=count))
        self.spacing, self.count = spacing, count
        bound = np.arange(count + 1)[:, None] * spacing
        self.radii, self.middles = bound[1:, 0], bound[1:, 0] - spacing / 2
        rim = count * spacing
        starts, ends = self.radii[:-1], self.radii[1:]  # between which w has its slopes
        turned = np.diff(_turned(bound, ends) - _turned(bound, starts), axis=0) / spacing
        self._lowering = self._of_slopes(turned)
        self._lowering[:, 0] += 1.0
        volumes = np.pi * (rim**2 * (ends - starts) - (ends**3 - starts**3) / 3)
        self.areas = self._of_slopes(volumes[None, :])[0]
        self.areas[0] += np.pi * rim**2
        turn = np.arcsin(np.minimum(bound.T / self.radii[:, None], 1.0))
        self._raising = 2 / np.pi * np.diff(turn, axis=1)

    def _of_slopes(self, rows: np.ndarray) -> np.ndarray:
        """Return rows that act on the depths of rings from rows that act on the slopes between."""
        rows = rows / self.spacing
        return np.pad(rows, ((0, 0), (1, 0))) - np.pad(rows, ((0, 0), (0, 1)))

    def lowered(self, worn: np.ndarray) -> np.ndarray:
        """Return the change of the line over the springs when rings have lost so much."""
        return self._lowering @ worn

    def raised(self, line: np.ndarray) -> np.ndarray:
        """Return the body of a line, (2/pi) int_0^r g(x)/sqrt(r^2 - x^2) dx, at the rims."""
        return self._raising @ line

    def pressures(self, deflection: np.ndarray) -> np.ndarray:
        """Return the pressure over E* at the rims from deflections of the springs.

        2 dx sum_i delta_i dg_i is their work over E* when the line rises by dg. Deflections out of
        contact are negative, and do none.
        """
        forces = 2 * self.spacing * (np.maximum(deflection, 0.0) @ self._lowering)
        return np.asarray(forces / self.areas)


def _turned(x: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return int_0^x t arcsin(min(radius/t, 1)) dt."""
    beyond = np.maximum(x, radius)
    root = np.sqrt((beyond - radius) * (beyond + radius))
    return 0.5 * np.where(
        x > radius, beyond**2 * np.arcsin(radius / beyond) + radius * root, np.pi / 2 * x**2
    )
