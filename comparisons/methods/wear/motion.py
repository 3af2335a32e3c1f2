"""What the methods for wear share: the tables of a scene, and the figure of worn profiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from comparisons.methods.solver import needed
from comparisons.scene.physics.tables.wear import Wear
from comparisons.scene.scene import Scene

SLIDING = frozenset({"wear"})
FRETTING = frozenset({"wear", "friction"})
NO_TABLE = "no [wear]"
# Points of a worn profile that are kept for the report.
_POINTS = 160


@dataclass(frozen=True)
class Motion:
    """How a scene wears.

    Attributes
    ----------
    coefficient : float
        k.
    oscillation : (float, float) or None
        Amplitude U and lag G* U/(mu E*) of the tangential oscillation; None where all slides.
    """

    coefficient: float
    oscillation: tuple[float, float] | None

    @classmethod
    def of(cls, scene: Scene) -> Motion:
        """Return that of a scene."""
        table = needed(scene.wear, NO_TABLE)
        return cls(table.coefficient, lag_of(scene, table))


def lag_of(scene: Scene, table: Wear) -> tuple[float, float] | None:
    """Return amplitude and lag of a scene's oscillation."""
    if table.amplitude is None or scene.friction is None:
        return None
    ratio = scene.tangential_modulus / (scene.friction.coefficient * scene.effective_modulus)
    return table.amplitude, ratio * table.amplitude


def worn_picture(r: np.ndarray, shapes: list[np.ndarray]) -> dict[str, np.ndarray]:
    """Return the fields that the report draws worn profiles from.

    Parameters
    ----------
    r : ndarray, shape (n,)
        Distances from the axis, or places along a section.
    shapes : list of ndarray, shape (n,)
        Heights of the body there: unworn, and at each step.
    """
    keep = np.unique(np.linspace(0, r.size - 1, min(r.size, _POINTS)).round().astype(int))
    return {"worn_r": r[keep], "worn_shapes": np.array(shapes)[:, keep]}
