"""What a bar stands for: 95 % where calibration shows it, else an estimate by the same rules."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from comparisons.facts.quantities import quantity
from comparisons.results.store import SceneRecord
from comparisons.scene.half_space import DEPTH_KEYS
from comparisons.scene.physics.tables import TABLES

# Quantities whose bars `roughline calibrate` holds against true errors.
SINGLE_CONTACTS = ("force", "penetration", "contact_area", "stiffness")
ROUGH_SURFACES = ("contact_area", "penetration", "mean_gap", "stiffness")
WHERE = (
    "95 % where calibration shows it: force, penetration, contact area, mean gap and stiffness of "
    "frictionless, elastic contacts on uniform half-spaces; elsewhere an estimate by the same rules"
)


def depends_on_depth(tables: Mapping[str, Any]) -> bool:
    """Tell whether the half-space of a scene has layers, a rigid base, or is graded."""
    half_space = tables.get("half_space")
    return isinstance(half_space, dict) and any(half_space.get(key) for key in DEPTH_KEYS)


def is_calibrated(tables: Mapping[str, Any], name: str) -> bool:
    """Tell whether calibration covers the bar of a quantity of a scene, given by its tables."""
    if depends_on_depth(tables) or "body" in tables or any(key in tables for key in TABLES):
        return False
    return name in (ROUGH_SURFACES if "surface" in tables else SINGLE_CONTACTS)


def confidence(record: SceneRecord) -> str:
    """Say what the bars of a scene stand for, in words."""
    if record.reference.exact:
        return "The truth is exact; u is that of the reduced model's own discretisation."
    covered = [name for name in record.quantities if is_calibrated(record.tables, name)]
    rest = [quantity(name).label for name in record.quantities if name not in covered]
    if not covered:
        return "u is an estimate from several resolutions; no calibration covers such scenes."
    but = f"; of {', '.join(rest)} an estimate that no calibration covers" if rest else ""
    # one in thirteen errors at a single load of a rough surface is beyond its bar: docs/claims.md
    over = " over the loads (92 % at one load)" if "surface" in record.tables else ""
    return f"u is a 95 % half-width{over}, by calibration{but}."
