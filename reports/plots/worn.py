"""Profiles of a body that wears, one curve for each distance or number of cycles."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from reports.plots.figure import Axis, Figure, Series
from reports.plots.stored import finest_fields
from reports.plots.style import DASHED, INK, MUTED, Look, look

# Heights are shown up to this many times the highest place that wears.
_SHOWN = 1.5
_SHADES = ("#9ecae1", "#4292c6", "#08519c", "#08306b")


def worn_profiles(scene: SceneRecord) -> list[Figure]:
    """Return the section of the body before and after each step, by the reference if it has one."""
    chosen = finest_fields(scene, "worn_r", "worn_shapes")
    figure = _figure(scene, *chosen) if chosen else None
    return [figure] if figure else []


def _figure(
    scene: SceneRecord, method: str, level: int, stored: dict[str, np.ndarray]
) -> Figure | None:
    x, shapes = np.ravel(stored["worn_r"]), stored["worn_shapes"]
    if shapes.ndim != 2 or shapes.shape[1] != x.size or len(shapes) < 2:
        return None
    worn = shapes[-1] > shapes[0]
    if not worn.any():
        return None
    top = _SHOWN * float(shapes[-1][worn].max())
    near = (shapes[0] <= top) | worn
    x, shapes = x[near], shapes[:, near]
    labels = _labels(scene, method, level, len(shapes) - 1)
    looks = [Look("unworn", MUTED, dash=DASHED)]
    for number, label in enumerate(labels, 1):
        shade = _SHADES[round((len(_SHADES) - 1) * number / len(labels))]
        looks.append(Look(label, INK if number == len(labels) else shade))
    return Figure(
        "worn-profile",
        "Worn profile",
        f"{look(method).label}, N = {level}: a section of the body, which touches from above. "
        "Heights count from its unworn lowest point.",
        Axis("place x", scale=fmt.prefix_for(x, "m")),
        Axis("height", scale=fmt.prefix_for([top], "m")),
        tuple(
            Series(style, x, shape, marks=False, hover=style.label)
            for style, shape in zip(looks, shapes, strict=True)
        ),
    )


def _labels(scene: SceneRecord, method: str, level: int, steps: int) -> list[str]:
    """Return what stands beside the curves: the distance or the cycles of each step."""
    row = quantity(scene.control)
    values = selection.column(selection.curve(scene, method, level), scene.control)
    if len(values) < steps:
        return [f"step {number}" for number in range(1, steps + 1)]
    if not row.unit:
        return [f"{fmt.number(value)} {row.label}" for value in values[:steps]]
    return [fmt.with_unit(value, row.unit) for value in values[:steps]]
