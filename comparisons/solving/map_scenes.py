"""Scenes that a scene of a measured map makes: a typical patch of it, and other preparations."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.errors import InputError
from comparisons.formatting import with_unit
from comparisons.geometry.prepare import Geometry, RoughGeometry, prepare
from comparisons.scene.scene import PREPARATION, Scene, load_scene, member, validated
from comparisons.scene.surface import TRENDS, MeasuredMap, trend_of, trend_problem

Crop = tuple[int, int, int, int]
DENSE = "bem_dense"
PATCH_POINTS = 16
# Slopes that differ by less are the same: which place is the median must not hang on rounding.
_SAME = 1e-9


def patch_of(scene: Scene, geometry: Geometry) -> Scene | None:
    """Return the scene of a typical patch of a map, or None if none is needed."""
    if not isinstance(scene.surface, MeasuredMap) or not isinstance(geometry, RoughGeometry):
        return None
    # it would have to be cut from both faces; under physics the dense method gains nothing
    if scene.surface2 is not None or scene.physics or DENSE not in (scene.compare.methods or ()):
        return None
    if geometry.periodic or max(geometry.points) <= PATCH_POINTS or min(geometry.points) < 8:
        return None
    assert geometry.measured is not None
    x0, y0, nx, ny = typical_window(geometry.measured, geometry.spacing(geometry.measured))
    origin = (0, 0) if scene.surface.crop is None else scene.surface.crop[:2]
    crop = origin[0] + x0, origin[1] + y0, nx, ny
    share = nx * ny / (geometry.points[0] * geometry.points[1])
    data = scene.model_dump(exclude_defaults=True, by_alias=True)
    data["directory"] = scene.directory
    data["name"] = f"{scene.name[:90]}-patch"
    data["title"] = f"{scene.heading}: patch of {nx} x {ny} points"
    data["surface"] |= {"crop": crop}
    data.get("compare", {}).pop("resolutions", None)
    force = scene.loading.force
    if force is not None and force.relative_to is None:
        values = [share * load for load in force.values]
        data["loading"] = {"force": {"values": values}}
    return validated(data)


def typical_window(heights: NDArray[np.float64], spacing: tuple[float, float]) -> Crop:
    """Return the window of median rms slope, half a window away from the rim where that fits.

    >>> ramp = np.outer(np.arange(64.0) ** 2, np.ones(64))
    >>> typical_window(ramp, (1.0, 1.0))
    (24, 24, 16, 16)
    """
    nx, ny = (min(PATCH_POINTS, n) for n in heights.shape)
    rise = [np.diff(heights, axis=axis) ** 2 / spacing[axis] ** 2 for axis in (0, 1)]
    starts = []  # of windows along each axis, half a window apart and away from the rim
    for n, side in zip(heights.shape, (nx, ny), strict=True):
        rim = min(side // 2, (n - side) // 2)
        starts.append(np.arange(rim, n - side - rim + 1, max(side // 2, 1)))
    squares = np.zeros((len(starts[0]), len(starts[1])))
    low_x, low_y = starts
    for part, sides in zip(rise, ((nx - 1, ny), (nx, ny - 1)), strict=True):
        # the sum over all windows, from the sums from the corner
        total = np.pad(part, ((1, 0), (1, 0))).cumsum(0).cumsum(1)
        high_x, high_y = low_x + sides[0], low_y + sides[1]
        within = (
            total[np.ix_(high_x, high_y)]
            - total[np.ix_(low_x, high_y)]
            - total[np.ix_(high_x, low_y)]
            + total[np.ix_(low_x, low_y)]
        )
        squares += within / (sides[0] * sides[1])
    slopes = np.sqrt(squares).ravel()
    steps = np.round(slopes / max(float(slopes.max()), np.finfo(float).tiny) / _SAME)
    place = np.argsort(steps, kind="stable")[(len(steps) - 1) // 2]
    i, j = np.unravel_index(place, (len(starts[0]), len(starts[1])))
    return int(starts[0][i]), int(starts[1][j]), nx, ny


# Points a side of the smallest quarter that is pressed.
LEAST = 16


def prepared_otherwise(scene: Scene) -> list[Scene]:
    """Return a scene of a map as it is, with other trends and cut-offs, and each quarter alone.

    A mean height moves a contact as a whole: maps without any trend subtracted add nothing.
    Cut-offs are twice and four times the given one, or else the shortest wave of the map, 2 cells.
    Quarters, of free patches, have a quarter of the forces. InputError if the scene has no map, or
    two faces.
    """
    face, (geometry, loads) = scene.surface, prepare(scene)
    if not isinstance(face, MeasuredMap) or not isinstance(geometry, RoughGeometry):
        raise InputError(f"{scene.name}: --sensitivity: expected a [surface] of kind map")
    if scene.surface2 is not None:
        raise InputError(f"{scene.name}: --sensitivity: expected one rough face, got two")
    variants: dict[str, dict[str, Any]] = {}
    for trend in TRENDS:
        other = trend != trend_of(face.detrend, face.periodic)
        if trend != "none" and other and not trend_problem(trend, face.periodic):
            variants[f"detrend {trend}"] = {"surface.detrend": trend}
    (nx, ny), (x0, y0) = geometry.points, (face.crop or (0, 0))[:2]
    for times in (2, 4):
        cutoff = times * (
            face.short_cutoff or 2 * max(geometry.size[0] / nx, geometry.size[1] / ny)
        )
        if cutoff <= min(geometry.size):
            variants[f"cut-off {with_unit(cutoff, 'm')}"] = {"surface.short_cutoff": cutoff}
    divides = (face.short_cutoff or 0.0) <= min(geometry.size) / 2 and min(nx, ny) >= 2 * LEAST
    if not face.periodic and divides:
        for x in (x0, x0 + nx - nx // 2):
            for y in (y0, y0 + ny - ny // 2):
                crop = [x, y, nx // 2, ny // 2]
                variants[f"crop at {x}, {y}"] = {"surface.crop": crop}
    if scene.loading.force is not None:  # relative to the slopes it would change with them
        for changes in variants.values():
            *_, px, py = changes.get("surface.crop", (nx, ny))
            changes["loading.force"] = (loads.values * (px * py / (nx * ny))).tolist()
    variants = {"as given": {}, **variants}
    return [
        load_scene(
            scene,
            changes
            | {
                "sweep": {PREPARATION: words},
                "name": member(scene.name, words),
                "title": f"{scene.heading}, {words}"[:300],
            },
        )
        for words, changes in variants.items()
    ]
