"""Rough lines as equally spaced heights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from reduced.arguments import positive_faults, refuse


@dataclass(frozen=True, eq=False)
class RoughLines:
    """Rigid rough lines, one or many: heights (m, n) or (n,), positive towards the half-space.

    A free line of n points is n dx long, half a cell beyond its outer points.

    >>> RoughLines([0.0, 1.0, 0.0, 0.0], 0.5).length
    2.0
    """

    heights: np.ndarray
    spacing: float
    periodic: bool = True

    def __post_init__(self) -> None:
        heights = np.atleast_2d(np.ascontiguousarray(self.heights, dtype=float))
        object.__setattr__(self, "heights", heights)
        wrong = []
        if heights.ndim != 2 or heights.shape[1] < 2 or heights.shape[0] < 1:
            wrong.append(f"lines must have shape (m, n) or (n,), n >= 2, got {heights.shape}")
        elif not np.all(np.isfinite(heights)):
            wrong.append("lines must be finite")
        refuse(wrong + positive_faults(spacing=self.spacing))

    @property
    def length(self) -> float:
        """Length of the lines."""
        return self.heights.shape[1] * self.spacing

    def __len__(self) -> int:
        return len(self.heights)

    def __getitem__(self, row: int) -> RoughLines:
        """Return one of the lines."""
        return RoughLines(self.heights[row], self.spacing, self.periodic)

    def single(self) -> np.ndarray:
        """Return the heights of a single line, shape (n,); raise an error if there are several."""
        if len(self.heights) != 1:
            raise ValueError(f"give one line, got {len(self.heights)}")
        return self.heights[0]


class Ends(NamedTuple):
    """Ends of contacts and of lines.

    With `sub_cell` the line is linear between points and contacts end inside cells, else they are
    whole springs; with `periodic` the last point is a neighbour of the first.
    """

    sub_cell: bool
    periodic: bool
