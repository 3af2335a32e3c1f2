"""Where a rough contact first yields: von Mises stress in the body, and the line's local stress."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.questions.experiments.experiment import (
    Above,
    Finding,
    OneOf,
    experiment,
    number_of,
)
from comparisons.questions.experiments.rough_ensemble import SEED, Surface, compare, press, truth
from comparisons.solving.shared import shared
from reduced.loads import Load
from reduced.rough import ensemble, regions
from reference.elasticity import Material
from reference.layered import Stack
from reference.layered.stresses import inside

# Depths in cells of the surface's own grid: nearly none, and on to where little is left.
DEPTHS = np.append(1e-6, 0.1 * 1.3 ** np.arange(16.0))


@shared(maxsize=16)
def _largest(
    surface: Surface, load: float, nu: float, factor: int, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest von Mises stress of every surface, and its depth in waves."""
    operator, side = surface.operator(factor), 1 / surface.points
    body = Stack([], [], Material(1 - nu**2, nu))
    stresses, depths = np.empty(count), np.empty(count)
    for k in range(count):
        contact, _ = press(operator, surface.heights(k, factor), load)
        fields = list(inside(body, contact.pressure, operator.spacing, DEPTHS * side))
        peaks = np.array([field.von_mises.max() for field in fields])
        stresses[k], depths[k] = peaks.max(), DEPTHS[peaks.argmax()] / surface.shortest
    return stresses, depths


def _line_stresses(surface: Surface, load: float, rule: str, count: int) -> np.ndarray:
    """Return the largest local stress (19.37) of every line."""
    # second differences need eight times the points of the surface
    random = ensemble.RandomLines(surface.line("rings"), 8 * surface.points, count, seed=SEED)
    pressed = ensemble.press_ensemble(random, 1.0, Load("force", load), quantities=["penetration"])
    return np.array(
        [
            regions.line_stress(random.draw([k]), 1.0, float(depth), rule=rule).pressure.max()
            for k, depth in enumerate(pressed.samples["penetration"][:, 0])
        ]
    )


@experiment(
    "rough-first-yield",
    "Largest local stress (19.37) of a line against von Mises below the rough contact",
    "load",
    "load F/(E* A0 h')",
)
def rough_first_yield(
    effort: str,
    *,
    load: Annotated[float, Above(0)] = 0.03,
    rule: Annotated[str, OneOf(*regions.RULES)] = "one_radius",
    poisson_ratio: float = 0.3,
    points: float = 32,
    hurst: float = 0.8,
    roll_off: float = 1.0,
    shortest: float = 4.0,
    realisations: Annotated[float, Above(2)] = 90,
) -> Finding:
    """Compare the largest local stress of lines with the largest von Mises stress of surfaces.

    Periodic surfaces, pressed by F = `load` E* A0 h'; the stresses are those of waves in the
    half-space under the pressure of the cells, at seventeen depths.
    """
    surface = Surface.of(points, hurst, roll_off, shortest, True)
    count = number_of(realisations, effort, 12)

    def sample(factor: int, number: int) -> np.ndarray:
        return _largest(surface, float(load), float(poisson_ratio), factor, number)[0]

    true, grid_bar = truth(sample, "refined", count, effort)
    stated = _line_stresses(surface, float(load), rule, 4 * count)
    finest = 4 if effort == "full" else 2
    number = max(3, count // 30) if effort == "full" else max(6, count // 6)
    depths = _largest(surface, float(load), float(poisson_ratio), finest, number)[1]
    details: dict[str, float | str] = {
        "depth of the largest, in shortest waves": float(depths.mean()),
        "surfaces that yield below their surface first": float((depths > 1e-3).mean()),
    }
    return compare(stated, true, grid_bar, details)
