"""What all methods share that roll: the creeps of a scene, and the quantities of a step."""

from __future__ import annotations

import numpy as np

from comparisons.methods.solver import Refused, needed
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.physics.tables.friction import Friction
from comparisons.scene.physics.tables.rolling import Rolling
from comparisons.scene.scene import Scene

PHYSICS = frozenset({"friction", "rolling"})


def tables_of(scene: Scene) -> tuple[Rolling, Friction]:
    """Return both tables of a scene that rolls.

    Raises
    ------
    Refused
        If one is missing, or a flat face would roll.
    """
    rolling = needed(scene.rolling, "no [rolling]")
    friction = needed(scene.friction, "no [friction]")
    indenter: Indenter | None = scene.indenter
    if indenter is not None and indenter.flat:
        raise Refused("a flat face does not roll")
    return rolling, friction


def acting(rolling: Rolling) -> tuple[bool, bool]:
    """Tell what acts at all: creep along, and what drives across: lateral creep or spin."""
    across = any(rolling.lateral_creep.values) or rolling.spin != 0
    return any(rolling.creep.values), across


def quantities(
    rolling: Rolling, value: float, forces: tuple[float, float], limit: float
) -> dict[str, float]:
    """Return the quantities of a step.

    Parameters
    ----------
    value : float
        The creep that is varied.
    forces : (float, float)
        Along and across.
    limit : float
        mu F.
    """
    along, across = forces
    creep, lateral = rolling.both(value)
    return {
        "tangential_force": along,
        "lateral_force": across,
        "traction": along / limit,
        "creep": creep,
        "lateral_creep": lateral,
    }


def pairs(rolling: Rolling, values: np.ndarray) -> list[tuple[float, float]]:
    """Return creep and lateral creep of several steps."""
    return [rolling.both(float(value)) for value in values]
