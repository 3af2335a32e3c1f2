"""Speed against error: the cost of a given accuracy with each method."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import QUANTITIES, quantity
from comparisons.judging.metrics import front
from comparisons.results import selection
from comparisons.results.advice import ITSELF
from comparisons.results.cost import cost
from comparisons.results.decisions import equal_at
from comparisons.results.store import SceneRecord
from reports.plots.axes import error_axis, error_range, padded, time_axis, tolerance_line
from reports.plots.curves import TRUTH_BAR
from reports.plots.errors import failed, refusal
from reports.plots.figure import Band, Figure, Guide, Series
from reports.plots.gutter import parted, with_foot
from reports.plots.signs import NOTE as SIGNS
from reports.plots.signs import sign_marks
from reports.plots.style import DASHED, MUTED, Look, drawing_order, look

GUIDES = (Guide(1e-3, "1 ms"), Guide(1.0, "1 s"), Guide(60.0, "1 min"))
PLOTTED = (
    *("resolution", "maximum", "error", "uncertainty", "rms", "unknowns"),
    *("seconds", "setup_seconds", "single_seconds", "surfaces", "single_low", "single_high"),
)
FRONT = Look("Pareto front", MUTED, dash=DASHED)
CAPTION = (
    "Largest relative error over all load steps against the time for the whole scene; lower left "
    "is better. One marker per resolution N; hollow: {hollow}. Dashed: Pareto front, which ends at "
    "the bar of the reference (shaded). Horizontal line: tolerance. "
    f"{SIGNS} Large arrows: at or below the bar, or the foot. {ITSELF}."
)
REUSED = "without the set-up, which other loads could reuse"
SINGLE = (
    "one line or surface, at the larger end of the band that 90 % of single errors lie in; filled: "
    "the mean, with the time of all solves that it stands on"
)


def speed(scene: SceneRecord) -> list[Figure]:
    """Return error against time, one figure per compared quantity."""
    timed = {key: points for key, points in timed_points(scene).items() if not points.empty}
    ends = ("maximum", "single_low", "single_high")
    sizes = [np.abs(selection.column(points, end)) for points in timed.values() for end in ends]
    if not sizes:
        return []
    limits = error_range(np.concatenate(sizes), scene.tolerance)
    return [_figure(scene, points, limits, *key) for key, points in timed.items()]


def timed_points(scene: SceneRecord) -> dict[tuple[str, str], pd.DataFrame]:
    """Return (quantity, equal load) -> one row per setting with its error and time.

    The reference is left out. The load held equal is the one used for the verdicts.
    """
    table = selection.compared_measures(scene)
    at = np.array(selection.texts(table, "at"))
    points = {}
    for name in dict.fromkeys(str(entry) for entry in table["quantity"]):
        judged = (table["quantity"] == name).to_numpy() & (at == equal_at(scene, name))
        points[name, equal_at(scene, name)] = _timed(scene, table[judged])
    return points


def _timed(scene: SceneRecord, part: pd.DataFrame) -> pd.DataFrame:
    settings = list(zip(part["method"], selection.column(part, "resolution"), strict=True))
    costs = [cost(scene, *setting) for setting in settings]
    names = ("seconds", "setup_seconds", "single_seconds", "surfaces")
    part = part.assign(**{name: [float(getattr(c, name)) for c in costs] for name in names})
    drawn = np.isfinite(selection.column(part, "seconds") + selection.column(part, "maximum"))
    return part[drawn & [not selection.is_reference(scene, *setting) for setting in settings]]


def _figure(
    scene: SceneRecord, points: pd.DataFrame, limits: tuple[float, float], name: str, at: str
) -> Figure:
    times, sizes = (selection.column(points, key) for key in ("seconds", "maximum"))
    low, high = limits
    span = time_range(scene, points)
    bar = _truth_bar(scene, name, points)
    known_to = max(low, bar)
    sizes = np.maximum(sizes, known_to)
    corners = front(times, sizes)
    along, reached = times[corners], sizes[corners]
    if reached[-1] > known_to:
        along, reached = np.append(along, span[1]), np.append(reached, reached[-1])
    best = Series(FRONT, along, reached, marks=False, width=1.5, stairs=True)
    series = [*_reference_mark(scene, span, bar, low), best]
    for method, settings in _by_method(points).items():
        for whole in _method_series(scene, method, settings, bar):
            series += parted(whole, known_to)
        series += sign_marks(whole, settings["error"], known_to, high)
    several = bool((selection.column(points, "surfaces") > 1).any())
    equal = f" at equal {quantity(at).label}" if at in QUANTITIES else ""
    floor = Band(np.array(span), np.full(2, low), np.full(2, bar), label=TRUTH_BAR)
    return Figure(
        f"speed-{name}",
        f"Error of {quantity(name).label}{equal}",
        CAPTION.format(hollow=SINGLE if several else REUSED),
        time_axis("time for the whole scene", span),
        with_foot(error_axis(low, high, "largest error", quantity(name).label), series),
        (*series, *_failures(scene, span, high)),
        (floor,) if bar > low else (),
        (tolerance_line(scene.tolerance),),
        tuple(guide for guide in GUIDES if span[0] < guide.value < span[1]),
        quantity=name,
    )


def time_range(scene: SceneRecord, points: pd.DataFrame) -> tuple[float, float]:
    """Return the limits of a time axis that shows every solve."""
    lost = [item.seconds for item in selection.failures(scene)]
    total, single = (selection.column(points, key) for key in ("seconds", "single_seconds"))
    solve_times = total - np.nan_to_num(selection.column(points, "setup_seconds"))
    times = np.concatenate([total, single, solve_times, lost, [_reference_cost(scene)]])
    times = times[np.isfinite(times) & (times > 0)]
    return padded(times, 0.06, 0.3) if len(times) else (1e-3, 1.0)


def _by_method(points: pd.DataFrame) -> dict[str, dict[str, np.ndarray]]:
    """Return the plotted columns of each method, coarse to fine, as plain arrays.

    A page asks hundreds of times, and a table of pandas takes ten times as long to be parted.
    """
    columns = {name: selection.column(points, name) for name in PLOTTED}
    names = np.array(selection.texts(points, "method"), dtype=object)
    order = np.argsort(columns["resolution"], kind="stable")
    return {
        method: {name: values[order][names[order] == method] for name, values in columns.items()}
        for method in drawing_order(dict.fromkeys(names))
    }


def _method_series(
    scene: SceneRecord, method: str, settings: dict[str, np.ndarray], bar: float
) -> list[Series]:
    """Return the settings of a method, filled, and hollow its single surfaces or the bare solves.

    The reference is known to `bar`.
    """
    style = look(method, scene)
    if method == selection.reference(scene)[0]:
        style = style.labelled(f"{style.label}*")
    total, errors = settings["seconds"], settings["maximum"]
    setup = np.nan_to_num(settings["setup_seconds"])
    rows = [dict(zip(settings, row, strict=True)) for row in zip(*settings.values(), strict=True)]
    shared: dict[str, Any] = {"group": method, "width": 1.5}
    hover = tuple(_hover(style.label, row, bar) for row in rows)
    filled = Series(style, total, errors, size=9, hover=hover, **shared)
    shared |= {"line": False, "hollow": True, "size": 8}
    if (settings["surfaces"] > 1).any():
        ends = np.fmax(np.abs(settings["single_low"]), np.abs(settings["single_high"]))
        single = style.labelled(f"{style.label}, one")
        shared |= {
            "legend": method == MODEL,
            "hover": tuple(_single_hover(style.label, row) for row in rows),
        }
        return [Series(single, settings["single_seconds"], ends, **shared), filled]
    if not (setup > 0).any():
        return [filled]
    solve_times = np.where((setup > 0) & (total > setup), total - setup, np.nan)
    renamed = style.labelled(f"{style.label}, without set-up")
    return [Series(renamed, solve_times, errors, legend=False, hover=hover, **shared), filled]


def _hover(label: str, row: dict[str, float], bar: float) -> str:
    signed = np.isfinite(row["error"])
    error = fmt.plus_minus(row["error" if signed else "maximum"], row["uncertainty"], signed=signed)
    if row["maximum"] <= bar:
        error = f"≤ {fmt.relative(bar)}, the bar of the reference: {error}"
    several = f" of {fmt.count(row['surfaces'])} at this N" if row["surfaces"] > 1 else ""
    return "\n".join(
        [
            f"{label}, N = {fmt.count(row['resolution'])}{several}",
            f"largest error {error}",
            f"rms {fmt.relative(row['rms'])}",
            f"time {fmt.duration(row['seconds'])}, "
            f"of which set-up {fmt.duration(row['setup_seconds'])}",
            f"unknowns {fmt.count(row['unknowns'])}",
        ]
    )


def _single_hover(label: str, row: dict[str, float]) -> str:
    return (
        f"{label}, N = {fmt.count(row['resolution'])}: one of {fmt.count(row['surfaces'])}\n"
        f"90 % err within {fmt.between(row['single_low'], row['single_high'])}\n"
        f"time {fmt.duration(row['single_seconds'])}"
    )


def _truth_bar(scene: SceneRecord, name: str, points: pd.DataFrame) -> float:
    """Return the bar of the reference, or else the widest bar of the settings."""
    bar = (scene.reference.get("uncertainty") or {}).get(name)
    if fmt.finite(bar):
        return float(bar)
    bars = selection.column(points, "uncertainty")
    return float(np.nanmax(bars)) if np.isfinite(bars).any() else 0.0


def _reference_mark(
    scene: SceneRecord, span: tuple[float, float], bar: float, low: float
) -> list[Series]:
    """Mark the cost of the reference at its own error bar."""
    method, level = selection.reference(scene)
    seconds = _reference_cost(scene)
    if bar <= low or not span[0] < seconds < span[1]:
        return []
    style = look(method, scene)
    text = (
        f"the reference, N = {fmt.count(level)}: {fmt.duration(seconds)}, "
        f"known to {fmt.relative(bar)}"
    )
    renamed = style.labelled(f"reference ({style.label})")
    place = np.array([seconds]), np.array([bar])
    return [Series(renamed, *place, line=False, outlined=True, size=9, hover=(text,))]


def _reference_cost(scene: SceneRecord) -> float:
    """Return the time of the reference, NaN if unknown."""
    return cost(scene, *selection.reference(scene)).seconds


def _failures(scene: SceneRecord, span: tuple[float, float], high: float) -> list[Series]:
    """Return crosses at the top: at the time of the failure if known, else at the right edge."""
    # One cross per setting: the load steps it lost all cost the same time.
    lost = {(item.method, item.resolution): item for item in selection.failures(scene)}
    unplaced, places = 0, {}
    for key, item in lost.items():
        if np.isfinite(item.seconds) and span[0] < item.seconds < span[1]:
            places[key] = item.seconds
        else:
            places[key] = span[1] / (span[1] / span[0]) ** (0.04 * unplaced)
            unplaced += 1
    return [
        failed(
            look(method, scene),
            [places[key] for key in lost if key[0] == method],
            high,
            [refusal(scene, item) for key, item in lost.items() if key[0] == method],
        )
        for method in dict.fromkeys(item.method for item in lost.values())
    ]
