"""Load steps of a scene: increasing loads, a path, a time history, speeds, creeps, distances."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from comparisons.facts.quantities import NORMAL
from comparisons.scene.loading import Control

if TYPE_CHECKING:
    from comparisons.scene.scene import Scene

# Axes whose steps follow each other: what a step finds depends on those before it.
PATHS = ("step", "time")


@dataclass(frozen=True)
class AbsoluteLoads:
    """Absolute loads, step by step."""

    control: Control  # the prescribed quantity
    values: np.ndarray  # (k,), strictly increasing, except along a path
    axis: str = ""  # along what steps are compared: `control` itself, or "step" (a path), or "time"
    times: np.ndarray | None = None  # (k,), of each step, where the axis is time
    # The normal load under which a tangential path is walked, or bodies slide or roll: one value.
    normal: AbsoluteLoads | None = None

    def __post_init__(self) -> None:
        if not self.axis:
            object.__setattr__(self, "axis", self.control)

    @property
    def is_path(self) -> bool:
        """Whether each step depends on those before it, so that none can be left out."""
        return self.axis in PATHS

    @property
    def compares_itself(self) -> bool:
        """Whether the prescribed load has a counterpart at which it is compared itself."""
        return self.axis in NORMAL

    @cached_property
    def columns(self) -> dict[str, np.ndarray]:
        """What each step prescribes, by the name of its column; "step" has one already."""
        columns: dict[str, np.ndarray] = {self.control: self.values}
        return columns if self.times is None else columns | {"time": self.times}


def loads_of(scene: Scene, unit: float | None = None) -> AbsoluteLoads:
    """Return what a scene walks along, its normal loads multiplied by `unit` (`Loading.unit`).

    By default that is the area of a flat face under a pressure, else 1.
    """
    loading, face = scene.loading, scene.indenter and scene.indenter.face_area
    unit = loading.unit(face or 1.0, 1.0) if unit is None else unit
    if loading.time is not None:
        times = loading.along("time")
        if scene.dynamics is not None and not loading.forces:
            return AbsoluteLoads("time", times, "time", times)
        return AbsoluteLoads(loading.control, loading.along(loading.control) * unit, "time", times)
    if scene.remembers and loading.tangential is None:
        return AbsoluteLoads(loading.control, loading.along(loading.control) * unit, "step")
    varied = next((found for name in scene.physics if (found := getattr(scene, name).varied)), None)
    if varied is None and loading.tangential is None:
        return AbsoluteLoads(loading.control, np.array(loading.range.values) * unit)
    normal = None  # an impact has none
    if scene.dynamics is None:
        normal = AbsoluteLoads(loading.control, np.array(loading.range.values[-1:]) * unit)
    if varied is not None:
        along, values = varied
        return AbsoluteLoads(along, np.array(values), normal=normal)
    assert loading.tangential is not None
    path = loading.along(loading.tangential, start=0.0)
    return AbsoluteLoads(loading.tangential, path, "step", normal=normal)
