"""What experiments measure, in closed form, where no claim's verdict would tell a fault."""

import math
from functools import cache

import pytest

from comparisons.methods.adhesion import edge_doubt
from comparisons.questions.experiments import EXPERIMENTS
from comparisons.scene.scene import load_scene
from comparisons.solving.execution import execute
from comparisons.solving.planning import plan_scene
from comparisons.tasks.task import Task


def measure(name, value, effort="quick", **parameters):
    return EXPERIMENTS[name].measure(value, effort, **parameters)


RULES = ("own_curvature", "one_radius")
MATES = {"against": "surfaces", "quantity": "stiffness"}
# Experiment, value, its parameters, error, and by how much it may differ. A claim judged quickly
# says neither how wrong a rule is nor where it begins to be.
ERRORS = [
    # equal to theory, to rounding or to the error of an integration
    *(("first-yield", 2, {"rule": rule}, 0.0, 1e-6) for rule in RULES),
    *(("transverse-isotropy", ratio, {}, 0.0, 1e-9) for ratio in (0.1, 0.7, 10.0)),
    *(
        ("corrected-rubber", number, {"quantity": quantity}, 0.0, 1e-7)
        for number in (0.1, 10.0)
        for quantity in ("work", "friction")
    ),
    ("free-vibration", 2.5, {}, 0.0, 1e-5),  # the ball flies
    ("procedure", 0.1, {"quantity": "undefined", "variant": "corrected"}, 0.0, 0.0),
    ("forced-vibration", 1e-3, {"model": "linear"}, 0.0, 1e-6),  # a weak drive at resonance
    ("far-field", 50.0, {"reading": "corrected"}, 0.0, 1e-4),
    ("influence-coefficient", 63, {"reading": "corrected"}, 0.0, 1e-10),
    ("line-moments", 64, {"rule": "rings"}, 0.0, 1e-12),
    ("line-moments", 64, {"rule": "rings", "quantity": "curvature_laplacian"}, 0.0, 0.005),
    ("straight-area", 0.01, {"realisations": 4}, 0.0, 1e-12),
    # wrong by what theory says
    ("far-field", 50.0, {}, math.pi - 1, 2e-3),
    ("influence-coefficient", 0, {}, (1 + math.pi) / 2 - 1, 1e-12),  # two terms without 1/pi
    ("line-moments", 64, {}, 1.102**2 - 1, 0.002),
    ("line-moments", 64, {"quantity": "curvature_product"}, -1.0, 1e-6),
    ("line-moments", 64, {"rule": "split", "quantity": "section_slope"}, 2**0.5 - 1, 1e-9),
    ("first-yield", 2, {"criterion": "mises"}, 0.62**3 - 1, 0.002),  # Johnson 4.2
    ("regularised-block", 1e4, {"quantity": "way"}, 4 / math.pi * 1e-4, 3e-7),  # + v0^2 log v0
    ("ridges", 0.5, {}, math.pi / 2 - 1, 1e-9),  # Westergaard's 1/2, the line's ceiling pi/4
    ("ridges", 0.5, {"quantity": "mean_gap"}, -1.0, 0.0),
    ("adhesive-range", 0.01, {}, -0.25, 0.01),  # -2 pi w R against -1.5 pi w R
    ("adhesive-range", 100.0, {}, 0.0, 1e-3),
    ("equivalent-body", 1, {}, 4 / math.pi - 1, 1e-12),  # (4/pi) int sin^n
    ("equivalent-body", 4, {}, -0.25, 1e-12),
    ("regularised-block", 200.0, {}, 1 / 200, 1e-14),  # tan(pi/4) v0
    ("regularised-block", 200.0, {"quantity": "kinetic"}, -2 / math.pi * math.atan(0.005), 1e-14),
    ("free-vibration", 1.1, {"model": "linear"}, 0.1**2 / 24, 2e-5),  # Nayak 1972, to order A^3
    # wrong by what is measured, or by no more than this
    pytest.param(  # in proportion to the amplitude
        *("harmonic-contact", 0.02, {}, 0.0078, 0.0025), marks=pytest.mark.slow
    ),
    ("harmonic-contact", 0.2, {}, 0.103, 0.005),
    ("regularised-amplitude", 10, {}, 0.1993, 1e-3),
    ("regularised-amplitude", 100, {}, 0.0380, 1e-3),
    ("set-valued-steps", 100, {}, 4.3e-3, 4e-4),  # of second order, friction being continuous
    ("set-valued-steps", 800, {}, 6.1e-5, 6e-6),
    ("relaxation-series", 0.5, {}, 0.378, 0.01),
    ("relaxation-series", 2, {}, 0.0062, 1e-3),
    ("printed-rubber", 1.0, {}, 0.0, 0.05),
    ("printed-rubber", 2.2, {}, -52.0, 14.0),
    ("procedure", 0.1, {"quantity": "undefined", "variant": "literal"}, 0.494, 0.01),
    ("two-rough-bodies", 0.003, {}, 0.0, 0.05),
    ("two-rough-bodies", 0.01, MATES | {"correlation": 0.0}, 0.05, 0.1),
    pytest.param(
        *("two-rough-bodies", 0.01, MATES | {"correlation": -0.8}, -0.29, 0.05),
        marks=pytest.mark.slow,
    ),
    *(
        ("contact-ends", 0.02, {"quantity": quantity, "model": "line", "exponent": 0.0}, 0.0, 0.1)
        for quantity in ("pressure", "gap")
    ),
    ("contact-ends", 0.02, {"quantity": "pressure", "exponent": 1.0}, 0.0, 0.35),
    ("contact-ends", 0.02, {"quantity": "gap", "exponent": -1 / 3}, 0.0, 0.05),
    ("rough-contact", 0.01, {}, 1.78, 0.23),  # the area; line and surface agree in the others
    ("rough-contact", 0.01, {"quantity": "stiffness"}, 0.0, 0.15),
    ("rough-contact", 0.01, {"quantity": "penetration"}, 0.0, 0.15),
]


@pytest.mark.parametrize(("name", "value", "parameters", "error", "within"), ERRORS)
def test_an_error_has_its_size(name, value, parameters, error, within):
    assert abs(measure(name, value, **parameters).error - error) <= within


def test_the_bars_of_quick_runs_hold_what_full_runs_find():
    """Twice as many steps: the change lies inside the bar of the coarser run, or near round-off."""
    for name, value in (("regularised-stick-slip", 1e3), ("regularised-belt", 1.2)):
        quick, full = (measure(name, value, effort) for effort in ("quick", "full"))
        assert abs(quick.error - full.error) <= quick.uncertainty + full.uncertainty


def test_without_a_difference_of_frictions_the_law_still_damps_the_swing():
    """Friction that rises with the speed takes energy; a smaller v0 takes less."""
    coarse = measure("regularised-belt", 1.0, speed_ratio=1e2).error
    fine = measure("regularised-belt", 1.0, speed_ratio=1e4).error
    assert coarse < fine < 0


def test_a_ball_that_is_pushed_at_one_depth_is_cattaneos_in_both_models():
    """Half of the sliding displacement: F_x = (1 - (1/2)^(3/2)) mu F; the half-space 0.2 % off it.

    Slip off the axis, which the springs leave out, is what remains.
    """
    measured = measure("changing-load", 1.0)
    assert measured.details["stated"] == pytest.approx(1 - 0.5**1.5, abs=1e-6)
    assert abs(measured.error) < 2e-3


def test_a_ball_that_is_pushed_in_deeper_as_it_is_pushed_aside_sticks():
    """Mindlin and Deresiewicz: dF_x/dF below mu throughout, so that nothing slips."""
    measured = measure("changing-load", 2.0)
    assert measured.details["share of the springs that stick"] == pytest.approx(1.0)
    assert measured.details["stated"] < 0.5


@cache
def face(effort="quick", **parameters):
    return EXPERIMENTS["adhesive-face"].measure(None, effort, **parameters)


def peeled(indenter, cells):
    """Pull-off force of the calibrated grid over the rule of equal area, and the grid's doubt."""
    forces = {"force": ["0 mN", "40 mN", "-400 mN"]}
    changes = {"half_space.effective_modulus": 2e6, "indenter": indenter, "loading": forces}
    scene = load_scene("adhesive-ball", changes)
    (plan, *_) = plan_scene(scene)
    force = {}
    for name, resolution in (("bem_fft", cells), ("reduced", 10)):
        given = name, resolution, ("pull_off_force",)
        task = Task(scene, plan.geometry, plan.loads, *given)
        force[name] = execute(task, 1).quantities["pull_off_force"][0, 0]
    return force["bem_fft"] / force["reduced"], edge_doubt(plan.geometry, cells)


@pytest.mark.slow
def test_the_limit_for_a_disc_is_kendalls_punch_to_a_percent():
    """Three zones, to an eighth of the radius: 0.7 % off, within a bar that is no wider."""
    result = face("full")
    assert abs(result.error) < 0.01
    assert abs(result.error) <= result.uncertainty < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("indenter", "parameters"),
    [
        ({"shape": "square_punch", "side": 2e-3}, {"shape": "square"}),
        ({"shape": "elliptic_punch", "semi_axes": [2e-3, 1e-3]}, {"aspect": 2.0}),
        ({"shape": "elliptic_punch", "semi_axes": [4e-3, 1e-3]}, {"aspect": 4.0}),
    ],
)
def test_the_doubt_of_the_calibrated_edge_covers_faces_without_a_closed_form(indenter, parameters):
    """Two methods that share nothing but the kernel, each within its own bar."""
    ratio, doubt = peeled(indenter, 12)
    limit = face(**parameters)
    assert abs(ratio * (1 + limit.error) - 1) <= doubt + limit.uncertainty
