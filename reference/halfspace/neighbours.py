"""Interaction of neighbouring contacts on a half-space."""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from reference.halfspace import kernels


def pair_force(distance: float, cells: int) -> float:
    """Return the force on one of two equal flat round punches over that of a single one.

    At equal depth the pressures are mirror images, so one disc of square cells is solved, with the
    coefficients (19.3) of its cells plus those of the other disc. Far apart the ratio is 1/(1 +
    2a/(pi s)), with the other punch as a point force 2 E* a d. The radius follows from the
    stiffness of the disc of cells, 2 E* a, not from its outline, so the staircase of the edge only
    affects the shape of the pressure.

    Parameters
    ----------
    distance : float
        s/a, centre distance over radius, more than 2.
    cells : int
        Cells per radius.

    Examples
    --------
    >>> round(pair_force(20.0, 8), 3), round(1 / (1 + 2 / (np.pi * 20)), 3)
    (0.969, 0.969)
    """
    if not (np.isfinite(distance) and distance > 2):
        raise ValueError(f"distance must be finite and more than two radii, got {distance!r}")
    if int(cells) != cells or cells < 2:
        raise ValueError(f"cells must be an integer of at least 2 per radius, got {cells!r}")
    axis = (np.arange(-cells, cells) + 0.5) / cells
    x, y = (coordinate.ravel() for coordinate in np.meshgrid(axis, axis, indexing="ij"))
    inside = np.hypot(x, y) < 1
    x, y = x[inside] * cells, y[inside] * cells
    spacing = (1 / cells, 1 / cells)
    self_response = kernels.love(x[:, None] - x, y[:, None] - y, spacing, 1.0)
    alone = cho_solve(cho_factor(self_response), np.ones(x.size)).sum()
    apart = distance * cells * (alone / cells**2 / 2)
    cross_response = kernels.love(apart - x[:, None] - x, y[:, None] - y, spacing, 1.0)
    beside = cho_solve(cho_factor(self_response + cross_response), np.ones(x.size)).sum()
    return float(beside / alone)


def array_force(distance: float, per_side: int) -> float:
    """Return the force on a square array of flat round punches over that of isolated ones.

    The per_side^2 punches of radius a at distances s have equal depth. A punch is a spring of
    stiffness 2 E* a, and a point force for the others: d = F_i/(2 E* a) + sum_j F_j/(pi E* r_ij),
    which neglects terms of relative order (a/s)^2 of the interaction.

    Parameters
    ----------
    distance : float
        s/a, at least 3.
    per_side : int
        Punches per side of the array, at most 80.

    Examples
    --------
    >>> array_force(20.0, 1)
    1.0
    """
    wrong = []
    if not (np.isfinite(distance) and distance >= 3):
        wrong.append(f"distance must be finite and at least three radii, got {distance!r}")
    if int(per_side) != per_side or not 1 <= per_side <= 80:
        wrong.append(f"per_side must be an integer from 1 to 80, got {per_side!r}")
    if wrong:
        raise ValueError("; ".join(wrong))
    place = np.indices((per_side, per_side)).reshape(2, -1)
    apart = np.hypot(*(place[:, :, None] - place[:, None, :])) * distance
    np.fill_diagonal(apart, 2 / np.pi)  # so that 2/(pi r) is the compliance of the spring
    forces = cho_solve(cho_factor(2 / np.pi / apart), np.ones(per_side**2))
    return float(forces.mean())
