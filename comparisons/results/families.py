"""Families of scenes: what a reader asks about ("round bodies", "rough surfaces")."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter, ValidationError

from comparisons.results.store import SceneRecord, once
from comparisons.scene.indenters import AnyIndenter
from comparisons.scene.indenters.indenter import Indenter

ROUND, FLAT, OTHER = "axisymmetric bodies", "flat punches that are not round", "other bodies"
LAYERED = "layered and graded half-spaces"
ELLIPSOIDS, ROUGH, FILES = "ellipsoids", "rough surfaces", "bodies from files"
# Physics first: what a scene adds to pressing says more of it than its shape does.
_BY_TABLE = {
    "dynamics": "impacts and pushes",
    "adhesion": "adhesive contacts",
    "sliding": "sliding over rubber",
    "rolling": "rolling contacts",
    "plasticity": "elastic-plastic contacts",
    "lubrication": "lubricated contacts",
    "wear": "contacts that wear",
    "friction": "contacts with friction",
    "viscoelastic": "rubber in time",
    "surface": ROUGH,
    "body": FILES,
}


@once
def family(record: SceneRecord) -> str:
    """Return the family of a scene, in the plural.

    Rough surfaces under other physics are a family of their own: what holds for a ball says
    nothing of them.
    """
    named = [label for table, label in _BY_TABLE.items() if table in record.tables]
    deep = depends_on_depth(record.tables)
    if not named and not deep:
        try:
            indenter: Indenter = TypeAdapter(AnyIndenter).validate_python(
                record.tables.get("indenter")
            )
        except ValidationError:
            return OTHER
        if indenter.axisymmetric:
            return ROUND
        return FLAT if indenter.flat else ELLIPSOIDS if indenter.shape == "ellipsoid" else OTHER
    name = named[0] if named else "bodies"
    if "surface" in record.tables and name != ROUGH:
        name = f"{name} on {ROUGH}"
    return f"{name} on {LAYERED}" if deep else name


def depends_on_depth(tables: Mapping[str, Any]) -> bool:
    """Tell whether the half-space of a scene has layers, a rigid base, or is graded."""
    half_space = tables.get("half_space")
    keys = ("layers", "thickness", "grading")
    return isinstance(half_space, dict) and any(half_space.get(key) for key in keys)
