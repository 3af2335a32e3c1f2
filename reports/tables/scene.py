"""Tables of a scene: cost and errors of each setting, stability, load steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.facts.quantities import counterpart, quantity
from comparisons.results import selection
from comparisons.results.advice import advise
from comparisons.results.confidence import confidence
from comparisons.results.cost import Cost, cost
from comparisons.results.decisions import Verdict, equal_at, verdict_of
from comparisons.results.store import SceneRecord, once
from reports.plots.style import look
from reports.tables import cells
from reports.tables.table import Cell, Head, Table

MOST_ROWS = 400
OF_MEANS = (
    "Of random surfaces the errors are those of means, and a time is that of all solves that the "
    "mean stands on."
)


def settings(scene: SceneRecord) -> Table:
    """Return the cost and largest errors of every method and resolution, including failures."""
    measures = selection.compared_measures(scene, details=True)
    at = selection.texts(measures, "at")
    pairs = list(dict.fromkeys(zip(measures["quantity"], at, strict=True)))
    return replace(
        _settings(scene, measures, pairs),
        note=f"Errors: largest over all load steps ± uncertainty. {OF_MEANS}",
    )


def printed_settings(scene: SceneRecord) -> Table:
    """Return the cost and errors at the loads used for the verdicts, for papers."""
    measures = selection.compared_measures(scene)
    names = dict.fromkeys(str(name) for name in measures["quantity"])
    pairs = [(name, equal_at(scene, name)) for name in names]
    title = (
        f"{scene.title}: largest relative errors over all load steps{_equal_loads(scene)}, with "
        "the half-widths of their bars, and the cost of each setting on one thread. "
        f"{confidence(scene)} {scene.reference.get('text', 'There is no reference.')}"
    )
    if single := advise(scene).single:
        title += f" {OF_MEANS} {single}"
    printed = _settings(scene, measures, pairs).without("set-up", "memory", "outcome")
    return replace(printed, title=title)


def _equal_loads(scene: SceneRecord) -> str:
    """Return the equal loads at which the quantities of a table are compared."""
    clause = f" at equal {quantity(scene.along).label}"
    if not counterpart(scene.along) or scene.along not in scene.quantities:
        return clause
    counterpart_label = quantity(counterpart(scene.along)).label
    return f"{clause} ({quantity(scene.along).label} itself at equal {counterpart_label})"


def _settings(scene: SceneRecord, measures: pd.DataFrame, pairs: list[tuple[str, str]]) -> Table:
    names = [name for name, _ in pairs]
    heads = [Head("method"), Head("N", "resolution"), Head("unknowns", "unknowns")]
    heads += [Head("time", csv="time / s"), Head("set-up", "set-up", "set-up / s")]
    heads += [Head("memory", csv="memory / B"), Head("outcome")]
    single = [Head("surfaces"), Head("time of one", csv="time of one / s")]
    for name, at in pairs:
        label = quantity(name).label
        suffix = f", equal {quantity(at).label}" if names.count(name) > 1 else ""
        heads.append(Head(f"error of {label}{suffix}", "uncertainty", short=label))
        single.append(Head(f"{label} of one{suffix}, 5 to 95 %", short=f"{label} of one"))
    judged = _verdicts_by_setting(scene, measures)
    ensemble = any(cost(scene, *setting).surfaces > 1 for setting in _all_settings(scene))
    rows = []
    for setting in _all_settings(scene):
        known = [judged.get((*setting, *pair)) for pair in pairs]
        rows.append(_setting_row(scene, *setting, known))
        if ensemble:
            rows[-1] += _single_cells(cost(scene, *setting), known)
    return Table((*heads, *single) if ensemble else tuple(heads), tuple(rows))


def _verdicts_by_setting(
    scene: SceneRecord, measures: pd.DataFrame
) -> dict[tuple[str, float, str, str], Verdict]:
    """Return (method, resolution, quantity, at) -> the verdict on it."""
    names = (selection.texts(measures, key) for key in ("quantity", "at"))
    settings = zip(
        selection.texts(measures, "method"),
        selection.column(measures, "resolution"),
        *names,
        strict=True,
    )
    verdicts = (verdict_of(scene, row) for row in measures.to_dict("records"))
    pairs = list(zip(settings, verdicts, strict=True))
    return dict(reversed(pairs))  # the first of several rows counts


@once
def _all_settings(scene: SceneRecord) -> list[tuple[str, float]]:
    refused = selection.unsupported(scene)
    names = selection.texts(scene.rows, "method")
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
    errors: list[Verdict | None],
) -> tuple[Cell, ...]:
    rows = selection.setting_rows(scene, method, level)
    first = {
        name: next((v for v in selection.column(rows, name) if np.isfinite(v)), np.nan)
        for name in ("unknowns", "memory")
    }
    spent = cost(scene, method, level)
    truth = selection.is_reference(scene, method, level)
    return (
        cells.method(method, scene=scene),
        cells.count(level),
        cells.count(first["unknowns"]),
        cells.duration(spent.seconds),
        cells.duration(spent.setup_seconds),
        cells.number(fmt.memory(first["memory"] or None), first["memory"]),
        _outcome(rows, truth, judges_itself=method == selection.reference(scene)[0]),
        *(_error_cell(error, truth) for error in errors),
    )


def _single_cells(spent: Cost, known: list[Verdict | None]) -> tuple[Cell, ...]:
    """Return the time and the band of errors of one surface or line of a setting."""
    bands = [
        cells.number(item.single, item.single_high) if item else cells.NOTHING for item in known
    ]
    return (cells.count(spent.surfaces), cells.duration(spent.single_seconds), *bands)


def _error_cell(error: Verdict | None, truth: bool) -> Cell:
    if truth:
        return cells.number("reference", 0.0)
    if error is None:
        return cells.NOTHING
    return cells.error(error.error, error.uncertainty, error.number)


def _outcome(rows: pd.DataFrame, truth: bool, *, judges_itself: bool) -> Cell:
    good = selection.converged(rows)
    if good.all():
        text = "same method as the reference" if judges_itself else "converged"
        return Cell("reference" if truth else text, "reference" if truth else text, "text")
    failed = "failed" if not good.any() else f"{int((~good).sum())} of {len(good)} failed"
    return Cell(failed, "failed", "failed")


def stability(scene: SceneRecord) -> Table:
    """Return the convergence, iterations, violation and failures of every setting."""
    heads = (
        *(Head("method"), Head("N", "resolution"), Head("loads solved"), Head("of")),
        *(Head("iterations, min"), Head("iterations, max")),
        *(Head("largest violation", "violation"), Head("failures")),
    )
    rows = tuple(_stability_row(scene, *setting) for setting in _all_settings(scene))
    note = "Over all load steps and realisations. Iterations: 0 for direct methods."
    return Table(heads, rows, note=note)


def _stability_row(scene: SceneRecord, method: str, level: float) -> tuple[Cell, ...]:
    rows = selection.setting_rows(scene, method, level)
    names = selection.texts(rows, "realisation")
    rows = rows[[name != selection.MEAN for name in names]]
    good = selection.converged(rows)
    total, solved = len(good), int(good.sum())
    solved_rows = rows[good]
    rounds = selection.column(solved_rows, "iterations")
    rounds = rounds[np.isfinite(rounds)]
    least, most = (rounds.min(), rounds.max()) if len(rounds) else (np.nan, np.nan)
    violation = selection.column(solved_rows, "violation")
    worst = float(np.nanmax(violation)) if np.isfinite(violation).any() else np.nan
    reasons = dict.fromkeys(reason for reason in selection.texts(rows[~good], "reason") if reason)
    failed = "; ".join(reasons) or ("no reason given" if solved < total else "none")
    return (
        cells.method(method, scene=scene),
        cells.count(level),
        Cell(fmt.count(solved), solved, "number" if solved == total else "failed"),
        cells.count(total),
        cells.count(least),
        cells.count(most),
        cells.relative(worst),
        Cell(failed, failed, "text wrap" if solved == total else "failed wrap"),
    )


def lost_solves(scene: SceneRecord) -> list[str]:
    """Return one line per failed setting, with the reason and the number of failed steps."""
    steps_lost: dict[tuple[str, float, str], int] = {}
    for item in selection.failures(scene):
        key = (item.method, item.resolution, item.reason)
        steps_lost[key] = steps_lost.get(key, 0) + int(np.isfinite(item.load))
    return [
        f"{look(method, scene).label}, N = {fmt.count(level)}"
        + (f", {steps} load step{'s' if steps > 1 else ''}" if steps else "")
        + f": {reason or 'no reason given'}"
        for (method, level, reason), steps in steps_lost.items()
    ]


def load_steps(scene: SceneRecord) -> Table:
    """Return the load steps of every setting (ensemble means), at most 400 rows."""
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
        name: fmt.prefix_for(selection.column(rows, name), quantity(name).unit) for name in names
    }
    heads = [Head("method"), Head("N", "resolution"), Head("step")]
    heads += [Head(quantity(name).title(scales[name].unit)) for name in names]
    heads += [Head(f"error of {quantity(name).label}") for name in errors]
    heads += [Head("iterations")]
    note = f"The first {MOST_ROWS} of {total} rows; " if total > MOST_ROWS else ""
    note += "all rows, realisations and columns are in results.csv."
    body = tuple(_step_rows(scene, rows, names, scales, errors))
    return Table(tuple(heads), body, note=note[0].upper() + note[1:])


def _step_rows(
    scene: SceneRecord,
    rows: pd.DataFrame,
    names: list[str],
    scales: dict[str, fmt.Scale],
    errors: list[str],
) -> list[tuple[Cell, ...]]:
    columns: list[list[Cell]] = [
        [cells.method(method, scene=scene) for method in selection.texts(rows, "method")],
        [cells.count(v) for v in selection.column(rows, "resolution")],
        [cells.count(v + 1) for v in selection.column(rows, "step")],
    ]
    for name in names:
        values = selection.column(rows, name)
        scaled = values * scales[name].factor
        columns.append([cells.number(fmt.number(v), v) for v in scaled])
    for name in errors:
        values = selection.column(rows, f"error_{name}")
        columns.append([cells.signed_error(v) for v in values])
    columns.append([cells.count(v) for v in selection.column(rows, "iterations")])
    return list(zip(*columns, strict=True))
