"""What yields: the section below an indenter cut open, and what stays of a surface."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import griddata

from comparisons import formatting as fmt
from comparisons.results.store import SceneRecord
from reports.plots.figure import Axis, Figure, Map, Series
from reports.plots.stored import Fields, at_last_load, finest_fields
from reports.plots.style import look

# Points a side of a section, and how far it reaches beyond what has yielded.
_POINTS, _BEYOND = 160, 1.4


def dents(scene: SceneRecord) -> list[Figure]:
    """Return the maps of plastic strain and von Mises' stress, and the dent, at the last load."""
    flat = finest_fields(scene, "dent")
    if flat is not None:
        return [_plan(flat[2], at_last_load(flat))]
    chosen = finest_fields(scene, "section_plastic_strain")
    if chosen is None or not np.any(chosen[2]["section_plastic_strain"] > 0):
        return []
    method, _, stored = chosen
    source = at_last_load(chosen)
    return [*_section(stored, source), _surface(stored, source, method)]


def _plan(stored: Fields, source: str) -> Figure:
    """Return the map of the depth to which a rough surface stays dented."""
    depth = stored["dent"]
    x, y = (
        (np.arange(n) + 0.5) * side / n
        for n, side in zip(depth.shape, np.ravel(stored["size"]), strict=True)
    )
    across, deep = fmt.prefix_for(x, "m"), fmt.prefix_for(depth, "m")
    drawn = Map(x, y, depth, "depth", deep, float(depth.max()))
    return Figure(
        "dent-map",
        "Dents of the surface",
        f"Plastic displacement under a pressure that has reached the hardness. {source}",
        Axis("x", scale=across),
        Axis("y", scale=across),
        map=drawn,
        quantity="residual_depth plastic_share contact_area",
    )


def _section(stored: Fields, source: str) -> list[Figure]:
    """Return plastic strain and von Mises' stress in a half-section, the surface at the top."""
    r, z = np.ravel(stored["section_r"]), np.ravel(stored["section_z"])
    strain, stress = (
        np.ravel(stored[f"section_{name}"]) for name in ("plastic_strain", "von_mises")
    )
    reach = _BEYOND * float(np.hypot(r, z)[strain > 0].max())
    near = (r < 1.5 * reach) & (z < 1.5 * reach)
    axis = np.linspace(0, reach, _POINTS)
    across = fmt.prefix_for(axis, "m")
    figures = []
    for key, title, values, symbol, scale in (
        ("plastic-zone", "Plastic zone", strain, "ε", fmt.Scale(100.0, "%")),
        ("von-mises", "Von Mises' stress", stress, "σ", fmt.prefix_for(stress, "Pa")),
    ):
        points = (r[near], z[near])
        grid = tuple(np.meshgrid(axis, axis, indexing="ij"))
        inside = griddata(points, values[near], grid, method="linear")
        # between the axis or the surface and the first points of the elements: the nearest
        rim = np.isnan(inside)
        inside[rim] = griddata(points, values[near], tuple(g[rim] for g in grid), method="nearest")
        subject = (
            "Equivalent plastic strain"
            if symbol == "ε"
            else "Von Mises' stress; without a load, what is left of it"
        )
        figures.append(
            Figure(
                key,
                title,
                f"{subject}, in a half-section: the axis on the left, the surface at the top. "
                f"{source}",
                Axis("radius", "r", scale=across),
                Axis("height", "z", scale=across),
                map=Map(axis, -axis[::-1], inside[:, ::-1], symbol, scale, float(inside.max())),
                quantity="residual_depth force contact_area",
            )
        )
    return figures


def _surface(stored: Fields, source: str, method: str) -> Figure:
    """Return the shape of the surface."""
    r, sunk = np.ravel(stored["surface_r"]), np.ravel(stored["surface_depth"])
    near = r <= 4 * _BEYOND * float(
        np.ravel(stored["section_r"])[np.ravel(stored["section_plastic_strain"]) > 0].max()
    )
    order = np.argsort(r[near])
    return Figure(
        "dent-profile",
        "Shape of the surface",
        f"Height of the half-space's surface; a dent is below zero, what piles up above. {source}",
        Axis("radius", "r", scale=fmt.prefix_for(r[near], "m")),
        Axis("height", "z", scale=fmt.prefix_for(sunk[near], "m")),
        (Series(look(method), r[near][order], -sunk[near][order], marks=False),),
        quantity="residual_depth force contact_area",
    )
