"""Stress below a contact on a grid: a section through where it is largest, and how deep that is."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.results.store import SceneRecord
from reports.plots.axes import log_axis
from reports.plots.figure import Axis, Figure, Map, Series
from reports.plots.stored import Fields, at_last_load, finest_fields
from reports.plots.style import look

# Depths of the section, which are equally far apart.
_DEPTHS = 120


def stresses_below(scene: SceneRecord) -> list[Figure]:
    """Return von Mises' stress in a section at the last load, and the largest at every depth."""
    chosen = finest_fields(scene, "von_mises_highest")
    if chosen is None:
        return []
    method, _, stored = chosen
    source = at_last_load(chosen)
    return [_section(stored, source), _profile(stored, source, method)]


def _section(stored: Fields, source: str) -> Figure:
    """Return the stress along x and down, through the place where it is largest."""
    depth = stored["von_mises_depth"]
    points = stored["mesh_points"].reshape(len(depth), -1, 3)
    x, y = (np.unique(points[0, :, k]) for k in (0, 1))
    stress = stored["mesh_von_mises"].reshape(len(depth), len(x), len(y))
    through = int(np.unravel_index(stress.argmax(), stress.shape)[2])
    down = np.linspace(0.0, min(float(depth[-1]), float(np.ptp(x)) / 2), _DEPTHS)
    cut = np.array([np.interp(down, depth, line) for line in stress[:, :, through].T])
    scale = fmt.prefix_for(stress, "Pa")
    return Figure(
        "stress-section",
        "Von Mises' stress below the contact",
        f"In a section along x where it is largest, the surface at the top. {source}",
        Axis("x", scale=fmt.prefix_for(x, "m")),
        Axis("height", "z", scale=fmt.prefix_for(down, "m")),
        map=Map(x, -down[::-1], cut[:, ::-1], "σ", scale, float(stress.max())),
        quantity="pressure force contact_area",
    )


def _profile(stored: Fields, source: str, method: str) -> Figure:
    """Return the largest stress at every depth below the surface."""
    depth, highest = stored["von_mises_depth"][1:], stored["von_mises_highest"][1:]
    worst = int(stored["von_mises_highest"].argmax())
    place = fmt.with_unit(float(stored["von_mises_depth"][worst]), "m")
    value = fmt.with_unit(float(stored["von_mises_highest"][worst]), "Pa")
    where = "at the surface" if worst == 0 else f"{place} below the surface"
    return Figure(
        "stress-depth",
        "Largest stress at a depth",
        f"Von Mises' stress, the largest of all places at a depth: {value} {where}, where the body "
        f"first yields. {source}",
        log_axis("depth −z", (depth[0], depth[-1]), lambda value: fmt.with_unit(value, "m", 1)),
        Axis("largest von Mises' stress", "σ", scale=fmt.prefix_for(highest, "Pa")),
        (Series(look(method), depth, highest, marks=False),),
        quantity="pressure force contact_area",
    )
