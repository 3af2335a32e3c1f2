"""Rules of the literature for contacts that are not round, against bounds and solved contacts."""

from __future__ import annotations

import math

import numpy as np

from comparisons.judging.uncertainty import combined, share_uncertainty
from comparisons.questions.experiments.proved import (
    corners_of,
    judged,
    punch_stiffness,
    pyramid_bounds,
)
from comparisons.questions.experiments.running import Finding, above, experiment, one_of
from comparisons.scene.polygons import signed_area
from reference.bounds.flat_faces import equal_area_stiffness
from reference.bounds.homogeneous import Pyramid
from reference.closed_form import ellipsoid
from reference.closed_form.outline_rules import ellipsoid_force, face_stiffness, pyramid_force
from reference.halfspace import FreeOperator, fft
from reference.halfspace.contact_line import located_area
from reference.halfspace.solution import Press
from reference.loads import Load

# S = 2 beta E* (A/pi)^(1/2): King (Int. J. Solids Struct. 23 (1987) 1657), Hendrix (J. Appl. Phys.
# 78 (1995) 7189), by the number of sides.
BETA = {"king": {4: 1.012, 3: 1.034}, "hendrix": {4: 1.0055, 3: 1.0226}}
_QUADRATURE = 1e-9

# Points along the side of the square below a pyramid of slope 1 at a depth of 1: contact along the
# ridges of three faces reaches out to 1.6.
_POINTS = {"quick": (64, 128, 256), "full": (128, 256, 512)}
_SIDE = 4.0


def _face(
    effort: str,
    *,
    sides: float = 4,
    shape: str = "polygon",
    aspect: float = 1.0,
    rule: str = "king",
) -> Finding:
    """Measure the error of a rule for the stiffness of a flat face, by the proved bounds.

    Rules: ``"king"`` and ``"hendrix"`` (squares and triangles), ``"fabrikant"``.
    """
    one_of("rule", rule, *BETA, "fabrikant")
    one_of("shape", shape, "polygon", "rectangle")
    above("aspect", aspect, 0)
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


def _pyramid(effort: str, *, faces: float = 4) -> Finding:
    """Measure the error of Popov's rule for the force of a regular pyramid, by proved bounds."""
    above("faces", faces, 2)
    stated = pyramid_force(int(faces))
    details: dict[str, float | str] = {"over the cone's": stated * math.pi / 2}
    return judged(stated, pyramid_bounds(int(faces), effort), details)


def _pressed(faces: int, points: int) -> tuple[float, float]:
    """Return force and contact area of a pyramid of slope 1 at a depth of 1, E* = 1."""
    spacing = _SIDE / points
    x = np.arange(1 - points, points, 2, dtype=np.float64) * (spacing / 2)
    gap = Pyramid(faces, 1.0).gap_anywhere(x[:, None], x[None, :])
    operator = FreeOperator((points, points), (spacing, spacing), 1.0)
    contact = fft.solve(Press(operator, gap), Load("penetration", np.array([1.0])))
    return contact.force, located_area(contact)


def _indenter(effort: str, *, faces: float = 4, rule: str = "king") -> Finding:
    """Measure the error of beta for an elastic pyramid, S = dF/dd = 2 F/d (F goes with d^2).

    Vickers's indenter has four faces, Berkovich's three; their slope has no part in beta.
    """
    one_of("rule", rule, *BETA)
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


def _ellipsoid(effort: str, *, ratio: float = 10.0) -> Finding:
    """Measure the error of Popov's rule for the force of an ellipsoid against Hertz's ellipse."""
    above("ratio", ratio, 0)
    depth = 0.01
    true = float(ellipsoid(float(ratio), 1.0, 1.0).force(depth))
    return Finding(ellipsoid_force(float(ratio), 1.0, depth), true, _QUADRATURE, {})


EXPERIMENTS = (
    experiment(
        "face-rule",
        "Stiffness of a flat face by rules of the literature, against proved bounds",
        "sides of the face",
        "sides",
        _face,
    ),
    experiment(
        "pyramid-rule",
        "Force of a regular pyramid by Popov's rule (2022), against proved bounds",
        "faces of the pyramid",
        "faces",
        _pyramid,
    ),
    experiment(
        "pyramid-stiffness",
        "Stiffness of a pressed pyramid by beta of the literature, against boundary elements",
        "faces of the pyramid",
        "faces",
        _indenter,
    ),
    experiment(
        "ellipsoid-rule",
        "Force of an ellipsoid by Popov's rule (2022), against Hertz",
        "ratio of the radii of curvature R'/R''",
        "ratio",
        _ellipsoid,
    ),
)
