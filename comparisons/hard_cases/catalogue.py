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
    sliding,
    viscoelastic,
)
from comparisons.hard_cases.case import HardCase

CASES: dict[str, HardCase] = {
    case.id: case
    for cases in (
        *(adhesion, materials, loads, shapes, rough, maps, friction, sliding, viscoelastic),
        impacts,
    )
    for case in cases.CASES
}
