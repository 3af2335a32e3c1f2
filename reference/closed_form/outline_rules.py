"""Rules for contacts that are not round, from the distance a(phi) of their edge.

A flat face: k = 2 E* A/(pi <a>), Fabrikant (Int. J. Solids Struct. 22 (1986) 1497), <a> the mean of
a(phi) over all directions. Other shapes: Popov (Symmetry 14 (2022) 390) takes the pressure of such
a face, F = max over outlines of (E*/(pi <a>)) int int (d - f)/sqrt(1 - r^2/a^2) dA, which is exact
for ellipses and a rule for other outlines.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize
from scipy.special import ellipk


def face_stiffness(corners: Sequence[tuple[float, float]], effective_modulus: float) -> float:
    """Return k of a flat polygonal face by Fabrikant's rule, seen from its centroid.

    A side at the distance h from the centroid, seen under the angles alpha to beta from its foot,
    contributes h [asinh tan phi] to the integral of a(phi) = h/cos(phi - foot).

    Parameters
    ----------
    corners : sequence of (x, y)
        Counter-clockwise; the centroid must see the whole outline.
    effective_modulus : float
        E*.

    Examples
    --------
    >>> square = [(1, -1), (1, 1), (-1, 1), (-1, -1)]
    >>> round(face_stiffness(square, 1.0) / (2 * math.sqrt(4 / math.pi)), 4)
    1.0055
    """
    points = np.asarray(corners, dtype=float)
    after = np.roll(points, -1, axis=0)
    cross = points[:, 0] * after[:, 1] - after[:, 0] * points[:, 1]
    area = 0.5 * float(cross.sum())
    points = points - ((points + after) * cross[:, None]).sum(axis=0) / (6 * area)
    after = np.roll(points, -1, axis=0)
    side = after - points
    length = np.hypot(*side.T)
    height = (points[:, 0] * after[:, 1] - after[:, 0] * points[:, 1]) / length
    along = [(ends * side).sum(axis=1) / length / height for ends in (points, after)]
    mean = float((height * (np.arcsinh(along[1]) - np.arcsinh(along[0]))).sum()) / (2 * math.pi)
    return 2 * effective_modulus * area / (math.pi * mean)


def pyramid_force(faces: int) -> float:
    """Return F s/(E* d^2) of a regular pyramid of face slope s by Popov's rule.

    With a(phi) = c/cos phi (apothem c) the rule is (E* c/<sec>) <sec^2> (2 d - pi c s/2), the
    largest at c = 2 d/(pi s): (2/pi) <sec^2>/<sec> = (2/pi) tan(pi/n)/ln(sec(pi/n) + tan(pi/n)).
    It tends to the cone's 2/pi.

    Examples
    --------
    >>> round(pyramid_force(4) * math.pi / 2, 4)
    1.1346
    """
    half = math.pi / faces
    return 2 / math.pi * math.tan(half) / math.log(1 / math.cos(half) + math.tan(half))


def ellipsoid_force(radius_x: float, radius_y: float, depth: float) -> float:
    """Return F/E* of an ellipsoid of radii R', R'' by Popov's rule over elliptic outlines.

    With semi-axes a, b: F = a b [2 pi d - (pi/3)(a^2/R' + b^2/R'')]/(2 max K(1 - min^2/max^2)),
    max and min being the longer and the shorter axis.
    """

    def negative(logs: np.ndarray) -> float:
        a, b = np.exp(logs)
        long, short = max(a, b), min(a, b)
        mean = 2 / math.pi * short * ellipk(1 - (short / long) ** 2)
        bracket = 2 * math.pi * depth - math.pi / 3 * (a**2 / radius_x + b**2 / radius_y)
        return -float(a * b * bracket / (math.pi * mean))

    start = 0.5 * np.log([radius_x * depth, radius_y * depth])
    options = {"xatol": 1e-12, "fatol": 1e-14, "maxiter": 2000}
    return -float(minimize(negative, start, method="Nelder-Mead", options=options).fun)
