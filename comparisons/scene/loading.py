"""The [loading] table: prescribed loads, absolute or relative; and the load steps of a scene.

Loads increase, unless the physics of the scene depends on history: then they form a path in the
given order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationInfo, model_validator

from comparisons.facts.quantities import NORMAL, TANGENTIAL
from comparisons.reasons import near
from comparisons.scene.fields import (
    FORCE,
    LENGTH,
    NUMBER,
    PRESSURE,
    SPEED,
    TIME,
    Dimension,
    SceneTable,
    WithUnit,
    excerpt,
    fail,
    flagged,
    quantity,
    to_si,
)

if TYPE_CHECKING:
    from comparisons.scene.scene import Scene

Control = Literal[
    "penetration",
    "force",
    "mean_gap",
    "tangential_force",
    "tangential_displacement",
    "time",
    "speed",
    "velocity",
    "creep",
    "lateral_creep",
    "sliding_distance",
    "cycles",
]
RELATIVE_FORCE = "E* A0 h'"
MOST_STEPS = 10_000
# The normal loads that a scene prescribes.
PRESCRIBED = (*NORMAL, "pressure")
# What validation is told about a scene: its normal loads are a path, in the order given.
PATH = "path"
# How the numbers of a range may follow each other.
Order = Literal["loads", "path", "times"]


class LoadRange(SceneTable):
    """Loads of one control: the values (SI, or relative), in order."""

    values: tuple[float, ...]
    relative_to: Literal["E* A0 h'"] | None = None


def ranged(dimension: Dimension, order: Order | None = None) -> Any:
    """Return the validator of a range: in a fixed order, or in that of the scene's normal loads."""

    def read(value: Any, info: ValidationInfo) -> Any:
        return read_range(value, dimension, order or ("path" if flagged(info, PATH) else "loads"))

    return WithUnit(read, dimension=dimension)


class Loading(SceneTable):
    """One of penetration, force, pressure, mean_gap; beside it a tangential path, or times."""

    penetration: Annotated[LoadRange | None, ranged(LENGTH)] = None
    force: Annotated[LoadRange | None, ranged(FORCE)] = None
    # The nominal one, force over the apparent area of a rough surface or a flat face.
    pressure: Annotated[LoadRange | None, ranged(PRESSURE)] = None
    mean_gap: Annotated[LoadRange | None, ranged(LENGTH)] = None
    # An ordered path from zero, at the last normal load.
    tangential_force: Annotated[LoadRange | None, ranged(FORCE, "path")] = None
    tangential_displacement: Annotated[LoadRange | None, ranged(LENGTH, "path")] = None
    # Of each load; between them the load is linear. Before the first nothing touches.
    time: Annotated[LoadRange | None, ranged(TIME, "times")] = None
    # At which lubricated bodies approach each other, far from the contact.
    squeeze_speed: Annotated[float | None, quantity(SPEED, kind="speed")] = None
    # Into how many equal steps each stretch of a path is divided.
    substeps: Annotated[int, Field(strict=True, ge=1, le=1000)] = 1

    @model_validator(mode="after")
    def _one_control(self) -> Loading:
        controls = [name for name in PRESCRIBED if getattr(self, name)]
        if len(controls) > 1 or not (controls or self.time):
            raise fail(
                "expected exactly one of penetration, force, pressure and mean_gap, got "
                + (" and ".join(controls) or "none")
            )
        if all(getattr(self, name) for name in TANGENTIAL):
            raise fail(f"expected one of {' and '.join(TANGENTIAL)}, got both")
        if controls and self.time and len(self.time.values) != len(self.range.values):
            count, loads = len(self.time.values), len(self.range.values)
            raise fail(f"time: expected one for each of the {loads} loads, got {count}")
        return self

    @property
    def control(self) -> Control:
        """The prescribed normal load; a pressure is a force."""
        if self.penetration is not None:
            return "penetration"
        return "mean_gap" if self.forces is None else "force"

    @property
    def forces(self) -> LoadRange | None:
        """The prescribed forces, or pressures."""
        return self.force or self.pressure

    @property
    def range(self) -> LoadRange:
        """The prescribed normal loads."""
        chosen = self.forces or self.penetration or self.mean_gap
        assert chosen is not None
        return chosen

    def unit(self, area: float, modulus_slope: float) -> float:
        """Return what the normal loads are multiplied by, from A0 and E* h'; 1 if absolute."""
        if self.pressure is not None:
            return area
        relative = self.force is not None and self.force.relative_to is not None
        return area * modulus_slope if relative else 1.0

    @property
    def tangential(self) -> Literal["tangential_force", "tangential_displacement"] | None:
        """Which tangential load is prescribed, None where none is."""
        if self.tangential_force is not None:
            return "tangential_force"
        return None if self.tangential_displacement is None else "tangential_displacement"

    def along(self, name: str, *, start: float | None = None) -> np.ndarray:
        """Return a path with each of its stretches divided into `substeps` equal steps.

        It comes from `start`, itself no step; default: its own first value, a step.

        >>> loading = Loading(force=1.0, tangential_force=[2.0, -2.0], substeps=2)
        >>> loading.along("tangential_force", start=0.0).tolist()
        [1.0, 2.0, 0.0, -2.0]
        """
        chosen = self.range if name == "force" else getattr(self, name)
        knots = list(chosen.values)
        first = [] if start is not None else knots[:1]
        knots = knots if start is None else [start, *knots]
        shares = np.arange(1, self.substeps + 1) / self.substeps
        # This form ends in b itself, to the last digit.
        inner = [(1 - shares) * a + shares * b for a, b in pairwise(knots)]
        path = np.concatenate([first, *inner])
        # A path that passes through zero meets it exactly in every unit of length: it is there that
        # surfaces touch.
        path[np.abs(path) <= 4 * np.finfo(float).eps * np.abs(knots).max()] = 0.0
        return path


def read_range(value: Any, dimension: Dimension, order: Order = "loads") -> Any:
    """Turn a number, a list, or a table of the contract into a LoadRange.

    Loads are positive and strictly increasing; a path goes up and down and may be negative; times
    increase from zero on.
    """
    if value is None or isinstance(value, LoadRange):
        return value
    table = value if isinstance(value, dict) else {"values": value}
    relative = table.get("relative_to")
    problems = []
    if "relative_to" in table and (relative != RELATIVE_FORCE or dimension != FORCE):
        problems.append(
            f'relative_to: expected "{RELATIVE_FORCE}", of a force, got {excerpt(relative)}'
        )
    unit = NUMBER if relative == RELATIVE_FORCE else dimension
    listed = "value" if "value" in table else "values"
    keys = {listed, "relative_to"} if listed in table else _RANGE_KEYS
    problems += [f"{key}: unknown key{near(key, keys)}" for key in table if key not in keys]
    if listed in table:
        values = table[listed]
        if listed == "value" and isinstance(values, (list, tuple)):
            problems.append(
                f"value: expected one load (of a list give `values`), got {excerpt(values)}"
            )
            values = []
        values = values if isinstance(values, (list, tuple)) else [values]
        if len(values) > MOST_STEPS:
            problems.append(f"expected at most {MOST_STEPS} loads, got {len(values)}")
            values = []
        numbers = [_number(load, unit, f"load {i}", problems) for i, load in enumerate(values, 1)]
    else:
        numbers = _spaced(table, unit, problems, order)
    kind = "positive finite values" if order == "loads" else "finite numbers"
    if problems:
        raise fail("; ".join(problems))
    if not numbers:
        problems.append("expected at least one load, got an empty list")
    elif not all(np.isfinite(numbers)):
        problems.append(f"expected {kind}, got {excerpt(numbers)}")
    elif order == "path":
        pass
    elif min(numbers) < 0 or (order == "loads" and min(numbers) <= 0):
        kind = kind if order == "loads" else "times from zero on"
        problems.append(f"expected {kind}, got {excerpt(numbers)}")
    elif any(b <= a for a, b in pairwise(numbers)):
        words = "times" if order == "times" else "values"  # loads, speeds, distances
        problems.append(f"expected strictly increasing {words}, got {excerpt(numbers)}")
    if problems:
        raise fail("; ".join(problems))
    return LoadRange(values=tuple(numbers), relative_to=relative)


_RANGE_KEYS = {"from", "to", "steps", "spacing", "relative_to"}


def _spaced(
    table: dict[str, Any], unit: Dimension, problems: list[str], order: Order
) -> list[float]:
    missing = [key for key in ("from", "to", "steps") if key not in table]
    if missing:
        problems.append(
            f"expected value, values, or from, to and steps; {', '.join(missing)} missing"
        )
        return []
    first = _number(table["from"], unit, "from", problems)
    last = _number(table["to"], unit, "to", problems)
    steps, spacing = table["steps"], table.get("spacing", "linear")
    if isinstance(steps, bool) or not isinstance(steps, int) or not 2 <= steps <= MOST_STEPS:
        problems.append(
            f"steps: expected a whole number from 2 to {MOST_STEPS} (of one load give `value`), "
            f"got {excerpt(steps)}"
        )
    if spacing not in ("linear", "log"):
        problems.append(f'spacing: expected "linear" or "log", got {excerpt(spacing)}')
    # A path may go down, and times begin at zero; ratios need positive numbers all the same.
    allowed = {
        "loads": 0 < first < last < math.inf,
        "times": 0 <= first < last < math.inf,
        "path": math.isfinite(first) and math.isfinite(last),
    }
    orders = {"loads": "0 < from < to", "times": "0 <= from < to", "path": "finite numbers"}
    if not problems and not allowed[order]:
        problems.append(f"expected {orders[order]}, got from = {first:g}, to = {last:g}")
    if not problems and spacing == "log" and not min(first, last) > 0:
        problems.append(f"expected from > 0 for logarithmic spacing, got {min(first, last):g}")
    if problems:
        return []
    if spacing == "linear":
        return [float(load) for load in np.linspace(first, last, steps)]
    # Not np.geomspace: through the ratio, a scene scaled by two has the same digits. Nor NumPy's
    # power of arrays, whose last digit hangs on the vector units of the processor: parts of a study
    # from two machines would not be parts of one scene.
    ratio = last / first
    return [first, *(first * ratio ** (k / (steps - 1)) for k in range(1, steps - 1)), last]


def _number(value: Any, unit: Dimension, name: str, problems: list[str]) -> float:
    try:
        return to_si(value, unit)
    except ValueError as error:
        problems.append(f"{name}: {error}, got {excerpt(value)}")
        return float("nan")


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
        """Whether the prescribed loads, of which there are several, have a counterpart."""
        return self.axis in NORMAL and len(self.values) > 1

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
