"""Tables to take away, which are never read back: the curves of a scene, its verdicts."""

from __future__ import annotations

import numpy as np
import pandas as pd

from comparisons.facts.quantities import CURVES, NORMAL, in_order, quantity
from comparisons.files import write_table
from comparisons.results import selection
from comparisons.results.rows import Rows
from comparisons.results.store import SceneRecord, StudyRecord, stacked

MEASURES, TO_TAKE = "measures.csv", "curves.csv"
# Of a setting: what its solves cost. Of a verdict: its numbers.
COST = (
    *("surfaces", "seconds", "setup_seconds", "seconds_all", "setup_seconds_all"),
    *("unknowns", "memory", "machine"),
)
NUMBERS = (
    *("uncertainty", "word", "step", "low", "high"),
    *("single_low", "single_high", "single_step", "outside_band"),
)


def write_exports(record: StudyRecord) -> None:
    """Write measures.csv and curves.csv."""
    tables = [measures(scene) for scene in record.scenes]
    write_table(record.directory / MEASURES, stacked(record, tables))
    tables = [curves(scene) for scene in record.scenes]
    if tables:
        write_table(record.directory / TO_TAKE, pd.concat(tables, ignore_index=True))


def measures(scene: SceneRecord) -> pd.DataFrame:
    """Return a row for each verdict of a method that gives the quantity, with its setting's cost.

    ``error`` is that at the step that decides (NaN: the distance of two fields has no sign),
    ``maximum`` its size; ``reason`` is the first one why a step has no answer.
    """
    table = []
    for item in scene.verdicts:
        if not (item.resolution and item.counts and item.offered):
            continue
        rows = selection.setting_rows(scene, item.method, item.resolution)
        table.append(
            {"scene": scene.name, "method": item.method, "resolution": item.resolution}
            | {name: rows[name][0] for name in COST}
            | {
                "converged": rows["converged"].all(),
                "reason": next(filter(None, rows["reason"]), ""),
            }
            | {"quantity": item.quantity, "at": item.at}
            | {"rms": item.rms, "maximum": abs(item.error)}
            | {"error": item.error if item.signed else np.nan}
            | {name: getattr(item, name) for name in NUMBERS}
            | {"single_step": item.single_step if item.single_step >= 0 else np.nan}
        )
    return Rows.of(pd.DataFrame(table).rename(columns={"word": "verdict"})).frame()


def curves(scene: SceneRecord) -> pd.DataFrame:
    """Return the answers of each method at its finest resolution, in SI units; NaN where lost.

    Columns are ``scene``, ``step`` (from 0), the prescribed load, and ``method:quantity / unit``:
    the methods in the order of every legend, the quantities in theirs. Of random surfaces these
    are the means.
    """
    along = selection.drawn_along(scene)
    names = in_order({*NORMAL, "contact_area", *scene.quantities} & {*CURVES, *NORMAL} - {along})
    found = {name: selection.curve(scene, name) for name in selection.methods(scene)}
    found = {name: rows for name, rows in found.items() if len(rows)}
    steps = np.unique(np.concatenate([[], *(rows["step"] for rows in found.values())]))

    def at_steps(rows: Rows, name: str) -> np.ndarray:
        values = np.full(len(steps), np.nan)
        values[np.searchsorted(steps, rows["step"])] = rows[name]
        return values

    columns = {"scene": [scene.name] * len(steps), "step": steps.astype(int)}
    if found:
        known = np.array([at_steps(rows, along) for rows in found.values()])
        first = np.argmax(np.isfinite(known), axis=0)
        columns[_titled(along)] = known[first, np.arange(len(steps))]
    for method, rows in found.items():
        for name in names:
            values = at_steps(rows, name)
            if np.isfinite(values).any():
                columns[f"{method}:{_titled(name)}"] = values
    return pd.DataFrame(columns)


def _titled(name: str) -> str:
    unit = quantity(name).unit
    return f"{name} / {unit}" if unit else name
