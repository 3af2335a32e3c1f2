"""How many surfaces or lines a method solves at each resolution."""

from __future__ import annotations

from typing import Any

import numpy as np

from comparisons.facts.methods import GRID, METHODS, MODEL, growth
from comparisons.methods.solver import Solver
from comparisons.scene.scene import Scene
from comparisons.scene.surface import SelfAffine

QUICK_REALISATIONS = 10
# Surfaces of methods that are compared with the leading grid surface by surface.
PAIRED_REALISATIONS = 4
# Surfaces on each grid, coarse to fine, that a plan begins with: their scatter says how many are
# needed (`judging.ensembles`). Of large surfaces, on which a solve costs more than DEAR of those on
# 64 x 64 points, as few as tell a scatter.
PILOTS, FEW_PILOTS = (50, 8, 4, 3), (8, 4, 3)
DEAR = 20.0


def realisation_count(scene: Scene, method: str, limit: int) -> int:
    """Return how many realisations a method solves: on a measured map only lines are drawn."""
    if scene.surface is None or METHODS[method].dimension == 2:
        return 1
    if not scene.random and METHODS[method].dimension == 3:
        return 1
    # What is compared surface by surface needs few of them: differences scatter little.
    return min(scene.realisations, limit if scene.physics else PAIRED_REALISATIONS)


def pilots(solver: Solver[Any], resolutions: tuple[int, ...]) -> tuple[int, ...]:
    """Return how many surfaces or lines are solved before their scatter is known, whole tasks.

    Empty where the number is not a matter of scatter: single contacts, single surfaces, physics
    with ensembles of their own, methods that are compared with the leading grid in pairs.
    """
    scene = solver.scene
    if scene.surface is None or scene.physics or solver.name not in (GRID, MODEL):
        return ()
    blocks = [solver.block(n) for n in resolutions]
    if solver.name == MODEL:
        return tuple(blocks)
    if not scene.random or scene.realisations == 1:
        return ()
    random = [face for face in scene.surfaces if isinstance(face, SelfAffine)]
    dear = surface_cost(GRID, max(random[0].points)) > DEAR
    first = FEW_PILOTS if dear else PILOTS
    numbers = (*first, *(first[-1:] * len(blocks)))
    whole = (-(-n // block) * block for n, block in zip(numbers, blocks, strict=False))
    return tuple(min(n, scene.realisations) for n in whole)


def surface_cost(method: str, resolution: int) -> float:
    """Return the cost of a surface, in solves of 64 x 64 points; measured once (`facts`).

    Times measured in a run would give other numbers of surfaces, and other digits, in the next.
    """
    return float(growth(method) ** np.log2(resolution / 64))
