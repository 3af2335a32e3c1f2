"""The [loading] table: which loads, in which control, absolute or relative."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, model_validator

from comparisons.quantities import fail, shown
from comparisons.units import FORCE, LENGTH, NUMBER, Dimension, to_si

Control = Literal["penetration", "force", "mean_gap"]
RELATIVE_FORCE = "E* A0 h'"
MOST_STEPS = 10_000


class LoadRange(BaseModel):
    """Loads of one control: the values (SI, or relative), strictly increasing."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    values: tuple[float, ...]
    relative_to: Literal["E* A0 h'"] | None = None


class Loading(BaseModel):
    """Exactly one of penetration, force and mean_gap."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    penetration: Annotated[LoadRange | None, BeforeValidator(lambda v: read_range(v, LENGTH))] = (
        None
    )
    force: Annotated[LoadRange | None, BeforeValidator(lambda v: read_range(v, FORCE))] = None
    mean_gap: Annotated[LoadRange | None, BeforeValidator(lambda v: read_range(v, LENGTH))] = None

    @model_validator(mode="after")
    def _one_control(self) -> Loading:
        given = [name for name in ("penetration", "force", "mean_gap") if getattr(self, name)]
        if len(given) != 1:
            raise fail(
                "expected exactly one of penetration, force and mean_gap, got "
                + (" and ".join(given) or "none")
            )
        return self

    @property
    def control(self) -> Control:
        """The prescribed quantity."""
        if self.penetration is not None:
            return "penetration"
        return "force" if self.force is not None else "mean_gap"

    @property
    def range(self) -> LoadRange:
        """The prescribed loads."""
        chosen = getattr(self, self.control)
        assert isinstance(chosen, LoadRange)
        return chosen


def read_range(value: Any, dimension: Dimension) -> Any:
    """Turn a number, a list, or a table of the contract into a LoadRange.

    Raises
    ------
    PydanticCustomError
        With everything that is wrong in one message.
    """
    if value is None or isinstance(value, LoadRange):
        return value
    table = value if isinstance(value, dict) else {"values": value}
    relative = table.get("relative_to")
    problems = []
    if "relative_to" in table and (relative != RELATIVE_FORCE or dimension != FORCE):
        problems.append(
            f'relative_to: expected "{RELATIVE_FORCE}", of a force, got {shown(relative)}'
        )
    unit = NUMBER if relative == RELATIVE_FORCE else dimension
    known = {"values", "relative_to"} if "values" in table else _RANGE_KEYS
    problems += [f"{key}: unknown key here" for key in table if key not in known]
    reader = _listed if "values" in table else _spaced
    numbers = reader(table, unit, problems)
    if not problems:
        problems += _order_problems(numbers)
    if problems:
        raise fail("; ".join(problems))
    return LoadRange(values=tuple(numbers), relative_to=relative)


_RANGE_KEYS = {"from", "to", "steps", "spacing", "relative_to"}


def _listed(table: dict[str, Any], unit: Dimension, problems: list[str]) -> list[float]:
    values = table["values"]
    values = values if isinstance(values, (list, tuple)) else [values]
    if len(values) > MOST_STEPS:
        problems.append(f"expected at most {MOST_STEPS} loads, got {len(values)}")
        return []
    return [_number(each, unit, f"load {i}", problems) for i, each in enumerate(values, 1)]


def _spaced(table: dict[str, Any], unit: Dimension, problems: list[str]) -> list[float]:
    missing = [key for key in ("from", "to", "steps") if key not in table]
    if missing:
        problems.append(f"expected values, or from, to and steps; {', '.join(missing)} missing")
        return []
    first = _number(table["from"], unit, "from", problems)
    last = _number(table["to"], unit, "to", problems)
    steps, spacing = table["steps"], table.get("spacing", "linear")
    if isinstance(steps, bool) or not isinstance(steps, int) or not 2 <= steps <= MOST_STEPS:
        problems.append(
            f"steps: expected a whole number from 2 to {MOST_STEPS}, got {shown(steps)}"
        )
    if spacing not in ("linear", "log"):
        problems.append(f'spacing: expected "linear" or "log", got {shown(spacing)}')
    if not problems and not 0 < first < last < math.inf:
        problems.append(f"expected 0 < from < to, got from = {first:g}, to = {last:g}")
    if problems:
        return []
    if spacing == "linear":
        return [float(each) for each in np.linspace(first, last, steps)]
    # Not np.geomspace: through the ratio, a scene scaled by two has the same digits.
    ratio = (last / first) ** (np.arange(1, steps - 1) / (steps - 1))
    return [first, *(float(first * each) for each in ratio), last]


def _number(value: Any, unit: Dimension, name: str, problems: list[str]) -> float:
    try:
        return to_si(value, unit)
    except ValueError as error:
        problems.append(f"{name}: {error}, got {shown(value)}")
        return float("nan")


def _order_problems(values: list[float]) -> list[str]:
    if not values:
        return ["expected at least one load, got an empty list"]
    if not all(np.isfinite(values)) or min(values) <= 0:
        return [f"expected positive finite loads, got {shown(values)}"]
    if any(b <= a for a, b in pairwise(values)):
        return [f"expected strictly increasing loads, got {shown(values)}"]
    return []
