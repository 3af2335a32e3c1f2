"""(19.30) for a real rubber: a sum of springs and dashpots in place of a continuous spectrum."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.questions.experiments.experiment import Above, Share, experiment
from reduced.memory.materials import fit

# Havriliak & Negami (1967): from 1 MPa at rest to 1 GPa as glass, over ten decades of frequency.
_RELAXED, _GLASSY, _TIME, _FIRST, _SECOND = 1e6, 1e9, 1e-3, 0.6, 0.7
_FREQUENCIES = np.geomspace(1e-2, 1e8, 201)
_EXACT = 1e-12


@experiment(
    "relaxation-series",
    "Modulus of a rubber with a continuous spectrum by a series of relaxation times",
    "per_decade",
    "relaxation times per decade",
)
def relaxation_series(effort: str, *, per_decade: Annotated[float, Above(0)] = 2.0) -> Share:
    """Measure the largest relative error of G(w) by a series with `per_decade` times per decade."""
    turns = (1j * _FREQUENCIES * _TIME) ** _FIRST
    true = _GLASSY - (_GLASSY - _RELAXED) / (1 + turns) ** _SECOND
    series = fit(_FREQUENCIES, true, per_decade=per_decade)
    details: dict[str, float | str] = {
        "relaxation times": float(series.material.times.size),
        "rms error": series.rms_error,
    }
    return Share(float(series.error.max()), _EXACT, details, "deviation")
