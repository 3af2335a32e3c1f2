"""The method `mujoco`: soft contact of a simulator of robots under test."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.methods.peers.live import Code, LiveCode

# 1 - the impedance of the script.
_YIELDS = 0.05


class MuJoCo(LiveCode):
    """MuJoCo's soft contact, a spring proportional to the mass: Hertz's depth at the largest force.

    At rest F = m k d/(1 - i). The parameter k follows for one mass: a ball twice as heavy is twice
    as stiff.
    """

    name = "mujoco"
    code = Code("MuJoCo", {"mujoco": ""}, "pip install mujoco")
    control = "force"
    wants = "MuJoCo is told the force on the ball: prescribe forces"

    def problem(self, loads: NDArray[np.float64]) -> dict[str, Any]:
        """Hold all forces on a mass that is the largest: accelerations are of order 1."""
        largest = float(loads.max())
        hertz = (0.75 * largest) ** (2 / 3)
        return {"stiffness": float(_YIELDS / hertz), "mass": largest, "forces": loads.tolist()}
