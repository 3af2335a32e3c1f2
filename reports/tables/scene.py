"""Tables of a scene: cost and errors of each setting, stability, load steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import counterpart, quantity
from comparisons.judging.verdicts import NO_RESULT, Verdict
from comparisons.results.advice import advise
from comparisons.results.record import MEAN, SceneRecord
from comparisons.results.rows import Rows
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
    # With a comparison of pressures come their peak and their integral.
    details = "pressure_" if "pressure" in scene.quantities else ""
    pairs = dict.fromkeys(
        (item.quantity, item.at)
        for item in _compared(scene)
        if item.quantity in scene.quantities or (details and item.quantity.startswith(details))
    )
    return replace(
        _settings(scene, list(pairs)),
        note=f"Errors: largest over all load steps ± uncertainty. {OF_MEANS}",
    )


def printed_settings(scene: SceneRecord) -> Table:
    """Return the cost and errors at the loads used for the verdicts, for papers."""
    names = dict.fromkeys(item.quantity for item in _compared(scene))
    pairs = [(name, scene.equal_at(name)) for name in names if name in scene.quantities]
    title = (
        f"{scene.title}: largest relative errors over all load steps{_equal_loads(scene)}, with "
        "the half-widths of their bars, and the cost of each setting on one thread. "
        f"{scene.confidence} {scene.reference.text or 'There is no reference.'}"
    )
    if single := advise(scene).single:
        title += f" {OF_MEANS} {single}"
    printed = _settings(scene, pairs).without("set-up", "memory", "outcome")
    return replace(printed, title=title)


def _equal_loads(scene: SceneRecord) -> str:
    """Return the equal loads at which the quantities of a table are compared."""
    clause = f" at equal {quantity(scene.along).label}"
    if not counterpart(scene.along) or scene.along not in scene.quantities:
        return clause
    counterpart_label = quantity(counterpart(scene.along)).label
    return f"{clause} ({quantity(scene.along).label} itself at equal {counterpart_label})"


def _compared(scene: SceneRecord) -> list[Verdict]:
    return [item for item in scene.verdicts if item.word != NO_RESULT]


def _settings(scene: SceneRecord, pairs: list[tuple[str, str]]) -> Table:
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
    judged = {(v.method, v.resolution, v.quantity, v.at): v for v in _compared(scene)}
    ensemble = any(scene.cost(*setting).surfaces > 1 for setting in _all_settings(scene))
    rows = []
    for setting in _all_settings(scene):
        known = [judged.get((*setting, *pair)) for pair in pairs]
        rows.append(_setting_row(scene, *setting, known))
        if ensemble:
            spent = scene.cost(*setting)
            bands = [
                cells.number(item.single, item.single_high) if item else cells.NOTHING
                for item in known
            ]
            rows[-1] += (cells.count(spent.surfaces), cells.duration(spent.single_seconds), *bands)
    return Table((*heads, *single) if ensemble else tuple(heads), tuple(rows))


def _all_settings(scene: SceneRecord) -> list[tuple[str, float]]:
    names = [n for n in scene.methods if n not in scene.unsupported]
    return [(name, level) for name in names for level in scene.resolutions_run(name)]


def _setting_row(
    scene: SceneRecord,
    method: str,
    level: float,
    errors: list[Verdict | None],
) -> tuple[Cell, ...]:
    rows = scene.setting_rows(method, level)
    first = {
        name: next((v for v in rows[name] if np.isfinite(v)), np.nan)
        for name in ("unknowns", "memory")
    }
    spent = scene.cost(method, level)
    truth = scene.is_reference(method, level)
    return (
        cells.method(method, scene=scene),
        cells.count(level),
        cells.count(first["unknowns"]),
        cells.duration(spent.seconds),
        cells.duration(spent.setup_seconds),
        cells.number(fmt.memory(first["memory"] or None), first["memory"]),
        _outcome(
            *_lost_of(scene, method, level), truth, judges_itself=method == scene.reference.method
        ),
        *(_error_cell(error, truth) for error in errors),
    )


def _error_cell(error: Verdict | None, truth: bool) -> Cell:
    if truth:
        return cells.number("reference", 0.0)
    if error is None:
        return cells.NOTHING
    return cells.error(error.error, error.uncertainty, error.number)


def _lost_of(scene: SceneRecord, method: str, level: float) -> tuple[int, int]:
    """Return how many load steps were lost, and of how many.

    Lost surfaces have rows, of those that were solved only the first.
    """
    rows = scene.setting_rows(method, level)
    rows = rows.where(rows["realisation"] != MEAN)
    planned = scene.cost(method, level).surfaces * len(set(rows["step"]))
    return int((~rows["converged"]).sum()), max(planned, len(rows))


def _outcome(lost: int, total: int, truth: bool, *, judges_itself: bool) -> Cell:
    if not lost:
        text = "same method as the reference" if judges_itself else "converged"
        return Cell("reference" if truth else text, "reference" if truth else text, "text")
    failed = "failed" if lost == total else f"{lost} of {total} failed"
    return Cell(failed, "failed", "failed")


def stability(scene: SceneRecord) -> Table:
    """Return the convergence, iterations, violation and failures of every setting."""
    heads = (
        *(Head("method"), Head("N", "resolution"), Head("loads solved"), Head("of")),
        *(Head("iterations, min"), Head("iterations, max")),
        *(Head("largest violation", "violation"), Head("failures")),
    )
    rows = tuple(_stability_row(scene, *setting) for setting in _all_settings(scene))
    note = (
        "Over all load steps and realisations; iterations and violation over the realisations that "
        "have rows in results.csv. Iterations: 0 for direct methods."
    )
    return Table(heads, rows, note=note)


def _stability_row(scene: SceneRecord, method: str, level: float) -> tuple[Cell, ...]:
    rows = scene.setting_rows(method, level)
    rows = rows.where(rows["realisation"] != MEAN)
    good = rows["converged"]
    lost, total = _lost_of(scene, method, level)
    solved = total - lost
    rounds = rows["iterations"][good]
    rounds = rounds[np.isfinite(rounds)]
    least, most = (rounds.min(), rounds.max()) if len(rounds) else (np.nan, np.nan)
    violation = rows["violation"][good]
    worst = float(np.nanmax(violation)) if np.isfinite(violation).any() else np.nan
    reasons = dict.fromkeys(filter(None, rows["reason"][~good]))
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
    for item in scene.failures:
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
        scene.curve(method, level)
        for method in scene.methods
        for level in scene.resolutions_solved(method)
    ]
    total = sum(map(len, tables))
    rows = Rows.joined(tables, MOST_ROWS)
    first = [scene.drawn_along, scene.control, "penetration", "force", "contact_area"]
    names = list(dict.fromkeys(first))
    names += [name for name in scene.quantities if name not in names]
    names = [name for name in names if np.isfinite(rows[name]).any()]
    errors = [name for name in scene.quantities if np.isfinite(rows[f"error_{name}"]).any()]
    scales = {name: fmt.prefix_for(rows[name], quantity(name).unit) for name in names}
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
    rows: Rows,
    names: list[str],
    scales: dict[str, fmt.Scale],
    errors: list[str],
) -> list[tuple[Cell, ...]]:
    columns: list[list[Cell]] = [
        [cells.method(method, scene=scene) for method in rows["method"]],
        [cells.count(v) for v in rows["resolution"]],
        [cells.count(v + 1) for v in rows["step"]],
    ]
    for name in names:
        values = rows[name]
        scaled = values * scales[name].factor
        columns.append([cells.number(fmt.number(v), v) for v in scaled])
    for name in errors:
        values = rows[f"error_{name}"]
        columns.append([cells.signed_error(v) for v in values])
    columns.append([cells.count(v) for v in rows["iterations"]])
    return list(zip(*columns, strict=True))
