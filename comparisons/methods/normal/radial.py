"""Points of an axisymmetric pressure profile, shared by the methods that know p(r)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

# The pressure is exact at each point; their number only sets how smooth a plot is.
POINTS = 200


@lru_cache(maxsize=1)
def unit_rings() -> tuple[np.ndarray, np.ndarray]:
    """Return relative radii in (0, 1) and the areas that they stand for, on the unit disc.

    Gauss points of t with rho = sin t: they crowd towards the edge, where a pressure falls or
    rises steeply, and their weights integrate even an inverse square root there exactly.
    """
    node, weight = np.polynomial.legendre.leggauss(POINTS)
    angle = np.pi / 4 * (node + 1)
    rho = np.sin(angle)
    ring = np.pi / 4 * weight * np.cos(angle) * 2 * np.pi * rho
    for array in (rho, ring):
        array.setflags(write=False)
    return rho, ring


def profile_fields(
    half_x: float, half_y: float, x: np.ndarray, pressure: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the fields of a pressure known along the x axis of an elliptic contact."""
    return {
        "pressure_x": x,
        "pressure_y": np.zeros_like(x),
        "pressure": pressure,
        "pressure_weight": unit_rings()[1] * (half_x * half_y),
    }
