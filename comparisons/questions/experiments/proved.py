"""Statements and rules of the literature against proved bounds: punches, pyramids.

Rules for contacts that are not round take the distance a(phi) of the edge. A flat face: k = 2 E*
A/(pi <a>), Fabrikant (Int. J. Solids Struct. 22 (1986) 1497), <a> the mean of a(phi) over all
directions. Other shapes: Popov (Symmetry 14 (2022) 390) takes the pressure of such a face, F = max
over outlines of (E*/(pi <a>)) int int (d - f)/sqrt(1 - r^2/a^2) dA, which is exact for ellipses and
a rule for other outlines.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy.optimize import minimize
from scipy.special import ellipk

from comparisons.judging.uncertainty import combined, share_uncertainty
from comparisons.questions.experiments.experiment import Finding, Positive, experiment, one_of
from comparisons.scene.polygons import signed_area
from reference.bounds import flat_faces, homogeneous
from reference.bounds.interval import Interval
from reference.closed_form import ellipsoid
from reference.contact.press import press
from reference.halfspace import FreeOperator
from reference.halfspace.areas import located_area
from reference.loads import Load

Sides = Annotated[int, Field(strict=False, gt=2, le=1000)]
# Cells from the origin to the edge, for the upper and the lower bound.
_CELLS = {"quick": (6, 8), "full": (14, 18)}


def corners_of(shape: str, sides: int, aspect: float) -> tuple[tuple[float, float], ...]:
    """Return the corners of a face: regular polygons of apothem 1, rectangles of width 1."""
    if shape == "polygon":
        angles = [(2 * k + 1) * math.pi / sides for k in range(sides)]
        radius = 1 / math.cos(math.pi / sides)
        return tuple((radius * math.cos(a), radius * math.sin(a)) for a in angles)
    a, b = 0.5 * aspect, 0.5
    return ((a, -b), (a, b), (-a, b), (-a, -b))


@lru_cache(maxsize=64)
def punch_stiffness(shape: str, sides: int, aspect: float, effort: str) -> Interval:
    """Return proved bounds of the stiffness k/E* of a flat punch with the sizes of `corners_of`."""
    return flat_faces.bounded(corners_of(shape, sides, aspect), _CELLS[effort])


@lru_cache(maxsize=64)
def pyramid_bounds(faces: int, effort: str) -> Interval:
    """Return proved bounds of the force F/(E* d^2) of a regular pyramid of slope 1."""
    return homogeneous.force(homogeneous.pyramid(faces, 1.0), 1.0, 1.0, cells=_CELLS[effort])


def judged(stated: float, true: Interval, details: Mapping[str, float | str]) -> Finding:
    """Return the finding in the middle of the errors that the interval permits."""
    most, least = stated / true.lower, stated / true.upper
    return Finding(stated, 2 * stated / (most + least), 0.5 * (most - least), details)


# S = 2 beta E* (A/pi)^(1/2): King (Int. J. Solids Struct. 23 (1987) 1657), Hendrix (J. Appl. Phys.
# 78 (1995) 7189), by the number of sides.
BETA = {"king": {4: 1.012, 3: 1.034}, "hendrix": {4: 1.0055, 3: 1.0226}}
EQUAL_AREA = "equal_area"
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


@experiment("face-rule", "sides of the face")
def face_rule(
    effort: str,
    *,
    sides: Sides = 4,
    shape: Literal["polygon", "rectangle"] = "polygon",
    aspect: Positive = 1.0,
    rule: Annotated[str, one_of(*BETA, "fabrikant", EQUAL_AREA)] = "king",
) -> Finding:
    """Stiffness of a flat face by rules of the literature, against proved bounds.

    Rules: ``"king"`` and ``"hendrix"`` (squares and triangles), ``"fabrikant"``; ``"equal_area"``,
    the circle of D = (4A/pi)^(1/2): never too stiff (Polya & Szego 1951).
    """
    corners = corners_of(shape, sides, aspect)
    true = punch_stiffness(shape, sides, aspect, effort)
    disc = flat_faces.equal_area_stiffness(signed_area(np.array(corners)))
    if rule == "fabrikant":
        stated = face_stiffness(corners, 1.0)
    elif rule == EQUAL_AREA:
        stated = disc
    elif sides in BETA[rule]:
        stated = BETA[rule][sides] * disc
    else:
        raise ValueError(f"{rule} has no number for {sides} sides")
    details = {
        "beta stated": stated / disc,
        "beta not below": true.lower / disc,
        "beta not above": true.upper / disc,
    }
    return judged(stated, true, details)


@experiment("pyramid-rule", "faces of the pyramid")
def pyramid_rule(effort: str, *, faces: Sides = 4) -> Finding:
    """Force of a regular pyramid by Popov's rule (2022), against proved bounds."""
    stated = pyramid_force(faces)
    details = {"over the cone's": stated * math.pi / 2}
    return judged(stated, pyramid_bounds(faces, effort), details)


def pressed_pyramid(faces: int, points: int) -> tuple[float, float]:
    """Return force and contact area of a pyramid of slope 1 at a depth of 1, E* = 1."""
    spacing = _SIDE / points
    x = np.arange(1 - points, points, 2, dtype=np.float64) * (spacing / 2)
    gap = homogeneous.pyramid(faces, 1.0).gap_anywhere(x[:, None], x[None, :])
    operator = FreeOperator((points, points), (spacing, spacing), 1.0)
    contact = press(operator, gap, Load("penetration", np.array([1.0])))
    return contact.force, located_area(contact)


@experiment("pyramid-stiffness", "faces of the pyramid")
def pyramid_stiffness(
    effort: str, *, faces: Sides = 4, rule: Annotated[str, one_of(*BETA)] = "king"
) -> Finding:
    """Stiffness of a pressed pyramid by beta of the literature, against boundary elements.

    S = dF/dd = 2 F/d (F goes with d^2). Vickers's indenter has four faces, Berkovich's three; their
    slope has no part in beta.
    """
    if faces not in BETA[rule]:
        raise ValueError(f"{rule} has no number for {faces} faces")
    resolutions = np.array(_POINTS[effort])
    force, area = np.array([pressed_pyramid(faces, int(n)) for n in resolutions]).T
    # S = 2 beta E* (A/pi)^(1/2) with S = 2 F/d, d = 1
    true = force * np.sqrt(np.pi / area)
    bars = [
        share_uncertainty(resolutions, values[:, None], (name, "cells"))[0]
        for name, values in (("force", force), ("contact_area", area))
    ]
    stated, beta = BETA[rule][faces], float(true[-1])
    proved = pyramid_bounds(faces, "quick")
    details = {
        "F s/(E* d^2)": float(force[-1]),
        "F s/(E* d^2) not below": proved.lower,
        "F s/(E* d^2) not above": proved.upper,
    }
    return Finding(stated, beta, stated / beta * float(combined(bars[0], bars[1] / 2)), details)


@experiment("ellipsoid-rule", "ratio of the radii of curvature R'/R''")
def ellipsoid_rule(effort: str, *, ratio: Positive = 10.0) -> Finding:
    """Force of an ellipsoid by Popov's rule (2022), against Hertz."""
    depth = 0.01
    true = float(ellipsoid(ratio, 1.0, 1.0).force(depth))
    return Finding(ellipsoid_force(ratio, 1.0, depth), true, _QUADRATURE, {})
