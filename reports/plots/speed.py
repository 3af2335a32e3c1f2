"""Speed against error: the cost of a given accuracy with each method, of one scene and of all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import QUANTITIES, quantity
from comparisons.judging.metrics import front
from comparisons.judging.verdicts import NO_RESULT
from comparisons.results import selection
from comparisons.results.advice import ITSELF, Advice, Setting
from comparisons.results.cost import cost
from comparisons.results.decisions import equal_at
from comparisons.results.store import SceneRecord
from reports.plots.axes import (
    error_axis,
    error_range,
    log_axis,
    padded,
    time_axis,
    tolerance_line,
)
from reports.plots.curves import TRUTH_BAR
from reports.plots.figure import Band, Figure, Guide, Level, Series
from reports.plots.marks import SIGN_NOTE, failed, parted, refusal, sign_marks, with_foot
from reports.plots.style import DASHED, MUTED, Look, drawing_order, look

GUIDES = (Guide(1e-3, "1 ms"), Guide(1.0, "1 s"), Guide(60.0, "1 min"))
FRONT = Look("Pareto front", MUTED, dash=DASHED)
CAPTION = (
    "Largest relative error over all load steps against the time for the whole scene; lower left "
    "is better. One marker per resolution N; hollow: {hollow}. Dashed: Pareto front, which ends at "
    "the bar of the reference (shaded). Horizontal line: tolerance. "
    f"{SIGN_NOTE} Large arrows: at or below the bar, or the foot. {ITSELF}."
)
REUSED = "without the set-up, which other loads could reuse"
SINGLE = (
    "one line or surface, at the larger end of the band that 90 % of single errors lie in; filled: "
    "the mean, with the time of all solves that it stands on"
)
LOW, HIGH = 1e-3, 1e3  # of error over tolerance: what lies beyond stands at the edge
OVERVIEW_CAPTION = (
    "Every setting of every scene: time against the largest |e| + u over load steps and the "
    "quantities that it gives, over the tolerance. Below the line: within. Arrows at the foot: "
    "at or below it. Click one to open its scene."
)
# A setting's columns as plain arrays: a table of pandas takes ten times as long to be parted.
Columns = dict[str, np.ndarray]
Scenes = Sequence[tuple[str, SceneRecord, Advice]]


def speed(scene: SceneRecord) -> list[Figure]:
    """Return error against time, one figure per compared quantity."""
    table = selection.compared_measures(scene)
    at = np.array(selection.texts(table, "at"))
    timed: dict[str, Columns] = {}
    for name in dict.fromkeys(str(entry) for entry in table["quantity"]):
        # The load held equal is the one used for the verdicts.
        judged = (table["quantity"] == name).to_numpy() & (at == equal_at(scene, name))
        points = _timed(scene, table[judged])
        if len(points["method"]):
            timed[name] = points
    ends = ("maximum", "single_low", "single_high")
    sizes = [np.abs(points[end]) for points in timed.values() for end in ends]
    if not sizes:
        return []
    limits = error_range(np.concatenate(sizes), scene.tolerance)
    return [_figure(scene, name, points, limits) for name, points in timed.items()]


def _timed(scene: SceneRecord, part: pd.DataFrame) -> Columns:
    """Return the errors and times of all settings that have both, the reference left out."""
    errors = ("resolution", "maximum", "error", "uncertainty", "rms", "unknowns")
    columns = {
        name: selection.column(part, name) for name in (*errors, "single_low", "single_high")
    }
    columns["method"] = np.array(selection.texts(part, "method"), dtype=object)
    settings = list(zip(columns["method"], columns["resolution"], strict=True))
    costs = [cost(scene, *setting) for setting in settings]
    for name in ("seconds", "setup_seconds", "single_seconds", "surfaces"):
        columns[name] = np.array([getattr(c, name) for c in costs], dtype=float)
    drawn = np.isfinite(columns["seconds"] + columns["maximum"])
    drawn &= [not selection.is_reference(scene, *setting) for setting in settings]
    return {name: values[drawn] for name, values in columns.items()}


def _figure(scene: SceneRecord, name: str, points: Columns, limits: tuple[float, float]) -> Figure:
    low, high = limits
    truth, level = selection.reference(scene)
    truth_seconds = cost(scene, truth, level).seconds
    lost = selection.failures(scene)
    # Every solve is in the plot: those without their set-up, of one surface, and what failed, too.
    bare = points["seconds"] - np.nan_to_num(points["setup_seconds"])
    failed_after = [item.seconds for item in lost]
    times = [points["seconds"], points["single_seconds"], bare, failed_after, [truth_seconds]]
    span = _time_range(np.concatenate(times))
    # The bar of the reference, or else the widest bar of the settings.
    bar = (scene.reference.get("uncertainty") or {}).get(name)
    if not fmt.finite(bar):
        bar = np.max(points["uncertainty"][np.isfinite(points["uncertainty"])], initial=0.0)
    bar = float(bar)
    known_to = max(low, bar)
    series: list[Series] = []
    if bar > low and span[0] < truth_seconds < span[1]:
        style = look(truth, scene)
        text = (
            f"the reference, N = {fmt.count(level)}: {fmt.duration(truth_seconds)}, "
            f"known to {fmt.relative(bar)}"
        )
        style = style.labelled(f"reference ({style.label})")
        at = np.array([truth_seconds]), np.array([bar])
        series.append(Series(style, *at, line=False, outlined=True, size=9, hover=(text,)))
    reached = np.maximum(points["maximum"], known_to)
    corners = front(points["seconds"], reached)
    along, reached = points["seconds"][corners], reached[corners]
    if reached[-1] > known_to:
        along, reached = np.append(along, span[1]), np.append(reached, reached[-1])
    series.append(Series(FRONT, along, reached, marks=False, width=1.5, stairs=True))
    order = np.argsort(points["resolution"], kind="stable")
    for method in drawing_order(dict.fromkeys(points["method"])):
        own = order[points["method"][order] == method]
        settings = {key: values[own] for key, values in points.items() if key != "method"}
        drawn = _method_series(scene, method, settings, bar)
        series += [part for whole in drawn for part in parted(whole, known_to)]
        series += sign_marks(drawn[-1], settings["error"], known_to, high)
    several = bool((points["surfaces"] > 1).any())
    at_equal = equal_at(scene, name)
    equal = f" at equal {quantity(at_equal).label}" if at_equal in QUANTITIES else ""
    floor = Band(np.array(span), np.full(2, low), np.full(2, bar), label=TRUTH_BAR)
    return Figure(
        f"speed-{name}",
        f"Error of {quantity(name).label}{equal}",
        CAPTION.format(hollow=SINGLE if several else REUSED),
        time_axis("time for the whole scene", span),
        with_foot(error_axis(low, high, "largest error", quantity(name).label), series),
        (*series, *_failures(scene, lost, span, high)),
        (floor,) if bar > low else (),
        (tolerance_line(scene.tolerance),),
        _guides(span),
        quantity=name,
    )


def _time_range(times: np.ndarray, share: float = 0.06, least: float = 0.3) -> tuple[float, float]:
    times = times[np.isfinite(times) & (times > 0)]
    return padded(times, share, least) if len(times) else (1e-3, 1.0)


def _guides(span: tuple[float, float]) -> tuple[Guide, ...]:
    return tuple(guide for guide in GUIDES if span[0] < guide.value < span[1])


def _method_series(scene: SceneRecord, method: str, settings: Columns, bar: float) -> list[Series]:
    """Return the hollow single surfaces or bare solves of a method, if any, then its settings.

    The reference is known to `bar`.
    """
    style = look(method, scene)
    if method == selection.reference(scene)[0]:
        style = style.labelled(f"{style.label}*")
    total, setup = settings["seconds"], np.nan_to_num(settings["setup_seconds"])
    rows = [dict(zip(settings, row, strict=True)) for row in zip(*settings.values(), strict=True)]
    several = (settings["surfaces"] > 1).any()
    texts, singles = [], []
    for row in rows:
        at = f"{style.label}, N = {fmt.count(row['resolution'])}"
        count = fmt.count(row["surfaces"])
        signed = np.isfinite(row["error"])
        size = row["error"] if signed else row["maximum"]
        error = fmt.plus_minus(size, row["uncertainty"], signed=signed)
        if row["maximum"] <= bar:
            error = f"≤ {fmt.relative(bar)}, the bar of the reference: {error}"
        texts.append(
            f"{at}{f' of {count} at this N' if row['surfaces'] > 1 else ''}\n"
            f"largest error {error}\n"
            f"rms {fmt.relative(row['rms'])}\n"
            f"time {fmt.duration(row['seconds'])}, "
            f"of which set-up {fmt.duration(row['setup_seconds'])}\n"
            f"unknowns {fmt.count(row['unknowns'])}"
        )
        singles.append(
            f"{at}: one of {count}\n"
            f"90 % err within {fmt.between(row['single_low'], row['single_high'])}\n"
            f"time {fmt.duration(row['single_seconds'])}"
        )
    shared: dict[str, Any] = {"group": method, "width": 1.5}
    errors, hover = settings["maximum"], tuple(texts)
    filled = Series(style, total, errors, size=9, hover=hover, **shared)
    shared |= {"line": False, "hollow": True, "size": 8}
    if several:
        ends = np.fmax(np.abs(settings["single_low"]), np.abs(settings["single_high"]))
        single, legend = style.labelled(f"{style.label}, one"), method == MODEL
        shared |= {"legend": legend, "hover": tuple(singles)}
        return [Series(single, settings["single_seconds"], ends, **shared), filled]
    if not (setup > 0).any():
        return [filled]
    solve_times = np.where((setup > 0) & (total > setup), total - setup, np.nan)
    bare = style.labelled(f"{style.label}, without set-up")
    return [Series(bare, solve_times, errors, legend=False, hover=hover, **shared), filled]


def _failures(
    scene: SceneRecord, items: list[selection.Failure], span: tuple[float, float], high: float
) -> list[Series]:
    """Return crosses at the top: at the time of the failure if known, else at the right edge."""
    # One cross per setting: the load steps it lost all cost the same time.
    lost = {(item.method, item.resolution): item for item in items}
    by_method: dict[str, tuple[list[float], list[str]]] = {}
    unplaced = 0
    for item in lost.values():
        place = item.seconds
        if not (np.isfinite(place) and span[0] < place < span[1]):
            place = span[1] / (span[1] / span[0]) ** (0.04 * unplaced)
            unplaced += 1
        places, reasons = by_method.setdefault(item.method, ([], []))
        places.append(place)
        reasons.append(refusal(scene, item))
    return [
        failed(look(method, scene), places, high, reasons)
        for method, (places, reasons) in by_method.items()
    ]


def overview(scenes: Scenes) -> Figure | None:
    """Return the plot of all settings of all scenes (anchor, record, advice), or None.

    Each method has two series, of points and of arrows at the foot, in the order of `places`.
    """
    by_method = _points(scenes)
    if not by_method:
        return None
    times = np.array([item.seconds for items in by_method.values() for *_, item in items])
    span = _time_range(times, 0.05, 0.2)
    series: list[Series] = []
    for method, items in by_method.items():
        style = look(method).labelled(", ".join(dict.fromkeys(item.title for *_, item in items)))
        own = Series(
            replace(style, size=min(style.size, 8)),
            np.array([setting.seconds for *_, setting in items]),
            np.array([np.clip(_ratio(scene, setting), LOW, HIGH) for *_, scene, setting in items]),
            line=False,
            hover=tuple(
                f"{scene.title or scene.name}\n{setting.text}\n"
                f"{setting.deciding.text}: {setting.verdict}"
                for *_, scene, setting in items
            ),
            faint=0.75,
        )
        series += parted(own, LOW, always=True)
    axis = log_axis("largest error / tolerance", (LOW, HIGH), lambda v: fmt.number(v, 1))
    return Figure(
        "overview",
        "All scenes: time against error over tolerance",
        OVERVIEW_CAPTION,
        time_axis("time for the whole scene", span),
        with_foot(axis, series),
        tuple(series),
        levels=(Level(1.0, "asked"),),
        guides=_guides(span),
    )


def places(scenes: Scenes) -> list[list[tuple[int, int]]]:
    """Return the places (scene, setting) of the points of each method in the page's judgements."""
    return [[(number, place) for number, place, *_ in items] for items in _points(scenes).values()]


def _points(scenes: Scenes) -> dict[str, list[tuple[int, int, SceneRecord, Setting]]]:
    """Return the settings of each method that can be drawn, in drawing order."""
    points: dict[str, list[tuple[int, int, SceneRecord, Setting]]] = {}
    for number, (_, scene, advice) in enumerate(scenes):
        for place, setting in enumerate(advice.settings):
            if np.isfinite(_ratio(scene, setting)) and setting.seconds > 0:
                points.setdefault(setting.method, []).append((number, place, scene, setting))
    return {method: points[method] for method in drawing_order(points)}


def _ratio(scene: SceneRecord, setting: Setting) -> float:
    """Return the largest |e| + u over the tolerance in the quantities that a setting gives."""
    known = [item.high for item in setting.counted if item.word != NO_RESULT]
    return float(np.max(known)) / scene.tolerance if known else float("nan")
