"""What judges contacts in single experiments: least energy, asperities, particles, punches."""

import csv
import math
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from comparisons.questions.experiments.adhesive_minimum import Adhesive
from comparisons.questions.experiments.asperities import Asperities
from comparisons.questions.experiments.bodies import array_force, pair_force
from comparisons.questions.experiments.particles import leapfrog
from comparisons.questions.experiments.proved import punch_stiffness, pyramid_bounds
from comparisons.questions.experiments.punched_section import press_section
from reference import closed_form
from reference.bounds.flat_faces import equal_area_stiffness
from reference.contact.press import press
from reference.elasticity import lame_parameters, von_mises
from reference.halfspace import PeriodicOperator
from reference.halfspace.cohesive import CohesiveProblem, exponential
from reference.loads import Load
from reference.particles import Automata, periodic_packing
from reference.surfaces import SelfAffine, self_affine


def rough_patch() -> tuple[PeriodicOperator, np.ndarray]:
    """Return a periodic rough patch of 32 x 32 cells, with rms slope, side and E* of one."""
    spectrum = SelfAffine(power=3.6, rms_slope=1.0, long_cutoff=0.5, short_cutoff=1 / 8)
    heights = self_affine(32, 1.0, spectrum, seed=1, realisation=0)
    return PeriodicOperator((32, 32), (1 / 32, 1 / 32), 1.0), heights.max() - heights


def test_least_energy_is_the_equilibrium_of_newtons_method():
    """Two algorithms, one state: Newton's pressures at the depth of the least energy's gaps."""
    operator, gap = rough_patch()
    law = exponential(2e-4, 0.015)
    plain = press(operator, gap, Load("force", 0.02))
    least = Adhesive(operator, gap, law).at_force(0.02, plain.gap)
    newton = CohesiveProblem(operator, gap, law).at_penetration(gap.mean() - least.mean_gap)
    assert newton.force == pytest.approx(least.force, rel=1e-5)
    assert np.abs(newton.gap - least.gap).max() < 1e-4 * law.reach
    # adhesion draws more cells into contact
    assert newton.mask.sum() > plain.mask.sum()


def test_weak_adhesion_takes_what_the_surface_energy_loses_with_the_gap():
    """Derjaguin: the energy of an equilibrium is stationary, so that dF = d<phi>/d<h> at once."""
    operator, gap = rough_patch()
    law = exponential(3e-5, 0.015)
    low, middle, high = (press(operator, gap, Load("force", load)) for load in (0.021, 0.02, 0.019))
    weak = Adhesive(operator, gap, law).at_mean_gap(middle.mean_gap, middle.gap, 0.02)
    lost = law.energy(low.gap).mean() - law.energy(high.gap).mean()
    # central differences over loads 5 % apart, in which cells enter one by one
    assert 0.02 - weak.force == pytest.approx(lost / (high.mean_gap - low.mean_gap), rel=0.03)
    # ... and not what the tension across these gaps would take, for gaps at the rims open less
    across = np.mean(law.tension(middle.gap) * ~middle.mask)
    assert across > 1.2 * (0.02 - weak.force)


def test_the_work_of_a_pass_is_stored_damped_or_spent_on_bonds():
    """Steps of first order where velocities are damped: 1 %."""
    drag = Asperities(overlap=0.5, speed=0.2, radius=3.0, height=2.0).drag(0)
    assert_allclose(drag.stored + drag.damped + drag.spent, drag.work, rtol=0.02)
    assert drag.work > drag.spent > 0
    assert drag.broken > 0
    assert_allclose(np.trapezoid(drag.force, drag.way), drag.work, rtol=0.02)


def test_bonds_that_cannot_break_lose_nothing_and_nothing_is_worn():
    """A strain of 0.3 is not reached by tips that barely touch, and free pairs do not heal."""
    drag = Asperities(
        overlap=0.1, energy=0.045, healing=0.9, speed=0.2, radius=3.0, height=2.0
    ).drag(0)
    assert drag.broken == drag.healed == drag.worn == drag.loose == 0
    assert drag.spent == 0


@pytest.mark.slow
def test_a_seed_draws_the_same_pass_again():
    given = Asperities(overlap=0.5, speed=0.3, radius=3.0, height=2.0)
    first, again, other = given.drag(3), given.drag(3), given.drag(4)
    assert np.array_equal(first.force, again.force)
    assert not np.array_equal(first.force, other.force)
    assert von_mises(first.stress).max() > 0


RNG = np.random.default_rng(1)


def ringing(step_share=0.35):
    packing = periodic_packing((2, 2, 2))
    lame, shear = lame_parameters(0.3)
    fastest = np.sqrt(lame + 2 * shear)
    velocities = RNG.normal(size=(packing.free, 6))
    moved, automata = np.zeros_like(velocities), Automata(packing, 0.3)
    return leapfrog(automata, moved, velocities, step_share / fastest), velocities


def test_undamped_motion_conserves_energy_and_momentum():
    motion, velocities = ringing()
    before = velocities[:, :3].sum(axis=0)
    energies = list(islice(motion, 2000))
    assert np.ptp(energies) < 1e-10 * energies[0]
    np.testing.assert_allclose(velocities[:, :3].sum(axis=0), before, atol=1e-11)


@pytest.mark.parametrize("distance", [6.0, 20.0, 60.0])
def test_far_apart_the_other_punch_is_a_point_force(distance):
    """F/F_single = 1/(1 + 2a/(pi s)), corrections of the relative order (a/s)^2."""
    point = 2 / (np.pi * distance)
    interaction = 1 / pair_force(distance, 10) - 1
    assert interaction == pytest.approx(point, rel=1.5 / distance**2)


def test_the_interaction_does_not_need_a_fine_edge():
    """With the radius of its own stiffness the staircase cancels: 0.2 % from 4 to 16 cells."""
    coarse, fine = (1 / pair_force(4.0, cells) - 1 for cells in (4, 16))
    assert coarse == pytest.approx(fine, rel=2e-3)


def test_arrays_and_pairs_agree_where_they_meet():
    """Four punches at the corners: three neighbours as point forces, by hand."""
    point = 2 / (np.pi * 10.0)
    assert array_force(10.0, 2) == pytest.approx(1 / (1 + point * (2 + 1 / np.sqrt(2))), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["axisymmetric", "plane"])
@pytest.mark.parametrize("support", ["fixed", "inertia"])
def test_the_stiffness_converges_with_the_fourth_power_of_the_elements(kind, support):
    """Order of three meshes; the root singularity of the edge would leave first order at best."""
    values = [
        press_section(20.0, 0.3, kind=kind, support=support, elements=n).stiffness
        for n in (4, 8, 16)
    ]
    order = np.log2(abs(values[0] - values[1]) / abs(values[1] - values[2]))
    assert order > 3


@pytest.mark.slow
def test_in_plane_strain_the_compliance_grows_by_two_over_pi_per_e_fold():
    """Flamant's field: d = (2 F/(pi E*)) ln R + const, whatever nu; corrections O((a/R)^2)."""
    low, high = (
        1 / press_section(radius, 0.3, kind="plane", elements=16).stiffness
        for radius in (100.0, 1e4)
    )
    assert (high - low) / np.log(100) == pytest.approx(2 / np.pi, rel=2e-4)


@pytest.mark.slow
def test_mean_displacement_and_energy_far_away_are_those_of_a_point_force():
    """2 <u>/d = (7 - 6 nu)/(2 pi (1 - nu)) D/R, by integrating Boussinesq's u_z over a half-ball.

    Corrections are O((a/R)^2) and the radius of the body around: 1e-3 at R = 50 a, of the energy
    beyond 20 a 0.25 %.
    """
    nu, inner, outer = 0.3, 20.0, 50.0
    contact = press_section(1e5, nu, radii=(inner, outer), elements=16)
    exact = (7 - 6 * nu) / (2 * np.pi * (1 - nu))
    assert 2 * contact.mean_displacement[1] * outer / 2 == pytest.approx(exact, rel=2e-3)
    # E* a d^2 is the unit of energy, E* a d of force
    energy = closed_form.boussinesq_energy(1.0, inner, 1.0, nu) * contact.stiffness**2
    assert 1 - contact.energy[0] == pytest.approx(energy / (contact.stiffness / 2), rel=0.005)


def test_a_free_body_deforms_about_its_centre_of_mass():
    """Koenig: measured from the centre of mass the mean vanishes, and K exceeds m v^2/2."""
    contact = press_section(20.0, 0.3, support="inertia")
    assert abs(contact.mean_displacement[-1]) < 1e-12
    assert contact.mean_square_displacement[-1] > 0
    assert contact.energy[-1] == 1.0


@pytest.mark.slow
def test_the_problem_sheet_lies_within_coarser_intervals():
    # two enclosures of one number overlap; those of a few cells hold the sheet's
    file = Path(__file__).parents[4] / "docs" / "problem-sheet.csv"
    with file.open(newline="", encoding="utf-8") as lines:
        sheet = {row["problem"]: row for row in csv.DictReader(lines)}
    circle = equal_area_stiffness(4.0)
    coarse = {
        "square": punch_stiffness("polygon", 4, 1.0, "quick") * (1 / circle),
        "Vickers": pyramid_bounds(4, "quick") * math.tan(math.radians(68)),
    }
    for name, interval in coarse.items():
        sides = [float(sheet[name][side]) for side in ("not below", "not above")]
        assert interval.lower < sides[0] < sides[1] < interval.upper
        assert sides[1] / sides[0] - 1 < 2e-4
