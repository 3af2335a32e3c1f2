"""A measured force-depth curve over the computed ones, at the modulus that fits it."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.judging.modulus_fit import ModulusFit, force_at
from comparisons.results.measured import (
    computed_curve,
    measured_curve,
    modulus_fits,
    modulus_sentence,
)
from comparisons.results.store import SceneRecord
from reports.plots.axes import value_axis
from reports.plots.figure import Figure, Series
from reports.plots.style import CIRCLE, MUTED, Look, drawing_order, look

MOST_POINTS = 500
SHOWN = 120  # points of a fitted curve
POINTS = Look("measured", MUTED, CIRCLE, size=5)


def measured(scene: SceneRecord) -> list[Figure]:
    """Return the measured points with the fitted curve of the model and of the reference."""
    known = measured_curve(scene)
    if known is None:
        return []
    stride = -(-len(known[0]) // MOST_POINTS)
    points = Series(
        POINTS, known[0][::stride], known[1][::stride], line=False, hover="measured", faint=0.6
    )
    fits = modulus_fits(scene)
    fitted = [_fitted(scene, name, fits[name]) for name in drawing_order(fits)]
    drawn = (points, *fitted)
    depth, force = (np.concatenate([getattr(item, axis) for item in drawn]) for axis in "xy")
    return [
        Figure(
            "measured-force",
            "Measured force over penetration depth, and the fitted modulus",
            f"{modulus_sentence(scene)} Systematic errors (shape, drift, first touch) are in no "
            "interval; compare both lines.",
            value_axis("penetration", depth, log=False),
            value_axis("force", force, log=False),
            drawn,
            quantity="force",
        )
    ]


def _fitted(scene: SceneRecord, method: str, fit: ModulusFit) -> Series:
    """Return the curve of a method at the modulus that fits, moved to the fitted first touch."""
    computed = computed_curve(scene, method)
    depth = np.linspace(0.0, computed[0][-1], SHOWN)
    style = look(method)
    force = force_at(depth, computed) * fit.modulus / scene.plan["measured"]["modulus"]
    text = f"{style.label}, E* = {fmt.with_unit(fit.modulus, 'Pa')}"
    return Series(
        style.labelled(f"{style.label}, fitted"), depth + fit.zero, force, marks=False, hover=text
    )
