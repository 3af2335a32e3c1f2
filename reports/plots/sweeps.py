"""Errors along a sweep: every method on scenes that differ in one key."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from comparisons.facts.quantities import in_order, quantity
from comparisons.results.record import SceneRecord
from reports.plots.axes import (
    FOOT_NOTE,
    SIGN_NOTE,
    error_axis,
    error_range,
    padded,
    parted,
    sign_marks,
    tolerance_line,
    wants_log,
    with_foot,
)
from reports.plots.figure import Axis, Figure, Series
from reports.plots.style import drawing_order, look

CAPTION = (
    "Largest error over the loads of each scene, of each method at its finest resolution, with its "
    f"uncertainty. Horizontal lines: tolerances. {SIGN_NOTE} {FOOT_NOTE}"
)
MOST_TICKS = 10


def sweeps(scenes: Sequence[SceneRecord]) -> list[Figure]:
    """Return a figure for each quantity of each key that scenes of a study are swept along."""
    swept: dict[str, list[SceneRecord]] = {}
    for scene in scenes:
        table = scene.tables.get("sweep")
        for path in table if isinstance(table, dict) else ():
            swept.setdefault(path, []).append(scene)
    return [
        figure
        for path, members in swept.items()
        if len(members) > 1
        for name in in_order({name for scene in members for name in scene.quantities})
        if (figure := _along(path, members, name)) is not None
    ]


def _along(path: str, scenes: list[SceneRecord], name: str) -> Figure | None:
    """Return the errors of one quantity along a key."""
    places = np.array([_value(scene.tables, path) for scene in scenes])
    words = path.split(".")[-1].replace("_", " ")
    texts = [str(scene.tables["sweep"][path]) for scene in scenes]
    words_only = not np.isfinite(places).all()
    if words_only:  # one after the other, and nothing between them
        places = np.arange(1.0, len(scenes) + 1)
    order = np.argsort(places)
    log = wants_log(places) and not words_only
    marked = order[:: -(-len(order) // MOST_TICKS)]
    ticks = tuple((float(places[k]), texts[k]) for k in marked)
    limits = padded(places, 0.06, 0.05) if log else None
    if words_only:
        limits = (0.5, len(scenes) + 0.5)
    axis = Axis(words, log=log, limits=limits, ticks=ticks)
    known = {
        method: [
            next(v for v in scene.verdicts_on(method) if v.quantity == name) for scene in scenes
        ]
        for method in drawing_order({m for scene in scenes for m in scene.methods})
        if all(name in scene.quantities for scene in scenes)
    }
    errors = {method: np.array([v.error for v in found]) for method, found in known.items()}
    sizes = np.abs(np.concatenate([np.empty(0), *errors.values()]))
    if not np.isfinite(sizes).any():
        return None
    tolerances = sorted({scene.tolerance for scene in scenes})
    ranges = [error_range(sizes[np.isfinite(sizes)], tolerance) for tolerance in tolerances]
    (low, _), (_, high) = ranges[0], ranges[-1]
    series: list[Series] = []
    for method, error in errors.items():
        if not np.isfinite(error).any():
            continue
        style = look(method, scenes[0])
        hover = tuple(
            f"{style.label}, {scene.name}\n{verdict.text}: {verdict.word}"
            for scene, verdict in zip(scenes, known[method], strict=True)
        )
        bars = np.array([verdict.uncertainty for verdict in known[method]])
        whole = Series(
            *(style, places[order], np.abs(error)[order]),
            line=not words_only,
            bars=bars[order],
            hover=tuple(hover[k] for k in order),
        )
        series += [*parted(whole, low), *sign_marks(whole, error[order], low, high)]
    label = quantity(name).label
    return Figure(
        f"sweep-{path.replace('.', '-')}-{name}",
        f"Error of {label} along {words}",
        CAPTION,
        axis,
        with_foot(error_axis(low, high, "relative error", label), series),
        tuple(series),
        levels=tuple(map(tolerance_line, tolerances)),
        quantity=name,
    )


def _value(tables: dict[str, Any], path: str) -> float:
    """Return the number at a dotted key, in SI units; NaN where there is something else."""
    value: Any = tables
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return float(value) if number else float("nan")
