"""Tables of a scene: values, cost and errors of each setting, stability, load steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM
from comparisons.facts.quantities import quantity
from comparisons.facts.quantities.rows import HALF_AXES
from comparisons.judging.verdicts import NO_RESULT, Verdict
from comparisons.methods.normal.closed_form import form_of, form_pressure
from comparisons.results.advice import advise
from comparisons.results.record import MEAN, SceneRecord
from comparisons.results.rows import Rows
from comparisons.tasks.shown_loads import at_step, stored_steps
from comparisons.tasks.stresses import FROM_PRESSURE, pressure_quantities
from reference.halfspace.areas import corrected_area, patches
from reports.plots.figure import outer
from reports.plots.pressure import leading_map, pressure_fields
from reports.plots.stored import slider_steps, stored_fields
from reports.plots.style import look
from reports.tables import cells
from reports.tables.cells import Cell, Head, Table

MOST_ROWS, MOST_SPOTS = 400, 10
# Half of an area in fewer spots, or all of it on fewer cells, is no mean over many.
FEW_SPOTS, FEW_CELLS = 10, 300
LEFT_OPEN = 0.2  # a stress is not told from this share on of it that is not known
OF_MEANS = (
    "Of random surfaces the errors are those of means, and a time is that of all solves that the "
    "mean stands on."
)
# What a reader works with; the rest is in curves.csv.
COLUMNS = ("force", "penetration", "mean_gap", "contact_radius", *HALF_AXES, "contact_area")
STRESSES = ("pressure_mean", "pressure_peak", "von_mises_max", "von_mises_depth")


def values(scene: SceneRecord) -> Table:
    """Return loads, contact and stresses at every load, of the reference, then other methods.

    Of a single load, which has no plots of errors, each compared value has its error beside it.
    """
    first = filter(None, [scene.reference.method, *scene.judged_methods])
    methods = dict.fromkeys([*first, *filter(scene.resolutions_solved, scene.methods)])
    beside = scene.quantities if scene.of_one_load else ()
    names = dict.fromkeys([*COLUMNS, *scene.quantities, *STRESSES])
    rows: list[tuple[str, int, dict[str, float]]] = []
    for method in methods:
        curve = scene.curve(method)
        for index, step in enumerate(curve["step"]):
            known = {name: float(curve[name][index]) for name in names}
            if fmt.finite(known["force"]) and known["contact_area"] > 0:
                known["pressure_mean"] = known["force"] / known["contact_area"]
            asked = set(names) if method == scene.reference.method else {"pressure_peak"}
            found = stresses(scene, method, int(step), asked)
            rows.append((method, int(step), known | found))
    columns = [(Head("method"), [cells.method(method, scene=scene) for method, *_ in rows])]
    if not scene.of_one_load:
        steps = [cells.count(step + 1) for _, step, _ in rows]
        columns.append((Head("load step", short="step"), steps))
    for name in names:
        numbers = [known[name] for *_, known in rows]
        if shown := any(map(fmt.finite, numbers)):
            columns.append(cells.column(name, numbers, 4))
        if name in beside:
            text, judged = f"error of {quantity(name).label}", []
            for method, *_ in rows:
                (item,) = (item for item in scene.verdicts_on(method) if item.quantity == name)
                truth = method == scene.reference.method
                judged.append(cells.number("reference", 0.0) if truth else cells.of_verdict(item))
            columns.append((Head("error" if shown else text, "uncertainty", text), judged))
    title = (
        f"{scene.title}: values at every load, of the reference first, each method "
        "at its finest resolution; means over surfaces and lines where there are several. "
        "Stresses are those below the pressure that the method found."
    )
    return cells.of_columns(columns, title=title)


def stresses(
    scene: SceneRecord, method: str, step: int, asked: set[str] | frozenset[str]
) -> dict[str, float]:
    """Return the peak pressure, and below indenters the stresses, of a method at a load step.

    Of a closed form, or from the field that it has stored; nothing where it has none, and without
    what its cells leave open: the stress below an edge of a hundredth of a cell.
    """
    body = scene.scene
    if body is None:
        return {}
    curve = scene.curve(method)
    here = curve.where(curve["step"] == step)
    # Of rough surfaces the report has a figure of the stresses below; large maps are stored as
    # means over blocks, and their rows have the peak of all cells.
    if not body.indenter and np.isfinite(here["pressure_peak"]).any():
        return {"pressure_peak": float(here["pressure_peak"][0])}
    fields: dict[str, np.ndarray] = {}
    if method == CLOSED_FORM and body.indenter and body.half_space.uniform and body.only_pressed:
        form = form_of(body.indenter, body.effective_modulus)
        if form is not None and form.singular_at is None:
            fields = form_pressure(form, float(here["penetration"][0]))
    if not fields:
        fields = next((item.fields for item in stored_fields(scene, [method])), {})
        if step < curve["step"].max():
            fields = at_step(fields, step) if step in stored_steps(fields) else {}
    names = FROM_PRESSURE & asked if body.indenter else {"pressure_peak"}
    read = pressure_quantities(body, names, fields) if "pressure" in fields else {}
    return {name: known.value for name, known in read.items() if not known.bar > LEFT_OPEN}


def spots(scene: SceneRecord) -> list[Table]:
    """Return the largest contact spots of a rough surface at each load of the slider."""
    fields = [item for item in pressure_fields(scene) if item.rough and item.on_a_grid]
    if not fields:
        return []
    leading = leading_map(scene, fields)
    shape, first = np.array(leading.shape), np.array([axis[0] for axis in leading.axes])
    spacing = np.array([np.diff(outer(axis))[0] for axis in leading.axes]) / shape
    surface = scene.tables.get("surface")
    periodic = isinstance(surface, dict) and bool(surface.get("periodic"))
    counted = scene.curve(leading.method, leading.resolution)["contact_count"][-1:]
    how = (
        "The field is stored as means over blocks of cells: contacts that share a block count as "
        f"one ({fmt.count(np.sum(counted))} by cells), areas are of counted cells."
        if leading.share is not None
        else "Areas are of counted cells, less what their staircase adds at a rim."
    )
    labels = slider_steps(scene).labels if any(leading.earlier) else ()
    labels, known = labels or ("" if scene.of_one_load else "last load",), []
    for item in leading.stored:
        pressure = np.zeros(shape) if item is None else item.pressure.reshape(shape)
        found = patches(pressure > 0, tuple(spacing), periodic)
        largest = np.sort(found.areas)[::-1]
        half = 1 + int(np.searchsorted(np.cumsum(largest), np.sum(largest) / 2))
        cells_each = leading.resolution / max(leading.shape)  # along a side of a block
        touched = pressure > 0 if leading.share is None else leading.share * cells_each**2
        total, rows = np.sum(pressure, where=pressure > 0), []
        for number in np.argsort(-found.areas, kind="stable")[:MOST_SPOTS] + 1:
            inside = found.labels == number
            area = corrected_area(inside, tuple(spacing), periodic)
            if leading.share is not None:
                area = float(np.sum(leading.share, where=inside) * np.prod(spacing))
            p = pressure[inside]
            x, y = first + np.argwhere(inside)[np.argmax(p)] * spacing
            rows.append((area, float(np.sum(p) / total), float(x), float(y), float(np.max(p))))
        known.append((found.count, half, round(float(np.sum(touched))), sorted(rows, reverse=True)))
    values = np.array([row for *_, rows in known for row in rows]).reshape(-1, 5)
    size = fmt.prefix_for(values[:, 0], "m2")
    length = fmt.prefix_for(np.concatenate(leading.axes), "m")  # as on the map
    stress = fmt.prefix_for(values[:, 4], "Pa")
    peak = "peak pressure" if leading.share is None else "largest mean pressure of a block"
    heads = (
        *(f"area / {size.unit}", "share of the force"),
        *(f"x / {length.unit}", f"y / {length.unit}", f"{peak} / {stress.unit}"),
    )
    factors = size.factor, 1.0, length.factor, length.factor, stress.factor
    tables = []
    for label, (count, half, points, rows) in zip(labels, known, strict=True):
        body = []
        for row in rows:
            scaled = [value * factor for value, factor in zip(row, factors, strict=True)]
            body.append([cells.number(fmt.number(value), value) for value in scaled])
            body[-1][1] = cells.relative(row[1])
        note = f"{fmt.capitalised(label)}: " if label else ""
        note += f"{fmt.count(count)} contact{'s' * (count != 1)} on {fmt.count(points)} cells"
        if count > 1:
            note += f", half of their area in {fmt.count(half)}, the largest {len(body)} by area"
        if count and (half < FEW_SPOTS or points < FEW_CELLS):
            note += "; so few that another cut-out or surface may have another area"
        note += (
            f". {leading.label}. Cells that share a side are one contact; x, y: its highest "
            f"pressure. {how}"
        )
        tables.append(cells.table(heads, body, note=note))
    return tables


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
    equal = f"at equal {quantity(scene.along).label}"
    if quantity(scene.along).counterpart and scene.along in scene.quantities:
        other = quantity(quantity(scene.along).counterpart).label
        equal += f" ({quantity(scene.along).label} itself at equal {other})"
    title = (
        f"{scene.title}: largest relative errors over all load steps {equal}, with "
        "the half-widths of their bars, and the cost of each setting on one thread. "
        f"{scene.confidence} {scene.reference.text or 'There is no reference.'}"
    )
    if single := advise(scene).single:
        title += f" {OF_MEANS} {single}"
    printed = _settings(scene, pairs).without("set-up", "memory", "outcome")
    return replace(printed, title=title)


def _compared(scene: SceneRecord) -> list[Verdict]:
    return [item for item in scene.verdicts if item.word != NO_RESULT]


def _settings(scene: SceneRecord, pairs: list[tuple[str, str]]) -> Table:
    settings = _all_settings(scene)
    solved = [scene.setting_rows(*setting) for setting in settings]
    spent = [scene.cost(*setting) for setting in settings]
    unknowns, memory = (
        [next((v for v in rows[name] if np.isfinite(v)), np.nan) for rows in solved]
        for name in ("unknowns", "memory")
    )
    outcomes = []
    for method, level in settings:
        lost, total = _lost_of(scene, method, level)
        if lost:
            failed = "failed" if lost == total else f"{lost} of {total} failed"
            outcomes.append(Cell(failed, "failed", "failed"))
            continue
        itself = method == scene.reference.method
        word = "same method as the reference" if itself else "converged"
        word = "reference" if scene.is_reference(method, level) else word
        outcomes.append(Cell(word, word))
    columns: list[tuple[Head, list[Cell]]] = [
        (Head("method"), [cells.method(method, scene=scene) for method, _ in settings]),
        (Head("N", "resolution"), [cells.count(level) for _, level in settings]),
        (Head("unknowns", "unknowns"), [cells.count(number) for number in unknowns]),
        (Head("time", csv="time / s"), [cells.duration(cost.seconds) for cost in spent]),
        (
            Head("set-up", "set-up", "set-up / s"),
            [cells.duration(cost.setup_seconds) for cost in spent],
        ),
        (
            Head("memory", csv="memory / B"),
            [cells.number(fmt.with_unit(size or None, "B"), size) for size in memory],
        ),
        (Head("outcome"), outcomes),
    ]
    of_one = [
        (Head("surfaces"), [cells.count(cost.surfaces) for cost in spent]),
        (
            Head("time of one", csv="time of one / s"),
            [cells.duration(cost.single_seconds) for cost in spent],
        ),
    ]
    judged = {(v.method, v.resolution, v.quantity, v.at): v for v in _compared(scene)}
    names = [name for name, _ in pairs]
    for name, at in pairs:
        label = quantity(name).label
        suffix = f", equal {quantity(at).label}" if names.count(name) > 1 else ""
        errors, bands = [], []
        for setting in settings:
            known, truth = judged.get((*setting, name, at)), scene.is_reference(*setting)
            errors.append(cells.number("reference", 0.0) if truth else cells.of_verdict(known))
            bands.append(cells.number(known.single, known.single_high) if known else cells.NOTHING)
        columns.append((Head(f"error of {label}{suffix}", "uncertainty", short=label), errors))
        head = Head(f"{label} of one{suffix}, 5 to 95 %", short=f"{label} of one")
        of_one.append((head, bands))
    return cells.of_columns(
        [*columns, *of_one] if any(cost.surfaces > 1 for cost in spent) else columns
    )


def _all_settings(scene: SceneRecord) -> list[tuple[str, float]]:
    names = [n for n in scene.methods if n not in scene.unsupported]
    return [(name, level) for name in names for level in scene.resolutions_run(name)]


def _lost_of(scene: SceneRecord, method: str, level: float) -> tuple[int, int]:
    """Return how many load steps were lost, and of how many.

    Lost surfaces have rows, of those that were solved only the first.
    """
    rows = scene.setting_rows(method, level)
    rows = rows.where(rows["realisation"] != MEAN)
    planned = scene.cost(method, level).surfaces * len(set(rows["step"]))
    return int(rows.lost.sum()), max(planned, len(rows))


def stability(scene: SceneRecord) -> Table:
    """Return the convergence, iterations, violation and failures of every setting."""
    heads = (
        *(Head("method"), Head("N", "resolution"), Head("loads solved"), Head("of")),
        *(Head("iterations, min"), Head("iterations, max")),
        *(Head("largest violation", "violation"), Head("failures")),
    )
    body = []
    for method, level in _all_settings(scene):
        rows = scene.setting_rows(method, level)
        rows = rows.where(rows["realisation"] != MEAN)
        good = rows["converged"]
        lost, total = _lost_of(scene, method, level)
        rounds = rows["iterations"][good]
        rounds = rounds[np.isfinite(rounds)]
        least, most = (rounds.min(), rounds.max()) if len(rounds) else (np.nan, np.nan)
        violation = rows["violation"][good]
        worst = float(np.nanmax(violation)) if np.isfinite(violation).any() else np.nan
        reasons = dict.fromkeys(filter(None, rows["reason"][~good]))
        failed = "; ".join(reasons) or ("no reason given" if lost else "none")
        body.append(
            (
                cells.method(method, scene=scene),
                cells.count(level),
                Cell(fmt.count(total - lost), total - lost, "failed" if lost else "number"),
                cells.count(total),
                cells.count(least),
                cells.count(most),
                cells.relative(worst),
                Cell(failed, failed, "failed wrap" if lost else "text wrap"),
            )
        )
    note = (
        "Over all load steps and realisations; iterations and violation over the realisations that "
        "have rows in results.csv. Iterations: 0 for direct methods."
    )
    return Table(heads, tuple(body), note=note)


def lost_solves(scene: SceneRecord) -> list[str]:
    """Return one line per failed setting, with the reason and the number of failed steps."""
    steps_lost: dict[tuple[str, float, str], int] = {}
    for item in scene.failures:
        key = (item.method, item.resolution, item.reason)
        steps_lost[key] = steps_lost.get(key, 0) + int(np.isfinite(item.load))
    return [
        look(method, scene).at(level)
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
    first = (scene.drawn_along, scene.control, "penetration", "force", "contact_area")
    names = dict.fromkeys((*first, *scene.quantities))
    columns = [
        (Head("method"), [cells.method(method, scene=scene) for method in rows["method"]]),
        (Head("N", "resolution"), [cells.count(v) for v in rows["resolution"]]),
        (Head("step"), [cells.count(v + 1) for v in rows["step"]]),
    ]
    columns += [cells.column(name, rows[name]) for name in names if np.isfinite(rows[name]).any()]
    for name in scene.quantities:
        errors = rows[f"error_{name}"]
        if np.isfinite(errors).any():
            head = Head(f"error of {quantity(name).label}")
            columns.append((head, [cells.signed_error(v) for v in errors]))
    columns.append((Head("iterations"), [cells.count(v) for v in rows["iterations"]]))
    note = f"The first {MOST_ROWS} of {total} rows; " if total > MOST_ROWS else ""
    note += "all rows, realisations and columns are in results.csv, where steps count from 0."
    return cells.of_columns(columns, note=fmt.capitalised(note))
