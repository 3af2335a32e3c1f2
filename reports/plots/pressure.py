"""Contact pressure: radial profiles for circular contacts, a map and a cut for all others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import GRID, ours
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from comparisons.tasks.shown_loads import at_step, stored_steps
from reports.plots.figure import Axis, Figure, Map, Series
from reports.plots.load_slider import NO_STEPS, SliderSteps, slider_steps
from reports.plots.style import drawing_order, look

MOST_PIXELS = 96
MOST_MARKERS = 300
MOST_RADIAL = 120
LARGEST_SHOWN = 4.0  # times the mean pressure; sharp edges and tips are singular


@dataclass(frozen=True)
class Field:
    """The pressure of one solution at one load; `earlier` holds the earlier loads."""

    method: str
    resolution: int
    x: np.ndarray
    y: np.ndarray
    pressure: np.ndarray
    shape: tuple[int, ...]
    rough: bool
    earlier: dict[int, Field] = field(default_factory=dict, repr=False)

    @property
    def on_a_line(self) -> bool:
        """Whether the pressure is given along a radius (axisymmetric solutions)."""
        return bool(np.all(self.y == 0))

    @property
    def on_a_grid(self) -> bool:
        """Whether the points form a regular grid rather than a mesh."""
        return len(self.shape) == 2


def pressures(scene: SceneRecord) -> list[Figure]:
    """Return the pressure plots at the last load."""
    fields = pressure_fields(scene)
    if not fields:
        return []
    loads = slider_steps(scene)
    if not any(item.earlier for item in fields):
        loads = NO_STEPS
    radius, mean = _contact_scales(scene)
    if np.isfinite(radius) and not any(item.rough for item in fields):
        return [_radial(fields, radius, mean, loads)]
    maps = [item for item in fields if item.on_a_grid]
    if not maps:
        return []
    chosen = leading_map(scene, maps)
    # A single line would only repeat a column of the map beside it.
    cuts = [_cut(fields, chosen, loads)] if not chosen.rough or len(maps) > 1 else []
    return [_map(chosen, loads), *cuts]


def leading_map(scene: SceneRecord, maps: list[Field]) -> Field:
    """Return the field of the reference, else of the most trusted method."""
    name, level = selection.reference(scene)
    return next(
        (item for item in maps if item.method == name and item.resolution == level),
        min(maps, key=_trusted),
    )


def _trusted(item: Field) -> tuple[bool, bool]:
    """Rank maps if the reference has none: ours before the peers', the leading grid first."""
    return item.method not in ours(), item.method != GRID


def pressure_fields(scene: SceneRecord) -> list[Field]:
    """Return the stored pressures of each method at its finest resolution, in drawing order."""
    fields = []
    for method in drawing_order(selection.methods(scene)):
        levels = sorted(level for name, level in scene.fields if name == method)
        stored = scene.load_fields(method, levels[-1]) if levels else {}
        last = _field(method, levels[-1], stored) if levels else None
        if last is not None:
            earlier = {
                step: at_load
                for step in stored_steps(stored)
                if (at_load := _field(method, levels[-1], at_step(stored, step))) is not None
            }
            fields.append(replace(last, earlier=earlier))
    return fields


def _field(method: str, level: int, stored: dict[str, np.ndarray]) -> Field | None:
    """Return the pressure from stored arrays, or None if it cannot be drawn."""
    if not {"pressure", "pressure_x", "pressure_y"} <= stored.keys():
        return None
    x, y, p = (np.ravel(stored[f"pressure{suffix}"]) for suffix in ("_x", "_y", ""))
    if not len(p) or not len(x) == len(y) == len(p) or not np.nanmax(p) > 0:
        return None
    return Field(method, level, x, y, p, _shape(stored, len(p)), "heights" in stored)


def at_loads(item: Field, loads: SliderSteps) -> list[Field | None]:
    """Return the field at every load of the slider, None for loads not stored."""
    return [item.earlier.get(step) for step in loads.steps[:-1]] + [item]


def _moving(figures: Sequence[Figure]) -> Figure:
    """Return the figure of the last load with the earlier ones attached."""
    return replace(figures[-1], earlier=tuple(figures[:-1]))


def _shape(stored: dict[str, np.ndarray], count: int) -> tuple[int, ...]:
    """Return the shape of the grid, or the number of points of a mesh."""
    sides = tuple(int(side) for side in np.ravel(stored.get("pressure_shape", [])))
    return sides if len(sides) == 2 and sides[0] * sides[1] == count else (count,)


def _contact_scales(scene: SceneRecord) -> tuple[float, float]:
    """Return contact radius and mean pressure F/(π a²) at the last load, the reference's first."""
    name, level = selection.reference(scene)
    settings = [(name, level if np.isfinite(level) else None)]
    settings += [(method, None) for method in selection.methods(scene)]
    for method, resolution in settings:
        rows = selection.curve(scene, method, resolution).tail(1)
        radius, force = (selection.column(rows, key) for key in ("contact_radius", "force"))
        if len(radius) and np.isfinite(radius[0]) and np.isfinite(force[0]) and radius[0] > 0:
            return float(radius[0]), float(force[0] / (np.pi * radius[0] ** 2))
    return float("nan"), float("nan")


def _radial(fields: list[Field], radius: float, mean: float, loads: SliderSteps) -> Figure:
    curves = [
        [_scaled(at_load, radius, mean) for at_load in at_loads(item, loads)] for item in fields
    ]
    highest = max(float(np.nanmax(p, initial=0.0)) for curve in curves for _, p in curve)
    caption = (
        f"Contact pressure. a = {fmt.with_unit(radius, 'm')} is the contact radius and "
        f"F/(πa²) = {fmt.with_unit(mean, 'Pa')} the mean pressure, both of the reference at the "
        "last load."
    )
    if highest > LARGEST_SHOWN:
        caption += " The pressure is singular; the plot ends at four times the mean."
    empty = Figure(
        "pressure-radial",
        "Pressure along a radius",
        caption,
        Axis("distance from the axis r / a", limits=(0.0, 1.5)),
        Axis("pressure p / mean pressure", limits=(0.0, min(1.08 * highest, LARGEST_SHOWN))),
        quantity="pressure",
    )
    return _with_profiles(empty, fields, curves)


def _scaled(item: Field | None, radius: float, mean: float) -> tuple[np.ndarray, np.ndarray]:
    """Return r/a and p/mean at one load, empty if not stored."""
    if item is None:
        return np.empty(0), np.empty(0)
    r, p = _along_radius(item)
    keep = np.flatnonzero(r <= 1.5 * radius)
    keep = keep[:: -(-len(keep) // MOST_RADIAL) or 1]  # smooth: every second point will do
    return r[keep] / radius, p[keep] / mean


def _with_profiles(
    empty: Figure, fields: list[Field], curves: list[list[tuple[np.ndarray, np.ndarray]]]
) -> Figure:
    """Return a figure with profiles; `curves` holds one (x, p) per load for each field."""
    # Every load is drawn as the last one: only the values move.
    series = [
        _profile_series(item, *profiles[-1]) for item, profiles in zip(fields, curves, strict=True)
    ]
    at_loads = (
        tuple(_moved(s, *profiles) for s, profiles in zip(series, at_load, strict=True))
        for at_load in zip(*curves, strict=True)
    )
    return _moving([replace(empty, series=drawn) for drawn in at_loads])


def _moved(series: Series, x: np.ndarray, p: np.ndarray) -> Series:
    """Return a series with the values of another load, thinned."""
    stride = -(-len(x) // MOST_MARKERS) or 1
    return replace(series, x=x[::stride], y=p[::stride])


def _along_radius(item: Field) -> tuple[np.ndarray, np.ndarray]:
    """Return r and p in ascending order: the grid row next to the x axis, or all mesh points."""
    keep = np.ones(len(item.x), dtype=bool)
    if item.on_a_grid:
        keep = np.abs(item.y) <= np.abs(item.y).min() * (1 + 1e-9)
    r, p = np.hypot(item.x[keep], item.y[keep]), item.pressure[keep]
    order = np.argsort(r, kind="stable")
    return r[order], p[order]


def _profile_series(item: Field, r: np.ndarray, p: np.ndarray) -> Series:
    style = look(item.method)
    mesh = not item.on_a_line and not item.on_a_grid
    return Series(
        *(style, r, p),
        line=not mesh,
        marks=mesh or (len(r) <= 60 and item.method != "closed_form"),
        hover=f"{style.label}, N = {item.resolution}",
        size=max(style.size - 3, 5),
        digits=4,  # all that a profile on a screen can show
    )


def _axes_of(item: Field) -> tuple[np.ndarray, np.ndarray]:
    return item.x.reshape(item.shape)[:, 0], item.y.reshape(item.shape)[0, :]


def _window(touched: np.ndarray) -> slice:
    """Return the extent of the contact along one axis, with a margin of a quarter."""
    inside = np.flatnonzero(touched)
    if not len(inside):
        return slice(0, len(touched))
    margin = max(2, (inside[-1] - inside[0] + 1) // 4)
    return slice(max(inside[0] - margin, 0), min(inside[-1] + margin + 1, len(touched)))


def coarsened(values: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
    """Reduce a map to at most 96 pixels per side, each with the maximum of its cells."""
    step = int(np.ceil(max(values.shape) / MOST_PIXELS))
    if step == 1:
        return values, x, y
    padded = np.pad(values, [(0, -side % step) for side in values.shape])
    blocks = padded.reshape(padded.shape[0] // step, step, padded.shape[1] // step, step)
    centres = [
        np.array([axis_[i : i + step].mean() for i in range(0, len(axis_), step)])
        for axis_ in (x, y)
    ]
    return blocks.max(axis=(1, 3)), centres[0], centres[1]


def _map(item: Field, loads: SliderSteps) -> Figure:
    x, y, p, cells = _shown_part(item)
    limit = _ceiling(np.where(p > 0, p, np.nan))
    caption = f"Contact pressure, {look(item.method).label}, N = {item.resolution}. "
    caption += "Empty: no contact."
    if cells != p.shape:
        caption += " Each pixel shows the maximum over its cells."
    if limit is not None:
        caption += " Colours end at the 98 % quantile: sharp and free edges are singular."
    across = fmt.prefix_for(np.concatenate([x, y]), "m")
    # One colour bar for all loads: they can be compared.
    empty = Map(*(np.empty(0),) * 2, np.empty((0, 0)), "p", fmt.prefix_for(p, "Pa"))
    empty = replace(empty, highest=limit or float(np.max(p)))
    figure = Figure(
        "pressure-map",
        "Contact pressure",
        caption,
        Axis("x", scale=across, limits=outer(x)),
        Axis("y", scale=across, limits=outer(y)),
        quantity="pressure",
    )
    frames = at_loads(item, loads if item.earlier else NO_STEPS)
    return _moving([replace(figure, map=_filled(empty, frame)) for frame in frames])


def _filled(empty: Map, item: Field | None) -> Map:
    """Return the map at a load, empty if not stored."""
    if item is None or not item.on_a_grid:
        return empty
    x, y, p, _ = _shown_part(item)
    return replace(empty, x=x, y=y, values=np.where(p > 0, p, np.nan))


def _shown_part(item: Field) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[int, ...]]:
    """Return x, y and p of the part shown, coarsened, and its number of cells before coarsening."""
    x, y = _axes_of(item)
    p = item.pressure.reshape(item.shape)
    if not item.rough:
        rows, columns = _window(np.any(p > 0, axis=1)), _window(np.any(p > 0, axis=0))
        x, y, p = x[rows], y[columns], p[rows, columns]
    cells = p.shape
    p, x, y = coarsened(p, x, y)
    return x, y, p, cells


def outer(centres: np.ndarray) -> tuple[float, float]:
    """Return the range between the outer edges of the first and last pixels."""
    half = (centres[-1] - centres[0]) / max(len(centres) - 1, 1) / 2
    return float(centres[0] - half), float(centres[-1] + half)


def _ceiling(values: np.ndarray) -> float | None:
    """Return the upper end of the colour scale if a few pixels far exceed all others."""
    finite = values[np.isfinite(values)]
    if len(finite) < 20:
        return None
    high = float(np.quantile(finite, 0.98))
    return high if finite.max() > 2 * high else None


def _cut(fields: list[Field], chosen: Field, loads: SliderSteps) -> Figure:
    """Return the pressure along x, at the same y for all methods."""
    height = _interior_row(chosen) if chosen.rough else 0.0
    extent = np.ptp(chosen.x[chosen.pressure > 0])
    centre = 0.0 if not chosen.rough else float(chosen.x.mean())
    curves = [
        [_row(at_load, height, extent) for at_load in at_loads(item, loads)] for item in fields
    ]
    across = fmt.prefix_for(np.concatenate([curve[-1][0] for curve in curves]), "m")
    highest = max(float(np.max(curve[-1][1])) for curve in curves)
    where = f"y = {fmt.with_unit(height, 'm')}" if height else "y = 0"
    empty = Figure(
        "pressure-cut",
        "Pressure along a cut",
        f"Cut along x at {where}"
        + (", the row of the middle half that carries most." if chosen.rough else "."),
        Axis(
            "x",
            scale=across,
            limits=None if chosen.rough else (centre - 0.75 * extent, centre + 0.75 * extent),
        ),
        Axis(
            "contact pressure p", scale=fmt.prefix_for(highest, "Pa"), limits=(0.0, 1.08 * highest)
        ),
        quantity="pressure",
    )
    return _with_profiles(empty, fields, curves)


def _interior_row(item: Field) -> float:
    """Return the y of the row that carries most, in the middle half of a rough map.

    The largest pressure is often at a free edge, where one point decides and solvers differ.
    """
    y = _axes_of(item)[1]
    carried = np.nansum(item.pressure.reshape(item.shape), axis=0)
    inside = np.abs(y - (y[0] + y[-1]) / 2) <= np.ptp(y) / 4
    return float(y[np.argmax(np.where(inside, carried, -1.0))])


def _row(item: Field | None, height: float, extent: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x and p on the row of points next to y = `height`, empty if not stored."""
    if item is None:
        return np.empty(0), np.empty(0)
    distance = np.abs(item.y - height)
    keep = distance <= distance.min() + 1e-9 * max(extent, float(distance.min()))
    order = np.argsort(item.x[keep], kind="stable")
    return item.x[keep][order], item.pressure[keep][order]
