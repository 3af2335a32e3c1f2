"""The experiments, by name; one module per statement or family of statements."""

from __future__ import annotations

from comparisons.experiments.base import Experiment, Measurement

# Each module of this package offers a tuple of its experiments; they are listed here.
EXPERIMENTS: dict[str, Experiment] = {}

__all__ = ["EXPERIMENTS", "Experiment", "Measurement"]
