"""Contact pressure: radial profiles of round contacts; a map and a cut of all others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.store import SceneRecord
from reports import selection
from reports.figure_style import (
    Figure,
    axis,
    drawing_order,
    inert,
    layout,
    numbers,
    style,
)

MOST_PIXELS = 128
MOST_MARKERS = 400
LARGEST_SHOWN = 4.0  # times the mean pressure; sharp edges and tips are singular


@dataclass(frozen=True)
class Field:
    """The pressure of one solution."""

    method: str
    resolution: int
    x: np.ndarray
    y: np.ndarray
    pressure: np.ndarray
    shape: tuple[int, int] | None
    rough: bool

    @property
    def on_a_line(self) -> bool:
        """Axisymmetric solutions are given along a radius."""
        return bool(np.all(self.y == 0))


def pressures(scene: SceneRecord) -> list[Figure]:
    """Return the pressure plots of the last load."""
    fields = pressure_fields(scene)
    if not fields:
        return []
    radius, mean = _contact_scales(scene)
    if np.isfinite(radius) and not any(item.rough for item in fields):
        return [_radial(fields, radius, mean)]
    maps = [item for item in fields if item.shape is not None]
    if not maps:
        return []
    name, level = selection.reference(scene)
    chosen = next(
        (item for item in maps if item.method == name and item.resolution == level), maps[-1]
    )
    # A single line would only repeat a column of the map beside it.
    cuts = [_cut(fields, chosen)] if not chosen.rough or len(maps) > 1 else []
    return [_map(chosen), *cuts]


def pressure_fields(scene: SceneRecord) -> list[Field]:
    """Return the stored pressures, each method at its finest resolution, in drawing order."""
    found = []
    for method in drawing_order(selection.methods(scene)):
        levels = sorted(level for name, level in scene.fields if name == method)
        stored = scene.load_fields(method, levels[-1]) if levels else {}
        if not {"pressure", "pressure_x", "pressure_y"} <= stored.keys():
            continue
        x, y, p = (np.ravel(stored[f"pressure{suffix}"]) for suffix in ("_x", "_y", ""))
        if len(p) and len(x) == len(y) == len(p) and np.nanmax(p) > 0:
            shape = _shape(stored, len(p))
            found.append(Field(method, levels[-1], x, y, p, shape, "heights" in stored))
    return found


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


def _radial(fields: list[Field], radius: float, mean: float) -> Figure:
    data, highest = [], 0.0
    for item in fields:
        r, p = _along_radius(item)
        keep = r <= 1.5 * radius
        r, p = r[keep] / radius, p[keep] / mean
        highest = max(highest, float(np.nanmax(p, initial=0.0)))
        data.append(_profile_trace(item, r, p))
    top = min(1.08 * highest, LARGEST_SHOWN)
    spec = {
        "data": data,
        "layout": layout(
            axis("distance from the axis r / a", range=[0, 1.5]),
            axis("pressure p / mean pressure", range=[0, top]),
        ),
    }
    cut = highest > LARGEST_SHOWN
    caption = (
        f"Contact pressure at the last load: a = {fmt.with_unit(radius, 'm')}, mean pressure "
        f"F/(πa²) = {fmt.with_unit(mean, 'Pa')}, both of the reference. "
        + ("The pressure is singular; the plot ends at four times the mean." if cut else "")
    )
    return Figure("pressure-radial", "Pressure along a radius", caption.strip(), spec)


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
    stride = max(1, len(r) // MOST_MARKERS)
    return {
        "type": "scatter",
        "mode": mode,
        "name": inert(look.label),
        "x": numbers(r[::stride]),
        "y": numbers(p[::stride]),
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
    """Reduce a map to at most 128 pixels per side; each keeps its largest value."""
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


def _map(item: Field) -> Figure:
    x, y = _axes_of(item)
    p = item.pressure.reshape(item.shape)
    if not item.rough:
        rows, columns = _window((p > 0).any(axis=1)), _window((p > 0).any(axis=0))
        x, y, p = x[rows], y[columns], p[rows, columns]
    cells = p.shape
    p, x, y = _coarsened(p, x, y)
    across = fmt.prefix_for(np.concatenate([x, y]), "m")
    up = fmt.prefix_for(p, "Pa")
    values = np.where(p > 0, p * up.factor, np.nan)
    trace = {
        "type": "heatmap",
        "x": numbers(x, across.factor),
        "y": numbers(y, across.factor),
        # plotly's rows run along y, ours along x; three digits are what a colour can show.
        "z": [[float(f"{v:.3g}") if np.isfinite(v) else None for v in row] for row in values.T],
        "colorscale": "Viridis",
        "colorbar": {"title": {"text": f"p / {up.unit}", "side": "right"}, "thickness": 14},
        "hoverongaps": False,
        "hovertemplate": f"p = %{{z:.3g}} {up.unit}<extra></extra>",
    }
    limits = _ceiling(values)
    if limits is not None:
        trace |= {"zmin": 0, "zmax": limits}
    spec = {
        "data": [trace],
        "layout": layout(
            axis(f"x / {across.unit}", constrain="domain", showgrid=False),
            axis(f"y / {across.unit}", scaleanchor="x", constrain="domain", showgrid=False),
        ),
    }
    label = style(item.method).label
    caption = f"Pressure at the last load, {label}, N = {item.resolution}. Empty: no contact."
    if cells != p.shape:
        caption += " Each pixel shows the largest pressure of the cells it covers."
    if limits is not None:
        caption += " Colours end at the 99.5 % quantile: sharp edges are singular."
    return Figure("pressure-map", "Contact pressure", caption, spec)


def _ceiling(values: np.ndarray) -> float | None:
    """Return where colours should end: only where a few pixels tower over all the others."""
    known = values[np.isfinite(values)]
    if len(known) < 20:
        return None
    high = float(np.quantile(known, 0.995))
    return float(f"{high:.3g}") if known.max() > 2 * high else None


def _cut(fields: list[Field], chosen: Field) -> Figure:
    """Return the pressure along x through the highest point of the chosen solution."""
    height = float(chosen.y[np.argmax(chosen.pressure)]) if chosen.rough else 0.0
    extent = np.ptp(chosen.x[chosen.pressure > 0])
    centre = 0.0 if not chosen.rough else float(chosen.x.mean())
    found = []
    for item in fields:
        rows = np.unique(np.abs(item.y - height))
        keep = np.abs(item.y - height) <= rows[0] + 1e-9 * max(extent, rows[0])
        order = np.argsort(item.x[keep], kind="stable")
        found.append((item, item.x[keep][order], item.pressure[keep][order]))
    across = fmt.prefix_for(np.concatenate([x for _, x, _ in found]), "m")
    up = fmt.prefix_for([np.max(p) for _, _, p in found], "Pa")
    limits = None if chosen.rough else [centre - 0.75 * extent, centre + 0.75 * extent]
    spec = {
        "data": [_profile_trace(item, x * across.factor, p * up.factor) for item, x, p in found],
        "layout": layout(
            axis(
                f"x / {across.unit}",
                **({"range": [v * across.factor for v in limits]} if limits else {}),
            ),
            axis(f"contact pressure p / {up.unit}", rangemode="tozero"),
        ),
    }
    where = f"y = {fmt.with_unit(height, 'm')}" if height else "y = 0"
    caption = f"Cut through the contact along x at {where}, last load."
    return Figure("pressure-cut", "Pressure along a cut", caption, spec)
