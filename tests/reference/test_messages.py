"""What the reference refuses: one table, each row with the words that say why."""

import re
from functools import cache, partial

import numpy as np
import pytest

from reference import closed_form, surfaces
from reference.bounds.interval import Interval
from reference.closed_form import PartialSlip, rough_theories
from reference.closed_form.adhesive import AdhesiveForm
from reference.closed_form.worn import FrettingLimit
from reference.contact.press import CONTROLS, press, sweep
from reference.elasticity import Material
from reference.errors import ConvergenceError
from reference.fem import (
    Enforcement,
    RingMesh,
    TensorMesh,
    at_quadrature_points,
    columns,
    half_space_body,
    indent,
    nodal_friction,
    recover,
    two_bodies,
)
from reference.fem import press as press_elements
from reference.halfspace import FreeOperator, PeriodicOperator, cohesive, friction, punches
from reference.halfspace.detachment import peel
from reference.halfspace.stress_below import stress_below
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.halfspace.wear import Oscillation, wear
from reference.layered import Graded, Stack
from reference.loads import History, Load, LoadPath
from reference.lubrication import point as film
from reference.lubrication.reynolds import rigid_cylinder
from reference.particles import Automata, Domain, ParticleHalfSpace
from reference.plastic import PlasticMaterial, Walk
from reference.rolling.creep_theories import kalker
from reference.rolling.roll import Creep, roll
from reference.viscoelastic import creep, indentation, press_in_time
from reference.viscoelastic.materials import GeneralisedMaxwell as Maxwell
from reference.viscoelastic.rubber import slide_on_rubber
from reference.viscoelastic.travelling import Travelling

STEEL, BALL = Material(1.0, 0.3), closed_form.paraboloid(1.0, 1.0)
OVAL = closed_form.ellipsoid(1.0, 2.0, 1.0)
GRID, CLOSED = (body((4, 4), (1.0, 1.0), 1.0) for body in (FreeOperator, PeriodicOperator))
depth = partial(History, "penetration")
LEVEL, SLOPE = np.zeros((4, 4)), np.arange(16.0).reshape(4, 4)
CORK, ITERATED = Material(1.0, 0.5), "conjugate_gradients"
FORCE, DEPTH = Load("force", 1.0), Load("penetration", 1.0)
COLUMNS = (np.ones(1), np.ones(1)), (1.0, 1.0), Stack([9.0], [STEEL])
SOLID = Maxwell(1.0, [3.0], [0.3])
RUBBER = Travelling((24, 24), (0.4 / 24,) * 2, Maxwell.standard(0.25, 2.5, 0.1), 0.3)
SPRINGS = Enforcement("penalty")
AXIS = (np.arange(24) - 11.5) * 0.4 / 24
BOWL = (AXIS[:, None] ** 2 + AXIS**2) / 2
SHEARED = NormalAndTangential((8, 8), (1 / 8, 1 / 8), Compliance.of(1.0, 0.3))
SOFT = film.Ball(radius=0.01, effective_modulus=1e6, viscosity=1.0, load=0.2)
LINES = np.linspace(0.0, 1.0, 4)


def ROUND(x, y):  # noqa: N802
    return (x**2 + y**2) / 2


@cache
def ring(**options):
    return half_space_body(RingMesh(1.0, elements=2), STEEL, **options)


@cache
def box(symmetry=None, away=0.0):
    mesh = TensorMesh(LINES + away, LINES, **({"symmetry": symmetry} if symmetry else {}))
    return half_space_body(mesh, STEEL)


@cache
def particles():
    return ParticleHalfSpace(Domain((2.0, 2.0), 2.0), [(1.0, 0.3)])


def on_ring(gap, load=DEPTH, *how, **start):
    return list(press_elements(ring(), gap * np.ones(len(ring().nodes)), load, *how, **start))


def at_gauss_points(how):
    points = at_quadrature_points(ring())
    return press_elements(points, np.zeros(len(points.weights)), DEPTH, how)


def indented(gap, body=ring, **how):
    return list(indent(body(), gap, DEPTH, **how))


def spectrum(**keys):
    return surfaces.amplitude_spectrum(16, 1.0, surfaces.SelfAffine(**keys))


def slid(**loads):
    paths = [LoadPath(control, values) for control, values in loads.items()]
    return next(friction.sweep(friction.FrictionalPress(SHEARED, np.zeros((8, 8)), 0.4), *paths))


def rolled(creep):
    """Roll with a contact that reaches all sides of its grid."""
    return list(roll(friction.FrictionalPress(SHEARED, BOWL[:8, :8], 0.3), FORCE, [Creep(creep)]))


WRONG = {
    "bounds": [("is not below", lambda: Interval(1.0, 0.999))],
    "closed forms": [
        ("flat_.*-1.*edge_.*nan.*mod.*0.0", lambda: closed_form.rounded_punch(-1.0, np.nan, 0.0)),
        ("radius.*'1'.*mod.*True", lambda: closed_form.paraboloid("1", True)),
        ("1e15", lambda: closed_form.ellipsoid(1e16, 1.0, 1.0)),
        ("distance must be positive", lambda: closed_form.boussinesq(1.0, [1.0, 0.0], 1.7)),
        ("work must be", lambda: AdhesiveForm(closed_form.sphere(1.0, 1.0), 0.0)),
        ("above 1/2", lambda: AdhesiveForm(closed_form.power_law(0.5, 1.0, 1.0), 1.0)),
        ("control must be", lambda: AdhesiveForm(BALL, 1.0).pull_off("time")),
        ("slips", lambda: FrettingLimit(BALL, 1.0, 2.0)),
        ("at most mu F", lambda: (s := PartialSlip(BALL, 0.1, 0.3, 0.8)).along([1.1 * s.limit])),
        ("friction", lambda: PartialSlip(BALL, 0.5, 0.0, 0.8)),
        ("no circle", lambda: PartialSlip(OVAL, 0.5, 0.3, 0.8).along([0.0]).stick_radius),
        (r"1\.5", lambda: rough_theories.Moments(1.0, 1.0, 1.4)),
        ("ascend", lambda: rough_theories.Persson(np.array([2.0, 1.0]), np.ones(2))),
        ("relative_load", lambda: rough_theories.bush_gibson_thomas_area(-1.0)),
    ],
    "motion": [
        (r"axis_ratio.*poisson_ratio", lambda: kalker(20.0, -0.1)),
        ("along must be finite", lambda: rolled(np.nan)),
    ],
    "half-space": [
        ("shape.*spacing.*effective_modulus", lambda: FreeOperator((0, 4), (1.0, -1.0), np.nan)),
        (r"pressure has shape \(4, 5\)", lambda: GRID.apply(np.ones((4, 5)))),
        ("kernel", lambda: PeriodicOperator((4, 4), (1.0, 1.0), 1.0, kernel="spline")),
        ("square.*shape", lambda: punches.respond(FreeOperator((2, 2), (1, 2.0), 1.0), np.ones(3))),
        (r"tolerance.*max_iter", lambda: press(GRID, LEVEL, FORCE, tolerance=0, max_iterations=0)),
        # full contact has d = <g> whatever the force: the penetration says nothing about it
        ("give the force", lambda: press(CLOSED, SLOPE, Load("penetration", 7.6))),
        ("first touch", lambda: press(CLOSED, SLOPE, Load("mean_gap", 7.6))),
        ("mask has shape .*; work must be", lambda: peel(GRID, SLOPE, np.ones((3, 3)), -1.0)),
        ("rule must be", lambda: peel(GRID, SLOPE, SLOPE < 1, 1.0, rule="own")),
        ("reach must be", lambda: cohesive.exponential(1.0, 0.0)),
        ("ramp", lambda: cohesive.dugdale(1.0, 1.0, 1.5)),
        (
            "friction must be positive",
            lambda: friction.FrictionalPress(SHEARED, BOWL[:8, :8], -1.0),
        ),
        ("one of penetration, force, not 'tan", lambda: slid(tangential_force=1.0, force=1.0)),
        ("same number of steps", lambda: slid(force=[1.0, 2.0], tangential_force=[0.0] * 3)),
        (r"shear_modulus.*poisson_ratio", lambda: Compliance.of(0.0, 0.7)),
        ("finite", lambda: stress_below([[np.nan]], (1.0, 1.0), 1.0, 0.3)),
        ("grid", lambda: stress_below([1.0], (1.0, 1.0), 1.0, 0.3)),
        ("(?s)spacing.*depth", lambda: stress_below([[1.0]], (1.0, 0.0), -1.0, 0.3)),
        ("poisson_ratio", lambda: stress_below([[1.0]], (1.0, 1.0), 1.0, 0.7)),
        ("increasing", lambda: wear(GRID, LEVEL, FORCE, 1.0, np.array([2.0, 1.0]))),
        ("free half", lambda: wear(CLOSED, LEVEL, FORCE, 1, np.ones(1), Oscillation(1.0, 1.0))),
    ]
    + [
        (
            words,
            partial(lambda by, gap, *load: press(GRID, gap, Load(*load), by=by), by, gap, *load),
        )
        for by in CONTROLS
        for words, gap, *load in (
            ("control must be one of penetration, force.*not 'area'", LEVEL, "area", 1.0),
            ("positive and finite, not -1.0", LEVEL, "penetration", -1.0),
            ("positive and finite, not nan", LEVEL, "force", np.nan),
            ("strictly increasing", LEVEL, "force", [2.0, 1.0]),
            ("use sweep", LEVEL, "force", [1.0, 2.0]),
            (r"shape \(3, 4\)", LEVEL[:3], "force", 1.0),
            ("negative", LEVEL - 1, "force", 1.0),
        )
    ]
    + [
        (words, partial(lambda by, *of: sweep(GRID, of[0], Load("force", of[1]), by=by), by, *of))
        for by in CONTROLS
        for words, *of in (
            ("NaN", LEVEL * np.nan, [1.0]),
            ("infinite everywhere", LEVEL + np.inf, [1.0]),
            ("strictly increasing", LEVEL, [2.0, 1.0]),
        )
    ]
    + [
        (words, partial(solver, FreeOperator((2, 2), (1.0, 1.0), 1.0), face))
        for solver in (punches.respond, punches.respond_dense)
        for words, face in (
            ("between 0 and 1", [[0.5, 2.0], [np.nan, 0.0]]),
            ("no cell lies under the face", np.zeros((2, 2))),
        )
    ],
    "layers": [
        (r"as many, not 2 and 1; thicknesses\[0\] .*; thick", lambda: Stack([-1, np.nan], [STEEL])),
        ("rigid base must carry", lambda: Stack([], [])),
        ("depth .*; exponent must lie between -1 and 1, not 1", lambda: Graded(STEEL, 1.0, 0.0)),
        ("at least one", lambda: columns.compliance(*COLUMNS[:2], Stack([], [], STEEL))),
        ("element .*growth", lambda: columns.compliance(*COLUMNS, element="x", growth=9)),
        ("inertia", lambda: columns.tensor(*COLUMNS, inertia=1.5)),
    ],
    "elements": [
        (
            ("extent must be", "contact_radius", "elements", "symmetry", "edge"),
            lambda: RingMesh(-1.0, elements=1, symmetry="half", edge=3.0, extent=1.0),
        ),
        ("youngs_modulus must be positive.*poisson_ratio", lambda: Material(-1.0, 0.6)),
        ("solver must be", lambda: ring(solver="gauss")),
        ("which is indefinite", lambda: half_space_body(RingMesh(1.0), CORK, solver=ITERATED)),
        ("take order = 2", lambda: half_space_body(TensorMesh(LINES, LINES), CORK)),
        ("order.*x .*y must", lambda: TensorMesh(LINES[::-1], LINES + 1, "quarter", order=3)),
        ("reactions", lambda: recover(ring(), np.zeros(3))),
        ("method .*penalty.*max_", lambda: Enforcement("lagrange", penalty=-1, max_iterations=0)),
        ("control must be one of penetration, force", lambda: on_ring(0.0, Load("mean_gap", 1.0))),
        ("must be positive", lambda: on_ring(0.0, LoadPath("penetration", [0.1, -1.0]))),
        ("finite somewhere", lambda: on_ring(np.inf)),
        ("mesh circle", lambda: indented(lambda x, y: x**2, box)),
        ("gap .*start must", lambda: press_elements(ring(), np.zeros(1), FORCE, start=[True])),
        ("even in x", lambda: indented(lambda x, y: (x - 0.1) ** 2 + y**2)),
        ("one gap per point", lambda: indented(lambda x, y: 1.0)),
        ("nodes as candidates", lambda: at_quadrature_points(at_quadrature_points(ring()))),
        ("'nodes' or 'quadrature'", lambda: indented(lambda x, y: x**2 + y**2, points="corners")),
        (
            "contact_radius.*elements.*poisson_ratio",
            lambda: nodal_friction.frictional_body(0, CORK, elements=1),
        ),
        ("active_set", lambda: list(indent(ring(solver=ITERATED), ROUND, DEPTH, SPRINGS))),
        (
            "coupling must be.*multipliers must be.*same share",
            lambda: two_bodies.couple(box(), box("quarter"), coupling="glue", multipliers="x"),
        ),
        ("straight sides", lambda: two_bodies.couple(ring(), box("quarter"))),
        ("do not overlap", lambda: two_bodies.couple(box(), box(away=5.0))),
        ("finite", lambda: two_bodies.couple(box(), box()).press(lambda x, y: x * np.nan, DEPTH)),
    ]
    + [
        ("must be 'penalty' at quadrature points", partial(at_gauss_points, Enforcement(method)))
        for method in ("active_set", "augmented_lagrangian")
    ],
    "plasticity": [
        (
            ("yield_stress", "law", "hardening", "0.4999"),
            lambda: PlasticMaterial(CORK, -1.0, -1.0, "cubic"),
        ),
        (
            ("per_radius", "smallest"),
            lambda: Walk(PlasticMaterial(STEEL, 2e-3), np.square, 1.0, smallest=2.0, per_radius=1),
        ),
    ],
    "particles": [
        ("poisson_ratio must lie", partial(Automata, None, nu)) for nu in (0.6, -1.0, np.nan)
    ]
    + [
        ("must be below 0.5: mean stress", partial(Automata, None, 0.5)),
        ("loaded_x.*; margin", lambda: Domain((-1.0, 2.0), np.nan)),
        ("gap must have one number", lambda: next(particles().press([1.0, 2.0], DEPTH))),
    ],
    "films": [
        (
            "radius .*viscosity .*meniscus",
            lambda: film.Ball(-1, 1, viscosity=0, load=1, meniscus=0),
        ),
        ("speed must be positive", lambda: film.entrain(SOFT, 0.0, 8)),
        ("resolution .* 2", lambda: rigid_cylinder(1)),
        ("no ball of radius", lambda: film.entrain(SOFT, 1e3, 8)),
    ]
    # steps of the load shrink with the cells: on two there would be no next step
    + [
        (r"resolution must be .* 4", partial(solve, SOFT, 1e-2, cells))
        for solve in (film.entrain, film.approach)
        for cells in (1, 2, 3)
    ],
    "surfaces": [
        ("hurst and power.*rms_slope and rms_height.*long", lambda: spectrum(long_cutoff=-1.0)),
        (r"hurst must lie in \[0, 1\], not 1.5", lambda: spectrum(hurst=1.5, rms_slope=0.1)),
        ("below the short", lambda: spectrum(hurst=0.5, rms_slope=0.1, short_cutoff=2.0)),
        ("positive integer", lambda: surfaces.refine(np.zeros((4, 4)), 0)),
    ],
    "memory": [
        ("shape", lambda: slide_on_rubber(RUBBER, BOWL[:20], DEPTH)),
        ("not 'mean_gap'", lambda: slide_on_rubber(RUBBER, BOWL, Load("mean_gap", 1.0))),
        ("fluid.*speed", lambda: Travelling((4, 4), (1.0, 1.0), Maxwell(0.0, (1,), (1,)), 0.0)),
        (
            "falls once",
            lambda: indentation(BALL, 1.0, SOLID, depth([0, 1, 2, 3], [0, 1, 0, 1]), [1]),
        ),
        ("never falls", lambda: creep(BALL, 1.0, SOLID, History("force", [0, 1], [2, 1]), [1.0])),
        ("control must", lambda: press_in_time(GRID, SLOPE, SOLID, History("mean_gap", [0], [1]))),
        (
            "start at",
            lambda: press_in_time(GRID, SLOPE, Maxwell.kelvin_voigt(1, 1), depth([0], [1])),
        ),
        ("finite, not .* increasing", lambda: History("force", [0, 2.0, 1.0], [0, 1.0, np.inf])),
        ("as long as its times, of which there are 2", lambda: depth([0.0, 1.0], [0.0, 1.0, 2.0])),
        ("equi.*viscosity.*moduli.*times", lambda: Maxwell(-1.0, [np.inf], [0.0], viscosity=-1.0)),
        ("nothing resists", lambda: Maxwell(0.0)),
    ],
}
LOST = [
    ("full sliding", lambda: slid(force=1.0, tangential_force=[0.5])),
    ("overflows", lambda: on_ring(0.0, Load("force", 1e300))),
    ("grows without end", lambda: indented(lambda x, y: 0.0 * x)),
    ("infinite at every size", lambda: indented(lambda x, y: np.full_like(x, np.inf))),
    (
        "passes between the automata",
        lambda: next(particles().press(particles().points[:, 0] * 0 + 2, DEPTH)),
    ),
    ("leading edge", lambda: rolled(0.1)),
    ("edge of the grid", lambda: slide_on_rubber(RUBBER, BOWL, FORCE)),
    ("steps", lambda: list(wear(GRID, SLOPE / 9, FORCE, 1.0, np.array([1e9])))),
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
    with pytest.raises(ValueError, match=r"\w") as caught:
        call()
    for part in (words,) if isinstance(words, str) else words:
        assert re.search(part, str(caught.value))


@pytest.mark.parametrize(("words", "call"), LOST)
def test_what_has_no_answer_is_an_error_with_its_reason(words, call):
    with pytest.raises(ConvergenceError, match=words):
        call()
