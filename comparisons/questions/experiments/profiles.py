"""Profiles and their bodies: blunt ones of the textbooks, and the inverse of the transform."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Literal

import numpy as np

from comparisons.questions.experiments.experiment import (
    Above,
    Between,
    Finding,
    experiment,
    worst,
)
from reduced.loads import Load
from reduced.profiles import equivalents
from reduced.springs.indent import indent
from reduced.springs.line import Springs

_ROUNDING = 1e-9
Slope = Callable[[np.ndarray], np.ndarray]


def blunt(shape: str, b: float) -> tuple[Slope, float, float]:
    """Return slope f'(r), depth and force F/E* of a shape at the contact radius 1."""
    s = math.sqrt(1 - b * b)
    if shape == "truncated_cone":
        phi = math.acos(b)
        return (lambda r: np.where(r > b, 1.0, 0.0)), phi, phi + b * s
    if shape == "truncated_paraboloid":
        return (lambda r: np.where(r > b, r, 0.0)), s, 2 / 3 * (2 + b * b) * s
    f = math.asin(b)
    depth = (1 - math.cos(f)) / math.sin(f) + math.pi / 2 - f

    def share(x: np.ndarray) -> np.ndarray:
        """Depth g(x) of the same body at the contact radius x."""
        inner = np.arcsin(np.minimum(b / np.maximum(x, b), 1.0))
        outer = x * ((1 - np.cos(inner)) / np.sin(inner) + np.pi / 2 - inner)
        return np.where(x > b, outer, x * x / b)

    x, weights = np.polynomial.legendre.leggauss(200)
    parts = [(0.0, b), (b, 1.0)]
    area = sum(
        0.5 * (high - low) * float(weights @ share(0.5 * (low + high) + 0.5 * (high - low) * x))
        for low, high in parts
    )
    return (lambda r: np.minimum(r / b, 1.0)), depth, 2 * (depth - area)


@experiment("blunt-body", "flat or round radius over contact radius b/a")
def blunt_body(
    effort: str,
    *,
    flat: Annotated[float, Between(0, 1)] = 0.5,
    shape: Literal["truncated_cone", "truncated_paraboloid", "round_cone"] = "truncated_cone",
) -> Finding:
    """Springs under blunt bodies against their closed forms.

    Forces at equal depth, a = 1, E* = 1. Shapes (Popov, Hess & Willert 2019, 2.5):
    ``"truncated_cone"`` of slope 1 and ``"truncated_paraboloid"`` of radius 1, both flat to b =
    `flat`; ``"round_cone"``, of slope 1 with a round tip to b.
    """
    slope, depth, true = blunt(shape, flat)
    profile = equivalents.from_function(slope, length=1.0, breakpoints=(flat,))
    coarse, fine = (
        float(indent(Springs(profile, 1.0, count), Load("penetration", depth)).force[0])
        for count in (400, 800)
    )
    return Finding(fine, true, abs(fine - coarse) / true + _ROUNDING, {"depth": depth})


_RADII = np.linspace(0.05, 1.0, 20)
_QUADRATURE = 1e-11  # of the transform and its inverse, both to 1e-12


@experiment("equivalent-body", "exponent n of f = c r^n")
def equivalent_body(
    effort: str,
    *,
    exponent: Annotated[float, Above(0)] = 2.0,
    rule: Literal["half_radius", "transform"] = "half_radius",
) -> Finding:
    """Body of revolution that a profile stands for, against the one that it was made from.

    The largest error over radii up to one. ``"half_radius"``: the chapter's profile;
    ``"transform"``: the profile of the general transform, by quadrature of the slope f'.
    """
    if rule == "half_radius":
        section = equivalents.power_law(exponent, 1.0).section
        assert section is not None  # all shapes except for tables have one
        profile = equivalents.half_radius(section)
    else:
        profile = equivalents.from_function(lambda r: exponent * r ** (exponent - 1), length=1.0)
    body, true = equivalents.inverse_transform(profile, _RADII), _RADII**exponent
    details = {"spread over the radii": float(np.ptp(body / true))}
    return Finding(*worst(body, true), _QUADRATURE, details)
