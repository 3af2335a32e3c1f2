"""The pressure at several load steps, for the load slider of the report.

A solution stores its fields at the last load under their plain names; those of an earlier step K
stand beside them as ``step.K.pressure``, with ``step.K.pressure_x`` and its like only where they
differ (methods that scale their points to each contact).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache

import numpy as np

MOST_STEPS = 8
# A larger map is stored at the last load only: its earlier steps would fill disks, and no screen.
MOST_POINTS = 2**20
# Of a contact that rolls: the traction over its bound, and its direction.
SLIP = ("friction_used", "traction_x", "traction_y")
NAMES = ("pressure", "pressure_x", "pressure_y", "pressure_shape", *SLIP)
DRAWN = ("mesh_", "displacement", "gap", "heights")
# Of these, what pages show coarsely: colours, and exaggerated shifts.
COLOURED = ("heights", "mesh_displacement", "mesh_von_mises")
# What no page shows: anywhere, and below rough surfaces.
UNSEEN, BODY = ("displacement", "gap"), ("mesh_cells", "mesh_displacement")
# What pages show of the finest grid of a method alone.
SHOWN_ONLY = ("step.", "heights", "mesh_")
_KEY = re.compile(rf"step\.(\d{{1,6}})\.({'|'.join(NAMES)})")

Fields = Mapping[str, np.ndarray]


@cache
def shown_steps(count: int) -> tuple[int, ...]:
    """Return the load steps whose pressure is stored: at most eight, spread evenly.

    >>> shown_steps(3), shown_steps(20)
    ((0, 1, 2), (0, 3, 5, 8, 11, 14, 16, 19))
    """
    steps = np.round(np.linspace(0, count - 1, min(count, MOST_STEPS))).astype(int)
    return tuple(steps.tolist())


def point_pressure(points: np.ndarray, pressure: np.ndarray) -> dict[str, np.ndarray]:
    """Return the fields of a pressure at points (n, 2)."""
    return {"pressure_x": points[:, 0], "pressure_y": points[:, 1], "pressure": pressure}


def grid_pressure(x: np.ndarray, y: np.ndarray, pressure: np.ndarray) -> dict[str, np.ndarray]:
    """Return the fields of a pressure on a grid of cells (nx, ny) with centres x, y."""
    fields = {"pressure_x": x.ravel(), "pressure_y": y.ravel(), "pressure": pressure.ravel()}
    return fields | {"pressure_shape": np.array(pressure.shape)}


def earlier_fields(
    builders: Mapping[int, Callable[[], Fields]], steps: int, last: Fields
) -> dict[str, np.ndarray]:
    """Return the arrays of the steps before the last, in single precision.

    Builders: step -> function that returns the fields there. Without a pressure at the last load
    there is nothing to add.
    """
    size = last.get("pressure", np.empty(0)).size
    if not 0 < size <= MOST_POINTS:
        return {}
    stored = [step for step in shown_steps(steps)[:-1] if step in builders]
    arrays = {}
    for step in stored:
        fields = builders[step]()
        for name in NAMES:
            if name not in fields:
                continue
            if name not in last or not np.array_equal(fields[name], last[name]):
                arrays[f"step.{step}.{name}"] = _single(fields[name])
    return arrays


def shown(fields: Fields, *, all_of_them: bool = False) -> dict[str, np.ndarray]:
    """Return the fields that pages show or comparisons use; with `all_of_them` those for ParaView.

    Those that are only drawn, and never compared, are in single precision, and for pages in some
    4000 steps of their range. A rough surface is drawn by its heights, not by the body below it.
    """
    drawn = {name: _single(v) if name.startswith(DRAWN) else v for name, v in fields.items()}
    if all_of_them:
        return drawn
    unseen = UNSEEN + (BODY if "heights" in fields else ())
    kept = {name: values for name, values in drawn.items() if name not in unseen}
    for name in kept.keys() & set(COLOURED):
        values = kept[name]
        if values.dtype != np.float32 or not values.size:
            continue
        width = float(np.nanmax(values)) - float(np.nanmin(values))
        if np.isfinite(width) and width > 0:
            # steps of a power of two take less room
            step = np.exp2(np.floor(np.log2(width / 4096)))
            kept[name] = (np.round(values / step) * step).astype(np.float32)
    return kept


def _single(values: np.ndarray) -> np.ndarray:
    """Return numbers in single precision where its range has room for them."""
    if values.dtype != np.float64:
        return values
    largest = np.max(np.abs(values), where=np.isfinite(values), initial=0.0)
    return values.astype(np.float32) if largest == 0 or 1e-30 < largest < 1e37 else values


def stored_steps(fields: Fields) -> list[int]:
    """Return the earlier load steps of which anything is among the fields, ascending."""
    matches = (_KEY.fullmatch(name) for name in fields)
    return sorted({int(match[1]) for match in matches if match})


def at_step(fields: Fields, step: int) -> dict[str, np.ndarray]:
    """Return the fields with the pressure of an earlier step in place of the last one's."""
    step_arrays = {name: fields.get(f"step.{step}.{name}") for name in NAMES}
    return dict(fields) | {name: value for name, value in step_arrays.items() if value is not None}
