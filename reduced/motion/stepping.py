"""Fixed steps in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reduced.arguments import count_faults, positive_faults, refuse


@dataclass(frozen=True)
class Stepping:
    """Equal time steps, of which every `stride`-th is recorded; `steps` is a multiple of it.

    >>> Stepping(0.5, 4, stride=2).times
    array([0., 1., 2.])
    """

    step: float
    steps: int
    stride: int = 1

    def __post_init__(self) -> None:
        wrong = count_faults(steps=self.steps, stride=self.stride)
        if not wrong and self.steps % self.stride:
            wrong.append(f"steps must be a multiple of stride = {self.stride}, got {self.steps}")
        refuse(positive_faults(step=self.step) + wrong)

    @property
    def records(self) -> int:
        """Number of records, including the start."""
        return int(self.steps // self.stride) + 1

    @property
    def times(self) -> np.ndarray:
        """Times of the records, from 0."""
        return self.step * self.stride * np.arange(self.records)
