"""Speed against error: the cost of a given accuracy with each method, of one scene and of all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import QUANTITIES, quantity
from comparisons.judging.metrics import front
from comparisons.judging.verdicts import NO_RESULT, Verdict
from comparisons.results.advice import ITSELF, Setting, advise
from comparisons.results.record import Cost, Failure, SceneRecord
from reports.plots.axes import (
    DOWN,
    SIGN_NOTE,
    error_axis,
    error_range,
    failed,
    log_axis,
    padded,
    parted,
    refusal,
    sign_marks,
    time_axis,
    tolerance_line,
    with_foot,
)
from reports.plots.curves import TRUTH_BAR
from reports.plots.figure import Band, Figure, Guide, Level, Series
from reports.plots.style import DASHED, MUTED, Look, drawing_order, look

GUIDES = (Guide(1e-3, "1 ms"), Guide(1.0, "1 s"), Guide(60.0, "1 min"))
FRONT = Look("Pareto front", MUTED, dash=DASHED)
CAPTION = (
    "Largest relative error over all loads against the time for all; lower left is better. "
    "One marker per resolution N."
)
REUSED = "Hollow: without the set-up, which other loads could reuse."
SINGLE = (
    "Hollow: one line or surface, at the larger end of the band that 90 % of single errors lie in; "
    "filled: the mean, with the time of all solves that it stands on."
)
LOW, HIGH = 1e-3, 1e3  # of error over tolerance: what lies beyond stands at the edge
OVERVIEW_CAPTION = (
    "Every setting of every scene: time against the largest |e| + u over load steps and the "
    "quantities that it gives, over the tolerance. Below the line: within. Arrows at the foot: "
    "at or below it. Click one to open its scene."
)
# The settings of a method for one quantity: the verdict on each, its cost, its unknowns.
Points = list[tuple[Verdict, Cost, float]]


def speed(scene: SceneRecord) -> list[Figure]:
    """Return error against time, one figure per compared quantity.

    Of all settings that have an error and a time, but for the reference, coarse to fine.
    """
    timed: dict[str, Points] = {}
    for item in sorted(scene.verdicts, key=lambda item: item.resolution):
        name = item.quantity
        # The load held equal is the one used for the verdicts.
        judged = name in scene.quantities and item.at == scene.equal_at(name)
        if not judged or item.word == NO_RESULT:
            continue
        spent = scene.cost(item.method, item.resolution)
        if np.isfinite(spent.seconds):
            rows = scene.setting_rows(item.method, item.resolution)
            timed.setdefault(name, []).append((item, spent, float(rows["unknowns"][0])))
    if not timed:
        return []
    # Of each quantity the bar of the reference, or else the widest bar of the settings: errors
    # below it are arrows there, and an axis that went further down would squeeze all others.
    bars = {}
    sizes = []
    for name, points in timed.items():
        known = [v.uncertainty for v, *_ in points if fmt.finite(v.uncertainty)]
        bars[name] = max([*scene.reference.known_to(name)] or known, default=0.0)
        for v, *_ in points:
            sizes.append(np.fmax(np.abs([v.error, v.single_low, v.single_high]), bars[name]))
    limits = error_range(np.concatenate(sizes), scene.tolerance)
    names = [name for name in scene.quantities if name in timed]
    return [_figure(scene, name, timed[name], bars[name], limits) for name in names]


def _figure(
    scene: SceneRecord, name: str, points: Points, bar: float, limits: tuple[float, float]
) -> Figure:
    low, high = limits
    truth, level = scene.reference.method, scene.reference.resolution
    errors = np.array([abs(item.error) for item, *_ in points])
    seconds = np.array([spent.seconds for _, spent, _ in points])
    truth_seconds = scene.cost(truth, level).seconds
    lost = scene.failures
    # Every solve is in the plot: those without their set-up, of one surface, and what failed, too.
    times = [truth_seconds, *seconds, *(item.seconds for item in lost)]
    for _, spent, _ in points:
        times += [spent.single_seconds, spent.seconds - np.nan_to_num(spent.setup_seconds)]
    span = _time_range(np.array(times))
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
    reached = np.maximum(errors, known_to)
    corners = front(seconds, reached)
    along, reached = seconds[corners], reached[corners]
    if reached[-1] > known_to:
        along, reached = np.append(along, span[1]), np.append(reached, reached[-1])
    if len(along) > 1:  # one setting that is best in both is no line
        series.append(Series(FRONT, along, reached, marks=False, width=1.5, stairs=True))
    arrows: list[Series] = []
    for method in drawing_order(dict.fromkeys(item.method for item, *_ in points)):
        own = [point for point in points if point[0].method == method]
        drawn = _method_series(scene, method, own, bar)
        series += [part for whole in drawn for part in parted(whole, known_to)]
        signed = np.array([item.error if item.signed else np.nan for item, *_ in own])
        arrows += sign_marks(drawn[-1], signed, known_to, high)
    series += arrows
    if (errors <= known_to).any():
        where = Look(f"at or below the {'bar' if bar > low else 'foot'}", MUTED, DOWN)
        nowhere = np.array([np.nan])
        series.append(Series(where, nowhere, nowhere, line=False, size=9))
    several = any(spent.surfaces > 1 for _, spent, _ in points)
    hollow = any((item.hollow & np.isfinite(item.x * item.y)).any() for item in series)
    caption = CAPTION
    caption += f" {SINGLE if several else REUSED}" if hollow else ""
    caption += " Shaded: below the bar of the reference." if bar > low else ""
    caption += f" {SIGN_NOTE}" if arrows else ""
    caption += f" {ITSELF}." if truth in {item.method for item, *_ in points} else ""
    at_equal = scene.equal_at(name)
    equal = f" at equal {quantity(at_equal).label}" if at_equal in QUANTITIES else ""
    floor = Band(np.array(span), np.full(2, low), np.full(2, bar), label=TRUTH_BAR)
    return Figure(
        f"speed-{name}",
        f"Error of {quantity(name).label}{equal}",
        caption,
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


def _method_series(scene: SceneRecord, method: str, points: Points, bar: float) -> list[Series]:
    """Return the hollow single surfaces or bare solves of a method, if any, then its settings.

    The reference is known to `bar`.
    """
    style = look(method, scene)
    if method == scene.reference.method:
        style = style.labelled(f"{style.label}*")
    texts, singles = [], []
    for item, spent, unknowns in points:
        at, count = style.at(item.resolution), fmt.count(spent.surfaces)
        error = item.number
        if abs(item.error) <= bar:
            error = f"≤ {fmt.relative(bar)}, the bar of the reference: {error}"
        texts.append(
            f"{at}{f' of {count} at this N' if spent.surfaces > 1 else ''}\n"
            f"largest error {error}\n"
            f"rms {fmt.relative(item.rms)}\n"
            f"time {fmt.duration(spent.seconds)}, "
            f"of which set-up {fmt.duration(spent.setup_seconds)}\n"
            f"unknowns {fmt.count(unknowns)}"
        )
        singles.append(
            f"{at}: one of {count}\n"
            f"90 % err by {item.single}\n"
            f"time {fmt.duration(spent.single_seconds)}"
        )
    total, setup, single_seconds = (
        np.array([getattr(spent, name) for _, spent, _ in points])
        for name in ("seconds", "setup_seconds", "single_seconds")
    )
    setup = np.nan_to_num(setup)
    shared: dict[str, Any] = {"group": method, "width": 1.5}
    errors, hover = np.array([abs(item.error) for item, *_ in points]), tuple(texts)
    filled = Series(style, total, errors, size=9, hover=hover, **shared)
    shared |= {"line": False, "hollow": True, "size": 8}
    if any(spent.surfaces > 1 for _, spent, _ in points):
        ends = [np.fmax(abs(item.single_low), abs(item.single_high)) for item, *_ in points]
        single, legend = style.labelled(f"{style.label}, one"), method == MODEL
        shared |= {"legend": legend, "hover": tuple(singles)}
        return [Series(single, single_seconds, np.array(ends), **shared), filled]
    if not (setup > 0).any():
        return [filled]
    solve_times = np.where((setup > 0) & (total > setup), total - setup, np.nan)
    bare = style.labelled(f"{style.label}, without set-up")
    return [Series(bare, solve_times, errors, legend=False, hover=hover, **shared), filled]


def _failures(
    scene: SceneRecord, items: list[Failure], span: tuple[float, float], high: float
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


def overview(scenes: Sequence[SceneRecord]) -> Figure | None:
    """Return the plot of all settings of all scenes, or None.

    Each method has two series, of points and of arrows at the foot, in the order of `places`.
    """
    by_method = _points(scenes)
    if not by_method:
        return None
    times = np.array([item.seconds for items in by_method.values() for *_, item in items])
    span = _time_range(times, 0.05, 0.2)
    series: list[Series] = []
    for method, items in by_method.items():
        title = ", ".join(dict.fromkeys(item.title for *_, item in items))
        style = look(method, scenes[0]).labelled(title)
        own = Series(
            replace(style, size=min(style.size, 8)),
            np.array([setting.seconds for *_, setting in items]),
            np.array([np.clip(_ratio(scene, setting), LOW, HIGH) for *_, scene, setting in items]),
            line=False,
            hover=tuple(
                f"{scene.title}\n{setting.text}\n{setting.deciding.text}: {setting.verdict}"
                for *_, scene, setting in items
            ),
            faint=0.75,
        )
        series += parted(own, LOW, always=True)
    axis = log_axis("largest error / tolerance", (LOW, HIGH))
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


def places(scenes: Sequence[SceneRecord]) -> list[list[tuple[int, int]]]:
    """Return the places (scene, setting) of the points of each method in the page's judgements."""
    return [[(number, place) for number, place, *_ in items] for items in _points(scenes).values()]


def _points(
    scenes: Sequence[SceneRecord],
) -> dict[str, list[tuple[int, int, SceneRecord, Setting]]]:
    """Return the settings of each method that can be drawn, in drawing order."""
    points: dict[str, list[tuple[int, int, SceneRecord, Setting]]] = {}
    for number, scene in enumerate(scenes):
        for place, setting in enumerate(advise(scene).settings):
            if np.isfinite(_ratio(scene, setting)) and setting.seconds > 0:
                points.setdefault(setting.method, []).append((number, place, scene, setting))
    return {method: points[method] for method in drawing_order(points)}


def _ratio(scene: SceneRecord, setting: Setting) -> float:
    """Return the largest |e| + u over the tolerance in the quantities that a setting gives."""
    known = [item.high for item in setting.counted if item.word != NO_RESULT]
    return float(np.max(known)) / scene.tolerance if known else float("nan")
