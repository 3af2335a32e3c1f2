"""The film below a lubricated ball: a map with its cavity, and a section with the pressure."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.results.store import SceneRecord
from reports.plots.figure import Axis, Figure, Map, Series
from reports.plots.pressure import coarsened, outer
from reports.plots.stored import Fields, at_last_load, finest_fields
from reports.plots.style import DOTTED, INK, Look, look

# Colours and section end at this multiple of the central film: outside the contact the gap is wide.
_HIGHEST = 5.0
_NAMES = ("film", "vapour", "pressure", "pressure_x", "pressure_y")


def films(scene: SceneRecord) -> list[Figure]:
    """Return the film at the last load that is stored on a grid, by the reference if it has one."""
    stored = finest_fields(scene, *_NAMES, "pressure_shape")
    if stored is None:
        return []
    method, _, fields = stored
    shape = tuple(int(n) for n in fields["pressure_shape"])
    if len(shape) != 2 or any(fields[name].size != shape[0] * shape[1] for name in _NAMES):
        return []
    grid = {name: fields[name].reshape(shape) for name in _NAMES}
    whose = at_last_load(stored)
    return [_map(grid, whose), _section(grid, whose, look(method).colour)]


def _map(grid: Fields, whose: str) -> Figure:
    """Return the map of the film, empty where vapour fills a part of the gap."""
    x, y = grid["pressure_x"][:, 0], grid["pressure_y"][0, :]
    shown, along, up = coarsened(np.where(grid["vapour"] > 0, np.nan, grid["film"]), x, y)
    across = fmt.prefix_for(np.concatenate([x, y]), "m")
    highest = _HIGHEST * _central(grid)
    return Figure(
        "film-map",
        "Film and cavity",
        f"Thickness of the film, {whose} {_cavity(grid)}The colours end at five times its central "
        "value.",
        Axis("x", scale=across, limits=outer(along)),
        Axis("y", scale=across, limits=outer(up)),
        map=Map(along, up, shown, "h", fmt.prefix_for([highest], "m"), highest),
        quantity="film_central film_minimum",
    )


def _section(grid: Fields, whose: str, colour: str) -> Figure:
    """Return film, oil and pressure along the flow through the middle."""
    row = grid["film"].shape[1] // 2
    x, film, vapour, pressure = (
        grid[name][:, row] for name in ("pressure_x", "film", "vapour", "pressure")
    )
    thickness = film / _central(grid)
    near = thickness < _HIGHEST
    curves = (
        (Look("film over central film", colour), thickness),
        (Look("oil in the gap", colour, dash=DOTTED), thickness * (1 - vapour)),
        (Look("pressure over its maximum", INK), pressure / max(grid["pressure"].max(), 1e-300)),
    )
    return Figure(
        "film-section",
        "Section through film and pressure",
        f"Through the middle, {whose}",
        Axis("x", scale=fmt.prefix_for(x, "m"), limits=outer(x[near])),
        Axis("film, pressure", limits=(0.0, _HIGHEST / 2)),
        series=tuple(
            Series(style, x[near], values[near], marks=False, hover=style.label)
            for style, values in curves
        ),
        quantity="film_central film_minimum",
    )


def _cavity(grid: Fields) -> str:
    """Describe the cavity of an entrained film; a squeezed film has none."""
    cavity = "Oil comes from the left. Empty: vapour fills a part of the gap. "
    return cavity if np.any(grid["vapour"] > 0) else ""


def _central(grid: Fields) -> float:
    """Return the film of the cell next to the middle."""
    nearest = np.argmin(np.hypot(grid["pressure_x"], grid["pressure_y"]))
    return float(grid["film"].ravel()[nearest])
