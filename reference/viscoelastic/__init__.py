"""Contact with linear viscoelastic half-spaces.

- `materials`: generalised Maxwell bodies;
- `hereditary`: bodies of revolution by quadrature, Lee-Radok and Ting; impact of a mass;
- `time_steps`: any shape over time, on the half-space solvers;
- `travelling`: the half-space under pressure that travels, on a grid;
- `rubber`: steady sliding, whose operator is not symmetric; a paraboloid on fitted grids.
"""

from reference.viscoelastic.hereditary import Curve, Rebound, creep, impact, indentation
from reference.viscoelastic.materials import GeneralisedMaxwell
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
