"""Load curves: quantities against load, for all methods at their finest resolution.

Figures of a SceneRecord are none if there is no data, so that no page shows an empty plot.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.facts.quantities import FIELDS, NORMAL, quantity
from comparisons.judging.metrics import sizes_along_path
from comparisons.results.measured import computed_curve, force_at, modulus_fits, modulus_sentence
from comparisons.results.record import SceneRecord, once
from reports.plots.axes import value_axis, wants_log
from reports.plots.figure import Axis, Band, Figure, Level, Series
from reports.plots.style import CIRCLE, MUTED, Look, drawing_order, look

if TYPE_CHECKING:
    from comparisons.questions.single import SingleResult

VISIBLE = 2e-3  # of the largest value: a bar thinner than a line of the plot is not drawn
COINCIDES = 0.05  # curves that are closer cannot be told apart
SPREAD = 5.0  # quantities over speeds that spread wider than this take a logarithmic axis
MOST_MEASURED, FITTED_POINTS = 500, 120  # points of a measured curve, and of one fitted to it
TRUTH_BAR = "bar of the reference"
PROVED = "proved interval"


def curves(scene: SceneRecord) -> list[Figure]:
    """Return each quantity against the prescribed load, or against time for a history.

    Before them a measured curve; beside those that coincide their differences from the reference.
    None of a single load: points in empty plots say less than a table.
    """
    if scene.of_one_load and not scene.plan.measured:
        return []
    first = "penetration" if scene.control == "force" else "force"
    names = dict.fromkeys([first, "contact_area", *scene.quantities])
    if scene.control not in NORMAL:
        names = dict.fromkeys(scene.quantities)  # the normal load is held
    if scene.along == "time":
        names = dict.fromkeys([scene.control, *names])  # what is prescribed is seen first
    along = scene.drawn_along
    figures = [measured(scene)]
    for name in names:
        if name != along and name not in FIELDS:
            figures.append(curve(scene, along, name))
            if not quantity(name).single:
                figures.append(difference(scene, along, name))
    return [figure for figure in figures if figure]


def printed_curves(scene: SceneRecord) -> list[Figure]:
    """Return the curves for papers.

    Under normal loads force against penetration and area against force, whichever is prescribed;
    otherwise every quantity along the path, against time or against speed. None of a single load.
    """
    if scene.of_one_load and not scene.plan.measured:
        return []
    if scene.control in NORMAL and not scene.is_path:
        pairs = [("penetration", "force"), ("force", "contact_area")]
    else:
        along = scene.drawn_along
        pairs = [(along, name) for name in scene.quantities if name not in (along, *FIELDS)]
    return [figure for pair in pairs if (figure := curve(scene, *pair))]


def curve(scene: SceneRecord, across: str, up: str) -> Figure | None:
    """Return one quantity against another, with the reference's bar and the ensemble scatter.

    Along a path the points are joined in order, so that hysteresis loops are visible. A quantity
    that has one value for the whole scene is a point for each method.
    """
    drawn = _curves(scene, across, up)
    if not drawn:
        return None
    name = quantity(up)
    if name.single:
        points = []
        for place, item in enumerate(drawn):
            last = np.flatnonzero(np.isfinite(item.series.y))[-1:]
            bars = None if item.series.bars is None else item.series.bars[last]
            x, y = np.array([float(place)]), item.series.y[last]
            points.append(replace(item.series, x=x, y=y, bars=bars, line=False, marks=True))
        names = tuple((float(place), point.look.label) for place, point in enumerate(points))
        return Figure(
            f"curve-{up}",
            fmt.capitalised(quantity(up).label),
            "One value of the whole scene, by each method at its finest resolution.",
            Axis("", limits=(-0.5, len(points) - 0.5), ticks=names),
            value_axis(up, np.concatenate([point.y for point in points]), log=False),
            tuple(points),
            legend=False,
            quantity=up,
        )
    x, y, loads = (
        np.concatenate(part)
        for part in zip(
            *((item.series.x, item.series.y, item.loads) for item in drawn), strict=True
        )
    )
    bands = tuple(band for item in drawn for band in item.bands)
    edges = np.concatenate([np.empty(0), *(edge for b in bands for edge in (b.low, b.high))])
    log = wants_log(loads) and not scene.is_path
    # Load curves are near power laws; what is drawn over speeds need not be.
    upright = log and (scene.control in NORMAL or wants_log(y, SPREAD))
    series = [item.series for item in drawn]
    if scene.along == "step" and len(series[0].x) > 1:
        # A path may cross itself; only the page draws its arrows.
        way = Look("way of the path", MUTED)
        x0, y0 = series[0].x, series[0].y
        series.append(Series(way, x0, y0, line=False, legend=False, size=12, directed=True))
    return Figure(
        f"curve-{up}",
        fmt.capitalised(f"{name.label} against {quantity(across).label}"),
        _caption(scene, up, _apart(drawn)),
        value_axis(across, x, log, edges if up == scene.control else ()),
        value_axis(up, y, upright, () if up == scene.control else edges),
        tuple(series),
        bands,
        quantity=up,
    )


def difference(scene: SceneRecord, across: str, up: str) -> Figure | None:
    """Return a quantity less that of the reference, where its curves coincide; else None.

    Along a path errors are relative to the largest value of it, and have a plot that says so.
    """
    beside = _curves(scene, across, up)
    drawn = [item for item in beside if np.isfinite(item.errors).any()]
    apart = _apart(beside)
    if scene.is_path or not drawn or not fmt.ROUND_OFF < apart < COINCIDES:
        return None
    x = np.concatenate([item.series.x for item in drawn])
    loads = np.concatenate([item.loads for item in drawn])
    bars = drawn[0].truth_bar
    floor = Band(drawn[0].series.x, -bars, bars, label=TRUTH_BAR)
    name = quantity(up)
    scale = fmt.Scale(100.0, "%") if apart >= 1e-4 else fmt.Scale(1e6, "ppm")
    return Figure(
        f"difference-{up}",
        fmt.capitalised(f"{name.label}: relative difference from the reference"),
        "Each method at its finest resolution. Differences are at equal "
        f"{quantity(across).label}; light band, if any: uncertainty of the reference.",
        value_axis(across, x, wants_log(loads)),
        Axis("relative difference", f"Δ{name.symbol}", scale=scale),
        tuple(replace(item.series, y=item.errors, bars=None, marks=True) for item in drawn),
        (floor,) if (bars > fmt.ROUND_OFF).any() else (),
        (Level(0.0),),
        quantity=up,
    )


@dataclass(frozen=True)
class _Curve:
    """The curve of one method: points, bands, and at each point load, error and truth's bar."""

    series: Series
    bands: tuple[Band, ...]
    loads: np.ndarray
    errors: np.ndarray
    truth_bar: np.ndarray


def _apart(drawn: list[_Curve]) -> float:
    """Return how far curves are from the reference at most, relative; NaN where nothing says."""
    known = np.concatenate([np.abs(item.errors) for item in drawn]) if drawn else np.empty(0)
    return float(np.max(known[np.isfinite(known)], initial=0.0)) if len(drawn) > 1 else np.nan


@once
def _curves(scene: SceneRecord, across: str, up: str) -> list[_Curve]:
    """Return the curves of all methods that have one, in drawing order."""
    truth = scene.reference.method
    drawn = []
    for method in drawing_order(scene.methods):
        rows = scene.curve(method)
        x, y = (rows[name] for name in (across, up))
        if not (np.isfinite(x) & np.isfinite(y)).any():
            continue
        # Bars and bands lie along the axis that is not prescribed.
        sideways = up == scene.control
        name, value, along = (across, x, y) if sideways else (up, y, x)
        bar = rows[f"reference_uncertainty_{name}"]
        half = np.full(len(value), np.nan)
        if method == truth:
            half = bar * (sizes_along_path(value) if scene.is_path else np.abs(value))
        visible = np.any(half > VISIBLE * np.nanmax(np.abs(value), initial=0.0))
        resolution = float(rows["resolution"][0])
        exact, style = method == "closed_form", look(method, scene)
        series = Series(
            *(style, x, y),
            marks=not exact,
            bars=half if visible and not sideways else None,
            hover=style.label if exact else style.at(resolution),
        )
        bands = []
        low, high = (rows[f"{name}_{side}"] for side in ("lower", "upper"))
        if np.isfinite(low).any():
            # inside the estimated bar, drawn solid: nothing is estimated about it
            bands.append(Band(along, low, high, opacity=0.9, label=PROVED, sideways=sideways))
        if (half > fmt.ROUND_OFF * np.abs(value)).any():
            low, high = value - half, value + half
            bands.append(Band(along, low, high, label=TRUTH_BAR, sideways=sideways))
        single = scene.realisations(method, resolution)
        # Solvers of the same surfaces scatter alike: of them the truth's band says it all.
        if len(single) and (truth in ("", method) or scene.dimension_of(method) == 1):
            # 5 % to 95 % of the realisations, and the standard error of their mean: at the loads
            # of the mean, because the prescribed load is the same for all.
            grouped = pd.Series(single[name]).groupby(single["step"])
            low, high = (
                grouped.quantile(share).reindex(rows["step"]).to_numpy() for share in (0.05, 0.95)
            )
            bands.append(Band(along, low, high, style.colour, 0.10, sideways=sideways))
            half = rows[f"stderr_{name}"]
            low, high = value - half, value + half
            bands.append(Band(along, low, high, style.colour, 0.28, sideways=sideways))
        loads = rows[scene.drawn_along]
        errors = rows[f"error_{name}"]
        drawn.append(_Curve(series, tuple(bands), loads, errors, bar))
    return drawn


def _caption(scene: SceneRecord, name: str, apart: float) -> str:
    parts = ["Each method at its finest resolution."]
    if fmt.ROUND_OFF < apart < COINCIDES:
        where = "errors at every step" if scene.is_path else "differences from the reference"
        parts.append(f"The curves coincide within {fmt.relative(apart)}: see their {where}.")
    if scene.along == "step":
        parts.append("Points are joined in the order of the path, along the arrows.")
    bars = scene.reference.known_to(name)
    if (bars > fmt.ROUND_OFF).any():
        hidden = "" if (bars >= VISIBLE).any() else " (thinner than its line)"
        parts.append(
            "Light band and error bars: uncertainty of the reference, "
            f"{fmt.relative_range(bars)}{hidden}."
        )
    proved = scene.reference.proved
    # the rows of a study have the columns of all of its scenes
    if proved and np.isfinite(scene.rows[f"{name}_lower"]).any():
        parts.append(f"Solid band: {proved.in_words}")
    solved = ((method, scene.resolutions_solved(method)) for method in scene.methods)
    if any(len(scene.realisations(method, levels[-1])) for method, levels in solved if levels):
        parts.append(
            "Lines: means over the realisations, with one standard error; faint bands: 5 % to "
            "95 % of the realisations (for 3-D solvers, those of the reference)."
        )
    return " ".join(parts)


def measured(scene: SceneRecord) -> Figure | None:
    """Return measured points with the curves of the model and of the reference, fitted by E*."""
    stated = scene.plan.measured
    if stated is None:
        return None
    stride = -(-len(stated.force) // MOST_MEASURED)
    x, y = (values[::stride] for values in stated.curve)
    points = Look("measured", MUTED, CIRCLE, size=5)
    drawn = [Series(points, x, y, line=False, hover="measured", faint=0.6)]
    fits = modulus_fits(scene)
    for method in drawing_order(fits):
        fit, computed, style = fits[method], computed_curve(scene, method), look(method, scene)
        depth = np.linspace(0.0, computed[0][-1], FITTED_POINTS)
        force = force_at(depth, computed) * fit.modulus / stated.modulus
        text = f"{style.label}, E* = {fmt.with_unit(fit.modulus, 'Pa')}"
        style = style.labelled(f"{style.label}, fitted")
        drawn.append(Series(style, depth + fit.zero, force, marks=False, hover=text))
    depth, force = (np.concatenate([getattr(item, axis) for item in drawn]) for axis in "xy")
    return Figure(
        "measured-force",
        "Measured force over penetration depth, and the fitted modulus",
        f"{modulus_sentence(scene)} Systematic errors (shape, drift, first touch) are in no "
        "interval; compare both lines.",
        value_axis("penetration", depth, log=False),
        value_axis("force", force, log=False),
        tuple(drawn),
        quantity="force",
    )


def solution_figure(result: SingleResult, quantity: str | None = None) -> Figure:
    """Return a quantity of one solve against load; by default the first compared quantity."""
    columns = result.curves()
    control, axis = result.plan.loads.control, result.plan.loads.axis
    along = "time" if axis == "time" and "time" in columns else control
    if quantity is None:
        compared = [q for q in result.plan.scene.compare.quantities if q in columns and q != along]
        quantity = compared[0] if compared else next(iter(columns))
    x, y = (np.asarray(result[name], dtype=float) for name in (along, quantity))
    log = along in NORMAL and wants_log(x) and bool((y[np.isfinite(y)] > 0).all())
    style = look(result.method)
    heading = result.plan.scene.heading
    axes = value_axis(along, x, log), value_axis(quantity, y, log)
    return Figure(
        f"curve-{quantity}", heading, "", *axes, (Series(style, x, y),), quantity=quantity
    )


def pressure_figure(result: SingleResult, pressures: dict[int, dict[str, np.ndarray]]) -> Figure:
    """Return the pressures of one solve over the radius, else in the row next to y = 0."""
    lines = []
    for pressure in pressures.values():
        if "r" in pressure:
            lines.append((pressure["r"], pressure["p"]))
            continue
        x, y, p = (pressure[name] for name in "xyp")
        row = np.flatnonzero(np.abs(y) <= np.abs(y).min() * (1 + 1e-9))
        row = row[np.argsort(x[row], kind="stable")]
        lines.append((x[row], p[row]))
    place, p = (np.concatenate(part) for part in zip(*lines, strict=True))
    title = "distance from the axis r" if "r" in next(iter(pressures.values())) else "place x"
    style = look(result.method)
    return Figure(
        "curve-pressure",
        result.plan.scene.heading,
        "",
        Axis(title, scale=fmt.prefix_for(place, "m")),
        value_axis("pressure", p, False),
        tuple(Series(style, x, line) for x, line in lines),
        quantity="pressure",
    )
