"""Load curves: quantities against load, for all methods at their finest resolution.

Every function takes a SceneRecord and returns figures, or none if there is no data, so that no
page shows an empty plot.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.facts.methods import METHODS
from comparisons.facts.quantities import FIELDS, NORMAL, quantity
from comparisons.judging.metrics import sizes_along_path
from comparisons.judging.proofs import in_words
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from reports.plots.axes import value_axis, wants_log
from reports.plots.figure import Axis, Band, Figure, Level, Series
from reports.plots.style import MUTED, Look, drawing_order, look

if TYPE_CHECKING:
    from comparisons.questions.single import SingleResult

VISIBLE = 2e-3  # of the largest value: a bar thinner than a line of the plot is not drawn
COINCIDES = 0.05  # curves that are closer cannot be told apart
SPREAD = 5.0  # quantities over speeds that spread wider than this take a logarithmic axis
TRUTH_BAR = "bar of the reference"
PROVED = "proved interval"


def curves(scene: SceneRecord) -> list[Figure]:
    """Return each quantity against the prescribed load, or against time for a history."""
    first = "penetration" if scene.control == "force" else "force"
    names = dict.fromkeys([first, "contact_area", *scene.quantities])
    if scene.control not in NORMAL:
        names = dict.fromkeys(scene.quantities)  # the normal load is held
    if scene.along == "time":
        names = dict.fromkeys([scene.control, *names])  # what is prescribed is seen first
    along = selection.drawn_along(scene)
    drawable = [name for name in names if name != along and name not in FIELDS]
    pairs = [
        (values(scene, along, name), None)
        if quantity(name).single
        else (curve(scene, along, name), ratio(scene, along, name))
        for name in drawable
    ]
    return [figure for pair in pairs for figure in pair if figure]


def printed_curves(scene: SceneRecord) -> list[Figure]:
    """Return the curves for papers.

    Under normal loads force against penetration and area against force, whichever is prescribed;
    otherwise every quantity along the path, against time or against speed.
    """
    if scene.control in NORMAL and not scene.is_path:
        pairs = [("penetration", "force"), ("force", "contact_area")]
    else:
        along = selection.drawn_along(scene)
        names = [q for q in scene.quantities if q != along and q not in FIELDS]
        pairs = [(along, name) for name in names]
    drawn = (values(scene, *p) if quantity(p[1]).single else curve(scene, *p) for p in pairs)
    return [figure for figure in drawn if figure]


def curve(scene: SceneRecord, across: str, up: str) -> Figure | None:
    """Return one quantity against another, with the reference's bar and the ensemble scatter.

    Along a path the points are joined in order, so that hysteresis loops are visible.
    """
    drawn = _curves(scene, across, up)
    if not drawn:
        return None
    x, y = (
        np.concatenate([method_curve.column(name) for method_curve in drawn])
        for name in (across, up)
    )
    bands = tuple(band for method_curve in drawn for band in method_curve.bands())
    edges = np.concatenate([np.empty(0), *(edge for b in bands for edge in (b.low, b.high))])
    loads = np.concatenate(
        [method_curve.column(selection.drawn_along(scene)) for method_curve in drawn]
    )
    log = wants_log(loads) and not scene.is_path
    # Load curves are near power laws; what is drawn over speeds need not be.
    upright = log and (scene.control in NORMAL or wants_log(y, SPREAD))
    title = f"{quantity(up).label} against {quantity(across).label}"
    return Figure(
        f"curve-{up}",
        title[0].upper() + title[1:],
        _caption(scene, up, _apart(drawn)),
        value_axis(across, x, log, edges if up == scene.control else ()),
        value_axis(up, y, upright, () if up == scene.control else edges),
        (*(method_curve.series for method_curve in drawn), *_direction(scene, drawn[0].series)),
        bands,
        quantity=up,
    )


def values(scene: SceneRecord, across: str, up: str) -> Figure | None:
    """Return a quantity that has one value for the whole scene: a point for each method."""
    drawn = _curves(scene, across, up)
    if not drawn:
        return None
    points = []
    for place, item in enumerate(drawn):
        last = np.flatnonzero(np.isfinite(item.column(up)))[-1:]
        bars = None if item.series.bars is None else item.series.bars[last]
        where, height = np.array([float(place)]), item.column(up)[last]
        points.append(replace(item.series, x=where, y=height, bars=bars, line=False, marks=True))
    names = tuple((float(place), point.look.label) for place, point in enumerate(points))
    title = quantity(up).label
    return Figure(
        f"curve-{up}",
        title[0].upper() + title[1:],
        "One value of the whole scene, by each method at its finest resolution.",
        Axis("", limits=(-0.5, len(points) - 0.5), ticks=names),
        value_axis(up, np.concatenate([point.y for point in points]), log=False),
        tuple(points),
        legend=False,
        quantity=up,
    )


def ratio(scene: SceneRecord, across: str, up: str) -> Figure | None:
    """Return a quantity over that of the reference, where its curves coincide; else None.

    Along a path errors are relative to the largest value of it: ratios would be others.
    """
    beside = _curves(scene, across, up)
    drawn = [item for item in beside if np.isfinite(item.errors).any()]
    if scene.is_path or not drawn or not _coincide(_apart(beside)):
        return None
    x = np.concatenate([item.column(across) for item in drawn])
    log = wants_log(np.concatenate([item.column(selection.drawn_along(scene)) for item in drawn]))
    bars = drawn[0].column(f"reference_uncertainty_{up}")
    along = drawn[0].column(across)
    name = quantity(up)
    return Figure(
        f"ratio-{up}",
        f"{name.label[0].upper()}{name.label[1:]} over that of the reference",
        "What parts the curves: each method at its finest resolution over the reference, at equal "
        f"{quantity(across).label}. Light band, if any: uncertainty of the reference.",
        value_axis(across, x, log),
        Axis(f"{name.symbol} over the reference's"),
        tuple(replace(item.series, y=1 + item.errors, bars=None, marks=True) for item in drawn),
        (Band(along, 1 - bars, 1 + bars, label=TRUTH_BAR),) if (bars > fmt.ROUND_OFF).any() else (),
        (Level(1.0),),
        quantity=up,
    )


def _coincide(apart: float) -> bool:
    return bool(fmt.ROUND_OFF < apart < COINCIDES)


def _curves(scene: SceneRecord, across: str, up: str) -> list[_Curve]:
    """Return the curves of all methods that have one, in drawing order."""
    candidates = (
        _Curve(scene, method, selection.curve(scene, method), across, up)
        for method in drawing_order(selection.methods(scene))
    )
    return [candidate for candidate in candidates if candidate.is_drawn]


def _apart(drawn: list[_Curve]) -> float:
    """Return how far curves are from the reference at most, relative; NaN where nothing says."""
    known = np.concatenate([np.abs(item.errors) for item in drawn]) if drawn else np.empty(0)
    return float(np.max(known[np.isfinite(known)], initial=0.0)) if len(drawn) > 1 else np.nan


def _direction(scene: SceneRecord, along: Series) -> list[Series]:
    """Return arrows along a path, which may cross itself; only the page draws them."""
    if scene.along != "step" or len(along.x) < 2:
        return []
    style = Look("way of the path", MUTED)
    return [Series(style, along.x, along.y, line=False, legend=False, size=12, directed=True)]


@dataclass(frozen=True)
class _Curve:
    """The curve of one method with bands along the axis that is not prescribed."""

    scene: SceneRecord
    method: str
    rows: pd.DataFrame
    across: str
    up: str

    @cached_property
    def _columns(self) -> dict[str, np.ndarray]:
        return {}

    def column(self, name: str) -> np.ndarray:
        # Asked for a dozen times each, and a table of pandas takes long to answer.
        if name not in self._columns:
            self._columns[name] = selection.column(self.rows, name)
        return self._columns[name]

    @property
    def is_drawn(self) -> bool:
        defined = np.isfinite(self.column(self.across)) & np.isfinite(self.column(self.up))
        return bool(defined.any())

    @property
    def resolution(self) -> float:
        return float(self.column("resolution")[0])

    @property
    def sideways(self) -> bool:
        return self.up == self.scene.control

    @property
    def name(self) -> str:
        return self.across if self.sideways else self.up

    @property
    def errors(self) -> np.ndarray:
        return self.column(f"error_{self.name}")

    @property
    def series(self) -> Series:
        exact = self.method == "closed_form"
        style = look(self.method, self.scene)
        half, size = self._half_widths(), np.abs(self.column(self.name))
        visible = bool(np.any(half > VISIBLE * np.nanmax(size, initial=0.0)))
        return Series(
            *(style, self.column(self.across), self.column(self.up)),
            marks=not exact,
            bars=half if visible and not self.sideways else None,
            hover=style.label if exact else f"{style.label}, N = {fmt.count(self.resolution)}",
        )

    def _half_widths(self) -> np.ndarray:
        """Return the half-widths of the reference's bars; NaN for other methods."""
        value = self.column(self.name)
        if self.method != selection.reference(self.scene)[0]:
            return np.full(len(value), np.nan)
        bar = self.column(f"reference_uncertainty_{self.name}")
        return bar * (sizes_along_path(value) if self.scene.is_path else np.abs(value))

    def bands(self) -> Iterator[Band]:
        """Yield the reference's bar, the 5 % to 95 % range of realisations, and the standard error.

        All are drawn at the loads of the mean, because the prescribed load is the same for all.
        """
        value, half = self.column(self.name), self._half_widths()
        along = self.column(self.up if self.sideways else self.across)
        low, high = (self.column(f"{self.name}_{side}") for side in ("lower", "upper"))
        if np.isfinite(low).any():
            # inside the estimated bar, drawn solid: nothing is estimated about it
            yield Band(along, low, high, opacity=0.9, label=PROVED, sideways=self.sideways)
        if (half > fmt.ROUND_OFF * np.abs(value)).any():
            yield Band(along, value - half, value + half, label=TRUTH_BAR, sideways=self.sideways)
        single = selection.realisations(self.scene, self.method, self.resolution)
        truth = selection.reference(self.scene)[0]
        # Solvers of the same surfaces scatter alike: of them the truth's band says it all.
        if single.empty or (truth not in ("", self.method) and not _is_line(self.method)):
            return
        colour, deviation = look(self.method).colour, self.column(f"stderr_{self.name}")
        low, high = quantiles(single, self.name, self.column("step"))
        yield Band(along, low, high, colour, 0.10, sideways=self.sideways)
        yield Band(
            along, value - deviation, value + deviation, colour, 0.28, sideways=self.sideways
        )


def _is_line(method: str) -> bool:
    row = METHODS.get(method)
    return row is not None and row.dimension == 1


def quantiles(single: pd.DataFrame, name: str, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the 5 % and 95 % quantiles over the realisations at each step."""
    grouped = pd.Series(selection.column(single, name)).groupby(selection.column(single, "step"))
    low, high = grouped.quantile(0.05), grouped.quantile(0.95)
    return low.reindex(steps).to_numpy(), high.reindex(steps).to_numpy()


def _caption(scene: SceneRecord, name: str, apart: float) -> str:
    parts = ["Each method at its finest resolution."]
    if _coincide(apart):
        where = "the errors at every step" if scene.is_path else "their ratios to the reference"
        parts.append(f"The curves coincide within {fmt.relative(apart)}: see {where}.")
    if scene.along == "step":
        parts.append("Points are joined in the order of the path, along the arrows.")
    bar = (scene.reference.get("uncertainty") or {}).get(name)
    if fmt.finite(bar) and float(bar) > fmt.ROUND_OFF:
        hidden = " (thinner than its line)" if float(bar) < VISIBLE else ""
        parts.append(
            "Light band and error bars: uncertainty of the reference, "
            f"{fmt.relative(bar)} in the rms over the loads{hidden}."
        )
    proved = scene.reference.get("proved")
    # the rows of a study have the columns of all of its scenes
    if proved and np.isfinite(selection.column(scene.rows, f"{name}_lower")).any():
        parts.append(f"Solid band: {in_words(proved)}")
    if any(_is_ensemble(scene, method) for method in selection.methods(scene)):
        parts.append(
            "Lines: means over the realisations, with one standard error; faint bands: 5 % to "
            "95 % of the realisations (for 3-D solvers, those of the reference)."
        )
    return " ".join(parts)


def _is_ensemble(scene: SceneRecord, method: str) -> bool:
    levels = selection.resolutions(scene, method)
    return bool(levels) and not selection.realisations(scene, method, levels[-1]).empty


def solution_figure(result: SingleResult, quantity: str | None = None) -> Figure:
    """Return a quantity of one solve against load; by default the first compared quantity."""
    columns = result.solved()
    control, axis = result.plan.loads.control, result.plan.loads.axis
    along = "time" if axis == "time" and "time" in columns else control
    if quantity is None:
        compared = [q for q in result.plan.scene.compare.quantities if q in columns and q != along]
        quantity = compared[0] if compared else next(iter(columns))
    x, y = (np.asarray(result.column(name), dtype=float) for name in (along, quantity))
    log = along in NORMAL and wants_log(x) and bool((y[np.isfinite(y)] > 0).all())
    style = look(result.method)
    heading = result.plan.scene.heading
    axes = value_axis(along, x, log), value_axis(quantity, y, log)
    return Figure(
        f"curve-{quantity}", heading, "", *axes, (Series(style, x, y),), quantity=quantity
    )


def pressure_figure(result: SingleResult, pressures: dict[int, dict[str, np.ndarray]]) -> Figure:
    """Return the pressures of one solve over the radius, else in the row next to y = 0."""
    lines = [_along_a_line(pressure) for pressure in pressures.values()]
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


def _along_a_line(pressure: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    if "r" in pressure:
        return pressure["r"], pressure["p"]
    x, y, p = (pressure[name] for name in "xyp")
    away = np.abs(y)
    row = np.flatnonzero(away <= away.min() * (1 + 1e-9))
    row = row[np.argsort(x[row], kind="stable")]
    return x[row], p[row]
