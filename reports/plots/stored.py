"""The stored fields that a picture is made from."""

from __future__ import annotations

import numpy as np

from comparisons.results import selection
from comparisons.results.store import SceneRecord
from reports.plots.style import drawing_order, look

Fields = dict[str, np.ndarray]
# Method, resolution, and its arrays by name.
Stored = tuple[str, int, Fields]


def finest_fields(scene: SceneRecord, *names: str) -> Stored | None:
    """Return the reference's finest fields, or another method's, if they hold all names."""
    first, _ = selection.reference(scene)
    methods = drawing_order(selection.methods(scene))
    for method in sorted(methods, key=lambda name: name != first):
        levels = sorted(level for name, level in scene.fields if name == method)
        fields = scene.load_fields(method, levels[-1]) if levels else {}
        if set(names) <= fields.keys():
            return method, int(levels[-1]), fields
    return None


def at_last_load(stored: Stored) -> str:
    """Return whose fields these are, for a caption."""
    method, resolution, _ = stored
    return f"{look(method).label}, N = {resolution}, at the last load."
