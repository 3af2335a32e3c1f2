"""Section 19.3 (b): contacts far apart "can be considered as being independent"."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.judging.uncertainty import grid_uncertainty
from comparisons.questions.experiments.experiment import Above, Finding, experiment
from reference.halfspace.neighbours import array_force, pair_force


@experiment(
    "independent-contacts",
    "Forces of flat punches side by side against those of single ones",
    "distance",
    "distance over diameter s/D",
)
def independent_contacts(
    effort: str, *, distance: Annotated[float, Above(1)] = 10.0, per_side: float = 0
) -> Finding:
    """Compare the sum of forces on isolated flat punches `distance` D apart with the true force.

    At equal penetration, for two punches (exact) or a square array of per_side^2. The bar of arrays
    is the error of point forces, measured for the pair.
    """
    resolutions = np.array([4, 8, 16] if effort == "quick" else [5, 10, 20])
    forces = np.array([pair_force(2 * distance, int(n)) for n in resolutions])
    interaction = 1 / forces - 1
    grid = float(grid_uncertainty(resolutions, interaction[:, None])[0])
    points = 1 / (np.pi * distance)  # 2a/(pi s)
    details: dict[str, float | str] = {
        "pair: sum over true - 1": float(interaction[-1]),
        "pair, as point forces": points,
    }
    if not per_side:
        return Finding(1.0, float(forces[-1]), float(interaction[-1]) * grid, details)
    true = array_force(2 * distance, int(per_side))
    left_out = abs(points / interaction[-1] - 1) + grid
    details["punches"] = float(int(per_side) ** 2)
    details["share of the area"] = float(np.pi / 4 / distance**2)
    return Finding(1.0, true, (1 / true - 1) * left_out, details)
