"""Rules of the literature for contacts that are not round, against bounds and solved contacts.

From the distance a(phi) of the edge. A flat face: k = 2 E* A/(pi <a>), Fabrikant (Int. J. Solids
Struct. 22 (1986) 1497), <a> the mean of a(phi) over all directions. Other shapes: Popov (Symmetry
14 (2022) 390) takes the pressure of such a face, F = max over outlines of (E*/(pi <a>)) int int
(d - f)/sqrt(1 - r^2/a^2) dA, which is exact for ellipses and a rule for other outlines.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from scipy.optimize import minimize
from scipy.special import ellipk

from comparisons.judging.uncertainty import combined, share_uncertainty
from comparisons.questions.experiments.experiment import Above, Finding, OneOf, experiment
from comparisons.questions.experiments.proved import (
    corners_of,
    judged,
    punch_stiffness,
    pyramid_bounds,
)
from comparisons.scene.polygons import signed_area
from reference.bounds.flat_faces import equal_area_stiffness
from reference.bounds.homogeneous import pyramid
from reference.closed_form import ellipsoid
from reference.contact.press import press
from reference.halfspace import FreeOperator
from reference.halfspace.areas import located_area
from reference.loads import Load

# S = 2 beta E* (A/pi)^(1/2): King (Int. J. Solids Struct. 23 (1987) 1657), Hendrix (J. Appl. Phys.
# 78 (1995) 7189), by the number of sides.
BETA = {"king": {4: 1.012, 3: 1.034}, "hendrix": {4: 1.0055, 3: 1.0226}}
_QUADRATURE = 1e-9

# Points along the side of the square below a pyramid of slope 1 at a depth of 1: contact along the
# ridges of three faces reaches out to 1.6.
_POINTS = {"quick": (64, 128, 256), "full": (128, 256, 512)}
_SIDE = 4.0


def face_stiffness(corners: Sequence[tuple[float, float]], effective_modulus: float) -> float:
    """Return k of a flat polygonal face by Fabrikant's rule, seen from its centroid.

    A side at the distance h from the centroid, seen under the angles alpha to beta from its foot,
    contributes h [asinh tan phi] to the integral of a(phi) = h/cos(phi - foot).

    The corners are counter-clockwise, and the centroid must see the whole outline.

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


@experiment(
    "face-rule",
    "Stiffness of a flat face by rules of the literature, against proved bounds",
    "sides",
    "sides of the face",
)
def face_rule(
    effort: str,
    *,
    sides: float = 4,
    shape: Literal["polygon", "rectangle"] = "polygon",
    aspect: Annotated[float, Above(0)] = 1.0,
    rule: Annotated[str, OneOf(*BETA, "fabrikant")] = "king",
) -> Finding:
    """Measure the error of a rule for the stiffness of a flat face, by the proved bounds.

    Rules: ``"king"`` and ``"hendrix"`` (squares and triangles), ``"fabrikant"``.
    """
    corners = corners_of(shape, int(sides), float(aspect))
    true = punch_stiffness(shape, int(sides), float(aspect), effort)
    disc = equal_area_stiffness(signed_area(np.array(corners)))
    if rule == "fabrikant":
        stated = face_stiffness(corners, 1.0)
    elif int(sides) in BETA[rule]:
        stated = BETA[rule][int(sides)] * disc
    else:
        raise ValueError(f"{rule} has no number for {int(sides)} sides")
    details: dict[str, float | str] = {
        "beta stated": stated / disc,
        "beta not below": true.lower / disc,
        "beta not above": true.upper / disc,
    }
    return judged(stated, true, details)


@experiment(
    "pyramid-rule",
    "Force of a regular pyramid by Popov's rule (2022), against proved bounds",
    "faces",
    "faces of the pyramid",
)
def pyramid_rule(effort: str, *, faces: Annotated[float, Above(2)] = 4) -> Finding:
    """Measure the error of Popov's rule for the force of a regular pyramid, by proved bounds."""
    stated = pyramid_force(int(faces))
    details: dict[str, float | str] = {"over the cone's": stated * math.pi / 2}
    return judged(stated, pyramid_bounds(int(faces), effort), details)


def _pressed(faces: int, points: int) -> tuple[float, float]:
    """Return force and contact area of a pyramid of slope 1 at a depth of 1, E* = 1."""
    spacing = _SIDE / points
    x = np.arange(1 - points, points, 2, dtype=np.float64) * (spacing / 2)
    gap = pyramid(faces, 1.0).gap_anywhere(x[:, None], x[None, :])
    operator = FreeOperator((points, points), (spacing, spacing), 1.0)
    contact = press(operator, gap, Load("penetration", np.array([1.0])))
    return contact.force, located_area(contact)


@experiment(
    "pyramid-stiffness",
    "Stiffness of a pressed pyramid by beta of the literature, against boundary elements",
    "faces",
    "faces of the pyramid",
)
def pyramid_stiffness(
    effort: str, *, faces: float = 4, rule: Annotated[str, OneOf(*BETA)] = "king"
) -> Finding:
    """Measure the error of beta for an elastic pyramid, S = dF/dd = 2 F/d (F goes with d^2).

    Vickers's indenter has four faces, Berkovich's three; their slope has no part in beta.
    """
    if int(faces) not in BETA[rule]:
        raise ValueError(f"{rule} has no number for {int(faces)} faces")
    resolutions = np.array(_POINTS[effort])
    force, area = np.array([_pressed(int(faces), int(n)) for n in resolutions]).T
    # S = 2 beta E* (A/pi)^(1/2) with S = 2 F/d, d = 1
    true = force * np.sqrt(np.pi / area)
    bars = [
        share_uncertainty(resolutions, values[:, None], (name, "cells"))[0]
        for name, values in (("force", force), ("contact_area", area))
    ]
    stated, beta = BETA[rule][int(faces)], float(true[-1])
    proved = pyramid_bounds(int(faces), "quick")
    details: dict[str, float | str] = {
        "F s/(E* d^2)": float(force[-1]),
        "F s/(E* d^2) not below": proved.lower,
        "F s/(E* d^2) not above": proved.upper,
    }
    return Finding(stated, beta, stated / beta * float(combined(bars[0], bars[1] / 2)), details)


@experiment(
    "ellipsoid-rule",
    "Force of an ellipsoid by Popov's rule (2022), against Hertz",
    "ratio",
    "ratio of the radii of curvature R'/R''",
)
def ellipsoid_rule(effort: str, *, ratio: Annotated[float, Above(0)] = 10.0) -> Finding:
    """Measure the error of Popov's rule for the force of an ellipsoid against Hertz's ellipse."""
    depth = 0.01
    true = float(ellipsoid(float(ratio), 1.0, 1.0).force(depth))
    return Finding(ellipsoid_force(float(ratio), 1.0, depth), true, _QUADRATURE, {})
