"""Scenes of parts of a measured map, or of the map prepared otherwise.

On a patch of a large map the dense solver runs, where a scene names it. The patch is a typical one:
of all places away from the rim of the map, the one whose rms slope is the median. At the highest
point, which is often an outlier or a corner, an artefact of the measurement would decide. Quarters,
and other trends, show how much verdicts hang on the preparation.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.errors import InputError
from comparisons.geometry.prepare import Geometry, RoughGeometry, prepare
from comparisons.scene.scene import PREPARATION, Scene, load_scene, member, validated
from comparisons.scene.surface import TRENDS, MeasuredMap, trend_of, trend_problem

Crop = tuple[int, int, int, int]
DENSE = "bem_dense"
PATCH_POINTS = 16
# Slopes that differ by less are the same: which place is the median must not hang on rounding.
_SAME = 1e-9


def patch_of(scene: Scene, geometry: Geometry) -> tuple[Scene, Crop] | None:
    """Return the scene of a typical patch and its place in the file, or None if none is needed."""
    if not isinstance(scene.surface, MeasuredMap) or not isinstance(geometry, RoughGeometry):
        return None
    if scene.surface2 is not None:  # the patch would have to be cut from both
        return None
    if scene.physics:  # the dense method gains nothing from a patch there
        return None
    if geometry.periodic or max(geometry.points) <= PATCH_POINTS or min(geometry.points) < 8:
        return None
    if DENSE not in (scene.compare.methods or ()):
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
    return validated(data), crop


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
    """Return a scene with a measured map as it is, with other trends, and each quarter of the map.

    A mean height moves a contact as a whole: maps without any trend subtracted add nothing.

    Quarters of free patches only, at the same nominal pressure. The scenes are those of a sweep
    over the preparation. InputError if the scene has no map, or two faces.
    """
    face, geometry = scene.surface, prepare(scene)[0]
    if not isinstance(face, MeasuredMap) or not isinstance(geometry, RoughGeometry):
        raise InputError(f"{scene.name}: --sensitivity: expected a [surface] of kind map")
    if scene.surface2 is not None:
        raise InputError(f"{scene.name}: --sensitivity: expected one rough face, got two")
    variants: dict[str, dict[str, Any]] = {"as given": {}}
    for trend in TRENDS:
        other = trend != trend_of(face.detrend, face.periodic)
        if trend != "none" and other and not trend_problem(trend, face.periodic):
            variants[f"detrend {trend}"] = {"surface.detrend": trend}
    (nx, ny), (x0, y0) = geometry.points, (face.crop or (0, 0))[:2]
    if not face.periodic and min(nx, ny) >= 2 * LEAST:
        for x in (x0, x0 + nx - nx // 2):
            for y in (y0, y0 + ny - ny // 2):
                changes: dict[str, Any] = {"surface.crop": [x, y, nx // 2, ny // 2]}
                force = scene.loading.force
                if force is not None and force.relative_to is None:
                    share = (nx // 2) * (ny // 2) / (nx * ny)
                    changes["loading.force"] = [share * value for value in force.values]
                variants[f"crop at {x}, {y}"] = changes
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
