"""Section 19.3 (b): independent contacts; frictionless contact for heat and other materials."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from comparisons.judging.uncertainty import grid_uncertainty
from comparisons.questions.experiments.experiment import Above, Finding, experiment
from reference.closed_form.infinite import TransverselyIsotropic
from reference.halfspace.punches import array_force, pair_force


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


_ROUNDING = 1e-9


@experiment(
    "transverse-isotropy",
    "Elliott's modulus of transversely isotropic half-spaces against the answer to a wave",
    "ratio",
    "stiffness along the axis over across c33/c11",
)
def transverse_isotropy(
    effort: str, *, ratio: Annotated[float, Above(0)] = 2.0, shear: float = 0.4, cross: float = 0.3
) -> Finding:
    """Compare Elliott's E* with the answer to a wave of pressure, solved from equilibrium.

    ratio : c33/c11, along the axis over across; shear : c44/c11; cross : c13/sqrt(c11 c33).
    """
    body = TransverselyIsotropic(1.0, cross * math.sqrt(ratio), ratio, shear)
    stated, true = body.effective_modulus, body.modulus_of_a_wave()
    return Finding(stated, true, _ROUNDING, {})


@experiment(
    "conductance",
    "Greenwood's conductance of two spots against the stiffness of two punches",
    "distance",
    "distance over diameter s/D",
)
def conductance(effort: str, *, distance: Annotated[float, Above(1)] = 2.0) -> Finding:
    """Compare Greenwood's conductance of two round spots `distance` diameters apart with the true.

    Greenwood (Brit. J. Appl. Phys. 17 (1966) 1621), n like spots: 1/C = 1/(4 k n a) + sum 1/s_ij/
    (2 pi k n^2). By Barber's analogy (Proc. R. Soc. A 459 (2003) 53) C = 2 k/E* times the contact
    stiffness, which is known for two punches by FFT BEM.
    """
    counts = (8, 16) if effort == "quick" else (10, 20)
    coarse, fine = (pair_force(2 * distance, n) for n in counts)
    stated = 1 / (1 + 1 / (math.pi * distance))
    bar = 1.25 * abs(fine / coarse - 1)
    return Finding(stated, fine, bar, {})
