"""Rough surfaces that yield (19.6): A = F/H, and elastic contact, against a capped pressure.

The surfaces of the scene `plastic-rough`, under forces that are a share of H A0.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from comparisons.geometry.prepare import RoughGeometry, prepare
from comparisons.questions.experiments.experiment import (
    Above,
    Effort,
    Finding,
    OneOf,
    experiment,
    number_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    Surface,
    compare,
    each_line,
    press,
    truth,
)
from comparisons.scene.scene import load_scene
from comparisons.solving.shared import shared
from reduced.rough import regions
from reference.elasticity import Material
from reference.halfspace import PeriodicOperator
from reference.halfspace.areas import located_area
from reference.layered import Stack
from reference.layered.stresses import inside
from reference.loads import LoadPath
from reference.plastic.capped import Dent, along

_QUANTITIES = ("hardness_area", "elastic_area", "plastic_share")
# Points per side, and surfaces.
_GRIDS: dict[Effort, tuple[int, int]] = {"quick": (64, 128), "full": (128, 256)}
_SURFACES: dict[Effort, int] = {"quick": 4, "full": 8}


@cache
def _surfaces() -> RoughGeometry:
    geometry, _ = prepare(load_scene("plastic-rough", {"surface.realisations": 8}))
    assert isinstance(geometry, RoughGeometry)
    return geometry


@cache
def _pressed(surface: int, points: int, index: float, load: float) -> tuple[Dent, Dent, float]:
    """Press a surface with E* = 1 to F = load H A0, yielding and elastic; also return H."""
    rough = _surfaces()
    hardness = rough.rms_slope / index
    heights = rough.heights(surface, points)
    body = PeriodicOperator((points, points), rough.spacing(heights), 1.0)
    gap, force = rough.top(surface) - heights, LoadPath("force", load * hardness * rough.area)
    (dent,), (elastic,) = (along(body, gap, cap, force) for cap in (hardness, np.inf))
    return dent, elastic, hardness


@shared(maxsize=256)
def _compared(
    surface: int, points: int, index: float, load: float
) -> dict[str, tuple[float, float]]:
    """Return what is stated and what is true of one surface on one grid."""
    dent, elastic, hardness = _pressed(surface, points, index, load)
    area = located_area(dent.contact, hardness, patch=True)
    pressure = elastic.contact.pressure
    over = np.count_nonzero(pressure >= hardness) / np.count_nonzero(pressure)
    return {
        "hardness_area": (dent.contact.force / hardness, area),
        "elastic_area": (located_area(elastic.contact, patch=True), area),
        "plastic_share": (over, dent.plastic_share),
    }


@experiment(
    "rough-yield",
    "Rough contacts by their hardness, or elastic, against a capped pressure",
    "index",
    "plasticity index E* h'/H",
)
def rough_yield(
    effort: Effort,
    *,
    index: Annotated[float, Above(0)] = 3.0,
    load: float = 0.1,
    quantity: Annotated[str, OneOf(*_QUANTITIES)] = "hardness_area",
) -> Finding:
    """Compare the area F/H, the elastic one, or the elastic share above H, with what yields."""
    if not 0 < load <= 0.5:
        raise ValueError(f"load must be above 0 and at most 0.5, not {load!r}")
    numbers = range(_SURFACES[effort])
    errors = []
    for points in _GRIDS[effort]:
        pairs = [_compared(k, points, index, load)[quantity] for k in numbers]
        stated, true = np.transpose(pairs)
        if not true.mean() > 0:
            raise ValueError(f"nothing yields at an index of {index!r}")
        errors.append(float(stated.mean() / true.mean() - 1))
    residual = stated - (1 + errors[-1]) * true
    scatter = float(2 * np.std(residual, ddof=1) / np.sqrt(len(pairs)) / true.mean())
    # grids err in proportion to their cells (Richardson's rule of first order)
    coarse, fine = errors
    everything = [_compared(k, _GRIDS[effort][-1], index, load) for k in numbers]
    details: dict[str, float | str] = {
        "share of the contact that yields": float(
            np.mean([pair["plastic_share"][1] for pair in everything])
        ),
        "F over H A": float(np.mean([np.divide(*pair["hardness_area"]) for pair in everything])),
    }
    return Finding(stated.mean(), true.mean(), abs(fine - coarse) + scatter, details)


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
    # The largest local stress (19.37) of every line: second differences need eight times the points
    # of the surface.
    stated = [
        regions.line_stress(line, 1.0, depth, rule=rule).pressure.max()
        for line, depth in each_line(surface, float(load), 4 * count, 8)
    ]
    finest = 4 if effort == "full" else 2
    number = max(3, count // 30) if effort == "full" else max(6, count // 6)
    depths = _largest(surface, float(load), float(poisson_ratio), finest, number)[1]
    details: dict[str, float | str] = {
        "depth of the largest, in shortest waves": float(depths.mean()),
        "surfaces that yield below their surface first": float((depths > 1e-3).mean()),
    }
    return compare(stated, true, grid_bar, details)
