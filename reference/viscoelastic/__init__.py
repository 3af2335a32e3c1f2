"""Contact with linear viscoelastic half-spaces.

- `materials`: generalised Maxwell bodies;
- `hereditary`: bodies of revolution by quadrature, Lee-Radok and Ting;
- `time_steps`: any shape over time, on the half-space solvers;
- `rebound`: impact of a mass as an initial value problem.
"""

from __future__ import annotations

from reference.viscoelastic.hereditary import Curve, creep, indentation
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.rebound import Rebound, impact
from reference.viscoelastic.time_steps import Instant, press_in_time

__all__ = [
    "Curve",
    "GeneralisedMaxwell",
    "Instant",
    "Rebound",
    "creep",
    "impact",
    "indentation",
    "press_in_time",
]
