"""Rules of the literature for contacts that are not round, against bounds and exact forms."""

from __future__ import annotations

import math

import numpy as np

from comparisons.questions.experiments.proved import (
    corners_of,
    judged,
    punch_stiffness,
    pyramid_bounds,
)
from comparisons.questions.experiments.running import Finding, above, experiment, one_of
from comparisons.scene.polygons import signed_area
from reference.bounds.punches import equal_area_stiffness
from reference.closed_form import ellipsoid
from reference.closed_form.outline_rules import ellipsoid_force, face_stiffness, pyramid_force

# S = 2 beta E* (A/pi)^(1/2): King (Int. J. Solids Struct. 23 (1987) 1657), Hendrix (J. Appl. Phys.
# 78 (1995) 7189), by the number of sides.
BETA = {"king": {4: 1.012, 3: 1.034}, "hendrix": {4: 1.0055, 3: 1.0226}}
_QUADRATURE = 1e-9


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
    error, bar = judged(stated, true)
    details: dict[str, float | str] = {
        "beta stated": stated / disc,
        "beta not below": true.lower / disc,
        "beta not above": true.upper / disc,
    }
    return Finding(error, bar, details)


def _pyramid(effort: str, *, faces: float = 4) -> Finding:
    """Measure the error of Popov's rule for the force of a regular pyramid, by proved bounds."""
    above("faces", faces, 2)
    error, bar = judged(pyramid_force(int(faces)), pyramid_bounds(int(faces), effort))
    return Finding(error, bar, {"over the cone's": pyramid_force(int(faces)) * math.pi / 2})


def _ellipsoid(effort: str, *, ratio: float = 10.0) -> Finding:
    """Measure the error of Popov's rule for the force of an ellipsoid against Hertz's ellipse."""
    above("ratio", ratio, 0)
    depth = 0.01
    true = float(ellipsoid(float(ratio), 1.0, 1.0).force(depth))
    return Finding(ellipsoid_force(float(ratio), 1.0, depth) / true - 1, _QUADRATURE, {})


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
        "ellipsoid-rule",
        "Force of an ellipsoid by Popov's rule (2022), against Hertz",
        "ratio of the radii of curvature R'/R''",
        "ratio",
        _ellipsoid,
    ),
)
