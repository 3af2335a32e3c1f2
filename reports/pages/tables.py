"""The tables of a scene: one row per setting (cost and errors), one per load step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from reports.plots.style import look

MOST_ROWS = 400


@dataclass(frozen=True)
class Cell:
    """What is printed, and what it is sorted by."""

    text: str
    key: float | str = ""
    kind: str = "number"  # "number", "text", "method" or "failed"
    method: str = ""
    bar: float | None = None


@dataclass(frozen=True)
class Head:
    """A column: its header, the glossary term behind it, and its name in a CSV file."""

    text: str
    term: str = ""
    csv: str = ""


@dataclass(frozen=True)
class Table:
    """A sortable table: headers, rows of cells, a note below."""

    headers: tuple[Head, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""


def settings(scene: SceneRecord) -> Table:
    """Return cost and largest errors of every method and resolution, failures included."""
    table = selection.compared_measures(scene, details=True)
    pairs = list(dict.fromkeys(zip(table["quantity"], selection.words(table, "at"), strict=True)))
    names = [name for name, _ in pairs]
    headers = [Head("method"), Head("N", "resolution"), Head("unknowns", "unknowns")]
    headers += [Head("time", csv="time / s"), Head("set-up", "set-up", "set-up / s")]
    headers += [Head("memory", csv="memory / B"), Head("outcome")]
    for name, at in pairs:
        suffix = f", equal {fmt.quantity(at).words}" if names.count(name) > 1 else ""
        headers.append(Head(f"error of {fmt.quantity(name).words}{suffix}", "uncertainty"))
    rows = [
        _setting_row(scene, method, level, table, pairs) for method, level in _all_settings(scene)
    ]
    note = "Errors: the largest over all load steps ± its uncertainty."
    return Table(tuple(headers), tuple(rows), note)


def _all_settings(scene: SceneRecord) -> list[tuple[str, float]]:
    refused = selection.unsupported(scene)
    names = selection.words(scene.rows, "method")
    levels = selection.column(scene.rows, "resolution")
    pairs = {
        (name, level)
        for name, level in zip(names, levels, strict=True)
        if name not in refused and np.isfinite(level)
    }
    order = selection.methods(scene)
    return sorted(pairs, key=lambda pair: (order.index(pair[0]), pair[1]))


def _setting_row(
    scene: SceneRecord,
    method: str,
    level: float,
    measures: pd.DataFrame,
    pairs: list[tuple[str, str]],
) -> tuple[Cell, ...]:
    own = _rows_of(scene, method, level)
    first = {
        name: next((v for v in selection.column(own, name) if np.isfinite(v)), np.nan)
        for name in ("unknowns", "seconds", "setup_seconds", "memory")
    }
    cells = [
        Cell(look(method).label, look(method).label, "method", method),
        Cell(fmt.count(level), level),
        Cell(fmt.count(first["unknowns"]), first["unknowns"]),
        Cell(fmt.duration(first["seconds"]), first["seconds"]),
        Cell(fmt.duration(first["setup_seconds"]), first["setup_seconds"]),
        Cell(fmt.memory(first["memory"]), first["memory"]),
        _outcome(own, selection.is_reference(scene, method, level)),
    ]
    mine = measures[measures["method"] == method]
    mine = mine[selection.column(mine, "resolution") == level]
    truth = selection.is_reference(scene, method, level)
    cells += [_error_cell(mine, pair, truth) for pair in pairs]
    return tuple(cells)


def _error_cell(measures: pd.DataFrame, pair: tuple[str, str], truth: bool) -> Cell:
    if truth:
        return Cell("reference", 0.0)
    at = np.array(selection.words(measures, "at"))
    row = measures[(measures["quantity"] == pair[0]) & (at == pair[1])].head(1)
    error = selection.column(row, "maximum")
    if not len(error):
        return Cell(fmt.MISSING, float("nan"))
    bar = selection.column(row, "uncertainty")[0]
    return Cell(fmt.plus_minus(error[0], bar), float(error[0]), bar=float(bar))


def _outcome(rows: pd.DataFrame, truth: bool) -> Cell:
    good = selection.converged(rows)
    if good.all():
        text = "reference" if truth else "converged"
        return Cell(text, text, "text")
    failed = "failed" if not good.any() else f"{int((~good).sum())} of {len(good)} failed"
    return Cell(failed, "failed", "failed")


def stability(scene: SceneRecord) -> Table:
    """Return which loads of every setting converged, in how many iterations, and what failed."""
    headers = (Head("method"), Head("N", "resolution"), Head("loads solved"), Head("of"))
    headers += (Head("iterations, least"), Head("iterations, most"))
    headers += (Head("largest violation", "violation"), Head("what failed"))
    rows = tuple(_stability_row(scene, *each) for each in _all_settings(scene))
    note = "Over all load steps and realisations. Iterations: 0 where a method has none."
    return Table(headers, rows, note)


def _stability_row(scene: SceneRecord, method: str, level: float) -> tuple[Cell, ...]:
    own = _rows_of(scene, method, level)
    names = selection.words(own, "realisation")
    own = own[[name != selection.MEAN for name in names]]
    good = selection.converged(own)
    total, solved = len(good), int(good.sum())
    kept = own[good]
    rounds = selection.column(kept, "iterations")
    rounds = rounds[np.isfinite(rounds)]
    least, most = (rounds.min(), rounds.max()) if len(rounds) else (np.nan, np.nan)
    violation = selection.column(kept, "violation")
    worst = float(np.nanmax(violation)) if np.isfinite(violation).any() else np.nan
    reasons = dict.fromkeys(why for why in selection.words(own[~good], "reason") if why)
    failed = "; ".join(reasons) or ("no reason given" if solved < total else "nothing")
    return (
        Cell(look(method).label, look(method).label, "method", method),
        Cell(fmt.count(level), level),
        Cell(fmt.count(solved), solved, "number" if solved == total else "failed"),
        Cell(fmt.count(total), total),
        Cell(fmt.count(least), least),
        Cell(fmt.count(most), most),
        Cell(fmt.relative(worst), worst),
        Cell(failed, failed, "text wrap" if solved == total else "failed wrap"),
    )


def _rows_of(scene: SceneRecord, method: str, level: float) -> pd.DataFrame:
    names = np.array(selection.words(scene.rows, "method"))
    return scene.rows[(names == method) & (selection.column(scene.rows, "resolution") == level)]


def lost_solves(scene: SceneRecord) -> list[str]:
    """Return one line per setting that failed, with its reason and how many steps it lost."""
    found: dict[tuple[str, float, str], int] = {}
    for item in selection.failures(scene):
        key = (item.method, item.resolution, item.reason)
        found[key] = found.get(key, 0) + int(np.isfinite(item.load))
    return [
        f"{look(method).label}, N = {fmt.count(level)}"
        + (f", {steps} load step{'s' if steps > 1 else ''}" if steps else "")
        + f": {reason or 'no reason given'}"
        for (method, level, reason), steps in found.items()
    ]


def load_steps(scene: SceneRecord) -> Table:
    """Return every load step of every setting (means of ensembles), at most 400 rows."""
    tables = [
        selection.curve(scene, method, level)
        for method in selection.methods(scene)
        for level in selection.resolutions(scene, method)
    ]
    rows = pd.concat(tables, ignore_index=True) if tables else scene.rows.iloc[:0]
    total = len(rows)
    rows = rows.head(MOST_ROWS)
    first = [selection.drawn_along(scene), scene.control, "penetration", "force", "contact_area"]
    names = list(dict.fromkeys(first))
    names += [name for name in scene.quantities if name not in names]
    names = [name for name in names if np.isfinite(selection.column(rows, name)).any()]
    errors = [
        name
        for name in scene.quantities
        if np.isfinite(selection.column(rows, f"error_{name}")).any()
    ]
    scales = {
        name: fmt.prefix_for(selection.column(rows, name), fmt.quantity(name).unit)
        for name in names
    }
    headers = [Head("method"), Head("N", "resolution"), Head("step")]
    headers += [Head(fmt.axis_title(name, scales[name].unit)) for name in names]
    headers += [Head(f"error of {fmt.quantity(name).words}") for name in errors]
    headers += [Head("iterations")]
    note = f"The first {MOST_ROWS} of {total} rows; " if total > MOST_ROWS else ""
    note += "all rows, realisations and columns are in results.csv."
    body = tuple(_step_rows(rows, names, scales, errors))
    return Table(tuple(headers), body, note[0].upper() + note[1:])


def _step_rows(
    rows: pd.DataFrame, names: list[str], scales: dict[str, fmt.Scale], errors: list[str]
) -> list[tuple[Cell, ...]]:
    columns: list[list[Cell]] = [
        [
            Cell(look(method).label, look(method).label, "method", method)
            for method in selection.words(rows, "method")
        ],
        [Cell(fmt.count(v), v) for v in selection.column(rows, "resolution")],
        [Cell(fmt.count(v + 1), v + 1) for v in selection.column(rows, "step")],
    ]
    for name in names:
        values = selection.column(rows, name)
        scaled = values * scales[name].factor
        columns.append([Cell(fmt.number(v), v) for v in scaled])
    for name in errors:
        values = selection.column(rows, f"error_{name}")
        columns.append([Cell(fmt.relative(v), v) for v in values])
    columns.append([Cell(fmt.count(v), v) for v in selection.column(rows, "iterations")])
    return list(zip(*columns, strict=True))


def plan_rows(scene: SceneRecord) -> list[dict[str, Any]]:
    """Return what each method models and at which resolutions, or why it cannot."""
    refused = selection.unsupported(scene)
    planned = {str(item.get("method", "")): item for item in scene.plan.get("methods", [])}
    found = []
    for method in selection.methods(scene):
        item = planned.get(method, {})
        levels = item.get("resolutions") or selection.resolutions(scene, method)
        found.append(
            {
                "method": method,
                "label": look(method).label,
                "supported": method not in refused,
                "text": refused.get(method) or str(item.get("modelled") or ""),
                "resolutions": ", ".join(fmt.count(level) for level in levels),
            }
        )
    return found
