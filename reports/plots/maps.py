"""Maps over a place: coarsened to what a screen shows, with a frame for every load of a slider."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from comparisons import formatting as fmt
from reports.plots.figure import Axis, Figure, Map, moving

MOST_PIXELS = 80


def map_figure(
    key: str,
    title: str,
    caption: str,
    frames: Sequence[Map],
    quantity: str,
    axes: tuple[Axis, Axis] = (Axis("x"), Axis("y")),
) -> Figure:
    """Return the map of the last load with those of the earlier ones; lengths have one unit."""
    last = frames[-1]
    scale = fmt.prefix_for(np.concatenate([last.x, last.y]), "m")
    x, y = (
        Axis(axis.title, axis.symbol, scale=scale, limits=outer(centres))
        for axis, centres in zip(axes, (last.x, last.y), strict=True)
    )
    return moving([Figure(key, title, caption, x, y, map=m, quantity=quantity) for m in frames])


def outer(centres: np.ndarray) -> tuple[float, float]:
    """Return the range between the outer edges of the first and last pixels."""
    half = (centres[-1] - centres[0]) / max(len(centres) - 1, 1) / 2
    return float(centres[0] - half), float(centres[-1] + half)


def coarsened(
    x: np.ndarray, y: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Reduce a map to at most 96 pixels per side, each with the largest value, of any sign."""
    step = int(np.ceil(max(values.shape) / MOST_PIXELS))
    if step == 1:
        return x, y, values
    padded = np.pad(values, [(0, -side % step) for side in values.shape])
    blocks = padded.reshape(padded.shape[0] // step, step, padded.shape[1] // step, step)
    x, y = (
        np.array([axis[i : i + step].mean() for i in range(0, len(axis), step)]) for axis in (x, y)
    )
    highest, lowest = blocks.max(axis=(1, 3)), blocks.min(axis=(1, 3))
    return x, y, np.where(highest >= -lowest, highest, lowest)
