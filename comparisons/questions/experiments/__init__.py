"""The experiments, by name: every file of this package is imported, and adds its own.

Beside them stand the references that a single one of them needs.
"""

from __future__ import annotations

import sys

from comparisons.discovery import files_of
from comparisons.questions.experiments.experiment import EXPERIMENTS, Experiment, Measurement

list(files_of(sys.modules[__name__]))

__all__ = ["EXPERIMENTS", "Experiment", "Measurement"]
