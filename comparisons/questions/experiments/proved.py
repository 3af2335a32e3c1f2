"""Statements compared with proved bounds: punches, pyramids and rough contacts."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated

import numpy as np

from comparisons.questions.experiments.experiment import Above, Details, Finding, OneOf, experiment
from comparisons.questions.experiments.rough_ensemble import SEED
from comparisons.scene.polygons import signed_area
from comparisons.solving.shared import shared
from reference import surfaces
from reference.bounds import flat_faces, homogeneous, revolution
from reference.bounds.ellipses import ConvexGap, Ellipse, Face, best_ellipse, force_of_ellipse
from reference.bounds.interval import Interval
from reference.bounds.patches import Patch
from reference.bounds.periodic import PeriodicSurface

SHAPES = ("polygon", "rectangle", "l_shape", "right_isosceles", "disc")

# Cells from the origin to the edge, for the upper and the lower bound.
_CELLS = {"quick": (6, 8), "full": (14, 18)}

# Rings and arcs of a mean gap that is stated: it exceeds the mean by 1e-4.
_RINGS = 256, 192

# Corners relative to points from which the whole outline is visible: the L of three unit squares,
# and the right triangle with a hypotenuse of 2 about the centre of its inscribed circle.
_FIXED = {
    "l_shape": ((1.5, -0.5), (1.5, 0.5), (0.5, 0.5), (0.5, 1.5), (-0.5, 1.5), (-0.5, -0.5)),
    "right_isosceles": tuple(
        (x + math.sqrt(2) - 2, y) for x, y in ((1.0, -1.0), (1.0, 1.0), (0.0, 0.0))
    ),
}


def corners_of(shape: str, sides: int, aspect: float) -> tuple[tuple[float, float], ...]:
    """Return the corners of a face: regular polygons of apothem 1, rectangles of width 1."""
    if shape == "polygon":
        angles = [(2 * k + 1) * math.pi / sides for k in range(sides)]
        radius = 1 / math.cos(math.pi / sides)
        return tuple((radius * math.cos(a), radius * math.sin(a)) for a in angles)
    if shape == "rectangle":
        a, b = 0.5 * aspect, 0.5
        return ((a, -b), (a, b), (-a, b), (-a, -b))
    return _FIXED[shape]


@lru_cache(maxsize=64)
def punch_stiffness(shape: str, sides: int, aspect: float, effort: str) -> Interval:
    """Return proved bounds of the stiffness k/E* of a flat punch with the sizes of `corners_of`."""
    if shape == "disc":
        return revolution.disc_stiffness(1.0, 1.0, cells=2 * _CELLS[effort][0])
    return flat_faces.bounded(corners_of(shape, sides, aspect), _CELLS[effort])


@experiment(
    "equal-area-circle",
    "Stiffness of flat punches by the circle of equal area, against proved bounds",
    "sides",
    "sides n of a regular polygon",
)
def equal_area(
    effort: str,
    *,
    sides: Annotated[int, Above(2)] = 4,
    shape: Annotated[str, OneOf(*SHAPES)] = "polygon",
    aspect: Annotated[float, Above(0)] = 1.0,
) -> Finding:
    """Measure the error of k by D = (4A/pi)^(1/2), never positive (Polya & Szego 1951)."""
    face = shape, int(sides), float(aspect)
    true = punch_stiffness(*face, effort)
    area = math.pi if shape == "disc" else signed_area(np.array(corners_of(*face)))
    stated = flat_faces.equal_area_stiffness(area)
    details: dict[str, float | str] = {
        "k/E* not below": true.lower,
        "k/E* not above": true.upper,
        "k/(2 E* (A/pi)^(1/2)) not below": true.lower / stated,
        "k/(2 E* (A/pi)^(1/2)) not above": true.upper / stated,
        "never too stiff": "by theorem (Polya & Szego 1951)",
    }
    return judged(stated, true, details)


@lru_cache(maxsize=64)
def pyramid_bounds(faces: int, effort: str) -> Interval:
    """Return proved bounds of the force F/(E* d^2) of a regular pyramid of slope 1."""
    return homogeneous.force(homogeneous.pyramid(faces, 1.0), 1.0, 1.0, cells=_CELLS[effort])


@experiment(
    "equal-area-cone",
    "Force of pyramids by the cone of equal area, against proved bounds",
    "faces",
    "faces n of a regular pyramid",
)
def equal_area_cone(effort: str, *, faces: Annotated[int, Above(2)] = 4) -> Finding:
    """Compare the force of a pyramid with that of the cone of equal sectional areas."""
    true = pyramid_bounds(int(faces), effort)
    # a section has the apothem d, the circle of its area the radius (n tan(pi/n)/pi)^(1/2) d; a
    # cone of slope s carries (2/pi) E* d^2/s
    stated = 2 / math.pi * math.sqrt(faces * math.tan(math.pi / faces) / math.pi)
    body = homogeneous.pyramid(int(faces), 1.0)
    details: dict[str, float | str] = {
        "F s/(E* d^2) not below": true.lower,
        "F s/(E* d^2) not above": true.upper,
        "the best circle carries at least": body.punch_force,
    }
    return judged(stated, true, details)


@shared(maxsize=64)
def _ellipse_force(shape: str, sides: int, aspect: float) -> float:
    """Return the force at a penetration of 1 that the best ellipse proves, for E* = 1."""
    if shape == "pyramid":
        gap = homogeneous.pyramid(sides, 1.0).gap_anywhere
        starts = [Ellipse(0.0, 0.0, 0.8, 0.6, turn) for turn in (0.0, 0.8)]
        ellipse, _ = best_ellipse(ConvexGap(gap), 1.0, starts)
        return force_of_ellipse(ConvexGap(gap, *_RINGS), ellipse, 1.0)
    if shape == "disc":
        return Ellipse(0.0, 0.0, 1.0, 1.0).stiffness
    face = Face(corners_of(shape, sides, aspect))
    return best_ellipse(face, 1.0, face.starts())[1]


@experiment(
    "best-ellipse",
    "Force by the best flat ellipse (Barber 1974) on a face or under a pyramid, against proved "
    "bounds",
    "sides",
    "sides or faces n",
)
def _best_ellipse(
    effort: str,
    *,
    sides: Annotated[int, Above(2)] = 4,
    shape: Annotated[str, OneOf("pyramid", *SHAPES)] = "pyramid",
    aspect: Annotated[float, Above(0)] = 1.0,
) -> Finding:
    """Measure how far the best flat ellipse falls short, a proved formula for any shape."""
    if shape == "pyramid":
        true = pyramid_bounds(int(sides), effort)
    else:
        true = punch_stiffness(shape, int(sides), float(aspect), effort)
    stated = _ellipse_force(shape, int(sides), float(aspect))
    return judged(stated, true, {"never too much": "by theorem (Barber 1974)"})


def judged(stated: float, true: Interval, details: Details) -> Finding:
    """Return the finding in the middle of the errors that the interval permits."""
    most, least = stated / true.lower, stated / true.upper
    return Finding(stated, 2 * stated / (most + least), 0.5 * (most - least), details)


def _heights(points: float, hurst: float) -> np.ndarray:
    """Return a surface of side 1 and rms gradient 0.1."""
    spectrum = surfaces.SelfAffine(hurst=float(hurst), rms_slope=0.1)
    return surfaces.self_affine(int(points), 1.0, spectrum, seed=SEED, realisation=0)


@experiment(
    "rough-force-on-grid",
    "Force of a free rough patch by boundary elements, against proved bounds",
    "depth",
    "penetration over the rms height",
)
def rough_force_on_grid(
    effort: str,
    *,
    depth: Annotated[float, Above(0)] = 2.0,
    points: Annotated[int, Above(3)] = 16,
    hurst: float = 0.8,
    finer: Annotated[int, Above(0)] = 4,
) -> Finding:
    """Measure the force of the half-space solver on a rough patch against the continuous surface.

    At a penetration of `depth` rms heights; the surface is the band-limited one through the points.
    """
    heights = _heights(points, hurst)
    patch = Patch(heights, 1.0, int(finer) if effort == "full" else 2)
    penetration = float(depth) * float(heights.std())
    stated = patch.on_grid(penetration)
    details: dict[str, float | str] = {
        "cells per side": float(patch.grid[0]),
        "ellipses on the summits carry at least, over it": patch.by_ellipses(penetration, 1.0)
        / stated,
    }
    return judged(stated, patch.force(penetration, 1.0), details)


@experiment(
    "rough-penetration-on-grid",
    "Penetration of a periodic rough contact by boundary elements, against proved bounds",
    "load",
    "load F/(E* A0 h')",
)
def rough_penetration_on_grid(
    effort: str,
    *,
    load: Annotated[float, Above(0)] = 0.03,
    points: Annotated[int, Above(3)] = 32,
    hurst: float = 0.8,
    finer: Annotated[int, Above(0)] = 8,
) -> Finding:
    """Measure the penetration of the half-space solver against the continuous periodic surface.

    At a force of `load` E* A0 h', h' = 0.1.
    """
    heights = _heights(points, hurst)
    surface = PeriodicSurface(heights, (1.0, 1.0), int(finer) if effort == "full" else 4)
    mean = 0.1 * float(load)
    stored = surface.energy(mean, 1.0)
    stated = surface.on_grid(mean).penetration
    details: dict[str, float | str] = {
        "cells per side": float(surface.grid[0]),
        "width of the energy's bounds": stored.width,
    }
    return judged(stated, surface.penetration(mean, 1.0), details)
