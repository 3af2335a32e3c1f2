"""slippy's boundary elements in a separate process: an elastic ball on a rigid plane.

slippy (https://github.com/FrictionTribologyEnigma/slippy, MIT) needs NumPy below 1.25, and names
that NumPy has dropped: they are put back. Each load has a grid of its own, six contact radii wide:
on three radii the pressure was 2 % low.

A ball of radius 1 and E* = 1.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

for _dropped, _kept in {"product": np.prod, "bool": bool}.items():
    setattr(np, _dropped, _kept)

from slippy import contact, surface  # noqa: E402 - needs the names above

WIDTH, CELLS, TOLERANCE = 6.0, 128, 1e-6


def solve(problem: dict[str, Any]) -> dict[str, Any]:
    """Press a ball of radius 1 to depths (k,).

    Returns force, contact_area (of the cells that carry) and converged (k,), unknowns, seconds.
    """
    begin = time.perf_counter()
    rows = []
    for depth in problem["depths"]:
        width = WIDTH * np.sqrt(depth)
        ball = surface.RoundSurface(
            (1.0, 1.0, 1.0), extent=(width, width), shape=(CELLS, CELLS), generate=True
        )
        plane = surface.FlatSurface(shift=(0, 0))
        ball.material = contact.Elastic("elastic", {"E": 1.0, "v": 0.0})
        plane.material = contact.Rigid("rigid")
        model = contact.ContactModel("model", ball, plane)
        model.add_step(
            contact.StaticStep(
                "press",
                interference=depth,
                adhesion=False,
                rtol_interference=TOLERANCE,
                rtol_displacement=TOLERANCE,
            )
        )
        state = model.solve()
        loads = state["loads"]
        pressure = np.asarray(loads.z if hasattr(loads, "z") else loads["z"])
        cell = (width / CELLS) ** 2
        carrying = (pressure > 0).sum()
        rows.append((pressure.sum() * cell, carrying * cell, bool(state["converged"])))
    force, area, converged = np.array(rows).T
    return {
        "force": force,
        "contact_area": area,
        "converged": converged > 0,
        "unknowns": CELLS**2,
        "seconds": time.perf_counter() - begin,
    }
