"""The values of a scene with their units, load by load, as a paper prints them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM
from comparisons.facts.quantities import quantity
from comparisons.methods.normal.closed_form import form_of, form_pressure
from comparisons.results.record import SceneRecord
from comparisons.scene.scene import Scene, SceneError, make_scene
from comparisons.tasks.shown_loads import at_step, stored_steps
from comparisons.tasks.stresses import FROM_PRESSURE, pressure_quantities
from reports.plots.stored import stored_fields
from reports.tables import cells
from reports.tables.table import Cell, Head, Table

# What a reader works with; the rest is in curves.csv.
COLUMNS = ("force", "penetration", "mean_gap", "contact_radius", "contact_area")
STRESSES = ("pressure_mean", "pressure_peak", "von_mises_max", "von_mises_depth")


def values(scene: SceneRecord) -> Table:
    """Return loads, contact and stresses at every load, of the reference and the judged methods."""
    methods = dict.fromkeys(filter(None, [scene.reference.method, *scene.judged_methods]))
    rows: list[tuple[str, int, dict[str, float]]] = []
    for method in methods:
        curve = scene.curve(method)
        for index, step in enumerate(curve["step"]):
            known = {name: float(curve[name][index]) for name in (*COLUMNS, *STRESSES)}
            if fmt.finite(known["force"]) and known["contact_area"] > 0:
                known["pressure_mean"] = known["force"] / known["contact_area"]
            asked = STRESSES if method == scene.reference.method else ("pressure_peak",)
            found = stresses(scene, method, int(step), set(asked))
            rows.append((method, int(step), known | found))
    names = [n for n in (*COLUMNS, *STRESSES) if any(fmt.finite(row[n]) for _, _, row in rows)]
    scales = {n: fmt.prefix_for([row[n] for _, _, row in rows], quantity(n).unit) for n in names}
    heads = [Head("method"), Head("load step", short="step")]
    heads += [
        Head(quantity(n).title(scales[n].unit), short=_short(n, scales[n].unit)) for n in names
    ]
    title = (
        f"{scene.title or scene.name}: values at every load, of the reference and of what is "
        "judged, each at its finest resolution; means over surfaces and lines where there are "
        "several. Stresses are those below the pressure that the method found."
    )
    body = tuple(
        (cells.method(method, scene=scene), cells.count(step + 1), *_numbers(row, scales))
        for method, step, row in rows
    )
    return Table(tuple(heads), body, title=title)


def _short(name: str, unit: str) -> str:
    symbol = quantity(name).symbol or quantity(name).label
    return f"{symbol} / {unit}" if unit else symbol


def _numbers(row: dict[str, float], scales: dict[str, fmt.Scale]) -> tuple[Cell, ...]:
    scaled = {name: row[name] * scale.factor for name, scale in scales.items()}
    return tuple(
        cells.number(fmt.number(value, 4), value) if fmt.finite(value) else cells.NOTHING
        for value in scaled.values()
    )


def stresses(
    scene: SceneRecord, method: str, step: int, asked: set[str] | frozenset[str]
) -> dict[str, float]:
    """Return the peak pressure, and below indenters the stresses, of a method at a load step.

    Of a closed form, or from the field that it has stored; nothing where it has none.
    """
    try:
        body = make_scene(dict(scene.tables), scene.name, Path())
    except SceneError:
        return {}  # of a text that is no scene
    curve = scene.curve(method)
    here = curve.where(curve["step"] == step)
    # Of rough surfaces the report has a figure of the stresses below; large maps are stored as
    # means over blocks, and their rows have the peak of all cells.
    if not body.indenter and np.isfinite(here["pressure_peak"]).any():
        return {"pressure_peak": float(here["pressure_peak"][0])}
    fields = _fields(scene, body, method, step, float(curve["step"].max()))
    names = FROM_PRESSURE & asked if body.indenter else {"pressure_peak"}
    read = pressure_quantities(body, names, fields) if "pressure" in fields else {}
    return {name: known.value for name, known in read.items()}


def _fields(
    scene: SceneRecord, body: Scene, method: str, step: int, last: float
) -> dict[str, np.ndarray]:
    """Return the pressure of a method at a load step, with its points."""
    if method == CLOSED_FORM and body.indenter and body.half_space.uniform and not body.physics:
        curve = scene.curve(method)
        depth = curve["penetration"][curve["step"] == step]
        form = form_of(body.indenter, body.effective_modulus)
        if form is not None and not form.pressure_is_singular:
            return form_pressure(form, float(depth[0]))
    stored = next((item.fields for item in stored_fields(scene, [method])), {})
    if step == last:
        return stored
    return at_step(stored, step) if step in stored_steps(stored) else {}
