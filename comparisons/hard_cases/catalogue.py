"""All hard cases, by id."""

from __future__ import annotations

from comparisons.hard_cases import loads, maps, materials, rough, shapes
from comparisons.hard_cases.case import HardCase

CASES: dict[str, HardCase] = {
    case.id: case
    for case in (*materials.CASES, *loads.CASES, *shapes.CASES, *rough.CASES, *maps.CASES)
}
