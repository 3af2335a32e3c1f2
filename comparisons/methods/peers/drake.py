"""The method `drake`: hydroelastic contact under test."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.methods.peers.live import Code, LiveCode
from comparisons.methods.solver import Refused
from comparisons.scene.physics.absolute_loads import loads_of


class Drake(LiveCode):
    """Drake's hydroelastic contact, a pressure that goes as the overlap: Hertz's at the last load.

    The force is (E_h/H) pi d^2 (R - d/3) under a slab of thickness H. Its modulus is a parameter
    without a rule: the one that gives Hertz's force at d* is E_h = (4/(3 pi)) E* H/sqrt(R d*).
    """

    name = "drake"
    code = Code("Drake", {"drake": ""}, "pip install drake")
    wants = "Drake is told where the ball is: prescribe penetrations"

    def _refuse_unfit(self) -> None:
        if float(loads_of(self.scene).values.max()) >= self.radius:
            raise Refused("its mesh is the lower half of the ball: press less deep than the radius")

    def problem(self, loads: NDArray[np.float64]) -> dict[str, Any]:
        """Place the ball at all penetrations."""
        modulus = 4 / (3 * np.pi * np.sqrt(loads.max()))
        return {"modulus": float(modulus), "depths": loads.tolist()}
