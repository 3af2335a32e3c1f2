"""Mean and scatter of an ensemble of surfaces."""

from __future__ import annotations

import pandas as pd

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.results.ensemble_folder import EnsembleRecord
from reports.tables import cells
from reports.tables.table import Cell, Table, table

SHOWN = ("force", "penetration", "mean_gap", "contact_area")


def settings(record: EnsembleRecord) -> Table:
    """Return one row per method and resolution: surfaces and what they cost."""
    rows = [
        (
            cells.method(setting.method),
            cells.count(setting.resolution),
            cells.count(setting.surfaces),
            cells.count(setting.bundles),
            cells.count(setting.lost),
            cells.duration(setting.processor_seconds),
            cells.duration(setting.processor_seconds / max(setting.surfaces, 1)),
        )
        for setting in record.settings
    ]
    heads = ("method", "points", "surfaces", "files", "lost steps", "processor", "per surface")
    return table(heads, rows, title=f"{record.name}: {fmt.count(record.surfaces)} surfaces")


def means(record: EnsembleRecord, statistics: pd.DataFrame) -> Table:
    """Return the means with their standard errors at the first, middle and last load."""
    quantities = [name for name in SHOWN if name != record.control]
    last = len(record.loads) - 1
    rows = []
    for setting in record.settings:
        chosen = (statistics["method"] == setting.method) & (
            statistics["resolution"] == setting.resolution
        )
        own = statistics[chosen].set_index(["step", "quantity"])
        for step in sorted({0, last // 2, last}):
            row = [cells.method(setting.method), cells.count(setting.resolution)]
            row.append(_value(record.control, record.loads[step], 0.0))
            for name in quantities:
                known = (step, name) in own.index
                mean, error = own.loc[(step, name), ["mean", "standard_error"]] if known else (0, 0)
                row.append(_value(name, float(mean), float(error)) if known else cells.NOTHING)
            rows.append(row)
    labels = [quantity(name).label for name in (record.control, *quantities)]
    return table(["method", "points", *labels], rows, title="means ± standard errors")


def _value(name: str, mean: float, error: float) -> Cell:
    scale = fmt.prefix_for([mean], quantity(name).unit)
    text = fmt.number(mean * scale.factor, 4)
    if error:
        text += f" ± {fmt.number(error * scale.factor, 2)}"
    return cells.number(f"{text} {scale.unit}".rstrip(), mean)
