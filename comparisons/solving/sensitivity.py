"""A measured map prepared otherwise: how much verdicts hang on its trend, and on where it lies."""

from __future__ import annotations

from typing import Any

from comparisons.errors import InputError
from comparisons.geometry.prepare import RoughGeometry, prepare
from comparisons.scene.scene import Scene, load_scene, member
from comparisons.scene.surface import MeasuredMap
from comparisons.scene.trends import TRENDS, trend_of, trend_problem

# Points a side of the smallest quarter that is pressed.
LEAST = 16


def prepared_otherwise(scene: Scene) -> list[Scene]:
    """Return a scene with a measured map as it is, with other trends, and each quarter of the map.

    A mean height moves a contact as a whole: maps without any trend subtracted add nothing.

    Quarters of free patches only, at the same nominal pressure. The scenes are those of a sweep
    over the preparation.

    Raises
    ------
    InputError
        If the scene has no map, or two faces.
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
                "sweep": {"preparation": words},
                "name": member(scene.name, words),
                "title": f"{scene.heading}, {words}"[:300],
            },
        )
        for words, changes in variants.items()
    ]
