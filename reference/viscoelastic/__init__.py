"""Contact with linear viscoelastic half-spaces.

- `materials`: generalised Maxwell bodies;
- `hereditary`: bodies of revolution by quadrature, Lee-Radok and Ting;
- `half_space`: any shape over time, on the half-space solvers;
- `impact`: a mass as an initial value problem.
"""

from __future__ import annotations

from reference.viscoelastic.half_space import Instant, press_in_time
from reference.viscoelastic.hereditary import Curve, creep, indentation
from reference.viscoelastic.impact import Impact, impact
from reference.viscoelastic.materials import GeneralisedMaxwell

__all__ = [
    "Curve",
    "GeneralisedMaxwell",
    "Impact",
    "Instant",
    "creep",
    "impact",
    "indentation",
    "press_in_time",
]
