"""Error plots: the errors of the compared quantities at every load step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import NORMAL, quantity
from comparisons.judging.metrics import at_equal
from comparisons.results.record import SceneRecord
from comparisons.results.rows import Rows
from reports.plots.axes import (
    FOOT_NOTE,
    SIGN_NOTE,
    error_axis,
    error_range,
    failed,
    parted,
    refusal,
    sign_marks,
    tolerance_line,
    value_axis,
    wants_log,
    with_foot,
)
from reports.plots.curves import TRUTH_BAR
from reports.plots.figure import Band, Figure, Guide, Series, Stretch
from reports.plots.style import CIRCLE, INK, drawing_order, look

CAPTION = (
    "Each method at its finest resolution. Horizontal line: tolerance. Shaded: below the "
    "uncertainty of the reference, where an error is not resolved. Ring: the error that decided. "
    f"{SIGN_NOTE} {FOOT_NOTE}"
)
PATH_CAPTION = "Errors are relative to the largest value along the path, which passes through zero."
PREMISE = 0.1  # of the apparent area: rough lines are for real contact areas far below


def errors(scene: SceneRecord) -> list[Figure]:
    """Return the error magnitude of each compared quantity at every load step, on one scale."""
    tables: dict[str, dict[str, Rows]] = {}
    sizes = []
    for name in scene.quantities:
        for method in drawing_order(scene.methods):
            level = scene.finest(method)
            if level is None:
                continue
            rows = scene.curve(method, level)
            error = rows[f"error_{name}"]
            if np.isfinite(error).any():
                tables.setdefault(name, {})[method] = rows
                sizes.append(np.abs(error))
    if not sizes:
        return []
    limits = error_range(np.concatenate(sizes), scene.tolerance)
    figures = [_figure(scene, name, by_method, limits) for name, by_method in tables.items()]
    return _with_premise(scene, figures)


def _figure(
    scene: SceneRecord, name: str, tables: dict[str, Rows], limits: tuple[float, float]
) -> Figure:
    low, high = limits
    row, along = quantity(name), quantity(scene.along)
    series: list[Series] = []
    for method, rows in tables.items():
        style, error = look(method, scene), rows[f"error_{name}"]
        loads = scene.compared_along(rows)
        title = f"{style.label}, N = {fmt.count(rows['resolution'][0])}"
        hover = tuple(
            f"{title}\n{fmt.with_unit(load, along.unit)}\nerror {fmt.signed_error(value)}"
            for load, value in zip(loads, error, strict=True)
        )
        size = max(style.size - 1, 7)
        whole = Series(style, loads, np.abs(error), hover=hover, size=size, width=1.5)
        series += [*parted(whole, low), *sign_marks(whole, error, low, high)]
    upright = with_foot(error_axis(low, high, "relative error", row.label), series)
    loads = np.concatenate([scene.compared_along(rows) for rows in tables.values()])
    equal = scene.along
    if equal in NORMAL:
        equal = {"force": "penetration", "penetration": "force"}.get(name, equal)
    # The bar of the reference, from the method with most steps.
    column = f"reference_uncertainty_{name}"
    known = [np.isfinite(rows[column]).sum() for rows in tables.values()]
    longest = list(tables.values())[int(np.argmax(known))]
    bars = longest[column]
    bars = np.where(bars > low, bars, np.nan)
    places = scene.compared_along(longest)
    floor = Band(places, np.full(len(places), low), bars, label=TRUTH_BAR)
    # failed load steps: crosses at the upper edge, with the reason on hover
    lost: dict[str, dict[float, list[str]]] = {}
    for item in scene.failures:
        if np.isfinite(item.load):
            lost.setdefault(item.method, {}).setdefault(item.load, []).append(refusal(scene, item))
    return Figure(
        f"error-{name}",
        f"Error of {row.label} at equal {quantity(equal).label}",
        f"{CAPTION} {PATH_CAPTION}" if scene.is_path else CAPTION,
        value_axis(scene.along, loads, wants_log(loads) and not scene.is_path),
        upright,
        (
            *series,
            *_decided(scene, name, tables, low),
            *(
                failed(look(method, scene), reasons, high, map("\n".join, reasons.values()))
                for method, reasons in lost.items()
            ),
        ),
        (floor,) if np.isfinite(bars).any() else (),
        (tolerance_line(scene.tolerance),),
        quantity=name,
    )


def _decided(scene: SceneRecord, name: str, tables: dict[str, Rows], low: float) -> list[Series]:
    """Return a ring around the error that decided, for the method that the page leads with."""
    method = scene.judged_methods[0]
    verdict = next((v for v in scene.verdicts_on(method) if v.quantity == name), None)
    if verdict is None or verdict.step < 0 or method not in tables:
        return []
    rows = tables[method]
    rows = rows.where(rows["step"] == verdict.step)
    loads = scene.compared_along(rows)
    size = np.maximum(np.abs(rows[f"error_{name}"]), low)
    style = replace(look(method), label="decided here", marker=CIRCLE, colour=INK)
    hover = (f"{verdict.text}\n{verdict.because}: {verdict.word}",) * len(loads)
    return [Series(style, loads, size, line=False, hollow=True, size=16, hover=hover)]


def _with_premise(scene: SceneRecord, figures: list[Figure]) -> list[Figure]:
    """Shade the loads at which the premise of rough lines has ended, and list their area's errors.

    At a tenth of the apparent area, by the reference; no mark in scenes without rough lines.
    """
    method, level = scene.reference.method, scene.reference.resolution
    line, truth = scene.curve(MODEL), scene.curve(method, level)
    if not len(truth) or not np.isfinite(line["contact_length"]).any():
        return figures
    size = scene.load_fields(method, level).get("size")
    if size is None or scene.control not in NORMAL or scene.is_path:
        return figures
    loads = scene.compared_along(truth)
    share = truth["contact_area"] / float(np.prod(size))
    known = np.isfinite(share) & (share > 0)
    if not known.any() or np.nanmax(share) <= PREMISE:
        return figures
    inside = (known & (share <= PREMISE)).any()
    where = float(at_equal(np.array([PREMISE]), share, loads)[0] if inside else loads[known].min())
    text = f"A = {PREMISE:g} A\N{SUBSCRIPT ZERO}"
    caption = (
        f"Dark: real contact area A above {fmt.tolerance(PREMISE)} of the apparent one, where the "
        "premise of rough lines has ended."
    )
    errors = line["error_contact_area"]
    if len(errors) == len(share) and np.isfinite(errors).any():
        by_load = ", ".join(
            f"{fmt.signed_error(error)} at {fmt.relative(part)}"
            for error, part in zip(errors, share, strict=True)
        )
        caption += f" Error of the area of the lines at A/A\N{SUBSCRIPT ZERO}: {by_load}."
    return [
        replace(
            figure,
            caption=f"{figure.caption} {caption}",
            guides=(Guide(where, text),),
            stretches=(Stretch(where, float(np.nanmax(loads)), INK, text),),
        )
        for figure in figures
    ]
