"""Springs under blunt bodies of the textbooks, whose closed forms no scene has."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated

import numpy as np

from comparisons.questions.experiments.experiment import Between, Finding, OneOf, experiment
from reduced.loads import Load
from reduced.profiles.equivalents import from_function
from reduced.springs.indent import indent
from reduced.springs.line import Springs

_ROUNDING = 1e-9


@experiment(
    "blunt-body",
    "Springs under blunt bodies against their closed forms",
    "flat",
    "flat or round radius over contact radius b/a",
)
def blunt_body(
    effort: str,
    *,
    shape: Annotated[str, OneOf(*_BLUNT)] = "truncated_cone",
    flat: Annotated[float, Between(0, 1)] = 0.5,
) -> Finding:
    """Compare springs with the closed form of a blunt body: force at equal depth, a = 1, E* = 1.

    Shapes (Popov, Hess & Willert 2019, 2.5): ``"truncated_cone"`` of slope 1 and
    ``"truncated_paraboloid"`` of radius 1, both flat to b = `flat`; ``"round_cone"``, of slope 1
    with a round tip to b.
    """
    slope, depth, true = _BLUNT[shape](flat)
    profile = from_function(slope, length=1.0, breakpoints=(flat,))
    coarse, fine = (
        float(indent(Springs(profile, 1.0, count), Load("penetration", depth)).force[0])
        for count in (400, 800)
    )
    return Finding(fine, true, abs(fine - coarse) / true + _ROUNDING, {"depth": depth})


Slope = Callable[[np.ndarray], np.ndarray]
# Slope f'(r), depth and force F/E* at the contact radius 1.
Blunt = tuple[Slope, float, float]


def _truncated_cone(b: float) -> Blunt:
    phi = math.acos(b)
    return (lambda r: np.where(r > b, 1.0, 0.0)), phi, phi + b * math.sqrt(1 - b * b)


def _truncated_paraboloid(b: float) -> Blunt:
    s = math.sqrt(1 - b * b)
    return (lambda r: np.where(r > b, r, 0.0)), s, 2 / 3 * (2 + b * b) * s


def _round_cone(b: float) -> Blunt:
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


_BLUNT = {
    "truncated_cone": _truncated_cone,
    "truncated_paraboloid": _truncated_paraboloid,
    "round_cone": _round_cone,
}
