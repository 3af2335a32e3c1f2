"""Roughness parameters of a surface, and their plausibility.

A wrong unit changes the slope by a factor of a thousand without any error. The plan and the report
therefore state size, rms height and rms slope, and question implausible values.
"""

from __future__ import annotations

from comparisons.formatting import count, number, with_unit
from comparisons.geometry.plausibility import CHECK
from comparisons.geometry.prepare import RoughGeometry

# Limits of measured surfaces; beyond them, a wrong unit or size is more likely.
SMALLEST_SIDE, LARGEST_SIDE = 1e-9, 1.0  # metres: a few atoms; larger than any profiler's stage
LEAST_SLOPE = 1e-6  # superpolished mirrors have about 1e-5
LARGEST_SLOPE = 1.0  # 45 degrees; the half-space itself holds for small slopes
LARGEST_ASPECT = 10.0  # aspect ratio of a cell: scan lines much farther apart than points


def surface_notes(geometry: RoughGeometry) -> list[str]:
    """Return a sentence on size and roughness of a surface, and a warning if implausible."""
    nx, ny = geometry.points
    size = " x ".join(_length(side) for side in geometry.size)
    stated = (
        f"surface: {size}, {count(nx)} x {count(ny)} points, "
        f"rms height {_length(geometry.rms_height)}, rms slope h' = {number(geometry.rms_slope)}"
    )
    doubts = _doubts(geometry)
    if not doubts:
        return [stated]
    return [stated, f"{CHECK}units and the size of the surface: {', '.join(doubts)}"]


def _doubts(geometry: RoughGeometry) -> list[str]:
    """Return the implausible values in the words of the warning."""
    doubts = []
    slope, sides = geometry.rms_slope, geometry.size
    if slope > LARGEST_SLOPE:
        limit = f"{number(LARGEST_SLOPE, 1)}, where every method here takes slopes as small"
        doubts.append(f"an rms slope of {number(slope)} is steeper than {limit}")
    elif slope < LEAST_SLOPE:
        doubts.append(f"an rms slope of {number(slope)} is less than {number(LEAST_SLOPE, 1)}")
    if min(sides) < SMALLEST_SIDE:
        doubts.append(f"a side of {_length(min(sides))} is less than {_length(SMALLEST_SIDE)}")
    if max(sides) > LARGEST_SIDE:
        doubts.append(f"a side of {_length(max(sides))} is more than {_length(LARGEST_SIDE)}")
    cells = [side / n for side, n in zip(sides, geometry.points, strict=True)]
    aspect = max(cells) / min(cells)
    if aspect > LARGEST_ASPECT:
        doubts.append(f"points are {number(aspect)} times farther apart along one side")
    return doubts


def _length(metres: float) -> str:
    return with_unit(metres, "m")
