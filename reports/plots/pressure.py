"""Contact pressure: radial profiles for circular contacts, maps and a cut for all others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from comparisons import formatting as fmt
from comparisons.facts.methods import GRID, ours
from comparisons.results.record import SceneRecord
from comparisons.tasks.shown_loads import at_step, stored_steps
from reports.plots.figure import (
    MOST_PIXELS,
    Axis,
    Figure,
    Map,
    Series,
    coarsened,
    map_figure,
    moving,
    outer,
)
from reports.plots.stored import Stored, at_last_load, slider_steps, stored_fields
from reports.plots.style import look

ELEMENTS = "fem"
MOST_MARKERS = 300
MOST_RADIAL = 120
LARGEST_SHOWN = 4.0  # times the mean pressure; sharp edges and tips are singular
Profile = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Field:
    """The pressure of one solution at one load."""

    method: str
    resolution: int
    label: str
    x: np.ndarray
    y: np.ndarray
    pressure: np.ndarray
    shape: tuple[int, ...]  # of the grid, or the number of points of a mesh
    rough: bool
    share: np.ndarray | None = None  # of each block in contact, where the field is means over them
    # At the earlier loads of the slider, None where it is not stored; () where no method's is.
    earlier: tuple[Field | None, ...] = field(default=(), repr=False)

    @property
    def on_a_grid(self) -> bool:
        """Whether the points form a regular grid rather than a mesh."""
        return len(self.shape) == 2

    @property
    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """The places along x and along y of a grid."""
        return self.x.reshape(self.shape)[:, 0], self.y.reshape(self.shape)[0, :]

    def on_grid_of(self, other: Field) -> Field:
        """Return the pressure on the cells of another field: means over cells, or between points.

        Of a mesh in the quarter x, y > 0 the others are its mirror images.
        """
        earlier = tuple(item and item.on_grid_of(other) for item in self.earlier)
        there = replace(other, method=self.method, label=self.label, earlier=earlier)
        same_patch = self.on_a_grid and all(
            np.allclose(outer(own), outer(others), atol=1e-6 * np.ptp(own))
            for own, others in zip(self.axes, other.axes, strict=True)
        )
        if same_patch:
            (nx, ny), (rows, columns) = other.shape, np.floor_divide(self.shape, other.shape)
            if (nx * rows, ny * columns) == self.shape:
                means = self.pressure.reshape(nx, rows, ny, columns).mean(axis=(1, 3))
                return replace(there, pressure=means.ravel())
        x, y = (
            np.abs(places) if points.min() >= -1e-9 * points.max() else places
            for points, places in ((self.x, other.x), (self.y, other.y))
        )
        between = LinearNDInterpolator(np.stack([self.x, self.y], axis=1), self.pressure, 0.0)
        return replace(there, pressure=between(x, y))

    @property
    def at_loads(self) -> list[Field | None]:
        """The field at every load of the slider, None for loads not stored."""
        return [*self.earlier, self]

    @property
    def stored(self) -> list[Field | None]:
        """The same, of a field that is stored at its last load alone only that."""
        return self.at_loads if any(self.earlier) else [self]


def pressure_fields(scene: SceneRecord) -> list[Field]:
    """Return the stored pressures of each method at its finest resolution, in drawing order."""
    steps = slider_steps(scene).steps[:-1]
    fields = []
    for stored in stored_fields(scene):
        if last := _field(stored):
            known = set(stored_steps(stored.fields))
            earlier = (
                _field(replace(stored, fields=at_step(stored.fields, step)))
                if step in known
                else None
                for step in steps
            )
            fields.append(replace(last, earlier=tuple(earlier)))
    slid = any(any(item.earlier) for item in fields)
    return fields if slid else [replace(item, earlier=()) for item in fields]


def _field(stored: Stored) -> Field | None:
    """Return the pressure from stored arrays, or None if it cannot be drawn."""
    arrays = stored.fields
    if not {"pressure", "pressure_x", "pressure_y"} <= arrays.keys():
        return None
    x, y, p = (np.ravel(arrays[f"pressure{suffix}"]) for suffix in ("_x", "_y", ""))
    if not len(p) or not len(x) == len(y) == len(p) or not np.nanmax(p) > 0:
        return None
    sides = tuple(int(side) for side in np.ravel(arrays.get("pressure_shape", [])))
    shape = sides if len(sides) == 2 and sides[0] * sides[1] == len(p) else (len(p),)
    share = arrays.get("contact")
    if share is not None and (share.dtype == bool or share.shape != shape):
        share = None
    setting = stored.method, stored.resolution, stored.source
    return Field(*setting, x, y, p, shape, "heights" in arrays, share)


def leading_map(scene: SceneRecord, maps: list[Field]) -> Field:
    """Return the field of the reference, else ours before the peers', the leading grid first."""
    for item in maps:
        if scene.is_reference(item.method, item.resolution):
            return item
    return min(maps, key=lambda item: (item.method not in ours(), item.method != GRID))


def pressures(scene: SceneRecord) -> list[Figure]:
    """Return the pressure plots at the last load, with the earlier ones of the slider."""
    fields = pressure_fields(scene)
    if not fields:
        return []
    if not any(item.rough for item in fields):
        radius, mean = _contact_scales(scene)
        if np.isfinite(radius):
            return [_radial(scene, fields, radius, mean)]
    maps = [item for item in fields if item.on_a_grid]
    if not maps:
        return []
    chosen = leading_map(scene, maps)
    # A single line would only repeat a column of the map beside it.
    cuts = [_cut(scene, fields, chosen)] if not chosen.rough or len(maps) > 1 else []
    by_method = {item.method: item for item in fields}
    grid, elements = by_method.get(GRID), by_method.get(ELEMENTS)
    if grid is None or elements is None or not grid.on_a_grid:
        return [*_maps([chosen]), *cuts]
    # On the coarser grid of the two: what finer cells have is averaged, points are interpolated.
    common = min(grid, elements, key=lambda item: (not item.on_a_grid, len(item.x)))
    seen = elements if elements.on_a_grid else elements.on_grid_of(common)
    both = grid.on_grid_of(common), elements.on_grid_of(common)
    return [*_maps([grid, seen]), _difference(scene, *both), *cuts]


def _contact_scales(scene: SceneRecord) -> tuple[float, float]:
    """Return contact radius and mean pressure F/(π a²) at the last load, the reference's first."""
    settings: list[tuple[str, int | None]] = [(scene.reference.method, scene.reference.resolution)]
    settings += [(method, None) for method in scene.methods]
    for method, resolution in settings:
        rows = scene.curve(method, resolution)
        radius, force = (rows[key][-1:] for key in ("contact_radius", "force"))
        if len(radius) and np.isfinite(radius[0]) and np.isfinite(force[0]) and radius[0] > 0:
            return float(radius[0]), float(force[0] / (np.pi * radius[0] ** 2))
    return float("nan"), float("nan")


def _radial(scene: SceneRecord, fields: list[Field], radius: float, mean: float) -> Figure:
    def along_radius(item: Field) -> Profile:
        """Return r/a and p/mean: of the grid row next to the x axis, or of all mesh points."""
        row = np.ones(len(item.x), dtype=bool)
        if item.on_a_grid:
            row = np.abs(item.y) <= np.abs(item.y).min() * (1 + 1e-9)
        r, p = np.hypot(item.x[row], item.y[row]), item.pressure[row]
        order = np.argsort(r, kind="stable")
        order = order[r[order] <= 1.5 * radius]
        order = order[:: -(-len(order) // MOST_RADIAL) or 1]  # smooth: every second point will do
        return r[order] / radius, p[order] / mean

    curves = _at_loads(fields, along_radius)
    highest = max(float(np.nanmax(p, initial=0.0)) for curve in curves for _, p in curve)
    caption = (
        f"Contact pressure. a = {fmt.with_unit(radius, 'm')} is the contact radius and "
        f"F/(πa²) = {fmt.with_unit(mean, 'Pa')} the mean pressure, both of the reference"
        f"{at_last_load(scene)}."
    )
    if highest > LARGEST_SHOWN:
        caption += " The pressure is singular; the plot ends at four times the mean."
    x = Axis("distance from the axis r / a", limits=(0.0, 1.5))
    y = Axis("pressure p / mean pressure", limits=(0.0, min(1.08 * highest, LARGEST_SHOWN)))
    empty = Figure("pressure-radial", "Pressure along a radius", caption, x, y, quantity="pressure")
    return _with_profiles(scene, empty, fields, curves)


def _cut(scene: SceneRecord, fields: list[Field], chosen: Field) -> Figure:
    """Return the pressure along x, at the same y for all methods.

    On a rough surface where the row carries most, in the middle half: the largest pressure is often
    at a free edge, where one point decides and solvers differ.
    """
    height = 0.0
    if chosen.rough:
        y = chosen.axes[1]
        carried = np.nansum(chosen.pressure.reshape(chosen.shape), axis=0)
        inside = np.abs(y - (y[0] + y[-1]) / 2) <= np.ptp(y) / 4
        height = float(y[np.argmax(np.where(inside, carried, -1.0))])
    extent = np.ptp(chosen.x[chosen.pressure > 0])

    def along_row(item: Field) -> Profile:
        distance = np.abs(item.y - height)
        keep = distance <= distance.min() + 1e-9 * max(extent, float(distance.min()))
        order = np.argsort(item.x[keep], kind="stable")
        return item.x[keep][order], item.pressure[keep][order]

    curves = _at_loads(fields, along_row)
    across = fmt.prefix_for(np.concatenate([curve[-1][0] for curve in curves]), "m")
    highest = max(float(np.max(curve[-1][1])) for curve in curves)
    where = f"y = {fmt.with_unit(height, 'm')}" if height else "y = 0"
    middle = ", the row of the middle half that carries most" if chosen.rough else ""
    limits = None if chosen.rough else (-0.75 * extent, 0.75 * extent)
    scale = fmt.prefix_for(highest, "Pa")
    empty = Figure(
        "pressure-cut",
        "Pressure along a cut",
        f"Cut along x at {where}{middle}.",
        Axis("x", scale=across, limits=limits),
        Axis("contact pressure p", scale=scale, limits=(0.0, 1.08 * highest)),
        quantity="pressure",
    )
    return _with_profiles(scene, empty, fields, curves)


def _at_loads(fields: list[Field], profile: Callable[[Field], Profile]) -> list[list[Profile]]:
    """Return the profile of each field at each load, empty where it is not stored."""
    nothing = np.empty(0), np.empty(0)
    return [
        [nothing if at_load is None else profile(at_load) for at_load in item.at_loads]
        for item in fields
    ]


def _with_profiles(
    scene: SceneRecord, empty: Figure, fields: list[Field], curves: list[list[Profile]]
) -> Figure:
    """Return a figure with profiles; `curves` holds one (x, p) per load for each field."""
    series = []
    for item, profiles in zip(fields, curves, strict=True):
        style, (x, p) = look(item.method, scene), profiles[-1]
        mesh = not item.on_a_grid and bool(item.y.any())  # others are along a radius
        series.append(
            Series(
                *(style, x, p),
                line=not mesh,
                marks=mesh or (len(x) <= 60 and item.method != "closed_form"),
                hover=item.label,
                size=max(style.size - 3, 5),
                digits=4,  # all that a profile on a screen can show
            )
        )

    def moved(drawn: Series, x: np.ndarray, p: np.ndarray) -> Series:
        """Return the values of a load, thinned, drawn as at the last one: only they move."""
        stride = -(-len(x) // MOST_MARKERS) or 1
        return replace(drawn, x=x[::stride], y=p[::stride])

    return moving(
        [
            replace(empty, series=tuple(moved(s, *p) for s, p in zip(series, at_load, strict=True)))
            for at_load in zip(*curves, strict=True)
        ]
    )


def _shown(item: Field) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, y and p of what is in contact, or of all of a rough surface.

    With a margin of a quarter of the contact on each side.
    """
    x, y = item.axes
    p = item.pressure.reshape(item.shape)
    if item.rough or not p.any():
        return x, y, p
    shown = []
    for axis in (1, 0):
        inside = np.flatnonzero(np.any(p != 0, axis=axis))
        margin = max(2, (inside[-1] - inside[0] + 1) // 4)
        shown.append(slice(max(inside[0] - margin, 0), inside[-1] + margin + 1))
    rows, columns = shown
    return x[rows], y[columns], p[rows, columns]


def _maps(views: list[Field]) -> list[Figure]:
    """Return the pressures of one or two methods, at all loads, with one scale of colours."""
    pixels = coarsened(*_shown(views[0]))[2]
    limit = _ceiling(pixels)
    scale, highest = fmt.prefix_for(pixels, "Pa"), limit or float(np.max(pixels))
    figures = []
    for view in views:
        caption = "Empty: no contact."
        if max(_shown(view)[2].shape) > MOST_PIXELS:
            caption += " Each pixel shows the maximum over its cells."
        if limit is not None:
            caption += " Colours end at the 98 % quantile: sharp and free edges are singular."
        frames = []
        for item in view.stored:
            frame = Map(np.empty(0), np.empty(0), np.empty((0, 0)), "p", scale, highest)
            if item is not None and item.on_a_grid:
                x, y, p = coarsened(*_shown(item))
                frame = replace(frame, x=x, y=y, values=np.where(p > 0, p, np.nan))
            frames.append(frame)
        key = f"pressure-map-{view.method}" if len(views) > 1 else "pressure-map"
        title = f"Contact pressure, {view.label}"
        figures.append(map_figure(key, title, caption, frames, "pressure"))
    return figures


def _difference(scene: SceneRecord, grid: Field, elements: Field) -> Figure:
    """Return the pressure of the elements less that of the grid, on the same cells."""
    x, y, last = coarsened(*_shown(replace(grid, pressure=elements.pressure - grid.pressure)))
    sizes = np.abs(last)
    limit = _ceiling(sizes)
    frame = Map(
        *(x, y, np.full(last.shape, np.nan), "Δp"),
        fmt.prefix_for(sizes, "Pa"),
        highest=limit or float(sizes.max()) or 1.0,
        signed=True,
    )
    frames = []
    for before, after in zip(grid.at_loads, elements.at_loads, strict=True):
        if before is None or after is None:
            frames.append(frame)
            continue
        touched = (before.pressure > 0) | (after.pressure > 0)
        less = np.where(touched, after.pressure - before.pressure, 0.0)
        x, y, values = coarsened(*_shown(replace(grid, pressure=less)))
        frames.append(replace(frame, x=x, y=y, values=np.where(values != 0, values, np.nan)))
    touching = [item.pressure > 0 for item in (grid, elements)]
    both, either = np.mean(touching[0] & touching[1]), np.mean(touching[0] | touching[1])
    caption = (
        f"{elements.label}, less {grid.label}, on the same cells: orange where finite elements "
        "press harder, blue where they press less (of many cells in a pixel, the largest "
        f"difference). Of the cells with any pressure in either{at_last_load(scene)}, "
        f"{fmt.relative(both / either)} have it in both."
    )
    if limit is not None:
        caption += " Colours end at the 98 % quantile."
    return map_figure(
        "pressure-difference", "Difference of the pressures", caption, frames, "pressure"
    )


def _ceiling(pixels: np.ndarray) -> float | None:
    """Return where colours end: a few pixels at sharp and free edges may tower over all others."""
    pressed = pixels[pixels > 0]
    ceiling = float(np.quantile(pressed, 0.98)) if len(pressed) >= 20 else np.inf
    return ceiling if len(pressed) and pressed.max() > 2 * ceiling else None
