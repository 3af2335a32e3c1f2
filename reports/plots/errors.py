"""Error plots: the errors of the compared quantities at every load step."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import NORMAL, quantity
from comparisons.judging.metrics import at_equal
from comparisons.results import selection
from comparisons.results.decisions import finest, judged_methods, verdicts
from comparisons.results.store import SceneRecord
from reports.plots.axes import error_axis, error_range, tolerance_line, value_axis, wants_log
from reports.plots.curves import TRUTH_BAR
from reports.plots.figure import Band, Figure, Guide, Series, Stretch
from reports.plots.gutter import NOTE, parted, with_foot
from reports.plots.signs import NOTE as SIGNS
from reports.plots.signs import sign_marks
from reports.plots.style import CIRCLE, CROSS, INK, Look, drawing_order, look

CAPTION = (
    "Each method at its finest resolution. Horizontal line: tolerance. Shaded: below the "
    "uncertainty of the reference, where an error is not resolved. Ring: the error that decided. "
    f"{SIGNS} {NOTE}"
)
# The procedure of rough lines is for real contact areas far below the apparent one, A0.
PREMISE = 0.1
PATH_CAPTION = "Errors are relative to the largest value along the path, which passes through zero."


def errors(scene: SceneRecord) -> list[Figure]:
    """Return the error magnitude of each compared quantity at every load step, on one scale."""
    tables = {name: _tables(scene, name) for name in scene.quantities}
    sizes = [
        np.abs(selection.column(rows, f"error_{name}"))
        for name, by_method in tables.items()
        for rows in by_method.values()
    ]
    if not sizes:
        return []
    limits = error_range(np.concatenate(sizes), scene.tolerance)
    figures = [_figure(scene, name, drawn, limits) for name, drawn in tables.items() if drawn]
    return _with_premise(scene, figures)


def _figure(
    scene: SceneRecord, name: str, tables: dict[str, pd.DataFrame], limits: tuple[float, float]
) -> Figure:
    low, high = limits
    loads = np.concatenate([selection.compared_along(scene, rows) for rows in tables.values()])
    log = wants_log(loads) and not scene.is_path
    series = [
        part
        for method, rows in tables.items()
        for whole in (_series(scene, method, rows, name),)
        for part in (
            *parted(whole, low),
            *sign_marks(whole, selection.column(rows, f"error_{name}"), low, high),
        )
    ]
    upright = error_axis(low, high, "relative error", quantity(name).label)
    return Figure(
        f"error-{name}",
        f"Error of {quantity(name).label} at equal {_equal(scene, name)}",
        f"{CAPTION} {PATH_CAPTION}" if scene.is_path else CAPTION,
        value_axis(scene.along, loads, log),
        with_foot(upright, series),
        (*series, *_decided(scene, name, tables, low), *_lost_steps(scene, high)),
        _floor(scene, tables, name, low),
        (tolerance_line(scene.tolerance),),
        quantity=name,
    )


def _with_premise(scene: SceneRecord, figures: list[Figure]) -> list[Figure]:
    """Shade the loads at which the premise of rough lines has ended, and list their area's errors.

    At a tenth of the apparent area, by the reference; no mark in scenes without rough lines.
    """
    line = selection.curve(scene, MODEL)
    truth = selection.curve(scene, *selection.reference(scene))
    if truth.empty or not np.isfinite(selection.column(line, "contact_length")).any():
        return figures
    method, level = selection.reference(scene)
    size = scene.load_fields(method, int(level)).get("size")
    if size is None or scene.control not in NORMAL or scene.is_path:
        return figures
    loads = selection.compared_along(scene, truth)
    share = selection.column(truth, "contact_area") / float(np.prod(size))
    errors = selection.column(line, "error_contact_area")
    known = np.isfinite(share) & (share > 0)
    if not known.any() or np.nanmax(share) <= PREMISE:
        return figures
    inside = known & (share <= PREMISE)
    where = at_equal(np.array([PREMISE]), share, loads)[0] if inside.any() else loads[known].min()
    text = f"A = {PREMISE:g} A\N{SUBSCRIPT ZERO}"
    caption = (
        f"Dark: real contact area A above {fmt.tolerance(PREMISE)} of the apparent one, where the "
        "premise of rough lines has ended."
    )
    if len(errors) == len(share) and np.isfinite(errors).any():
        by_load = (
            f"{fmt.signed_error(error)} at {fmt.relative(part)}"
            for error, part in zip(errors, share, strict=True)
        )
        caption += (
            f" Error of the area of the lines at A/A\N{SUBSCRIPT ZERO}: {', '.join(by_load)}."
        )
    beyond = Stretch(float(where), float(np.nanmax(loads)), INK, text)
    return [
        replace(
            figure,
            caption=f"{figure.caption} {caption}",
            guides=(Guide(float(where), text),),
            stretches=(beyond,),
        )
        for figure in figures
    ]


def _equal(scene: SceneRecord, name: str) -> str:
    equal = scene.along
    if equal in NORMAL:
        equal = {"force": "penetration", "penetration": "force"}.get(name, equal)
    return quantity(equal).label


def _tables(scene: SceneRecord, name: str) -> dict[str, pd.DataFrame]:
    """Return the load steps of each method at its finest resolution with errors of a quantity."""
    tables = {}
    for method in drawing_order(selection.methods(scene)):
        level = finest(scene, method)
        rows = pd.DataFrame() if level is None else selection.curve(scene, method, level)
        if np.isfinite(selection.column(rows, f"error_{name}")).any():
            tables[method] = rows
    return tables


def _floor(
    scene: SceneRecord, tables: dict[str, pd.DataFrame], name: str, low: float
) -> tuple[Band, ...]:
    """Shade the region below the reference's uncertainty (of the method with most steps)."""
    column = f"reference_uncertainty_{name}"
    rows = max(tables.values(), key=lambda rows: np.isfinite(selection.column(rows, column)).sum())
    bars = selection.column(rows, column)
    bars = np.where(bars > low, bars, np.nan)
    if not np.isfinite(bars).any():
        return ()
    loads = selection.compared_along(scene, rows)
    return (Band(loads, np.full(len(loads), low), bars, label=TRUTH_BAR),)


def _series(scene: SceneRecord, method: str, rows: pd.DataFrame, name: str) -> Series:
    style, error = look(method, scene), selection.column(rows, f"error_{name}")
    loads, unit = selection.compared_along(scene, rows), quantity(scene.along).unit
    level = fmt.count(selection.column(rows, "resolution")[0])
    texts = (
        f"{style.label}, N = {level}\n{fmt.with_unit(load, unit)}\nerror {fmt.signed_error(value)}"
        for load, value in zip(loads, error, strict=True)
    )
    return Series(
        *(style, loads, np.abs(error)),
        hover=tuple(texts),
        size=max(style.size - 1, 7),
        width=1.5,
    )


def _decided(
    scene: SceneRecord, name: str, tables: dict[str, pd.DataFrame], low: float
) -> list[Series]:
    """Return a ring around the error that decided, for the method that the page leads with."""
    method = judged_methods(scene)[0]
    known = {verdict.quantity: verdict for verdict in verdicts(scene, method)}
    verdict = known.get(name)
    if verdict is None or verdict.step < 0 or method not in tables:
        return []
    rows = tables[method]
    rows = rows[selection.column(rows, "step") == verdict.step]
    loads = selection.compared_along(scene, rows)
    size = np.maximum(np.abs(selection.column(rows, f"error_{name}")), low)
    style = replace(look(method), label="decided here", marker=CIRCLE, colour=INK)
    text = f"{verdict.text}\n{verdict.because}: {verdict.word}"
    return [
        Series(style, loads, size, line=False, hollow=True, size=16, hover=(text,) * len(loads))
    ]


def _lost_steps(scene: SceneRecord, high: float) -> list[Series]:
    """Return failed load steps: hollow crosses at the upper edge, with the reason on hover."""
    lost: dict[str, dict[float, list[str]]] = {}
    for item in selection.failures(scene):
        if np.isfinite(item.load):
            lost.setdefault(item.method, {}).setdefault(item.load, []).append(refusal(scene, item))
    return [
        failed(look(method, scene), reasons, high, ["\n".join(texts) for texts in reasons.values()])
        for method, reasons in lost.items()
    ]


def failed(style: Look, x: Iterable[float], edge: float, reasons: list[str]) -> Series:
    """Return crosses at the upper edge of a plot."""
    places = np.array(list(x), dtype=float)
    return Series(
        replace(style, label=f"{style.label}: failed", marker=CROSS, size=11),
        places,
        # A hair inside: rounding in the logarithm must not push them out of the plot.
        np.full(len(places), 0.995 * edge),
        line=False,
        hollow=True,
        hover=tuple(reasons),
    )


def refusal(scene: SceneRecord, item: selection.Failure) -> str:
    """Return the setting and the reason of a failure."""
    return f"{look(item.method, scene).label}, N = {fmt.count(item.resolution)}: {item.reason}"
