"""Error plots: the errors of the compared quantities at every load step, and along a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import NORMAL, in_order, quantity
from comparisons.judging.metrics import at_equal
from comparisons.results.record import SceneRecord
from comparisons.results.rows import Rows
from reports.plots.axes import (
    FOOT_NOTE,
    SIGN_NOTE,
    error_axis,
    error_range,
    failed,
    key_words,
    padded,
    parted,
    refusal,
    sign_marks,
    tolerance_line,
    value_axis,
    wants_log,
    with_foot,
)
from reports.plots.curves import TRUTH_BAR
from reports.plots.figure import Axis, Band, Figure, Guide, Series, Stretch
from reports.plots.style import CIRCLE, INK, drawing_order, look

CAPTION = (
    "Each method at its finest resolution. Shaded: below the bar of the reference, where an error "
    f"is not resolved. Ring: the error that decided. {SIGN_NOTE} {FOOT_NOTE}"
)
PATH_CAPTION = "Errors are relative to the largest value of the path, as values may be zero."
SWEEP_CAPTION = (
    "Largest error over the loads of each scene, of each method at its finest resolution, with its "
    f"bar. {SIGN_NOTE} {FOOT_NOTE}"
)
MOST_TICKS = 10
PREMISE = 0.1  # of the apparent area: rough lines are for real contact areas far below


def errors(scene: SceneRecord) -> list[Figure]:
    """Return the error magnitude of each compared quantity at every load step, on one scale.

    None of a single load: its values and errors are in a table.
    """
    if scene.of_one_load:
        return []
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
        title = style.at(rows["resolution"][0])
        hover = tuple(
            f"{title}\n{fmt.with_unit(load, along.unit)}\nerror {fmt.signed_error(value)}"
            for load, value in zip(loads, error, strict=True)
        )
        size = max(style.size - 1, 7)
        whole = Series(style, loads, np.abs(error), hover=hover, size=size, width=1.5)
        series += [*parted(whole, low), *sign_marks(whole, error, low, high)]
    upright = with_foot(error_axis(low, high, "relative error", row.label), series)
    loads = np.concatenate([scene.compared_along(rows) for rows in tables.values()])
    # The bar of the reference, from the method with most steps.
    column = f"reference_uncertainty_{name}"
    known = [np.isfinite(rows[column]).sum() for rows in tables.values()]
    longest = list(tables.values())[int(np.argmax(known))]
    bars = longest[column]
    bars = np.where(bars > low, bars, np.nan)
    places = scene.compared_along(longest)
    floor = Band(places, np.full(len(places), low), bars, label=TRUTH_BAR)
    # a ring around the error that decided, for the method that the page leads with
    leading = scene.judged_methods[0]
    verdict = next((v for v in scene.verdicts_on(leading) if v.quantity == name), None)
    if verdict and verdict.step >= 0 and leading in tables:
        rows = tables[leading]
        rows = rows.where(rows["step"] == verdict.step)
        at = scene.compared_along(rows), np.maximum(np.abs(rows[f"error_{name}"]), low)
        style = replace(look(leading), label="decided here", marker=CIRCLE, colour=INK)
        hover = (f"{verdict.text}\n{verdict.because}: {verdict.word}",) * len(at[0])
        series.append(Series(style, *at, line=False, hollow=True, size=16, hover=hover))
    # failed load steps: crosses at the upper edge, with the reason on hover
    lost: dict[str, dict[float, list[str]]] = {}
    for item in scene.failures:
        if np.isfinite(item.load):
            lost.setdefault(item.method, {}).setdefault(item.load, []).append(refusal(scene, item))
    return Figure(
        f"error-{name}",
        f"Error of {row.label} at equal {quantity(scene.equal_at(name)).label}",
        f"{CAPTION} {PATH_CAPTION}" if scene.is_path else CAPTION,
        value_axis(scene.along, loads, wants_log(loads) and not scene.is_path),
        upright,
        (
            *series,
            *(
                failed(look(method, scene), reasons, high, map("\n".join, reasons.values()))
                for method, reasons in lost.items()
            ),
        ),
        (floor,) if np.isfinite(bars).any() else (),
        (tolerance_line(scene.tolerance),),
        quantity=name,
    )


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


def sweeps(scenes: Sequence[SceneRecord]) -> list[Figure]:
    """Return a figure for each quantity of each key that scenes of a study are swept along."""
    swept: dict[str, list[SceneRecord]] = {}
    for scene in scenes:
        table = scene.tables.get("sweep")
        for path in table if isinstance(table, dict) else ():
            swept.setdefault(path, []).append(scene)
    return [
        figure
        for path, members in swept.items()
        if len(members) > 1
        for name in in_order({name for scene in members for name in scene.quantities})
        if (figure := _along(path, members, name)) is not None
    ]


def _along(path: str, scenes: list[SceneRecord], name: str) -> Figure | None:
    """Return the errors of one quantity along a key."""
    # The numbers at the key, in SI units; NaN where there is something else.
    places = np.full(len(scenes), np.nan)
    for place, scene in enumerate(scenes):
        value: Any = scene.tables
        for key in path.split("."):
            value = value.get(key) if isinstance(value, dict) else None
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            places[place] = value
    words = key_words(path.split(".")[-1])
    texts = [str(scene.tables["sweep"][path]) for scene in scenes]
    words_only = not np.isfinite(places).all()
    if words_only:  # one after the other, and nothing between them
        places = np.arange(1.0, len(scenes) + 1)
    order = np.argsort(places)
    log = wants_log(places) and not words_only
    marked = order[:: -(-len(order) // MOST_TICKS)]
    ticks = tuple((float(places[k]), texts[k]) for k in marked)
    limits = padded(places, 0.06, 0.05) if log else None
    if words_only:
        limits = (0.5, len(scenes) + 0.5)
    axis = Axis(words, log=log, limits=limits, ticks=ticks)
    known = {
        method: [
            next(v for v in scene.verdicts_on(method) if v.quantity == name) for scene in scenes
        ]
        for method in drawing_order(dict.fromkeys(m for scene in scenes for m in scene.methods))
        if all(name in scene.quantities for scene in scenes)
    }
    errors = {method: np.array([v.error for v in found]) for method, found in known.items()}
    sizes = np.abs(np.concatenate([np.empty(0), *errors.values()]))
    if not np.isfinite(sizes).any():
        return None
    tolerances = sorted({scene.tolerance for scene in scenes})
    ranges = [error_range(sizes[np.isfinite(sizes)], tolerance) for tolerance in tolerances]
    (low, _), (_, high) = ranges[0], ranges[-1]
    series: list[Series] = []
    for method, error in errors.items():
        if not np.isfinite(error).any():
            continue
        style = look(method, scenes[0])
        hover = tuple(
            f"{style.label}, {scene.name}\n{verdict.text}: {verdict.word}"
            for scene, verdict in zip(scenes, known[method], strict=True)
        )
        bars = np.array([verdict.uncertainty for verdict in known[method]])
        whole = Series(
            *(style, places[order], np.abs(error)[order]),
            line=not words_only,
            bars=bars[order],
            hover=tuple(hover[k] for k in order),
        )
        series += [*parted(whole, low), *sign_marks(whole, error[order], low, high)]
    label = quantity(name).label
    return Figure(
        f"sweep-{path.replace('.', '-')}-{name}",
        f"Error of {label} over {words}",
        SWEEP_CAPTION,
        axis,
        with_foot(error_axis(low, high, "relative error", label), series),
        tuple(series),
        levels=tuple(map(tolerance_line, tolerances)),
        quantity=name,
    )
