"""What the references of single experiments refuse, each row with the words that say why."""

import numpy as np
import pytest

from comparisons.questions.experiments import coulomb
from comparisons.questions.experiments.adhesive_minimum import Adhesive
from comparisons.questions.experiments.asperities import Asperities
from comparisons.questions.experiments.bodies import TransverselyIsotropic, array_force, pair_force
from comparisons.questions.experiments.particles import leapfrog
from comparisons.questions.experiments.plane_flow import (
    effective_medium_factor,
    patir_cheng_factor,
    plane_flow,
    second_order_factors,
)
from comparisons.questions.experiments.punched_section import press_section
from comparisons.questions.experiments.rolling_cylinders import Carter, RubberCylinder
from comparisons.questions.experiments.vibrations import wave_impact
from reference.halfspace import PeriodicOperator
from reference.halfspace.cohesive import exponential
from reference.particles import Automata, half_space_packing

FLAT = np.zeros((4, 4))
ADHESIVE = Adhesive(PeriodicOperator((4, 4), (1.0, 1.0), 1.0), FLAT, exponential(1e-4, 0.015))
HALF = half_space_packing((3.0, 3.0, 3.0))


@pytest.mark.parametrize(
    ("words", "call"),
    [
        ("mass must be positive.*static >= kinetic", lambda: coulomb.Blocks(-1.0, 1.0, static=0.5)),
        ("expected 0 < speed", lambda: wave_impact(0)),
        ("expected 0 < speed", lambda: wave_impact(0.3)),
        ("poisson_ratio", lambda: wave_impact(0.01, poisson_ratio=0.6)),
        ("positive density_ratio", lambda: wave_impact(0.01, density_ratio=-1.0)),
        ("does not stop", lambda: coulomb.stopping(1.0, 1.0, 1.0, 2.0)),
        ("force must be at least 0", lambda: ADHESIVE.at_force(-1e-3, FLAT)),
        ("glassy must be above 1", lambda: RubberCylinder(1.0, 1.0, 1.0, 1.0, 1.0)),
        (r"traction must lie in \[-1, 1\]", lambda: Carter(1.0, 100.0, 0.3).creep(1.01)),
        (r"c13\^2", lambda: TransverselyIsotropic(1.0, 2.0, 1.0, 1.0)),
        (
            "step must be positive.*; automata must all be free",
            lambda: next(leapfrog(Automata(HALF, 0.3), *np.zeros((2, len(HALF.places), 6)), -1.0)),
        ),
        ("theta", lambda: coulomb.march(coulomb.Blocks(1.0, 1.0), step=1.0, steps=1, theta=0.3)),
        (
            "kind.*support.*elements.*poisson_ratio.*radius.*radii",
            lambda: press_section(1.0, 0.6, kind="x", support="y", radii=(1.0,), elements=1),
        ),
        ("distance", lambda: pair_force(2.0, 8)),
        ("cells", lambda: pair_force(4.0, 1)),
        (r"distance.*per_side", lambda: array_force(1.0, 0)),
        (r"speed(.|\n)*scatter", lambda: Asperities(speed=-1.0, scatter=2.0)),
        ("overlap must be below", lambda: Asperities(overlap=5.0)),
        ("bonds shorter than", lambda: Asperities(energy=1.0)),
        ("not negative", lambda: plane_flow(-np.ones((4, 4)))),
        ("at least 3 cells", lambda: plane_flow(np.ones((2, 4)))),
        ("open somewhere", lambda: plane_flow(np.zeros((4, 4)))),
        ("roughness must be finite", lambda: second_order_factors(-1.0)),
        ("roughness must be positive", lambda: patir_cheng_factor(0.0)),
        ("roughness must be positive", lambda: patir_cheng_factor(np.nan)),
        ("gaps must be", lambda: effective_medium_factor([])),
        ("gaps must be", lambda: effective_medium_factor([1.0, np.nan])),
        ("gaps must be", lambda: effective_medium_factor([-1.0, 1.0, 1.0])),
    ],
)
def test_wrong_arguments_are_all_named(words, call):
    with pytest.raises(ValueError, match=words):
        call()
