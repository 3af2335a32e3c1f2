"""All hard cases, by id."""

from __future__ import annotations

from comparisons.hard_cases import (
    adhesion,
    friction,
    impacts,
    loads,
    maps,
    materials,
    rough,
    shapes,
    viscoelastic,
)
from comparisons.hard_cases.case import HardCase

CASES: dict[str, HardCase] = {
    case.id: case
    for cases in (adhesion, materials, loads, shapes, rough, maps, friction, viscoelastic, impacts)
    for case in cases.CASES
}
