"""A validity map: claims as stretches along their parameters, the scenes of a study as points."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from comparisons import formatting as fmt
from comparisons.errors import InputError
from comparisons.facts.quantities import quantity
from comparisons.judging.verdicts import WITHIN, judged
from comparisons.questions.claims.nearest import Measured, Nearest, nearest
from comparisons.results.store import SceneRecord
from comparisons.scene.physics.absolute_loads import loads_of
from comparisons.scene.scene import Scene, load_scene
from reports.plots.claim import LOOKS
from reports.plots.figure import Axis, Figure, Series
from reports.plots.style import INK, Look, Marker

SCENE = Look("scene of this study", INK, Marker("diamond-tall", "d"), size=13)
CAPTION = (
    "Each row is a claim on the reduced model along its own parameter, from the least value that "
    "was measured, left, to the largest, judged at the tolerance of the claim. Diamonds: where the "
    "scenes of this study stand, at their largest error where loads spread; at an edge: beyond it."
)


def validity_map(scenes: Sequence[SceneRecord]) -> Figure | None:
    """Return the rows of all claims that a scene of the study lies on, or None without any."""
    rows: dict[str, list[tuple[str, Nearest]]] = {}
    for record in scenes:
        for answer in _known(record):
            key = f"{quantity(answer.quantity).label} ({answer.measured.claim})"
            rows.setdefault(key, []).append((record.name, answer))
    if not rows:
        return None
    series = [*_stretches([items[0][1].measured for items in rows.values()]), _scenes(rows)]
    ticks = tuple((float(row), key) for row, key in enumerate(rows))
    ends = ((0.0, "least measured"), (1.0, "largest"))
    return Figure(
        "validity",
        "Validity map: where these scenes stand",
        CAPTION,
        Axis("parameter of the claim", limits=(-0.05, 1.05), ticks=ends),
        Axis("", limits=(len(rows) - 0.5, -0.5), ticks=ticks),
        tuple(series),
    )


def _known(record: SceneRecord) -> list[Nearest]:
    """Return what is known of a scene; nothing of one whose files would have to be read."""
    named = any("file" in record.tables.get(name, {}) for name in ("surface", "surface2", "body"))
    if named or not record.quantities:
        return []
    try:
        scene: Scene = load_scene({"name": record.name, **record.tables})
        area, slope = _area_and_slope(scene, record)
        modulus_slope = scene.effective_modulus * slope
        unit = scene.loading.unit(area, modulus_slope) if math.isfinite(area) else None
        return nearest(scene, loads_of(scene, unit), area * modulus_slope)
    except (InputError, KeyError, TypeError, ValueError):
        return []  # damaged results, or of another version


def _area_and_slope(scene: Scene, record: SceneRecord) -> tuple[float, float]:
    """Return A0 and h' of a synthetic surface, as it was made; NaN where they are not known."""
    if scene.surface is None or scene.surface.size is None or "roughness" not in record.plan:
        return math.nan, math.nan
    slope = float(record.plan["roughness"]["statistics"]["rms_slope"])
    return math.prod(scene.surface.size), slope


def _place(measured: Measured, value: float) -> float:
    low, high = (measured.along(end) for end in measured.ends)
    return float(np.clip((measured.along(value) - low) / (high - low), -0.02, 1.02))


def _stretches(rows: list[Measured]) -> list[Series]:
    """Return the measured points of each claim by their word, those that hold joined to a bar."""
    series = []
    for word, style in LOOKS.items():
        x: list[float] = []
        y: list[float] = []
        hover: list[str] = []
        for row, measured in enumerate(rows):
            judgements = [judged(e, u, measured.tolerance).word for _, e, u in measured.points]
            for (value, error, bar), own in zip(measured.points, judgements, strict=True):
                x.append(_place(measured, value) if own == word else np.nan)
                y.append(float(row))
                hover.append(f"{measured.parameter} = {value:.3g}\n{fmt.plus_minus(error, bar)}")
            x.append(np.nan)
            y.append(float(row))
            hover.append("")
        if np.isfinite(x).any():
            line = word == WITHIN
            series.append(
                Series(style, np.array(x), np.array(y), line, hover=tuple(hover), width=6.0)
            )
    return series


def _scenes(rows: dict[str, list[tuple[str, Nearest]]]) -> Series:
    marks = [
        (_place(answer.measured, _worst_place(answer)), float(row), f"{name}\n{answer.place}")
        for row, items in enumerate(rows.values())
        for name, answer in items
    ]
    x, y, hover = zip(*marks, strict=True)
    return Series(SCENE, np.array(x), np.array(y), line=False, hollow=True, hover=tuple(hover))


def _worst_place(answer: Nearest) -> float:
    """Return the scene's own value, or the measured one that decides where its loads spread."""
    low, high = answer.here
    return low if low == high else min(max(answer.there, low), high)
