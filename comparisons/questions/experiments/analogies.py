"""What frictionless contact says of other materials and of heat: judges and rules from outside."""

from __future__ import annotations

import math
from typing import Annotated

from comparisons.questions.experiments.experiment import Above, Finding, experiment
from reference.closed_form.infinite import TransverselyIsotropic
from reference.halfspace.neighbours import pair_force

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
