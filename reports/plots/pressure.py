"""Contact pressure: radial profiles of round contacts; a map and a cut of all others."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from comparisons.tasks.shown_loads import at_step, stored_steps
from reports.pages import load_frames
from reports.pages.load_frames import Loads
from reports.plots.style import (
    STYLES,
    Figure,
    axis,
    drawing_order,
    inert,
    layout,
    numbers,
    short_numbers,
    style,
)

MOST_PIXELS = 96
MOST_MARKERS = 300
MOST_RADIAL = 120
LARGEST_SHOWN = 4.0  # times the mean pressure; sharp edges and tips are singular


@dataclass(frozen=True)
class Field:
    """The pressure of one solution at one load; `earlier` holds it at the loads before."""

    method: str
    resolution: int
    x: np.ndarray
    y: np.ndarray
    pressure: np.ndarray
    shape: tuple[int, int] | None
    rough: bool
    earlier: dict[int, Field] = field(default_factory=dict, repr=False)

    @property
    def on_a_line(self) -> bool:
        """Axisymmetric solutions are given along a radius."""
        return bool(np.all(self.y == 0))


def pressures(scene: SceneRecord) -> list[Figure]:
    """Return the pressure plots of the last load."""
    fields = pressure_fields(scene)
    if not fields:
        return []
    loads = load_frames.loads_of(scene)
    if not any(item.earlier for item in fields):
        loads = load_frames.NO_LOADS
    radius, mean = _contact_scales(scene)
    if np.isfinite(radius) and not any(item.rough for item in fields):
        return [_radial(fields, radius, mean, loads)]
    maps = [item for item in fields if item.shape is not None]
    if not maps:
        return []
    name, level = selection.reference(scene)
    chosen = next(
        (item for item in maps if item.method == name and item.resolution == level),
        min(maps, key=_trusted),
    )
    # A single line would only repeat a column of the map beside it.
    cuts = [_cut(fields, chosen, loads)] if not chosen.rough or len(maps) > 1 else []
    return [_map(chosen, loads), *cuts]


def _trusted(item: Field) -> tuple[bool, bool]:
    """Order maps where the truth has none: ours before those of peers, FFT BEM first."""
    return item.method not in STYLES, item.method != "bem_fft"


def pressure_fields(scene: SceneRecord) -> list[Field]:
    """Return the stored pressures, each method at its finest resolution, in drawing order."""
    found = []
    for method in drawing_order(selection.methods(scene)):
        levels = sorted(level for name, level in scene.fields if name == method)
        stored = scene.load_fields(method, levels[-1]) if levels else {}
        last = _field(method, levels[-1], stored) if levels else None
        if last is not None:
            earlier = {
                step: each
                for step in stored_steps(stored)
                if (each := _field(method, levels[-1], at_step(stored, step))) is not None
            }
            found.append(replace(last, earlier=earlier))
    return found


def _field(method: str, level: int, stored: dict[str, np.ndarray]) -> Field | None:
    """Return the pressure among stored arrays, None where there is none that can be drawn."""
    if not {"pressure", "pressure_x", "pressure_y"} <= stored.keys():
        return None
    x, y, p = (np.ravel(stored[f"pressure{suffix}"]) for suffix in ("_x", "_y", ""))
    if not len(p) or not len(x) == len(y) == len(p) or not np.nanmax(p) > 0:
        return None
    return Field(method, level, x, y, p, _shape(stored, len(p)), "heights" in stored)


def _at_loads(item: Field, loads: Loads) -> list[Field | None]:
    """Return the field at every load of the slider, None where it is not stored."""
    return [item.earlier.get(step) for step in loads.steps[:-1]] + [item]


def _shape(stored: dict[str, np.ndarray], count: int) -> tuple[int, int] | None:
    sides = [int(side) for side in np.ravel(stored.get("pressure_shape", []))]
    return (sides[0], sides[1]) if len(sides) == 2 and sides[0] * sides[1] == count else None


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


def _radial(fields: list[Field], radius: float, mean: float, loads: Loads) -> Figure:
    curves = [[_scaled(each, radius, mean) for each in _at_loads(item, loads)] for item in fields]
    data = [_profile_trace(item, *each[-1]) for item, each in zip(fields, curves, strict=True)]
    highest = max(float(np.nanmax(p, initial=0.0)) for each in curves for _, p in each)
    top = min(1.08 * highest, LARGEST_SHOWN)
    spec = {
        "data": data,
        "layout": layout(
            axis("distance from the axis r / a", range=[0, 1.5]),
            axis("pressure p / mean pressure", range=[0, top]),
        ),
    }
    spec = _with_profiles(spec, curves, loads)
    cut = highest > LARGEST_SHOWN
    caption = (
        f"Contact pressure. a = {fmt.with_unit(radius, 'm')} is the contact radius and "
        f"F/(πa²) = {fmt.with_unit(mean, 'Pa')} the mean pressure, both of the reference at the "
        "last load. "
        + ("The pressure is singular; the plot ends at four times the mean." if cut else "")
    )
    return Figure("pressure-radial", "Pressure along a radius", caption.strip(), spec, "pressure")


def _scaled(item: Field | None, radius: float, mean: float) -> tuple[np.ndarray, np.ndarray]:
    """Return r/a and p/mean of one load, empty where nothing is stored."""
    if item is None:
        return np.empty(0), np.empty(0)
    r, p = _along_radius(item)
    keep = np.flatnonzero(r <= 1.5 * radius)
    keep = keep[:: -(-len(keep) // MOST_RADIAL) or 1]  # smooth: every second point will do
    return r[keep] / radius, p[keep] / mean


def _with_profiles(
    spec: dict[str, Any], curves: list[list[tuple[np.ndarray, np.ndarray]]], loads: Loads
) -> dict[str, Any]:
    """Return a figure of profiles with its frames: `curves` has per trace one (x, p) per load."""
    if not loads.steps:
        return spec
    frames = [
        {"data": [_coordinates(*each) for each in at_load]} for at_load in zip(*curves, strict=True)
    ]
    return load_frames.with_frames(spec, frames)


def _coordinates(x: np.ndarray, p: np.ndarray) -> dict[str, Any]:
    stride = -(-len(x) // MOST_MARKERS) or 1
    return {"x": short_numbers(x[::stride]), "y": short_numbers(p[::stride])}


def _along_radius(item: Field) -> tuple[np.ndarray, np.ndarray]:
    """Return r and p, ascending: a grid's row next to the x axis, every point of a mesh."""
    keep = np.ones(len(item.x), dtype=bool)
    if item.shape is not None:
        keep = np.abs(item.y) <= np.abs(item.y).min() * (1 + 1e-9)
    r, p = np.hypot(item.x[keep], item.y[keep]), item.pressure[keep]
    order = np.argsort(r, kind="stable")
    return r[order], p[order]


def _profile_trace(item: Field, r: np.ndarray, p: np.ndarray) -> dict[str, Any]:
    look = style(item.method)
    mesh = not item.on_a_line and item.shape is None
    mode = "markers" if mesh else "lines+markers" if len(r) <= 60 else "lines"
    mode = "lines" if item.method == "closed_form" else mode
    return {
        "type": "scatter",
        "mode": mode,
        "name": inert(look.label),
        **_coordinates(r, p),
        "line": {"color": look.colour, "dash": look.dash, "width": 2},
        "marker": {"color": look.colour, "symbol": look.symbol, "size": max(look.size - 3, 5)},
        "hovertemplate": f"{inert(look.label)}, N = {item.resolution}<br>"
        "%{x:.3g}, %{y:.3g}<extra></extra>",
    }


def _axes_of(item: Field) -> tuple[np.ndarray, np.ndarray]:
    assert item.shape is not None
    return item.x.reshape(item.shape)[:, 0], item.y.reshape(item.shape)[0, :]


def _window(touched: np.ndarray) -> slice:
    """Return the contact's extent along one axis with a margin of a quarter around it."""
    inside = np.flatnonzero(touched)
    if not len(inside):
        return slice(0, len(touched))
    margin = max(2, (inside[-1] - inside[0] + 1) // 4)
    return slice(max(inside[0] - margin, 0), min(inside[-1] + margin + 1, len(touched)))


def _coarsened(values: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
    """Reduce a map to at most 96 pixels per side; each keeps its largest value."""
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


def _map(item: Field, loads: Loads) -> Figure:
    x, y, p, cells = _shown_part(item)
    across = fmt.prefix_for(np.concatenate([x, y]), "m")
    up = fmt.prefix_for(p, "Pa")
    limits = _ceiling(np.where(p > 0, p * up.factor, np.nan))
    trace = {
        "type": "heatmap",
        **_map_data(x, y, p, across.factor, up.factor),
        "colorscale": "Viridis",
        "colorbar": {
            "title": {"text": f"p / {up.unit}", "side": "right"},
            "thickness": 14,
            "xpad": 18,
        },
        "hoverongaps": False,
        "hovertemplate": f"p = %{{z:.3g}} {up.unit}<extra></extra>",
        # One colour bar for all loads: they can be compared.
        "zmin": 0,
        "zmax": limits or float(f"{np.max(p) * up.factor:.3g}"),
    }
    ranges = [_outer(values * across.factor) for values in (x, y)]
    spec = {
        "data": [trace],
        "layout": layout(
            axis(f"x / {across.unit}", constrain="domain", showgrid=False, range=ranges[0]),
            axis(
                f"y / {across.unit}",
                scaleanchor="x",
                constrain="domain",
                showgrid=False,
                range=ranges[1],
            ),
        ),
    }
    if loads.steps and item.earlier:
        fields = _at_loads(item, loads)
        spec = load_frames.with_frames(
            spec, [{"data": [_map_frame(each, across.factor, up.factor)]} for each in fields]
        )
    label = style(item.method).label
    caption = f"Contact pressure, {label}, N = {item.resolution}. Empty: no contact."
    if cells != p.shape:
        caption += " Each pixel shows the largest pressure of the cells it covers."
    if limits is not None:
        caption += " Colours end at the 99.5 % quantile: sharp edges are singular."
    return Figure("pressure-map", "Contact pressure", caption, spec, "pressure")


def _shown_part(item: Field) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[int, ...]]:
    """Return x, y and p of what a map shows, coarsened, and the cells that it had before."""
    x, y = _axes_of(item)
    p = item.pressure.reshape(item.shape)
    if not item.rough:
        rows, columns = _window((p > 0).any(axis=1)), _window((p > 0).any(axis=0))
        x, y, p = x[rows], y[columns], p[rows, columns]
    cells = p.shape
    p, x, y = _coarsened(p, x, y)
    return x, y, p, cells


def _map_data(
    x: np.ndarray, y: np.ndarray, p: np.ndarray, across: float, up: float
) -> dict[str, Any]:
    # plotly's rows run along y, ours along x.
    values = np.where(p > 0, p * up, np.nan).T
    highest = float(np.nanmax(values)) if np.isfinite(values).any() else 0.0
    z = load_frames.coded_map(values, highest)
    return {"x": numbers(x, across), "y": numbers(y, across), "z": z}


def _map_frame(item: Field | None, across: float, up: float) -> dict[str, Any]:
    if item is None or item.shape is None:
        return {"x": [], "y": [], "z": []}
    x, y, p, _ = _shown_part(item)
    return _map_data(x, y, p, across, up)


def _outer(centres: np.ndarray) -> list[float]:
    """Return the range from the outer edge of the first pixel to that of the last."""
    half = (centres[-1] - centres[0]) / max(len(centres) - 1, 1) / 2
    return numbers([centres[0] - half, centres[-1] + half])


def _ceiling(values: np.ndarray) -> float | None:
    """Return where colours should end: only where a few pixels tower over all the others."""
    known = values[np.isfinite(values)]
    if len(known) < 20:
        return None
    high = float(np.quantile(known, 0.995))
    return float(f"{high:.3g}") if known.max() > 2 * high else None


def _cut(fields: list[Field], chosen: Field, loads: Loads) -> Figure:
    """Return the pressure along x through the highest point of the chosen solution."""
    height = float(chosen.y[np.argmax(chosen.pressure)]) if chosen.rough else 0.0
    extent = np.ptp(chosen.x[chosen.pressure > 0])
    centre = 0.0 if not chosen.rough else float(chosen.x.mean())
    curves = [[_row(each, height, extent) for each in _at_loads(item, loads)] for item in fields]
    across = fmt.prefix_for(np.concatenate([each[-1][0] for each in curves]), "m")
    up = fmt.prefix_for([np.max(each[-1][1]) for each in curves], "Pa")
    curves = [[(x * across.factor, p * up.factor) for x, p in each] for each in curves]
    limits = None if chosen.rough else [centre - 0.75 * extent, centre + 0.75 * extent]
    spec = {
        "data": [
            _profile_trace(item, *each[-1]) for item, each in zip(fields, curves, strict=True)
        ],
        "layout": layout(
            axis(
                f"x / {across.unit}",
                **({"range": [v * across.factor for v in limits]} if limits else {}),
            ),
            axis(
                f"contact pressure p / {up.unit}",
                range=[0, 1.08 * max(float(np.max(each[-1][1])) for each in curves)],
            ),
        ),
    }
    spec = _with_profiles(spec, curves, loads)
    where = f"y = {fmt.with_unit(height, 'm')}" if height else "y = 0"
    caption = f"Cut through the contact along x at {where}."
    return Figure("pressure-cut", "Pressure along a cut", caption, spec, "pressure")


def _row(item: Field | None, height: float, extent: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x and p on the row of points next to y = `height`, empty where nothing is stored."""
    if item is None:
        return np.empty(0), np.empty(0)
    distance = np.abs(item.y - height)
    keep = distance <= distance.min() + 1e-9 * max(extent, float(distance.min()))
    order = np.argsort(item.x[keep], kind="stable")
    return item.x[keep][order], item.pressure[keep][order]
