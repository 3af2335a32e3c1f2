"""The curves of a scene to take away: a row per load, a column per method and quantity."""

from __future__ import annotations

import numpy as np
import pandas as pd

from comparisons.facts.quantities import CURVES, NORMAL, in_order, quantity
from comparisons.results import selection
from comparisons.results.store import SceneRecord


def curves(scene: SceneRecord) -> pd.DataFrame:
    """Return the answers of each method at its finest resolution, in SI units; NaN where lost.

    Columns are ``scene``, ``step`` (from 0), the prescribed load, and ``method:quantity / unit``:
    the methods in the order of every legend, the quantities in theirs. Of random surfaces these
    are the means.
    """
    along = selection.drawn_along(scene)
    names = in_order({*NORMAL, "contact_area", *scene.quantities} & {*CURVES, *NORMAL} - {along})
    found = {name: selection.curve(scene, name) for name in selection.methods(scene)}
    found = {name: rows.set_index("step") for name, rows in found.items() if not rows.empty}
    steps = sorted({step for rows in found.values() for step in rows.index})
    columns = {"scene": [scene.name] * len(steps), "step": np.array(steps, dtype=int)}
    loads = [selection.column(rows.reindex(steps), along) for rows in found.values()]
    if loads:
        known = np.array(loads)
        first = np.argmax(np.isfinite(known), axis=0)
        columns[_titled(along)] = known[first, np.arange(len(steps))]
    for method, rows in found.items():
        for name in names:
            values = selection.column(rows.reindex(steps), name)
            if np.isfinite(values).any():
                columns[f"{method}:{_titled(name)}"] = values
    return pd.DataFrame(columns)


def _titled(name: str) -> str:
    unit = quantity(name).unit
    return f"{name} / {unit}" if unit else name
