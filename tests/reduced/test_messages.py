"""What the reduced model refuses: one table, each row with the words that say why."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from reduced.adhesion import adhere, pull_off
from reduced.errors import ConvergenceError
from reduced.film import Ball, approach, entrain
from reduced.friction.roll import roll, roll_rough
from reduced.friction.slide import Friction, follow, slide, tangential_modulus
from reduced.loads import Load, LoadPath
from reduced.memory.in_time import harmonic_stiffness, impact, indent_in_time
from reduced.memory.materials import fit, kelvin_voigt, prony, standard_solid
from reduced.memory.row import RelaxingSprings
from reduced.motion.blocks import Blocks, creep_speed, integrate
from reduced.motion.course import Mass, Push, Stepping, move
from reduced.motion.elastic_impact import SpringContact, strike
from reduced.plasticity import Yielding, YieldingSprings, walk
from reduced.profiles.equivalents import (
    cone,
    cylinder,
    paraboloid,
    power_law,
    rounded_punch,
    tabulated,
)
from reduced.profiles.section import Profile
from reduced.rough.ensemble import RandomLines, press_ensemble
from reduced.rough.line_spectrum import line_of, prescribed, resample, synthesise
from reduced.rough.press import RoughLines, press
from reduced.rough.procedure import calculate
from reduced.rough.regions import line_stress, regions
from reduced.rough.surface_spectrum import SelfAffineLaw, measured
from reduced.rubber.steady import slide as slide_on_rubber
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reduced.springs.stress import abel, local_rule
from reduced.wear import Oscillation, RoundBody, wear

BALL, TIP, PUNCH = paraboloid(1.0), cone(1.0), cylinder(1.0)
force, depth = partial(Load, "force"), partial(Load, "penetration")
pulled = partial(LoadPath, "tangential_force")
LINE, SLOPE = RoughLines([1.0, 2.0], 1.0), RoughLines(np.array([0.0, 1.0]), 1.0)
BOW = RoughLines(-(np.linspace(-1, 1, 65) ** 2), 1 / 32, periodic=False)
SPRINGS, UNIT, FRICTION = Springs(BALL, 1.3), Springs(BALL, 1.0), Friction(0.9, 0.4)
SOLID, KELVIN = prony(1.0, [3.0, 2.0], [0.3, 5.0]), kelvin_voigt(1.0, 1.0)
ELASTIC, FLUID = prony(1.0), prony(0.0, [1.0], [1.0])
LAW = SelfAffineLaw(hurst=0.8, rms_slope=0.1)
SPECTRUM = prescribed(8, 1.0, LAW)
DRAWN = RandomLines(SPECTRUM, 64, 2, 0)
STRAIGHT = tabulated([0.0, 0.25, 1.0], [0.0, 0.1, 1.0], "linear")
WORN = RoundBody(BALL, 2.0, 10)
# A ring whose middle does not touch.
HOLLOW = Profile("hollow", lambda x: (x - 1) ** 2, lambda x: 2 * (x - 1), None, 1.0)
FILM = Ball(0.01, 1e6, 1.0, 0.2)
SOFT = Yielding(1.0, 0.02)
PUSHED_AND_PULLED = LoadPath("force", [1e-9, -1e-9])


def in_time(times, control, loads, material=SOLID):
    return indent_in_time(RelaxingSprings(BALL, material), times, LoadPath(control, loads))


def rubbed(line, material, speed, force):
    return slide_on_rubber(line, material, speed, LoadPath("force", force))


def yielding(profile=BALL, modulus=1.0, hardness=2.84e-3, reading="stress", reach=1e-3):
    return YieldingSprings(profile, modulus, hardness, reading, reach=reach, springs=10)


def moved(springs, mass, **how):
    return move(SpringContact(springs, 0.1), mass, Stepping(0.1, 1), **how)


def worn(profile, reach, load=1.0, way=1.0):
    return list(wear(RoundBody(profile, reach, 30), 1.0, force(load), 1.0, np.array([way])))


WRONG = {
    "profiles": [
        (r"flat_radius.*-1.*edge_radius.*nan", lambda: rounded_punch(-1.0, np.nan)),
        ("penetration", lambda: BALL.contact_radius(-1e-9)),
        ("hollow", lambda: tabulated([0, 1, 2], [0, 1, 0.9], "pchip")),
        ("ring", lambda: tabulated([0, 1, 2], [0, 1, 1.1], "linear")),
        ("strictly", lambda: tabulated([0, 1, 1], [0, 1, 2], "pchip")),
        ("interpolation.*start at r = 0", lambda: tabulated([0.1, 1, 2], [0, 1, 2], "cubic")),
        ("finite", lambda: tabulated([0, 1, np.nan], [0, 1, 2], "pchip")),
        ("equal length", lambda: tabulated([0, 1], [0, 1, 2], "pchip")),
    ],
    "springs": [
        (
            "modulus.*radius.*edges.*offset",
            lambda: Springs(TIP, 0.0, per_radius=0, edges="cell", offset=1.0),
        ),
        *(
            ("spacing", lambda width=width: indent(Springs(TIP, 1.0, spacing=width), depth([1.0])))
            for width in (-1.0, np.nan, 2.0)
        ),
        ("'force', got 'mean_gap'", lambda: indent(UNIT, Load("mean_gap", 1.0))),
        *(
            ("penetration", lambda loads=loads: indent(UNIT, depth(loads)))
            for loads in ([], [0.0, 1.0], [2.0, 1.0], [np.nan], [[1.0]])
        ),
        (r"effective_modulus.*penetration.*r must", lambda: abel(TIP, -1.0, 0.0, np.array([-1.0]))),
        ("spacing", lambda: local_rule(TIP, 1.0, 1.0, np.array([1.0]), spacing=0.0)),
        # The tip of a cone and a kink of a straight-sided table carry logarithms.
        ("unbounded", lambda: abel(cone(0.3), 1.0, 0.1, np.array([0.0, 0.1]))),
        ("unbounded", lambda: abel(power_law(1.0, 0.3), 1.0, 0.1, np.array([0.0]))),
        ("unbounded", lambda: abel(STRAIGHT, 1.0, 0.4, np.array([0.25]))),
    ],
    "adhesion": [
        (
            "work .*control .*edges ",
            lambda: adhere(Springs(TIP, 1.0, edges="nodal"), 0.0, LoadPath("mean_gap", 1.0)),
        ),
        ("sharper than the root", lambda: pull_off(Springs(power_law(0.4, 1.0), 1.0), 0.013)),
    ],
    "friction": [
        (r"tangential_modulus.*coefficient", lambda: Friction(-1, np.nan)),
        ("full sliding", lambda: slide(SPRINGS, FRICTION, force(1.0), pulled([0.41]))),
        (
            "_displacement', 'tangential_force', got 'f",
            lambda: slide(SPRINGS, FRICTION, force(1.0), LoadPath("force", 1.0)),
        ),
        ("must be one value", lambda: slide(SPRINGS, FRICTION, force([1.0, 2.0]), pulled(0.1))),
        (r"spacing.*gap", lambda: follow(np.zeros(1), 0.0, 1.3, FRICTION, [1], [1])),
        ("one length", lambda: follow(np.zeros(2), 1.0, 1.3, FRICTION, [1], [1, 2])),
        ("poisson_ratio", lambda: tangential_modulus(1.0, 0.6)),
        ("finite", lambda: roll(UNIT, FRICTION, force(1.0), np.inf)),
        (
            "spacing.*force.*creep.*gap and",
            lambda: roll_rough(np.zeros(5), np.zeros(3), -1.0, 1.0, FRICTION, 0.0, np.nan),
        ),
    ],
    "memory": [
        ("dashpot", lambda: in_time([0.0, 1.0], "penetration", [0.1, 0.1], KELVIN)),
        (r"time must.*force must", lambda: in_time([1.0, 0.0], "force", [1.0, -1.0])),
        (
            "ratio.*spacing.*radius.*edges",
            lambda: RelaxingSprings(BALL, SOLID, 0.6, edges="x", per_radius=0, spacing=-1.0),
        ),
        ("'force', got 'speed'", lambda: in_time([0.0], "speed", [1.0])),
        ("poisson_ratio", lambda: harmonic_stiffness(SOLID, 1.0, 1.0, poisson_ratio=0.6)),
        (
            "long_term.*viscosity.*moduli.*times",
            lambda: prony(-1.0, [np.nan], [0.0], viscosity=-2.0),
        ),
        ("modulus or a viscosity", lambda: prony(0.0, [0.0], [1.0])),
        (r"long_term.*relaxation_time", lambda: standard_solid(-1.0, 1.0, 0.0)),
        (r"frequency.*loss", lambda: fit([0.0, 1.0], [1.0 - 1.0j, 1.0 + 1.0j])),
        ("times", lambda: SOLID.relaxation(-1.0)),
        (
            "mass.*velocity.*steps",
            lambda: impact(RelaxingSprings(PUNCH, ELASTIC), -1.0, 0.0, steps=0),
        ),
        ("G_inf > 0.*speed.*force", lambda: rubbed(LINE, FLUID, [-1.0], 0.0)),
        ("dashpot", lambda: rubbed(LINE, ELASTIC, 1.0, 1.0)),
    ],
    "motion": [
        (
            "mass .*stiffness .* symmetric",
            lambda: Blocks([-1.0, 1.0], 1.0, stiffness=[[1.0, 2.0], [0.0, 1.0]]),
        ),
        ("step must be finite and positive", lambda: Stepping(0.0, 1)),
        (
            "characteristic_speed.*scheme",
            lambda: integrate(Blocks(1.0, 1.0), 0.0, Stepping(1.0, 1), scheme="euler"),
        ),
        ("below the limit", lambda: creep_speed(1.0, 1.0, 1.0)),
        (r"mass must be.*velocity must be", lambda: strike(UNIT, -1.0, [1.0, 0.5])),
        (r"mass must be.*damping must be finite and >= 0", lambda: Mass(0.0, damping=-1.0)),
        (r"step must be.*multiple of stride = 2", lambda: Stepping(0.0, 3, stride=2)),
        ("scheme must be one of", lambda: moved(UNIT, Mass(1.0), scheme="euler")),
        ("history must be increasing", lambda: Push(history=([1.0, 0.0], [1.0, 1.0]))),
        ("sub_cell", lambda: moved(Springs(BALL, 1.0, edges="nodal"), Mass(1.0))),
    ],
    "rough lines": [
        (
            "hurst and power.*rms_slope and rms_height.*long",
            lambda: SelfAffineLaw(long_cutoff=-1.0),
        ),
        (
            r"hurst .*-0.5.*long_cutoff",
            lambda: SelfAffineLaw(hurst=-0.5, rms_slope=0.1, long_cutoff=np.nan),
        ),
        (r"points .*16.5.*size .*0.0", lambda: prescribed((16.5, 16), (1.0, 0.0), LAW)),
        ("one of 'rings', 'split', 'printed'", lambda: prescribed(64, 1.0, LAW, rule="sums")),
        ("one number or two", lambda: prescribed(16, (1.0, 1.0, 1.0), LAW)),
        ("no mode", lambda: prescribed(64, 1.0, replace(LAW, short_cutoff=2.0))),
        (r"size.*2-D", lambda: line_of(measured(np.zeros(4), -1.0))),
        ("finite", lambda: line_of(measured(np.full((4, 4), np.nan), 1.0))),
        ("Generator", lambda: synthesise(SPECTRUM, 64)),
        ("length", lambda: resample(SPECTRUM, 0.0)),
        ("realisations", lambda: press_ensemble(RandomLines(SPECTRUM, 64, 0, 0), 2.0, force(1.0))),
        ("quantities", lambda: press_ensemble(DRAWN, 2.0, force(1.0), quantities=["colour"])),
        ("flat", lambda: calculate(measured(np.full((8, 8), 3.0), 1.0), 1.0, np.ones(1))),
        (r"finite.*spacing", lambda: RoughLines([1.0, np.nan], 0.0)),
        ("modulus.*edges.*threads", lambda: press(LINE, -1.0, force(1.0), edges="cell", threads=0)),
        ("'force', 'mean_gap', got 'area'", lambda: press(LINE, 1.0, Load("area", 1.0))),
        ("strictly increasing", lambda: press(LINE, 1.0, force([2.0, 1.0]))),
        ("threads must be an integer", lambda: press(LINE, 1.0, force([1.0]), threads=np.nan)),
        ("n >= 2", lambda: press(RoughLines([1.0], 1.0), 1.0, force([1.0]))),
        ("one line, got 2", lambda: regions(RoughLines(np.zeros((2, 2)), 1.0), 1.0)),
        (r"edges.*penetration", lambda: regions(SLOPE, np.nan, edges="x")),
        ("rule", lambda: line_stress(SLOPE, 1.0, 1.0, rule="mean")),
        ("effective_modulus", lambda: line_stress(SLOPE, 0.0, 1.0)),
    ],
    "films": [
        # Steps of the load shrink with the cells: on one there would be no next step.
        *(
            ("resolution must be an integer >= 4", partial(solve, FILM, 1e-2, cells))
            for solve in (entrain, approach)
            for cells in (0, 1, 3)
        ),
        (r"viscosity .*rule", lambda: Ball(0.01, 1e6, 0.0, 0.2, "wide")),
    ],
    "wear": [
        (
            r"coefficient .* distances",
            lambda: next(wear(WORN, 1.0, force(1.0), 0.0, np.array([2.0, 1.0]))),
        ),
        ("lag", lambda: Oscillation(1.0, -1.0)),
    ],
    "yield": [
        ("curved everywhere", lambda: yielding(TIP)),
        ("modulus.*hardness.*reach.*reading", lambda: yielding(BALL, -1.0, 0.0, "hard", np.nan)),
        ("nothing holds", lambda: yielding().walk(PUSHED_AND_PULLED)),
        ("nothing holds", lambda: walk(SLOPE, SOFT, LoadPath("force", -1.0))),
        ("hardness.*'stress' only", lambda: Yielding(1.0, -1.0, "elastic_root", "one_radius")),
    ],
}
LOST = [
    ("end of the line", lambda: rubbed(BOW, KELVIN, 1.0, 100.0)),
    ("did not leave", lambda: moved(UNIT, Mass(1.0, velocity=0.1)).release()),
    ("steps", lambda: worn(BALL, 2.0, way=1e9)),
    ("no full circle", lambda: worn(HOLLOW, 3.0, 1.3)),
    # On rings up to its first contact radius.
    ("wider than the rings", lambda: worn(BALL, 1.0, 1.3)),
    ("never carry", lambda: walk(SLOPE, SOFT, LoadPath("force", 1e9))),
]


@pytest.mark.parametrize(
    ("words", "call"),
    [
        pytest.param(*row, id=f"{room}-{place}")
        for room, rows in WRONG.items()
        for place, row in enumerate(rows)
    ],
)
def test_wrong_arguments_are_all_named(words, call):
    with pytest.raises(ValueError, match=words):
        call()


@pytest.mark.parametrize(("words", "call"), LOST, ids=[words for words, _ in LOST])
def test_what_has_no_answer_is_an_error_with_its_reason(words, call):
    with pytest.raises(ConvergenceError, match=words):
        call()


def test_too_thin_films_are_told():
    """No NaN, but a reason and the history of errors."""
    with pytest.raises(ConvergenceError, match="too thin") as caught:
        entrain(FILM, 1e-9, 8)
    assert caught.value.history
