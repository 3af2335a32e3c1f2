"""Stick and slip under a roller: the part of the friction that is used, and the tractions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.results.store import SceneRecord
from comparisons.tasks.shown_loads import SLIP, at_step, stored_steps
from reports.plots.figure import NO_SCALE, Axis, Figure, Map
from reports.plots.load_slider import SliderSteps, slider_steps
from reports.plots.stored import Fields, finest_fields
from reports.plots.style import look


def slips(scene: SceneRecord) -> list[Figure]:
    """Return the map of stick and slip and those of the tractions, with the slider's creeps."""
    chosen = finest_fields(scene, *SLIP)
    if chosen is None:
        return []
    method, level, stored = chosen
    loads = slider_steps(scene)
    source = f"{look(method).label}, N = {level}. The contact moves to the right."
    used = _figure(
        ("slip-map", "Stick and slip", f"Traction over its bound µp: 1 where it slips. {source}"),
        "friction_used",
        stored,
        loads,
    )
    tractions = [
        _figure(
            (f"traction-{axis}", f"Traction along {axis}", f"On the half-space. {source}"),
            f"traction_{axis}",
            stored,
            loads,
        )
        for axis in "xy"
        if np.nanmax(np.abs(stored[f"traction_{axis}"])) > 0
    ]
    return [used, *tractions[:1]]


def _figure(labels: tuple[str, str, str], name: str, stored: Fields, loads: SliderSteps) -> Figure:
    """Return one map at the last creep, with the earlier ones for the slider."""
    x = np.ravel(stored["pressure_x"])
    across = fmt.prefix_for(x, "m")
    shared = name == "friction_used"
    scale = NO_SCALE if shared else fmt.prefix_for(np.abs(stored[name]), "Pa")
    known = set(stored_steps(stored))
    frames = [at_step(stored, step) for step in loads.steps[:-1] if step in known] + [stored]
    if len(frames) != len(loads.steps):
        frames = [stored]
    highest = max(float(np.nanmax(frame[name])) for frame in frames)
    maps = [
        Map(*_grid(frame, name), "|q|/(µp)" if shared else "q", scale, highest) for frame in frames
    ]
    key, title, caption = labels
    figures = [
        Figure(
            key,
            title,
            caption,
            Axis("x", scale=across),
            Axis("y", scale=across),
            map=drawn,
            quantity="traction tangential_force stick_area",
        )
        for drawn in maps
    ]
    return replace(figures[-1], earlier=tuple(figures[:-1]))


def _grid(frame: Fields, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, y and the values inside the contact on the grid of the contact."""
    shape = tuple(int(side) for side in np.ravel(frame["pressure_shape"]))
    values = np.ravel(frame[name]).reshape(shape)
    pressure = np.ravel(frame["pressure"]).reshape(shape)
    x, y = (np.ravel(frame[f"pressure_{axis}"]).reshape(shape) for axis in "xy")
    rows, columns = (np.flatnonzero((pressure > 0).any(axis=1 - axis)) for axis in (0, 1))
    inside = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    shown = np.where(pressure > 0, values, np.nan)[inside]
    return x[inside][:, 0], y[inside][0], shown
