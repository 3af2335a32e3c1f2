"""What a method does not do is said, with the reason: a line for each reason of each method.

An option that a solver does not read is refused, never recorded as if it had acted.
"""

from typing import Literal

import numpy as np
import pytest

from comparisons.geometry.prepare import equivalent_profile, prepare
from comparisons.methods import Solver
from comparisons.methods.adhesion import adhesive_form_of
from comparisons.methods.registry import SOLVERS, solver_for
from comparisons.methods.solver import Refusal
from comparisons.questions.claims.claim import load_claims, scene_of
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.options import MethodOptions
from comparisons.scene.scene import SceneError, load_scene

CONE = {"indenter": {"shape": "cone", "slope": 0.1}}
FLAT = {"indenter": {"shape": "cylinder", "radius": "1 mm"}}
SQUARE = {"indenter": {"shape": "square_punch", "side": "1 mm"}}
SHARP = {"indenter": {"shape": "power_law", "exponent": 0.4, "coefficient": 0.1}}
ELLIPSOID = {"indenter": {"shape": "ellipsoid", "radius_x": "10 mm", "radius_y": "20 mm"}}
OVAL = {"indenter": {"shape": "ellipsoid", "radius_x": "1 m", "radius_y": "1 mm"}}
NEEDLE = {"indenter": {"shape": "ellipsoid", "radius_x": "10 m", "radius_y": "1 um"}}
WEDGE = {"shape": "polygon_punch", "vertices": [[0.0, 0.0], [1e-3, 0.0], [0.0, 1e-3]]}
RUBBER = {"half_space": {"shear_modulus": "1 MPa", "poisson_ratio": 0.5}}
NEARLY = {"youngs_modulus": "1 MPa", "poisson_ratio": 0.495}
SOFT = {"half_space": NEARLY}
BOTH = {"counter_body": NEARLY | {"poisson_ratio": 0.5}}
GAP = {"loading": {"mean_gap": ["1 nm"]}}
BLOCK = {"methods.fem.mesh": "block"}
ITERATED = {"methods.fem.solver": "conjugate_gradients"}
ENDED = {"methods.fem.bottom": "impedance"}
PACKED = {"methods.mca.coupling": "automata"}
HARDENS = {"plasticity.hardening": "1 GPa"}
PULLED = {"friction.coefficient": 0.3, "loading": {"force": [1.0], "tangential_force": [0.1]}}
TIMED = {"dynamics.velocity": "1 m/s", "loading": {"time": [0, "50 us"]}}
FIRST_YIELD = 0.2126e-6  # m, on steel of 420 MPa below a ball of 10 mm


def dented(*depths):
    """Return loads in units of the penetration at first yield."""
    return {"loading": {"penetration": [depth * FIRST_YIELD for depth in depths]}}


def history(control, values, **more):
    return {"loading": {"time": [0.1 * k for k in range(len(values))], control: values} | more}


def squeezed(first, last):
    loading = {"force": [first, last], "squeeze_speed": 0.1}
    return {"half_space": {"effective_modulus": 1e14}, "loading": loading}


FASTER = {"lubrication.speed": [1e-3, 1e3]}
SHORT_WAVES = {"lubrication.speed": 5e-4} | {
    "lubrication.waviness": {"amplitude": 1e-7, "wavelength": 5e-5}
}
NO_BALL = "no ball of radius"
REFUSED = {
    "paraboloid": [
        ("lammps_hertz", {"loading": {"force": [1.0]}}, "prescribe penetrations"),
        ("lammps_hertz", CONE, "spheres and paraboloids only"),
        ("drake", {"loading": {"force": [1.0]}}, "prescribe penetrations"),
        ("mujoco", {}, "prescribe forces"),
        ("ngsolve", SQUARE, "no mesh is fitted to a square punch"),
        ("fem", BOTH | {"methods.fem.coupling": "mortar"}, "0.5 is incompressible"),
        ("fem", {"methods.fem.points": "quadrature"}, 'takes contact = "penalty" only'),
        ("fem", RUBBER | {"indenter": WEDGE}, "nu = 0.5"),
        ("fem", SQUARE | ITERATED, "single contacts"),
        ("fem", RUBBER | ITERATED, "definite matrix"),
        ("fem", {"methods.fem.contact": "penalty"} | ITERATED, "active_set only"),
        ("mca", SOFT, "lost in their pair strains above 0.49"),
        ("mca", PULLED, "does not model [friction]"),
        ("mca", PACKED, "coupling does nothing here"),
        ("mca", {"counter_body": NEARLY} | PACKED, "above 0.49"),
        ("closed_form", SQUARE, "no closed form is known for a square punch"),
    ],
    "coated-ball": [
        *(
            (name, {}, "the same at all depths")
            for name in sorted(set(SOLVERS) - {"closed_form", "bem_fft", "fem", "reduced"})
        ),
    ],
    "graded-ball": [("fem", ENDED, "an impedance bottom")],
    "layer-on-base": [("fem", ENDED, "an impedance bottom")],
    "rough-free": [
        ("reduced", {"half_space": {"youngs_modulus": 1e9, "poisson_ratio": 0.3}}
         | {"half_space.grading": {"exponent": 0.3, "depth": "1 um"}}, "a line has many"),
        ("closed_form", {}, "rough surface has no closed form"),
        ("lammps_hertz", {}, "for single indenters"),
        ("ngsolve", {}, "single contacts only"),
        ("fem", GAP | BLOCK, "mean-gap"),
        ("bem_dense", GAP, "use bem_fft"),
        ("mca", GAP, "no mean-gap control"),
        *(
            (name, {"dynamics": {"mass": 1.0, "velocity": 1.0}, "loading": {"time": [0, 1]}},
             "rough surface")
            for name in ("reduced", "closed_form", "bem_fft", "bem_dense", "fem")
        ),
    ],
    "rough-periodic": [
        ("bem_dense", {}, "free half-space"),
        ("fem", BLOCK, "periodic"),
        ("mca", {}, "free patch"),
    ],
    "plastic-ball": [
        ("closed_form", dented(2), "up to first yield only"),
        ("closed_form", dented(0.1) | NEEDLE | RUBBER, "poisson"),
        ("closed_form", dented(0.1) | NEEDLE, "slenderness"),
        ("kogut_etsion", dented(200), "fitted up to 110"),
        ("kogut_etsion", dented(10, 5), "fitted on loading"),
        ("kogut_etsion", dented(10) | CONE, "spheres and paraboloids"),
        ("jackson_green", dented(10) | HARDENS, "without hardening"),
        ("reduced", dented(10) | CONE, "curved at its tip"),
        ("fem", dented(10) | FLAT, "flat face"),
        ("fem", dented(10) | OVAL, "10 : 1"),
        ("bem_fft", {}, "model of rough surfaces"),
        ("mca", dented(5) | FLAT, "flat face"),
        ("mca", dented(5) | SOFT, "above 0.49"),
        ("lammps_mdr", HARDENS, "perfectly plastic"),
    ],
    "plastic-rough": [
        ("bem_fft", HARDENS, "without hardening"),
        ("reduced", {"plasticity.model": "zunker_kamrin"}, "for a ball"),
        (
            "reduced",
            {"plasticity.model": "elastic_root", "methods.reduced.stress": "one_radius"},
            "their own curvature",
        ),
        ("bem_dense", {}, "does not model [plasticity]"),
    ],
    "adhesive-ball": [
        ("closed_form", CONE | {"adhesion.range": "1 um"}, "paraboloids only"),
        ("lammps_jkr", {"adhesion.range": "1 um"}, "short range only"),
        ("bem_dense", {}, "does not model [adhesion]"),
        ("closed_form", SQUARE, "square punch"),
        *((name, SHARP, "sharper than") for name in ("reduced", "closed_form", "bem_fft")),
    ],
    "soft-ball-film": [
        *((name, {}, "does not model [lubrication]") for name in ("fem", "bem_dense")),
        ("hamrock_dowson", {"lubrication.speed": 1e-2}, "5×10⁻⁹"),
        ("hamrock_dowson", FASTER, NO_BALL),
        ("bem_fft", CONE, "paraboloids"),
        ("bem_fft", SHORT_WAVES, "waves so short"),
        ("hamrock_dowson", SHORT_WAVES, "smooth balls"),
    ],
    "squeezed-ball": [
        ("closed_form", {"half_space": {"effective_modulus": 1e6}}, "bends"),
        # a film thicker than the ball at the first load, or a contact wider at the last one
        *(
            (name, squeezed(*forces), NO_BALL)
            for name in ("bem_fft", "reduced", "closed_form")
            for forces in ((0.01, 10.0), (10.0, 1e9))
        ),
    ],
    "rolling-ball": [
        ("reduced", {"rolling": {"creep": 0.0, "spin": "0.02 m^-1"}}, "no spin"),
        ("reduced", FLAT, "flat face"),
        ("fastsim", CONE, "paraboloids and ellipsoids"),
        (
            "reduced",
            {"rolling": {"creep": 0.1, "lateral_creep": 0.1}}
            | {"methods.reduced.rolling": "matched"},
            "one stiffness",
        ),
    ],
    "sliding-ball": [
        *((name, FLAT, "flat face") for name in ("reduced", "bem_fft")),
        *(
            (name, {"viscoelastic": {"model": "maxwell", "shear_moduli": [1e6]}
                    | {"relaxation_times": [0.01]}}, "fluid")
            for name in ("reduced", "bem_fft")
        ),
    ],
    "impact-ball": [
        ("fem", TIMED, "time history"),
        ("reduced", TIMED | {"methods.reduced.edges": "nodal"}, "sub_cell"),
        ("tamaas", {}, "does not model [dynamics]"),
    ],
    "impact-rubber": [
        ("tamaas", {}, "does not model [viscoelastic] and [dynamics]"),
        # it has both, but not together
        ("bem_fft", {}, "does not model [viscoelastic] and [dynamics] in one scene"),
    ],
    "friction-steel": [
        ("fem", FLAT, "round smooth"),
        ("fem", {"friction.coupling": "none"}, "coupling"),
        ("closed_form", {}, "elastic coupling"),
        ("fem", RUBBER, "0.4999"),
        ("closed_form", RUBBER, "slip transverse"),
        ("closed_form", {"friction.coupling": "none"}, "slip transverse"),
    ],
    "rubber-ball": [
        ("closed_form", history("penetration", [0.0, 1e-4, 5e-5, 1e-4]), "falls once"),
        (
            "closed_form",
            {"loading": {"time": [0, 0.1, 0.12, 0.3], "penetration": [0, 1e-4, 7e-5, 6e-5]}},
            "grows again",
        ),
        ("closed_form", history("force", [0.1, 0.2, 0.1]), "never falls"),
        ("bem_fft", SQUARE, "flat face"),
        *(
            (name, history("penetration", [1e-4, 1e-4])
             | {"viscoelastic": {"model": "kelvin_voigt", "shear_moduli": 1e6, "viscosities": 1e3}},
             "dashpot")
            for name in ("closed_form", "reduced", "bem_fft")
        ),
    ],
    "worn-ball": [("reduced", ELLIPSOID, "round")],
}  # fmt: skip


@pytest.mark.parametrize("source", REFUSED)
def test_what_a_method_cannot_do_is_said(source):
    for method, changes, reason in REFUSED[source]:
        told = solver_for(method, load_scene(source, changes))
        assert isinstance(told, Refusal), (method, changes)
        assert reason in told.reason, (method, changes)


TAKEN = [
    ("paraboloid", "fem", BOTH),
    ("paraboloid", "fem", BOTH | {"methods.fem": {"contact": "penalty", "points": "quadrature"}}),
    ("plastic-ball", "reduced", dented(0.1) | NEEDLE),
    ("rough-free", "fem", GAP),
    ("rough-free", "bem_fft", GAP),
    ("rough-periodic", "fem", {}),
    ("soft-ball-film", "hamrock_dowson", {"lubrication.speed": 5e-4}),
    ("soft-ball-film", "reduced", SHORT_WAVES),
    ("worn-ball", "bem_fft", ELLIPSOID),
]


@pytest.mark.parametrize(("source", "method", "changes"), TAKEN)
def test_what_is_within_a_method_is_taken(source, method, changes):
    """Beside each, above, a method or a number that refuses it."""
    assert not isinstance(solver_for(method, load_scene(source, changes)), Refusal)


SPEED = 5e-4  # m/s, of the film: within its fit; 1e-2 is beyond


@pytest.mark.parametrize(
    ("source", "method", "quantity", "inside", "beside"),
    [
        ("plastic-ball", "kogut_etsion", "contact_area", dented(5, 50), dented(5, 50, 200)),
        ("plastic-ball", "jackson_green", "force", dented(5), dented(5, 1e6)),
        ("plastic-ball", "closed_form", "force", dented(0.5), dented(0.5, 2)),
        (
            "soft-ball-film",
            "hamrock_dowson",
            "film_central",
            {"lubrication.speed": SPEED},
            {"lubrication.speed": [SPEED, 1e-2]},
        ),
    ],
)
def test_a_load_beyond_the_range_of_a_method_costs_that_load_alone(
    solved, source, method, quantity, inside, beside
):
    """The others have the answers that they have without it."""
    known, both = (
        solved(load_scene(source, changes), method, lost=True) for changes in (inside, beside)
    )
    expected = [*known.quantities[quantity][0], np.nan]
    np.testing.assert_array_equal(both.quantities[quantity][0], expected)
    (((_, step), reason),) = both.reasons.items()
    assert step == len(expected) - 1
    assert reason.startswith(("fitted up to", "made for", "exact up to"))


class Wedge(Indenter):
    """f = slope |x|, cut off at |y| = length: nothing but what a scene asks for."""

    shape: Literal["blunt_wedge"] = "blunt_wedge"
    slope: float = 0.1
    length: float = 1e-3

    @property
    def axisymmetric(self):
        return False

    def gap(self, x, y):
        return np.where(np.abs(y) <= self.length, self.slope * np.abs(x), np.inf)

    def reach(self, penetration):
        return penetration / self.slope, self.length


@pytest.fixture
def scene():
    # of a shape of one's own no theorem of this repository proves anything
    unproved = load_scene("paraboloid", {"compare.proved": False})
    return unproved.model_copy(update={"indenter": Wedge()})


@pytest.mark.parametrize(
    ("method", "reason"),
    [
        ("closed_form", "no closed form is known for a blunt wedge"),
        ("fem", "no mesh is fitted to the contact of a blunt wedge"),
    ],
)
def test_a_method_without_its_part_of_a_shape_refuses_the_scene(scene, method, reason):
    """Finite elements fit a mesh to the contact: that of a wedge is no circle, nor an ellipse."""
    refusal = solver_for(method, scene)
    assert isinstance(refusal, Refusal)
    assert reason in str(refusal)


def test_a_grid_needs_nothing_but_the_gap(scene):
    assert not isinstance(solver_for("bem_fft", scene), Refusal)


def test_a_shape_without_an_equivalent_profile_is_an_error_of_the_scene(scene):
    """Estimates of the contact come from the profile, and all grids and meshes from them."""
    with pytest.raises(ValueError, match="no equivalent profile is known for a blunt wedge"):
        equivalent_profile(scene.indenter)
    with pytest.raises(SceneError, match="no equivalent profile is known for a blunt wedge"):
        prepare(scene)


def test_a_shape_without_an_adhesive_solution_has_none():
    assert adhesive_form_of(Wedge(), 1.0, 1.0) is None


COUNTER_BODY = {"counter_body.youngs_modulus": "5 GPa", "counter_body.poisson_ratio": 0.3}


def solver_or_refusal(method, source, options):
    """Return who solves a built-in scene with these options; a pair is the paraboloid on steel."""
    changes = {f"methods.{method}.{key}": value for key, value in options.items()}
    if source == "meshed pair":
        source, changes = "pair", changes | {"methods.fem.coupling": "mortar"}
    if source == "pair":
        source, changes = "paraboloid", changes | COUNTER_BODY
    return solver_for(method, load_scene(source, changes))


@pytest.mark.parametrize(
    ("source", "method", "options", "reads"),
    [
        ("paraboloid", "fem", {"mesh": "block"}, "contact, points, solver"),
        ("paraboloid", "fem", {"element": "linear"}, "contact, points, solver"),
        ("paraboloid", "fem", {"coupling": "mortar"}, "contact, points, solver"),
        ("paraboloid", "fem", {"penalty": 10.0}, "contact, points, solver"),
        ("rough-free", "fem", {"coupling": "node_to_surface"}, "bottom, contact, element"),
        ("friction-steel", "fem", {"contact": "penalty"}, "no option"),
        ("friction-steel", "fem", {"solver": "nested_dissection"}, "no option"),
        ("impact-ball", "fem", {"mesh": "block"}, "contact, points, solver"),
        ("paraboloid", "bem_fft", {"kernel": "cells"}, "tolerance"),
        ("rough-free", "bem_fft", {"kernel": "cells"}, "tolerance"),
        ("cylinder", "bem_fft", {"tolerance": 1e-6}, "no option"),
        ("adhesive-ball", "bem_fft", {"tolerance": 1e-6}, "no option"),
        ("sliding-ball", "bem_fft", {"tolerance": 1e-6}, "no option"),
        ("friction-steel", "bem_fft", {"tolerance": 1e-9}, "no option"),
        ("rough-free", "reduced", {"rule": "half_radius"}, "edges, line_length, line_points"),
        ("paraboloid", "reduced", {"spectrum": "printed"}, "edges, rule, stress"),
        ("paraboloid", "reduced", {"line_length": 2.0}, "edges, rule, stress"),
        ("ellipsoid-2", "reduced", {"stress": "local"}, "edges, rule"),
        ("adhesive-ball", "reduced", {"edges": "nodal"}, "rule"),
        ("sliding-rough", "reduced", {"edges": "nodal"}, "line_length, line_points, spectrum"),
        ("rubber-ball", "reduced", {"stress": "local"}, "edges, rule"),
        ("friction-rough", "reduced", {"stress": "local"}, "edges, line_length, line_points"),
        ("paraboloid", "fem", {"element": "linear", "mesh": "block"}, "contact, points, solver"),
        # how contact is enforced is said by the coupling of two meshes, on one mesh by `contact`
        ("meshed pair", "fem", {"contact": "penalty"}, "coupling"),
    ],
)
def test_an_option_that_does_nothing_is_refused_with_those_that_do(source, method, options, reads):
    assert isinstance(solver_or_refusal(method, source, {}), Solver)
    refusal = solver_or_refusal(method, source, options)
    named = " and ".join(f"methods.{method}.{key}" for key in options)
    start = f"{named} {'do' if len(options) > 1 else 'does'} nothing here: on this scene "
    assert refusal.reason.startswith(f"{start}{method} reads {reads}")


def test_an_element_is_that_of_the_repeating_mesh_only():
    block = {"element": "linear", "mesh": "block"}
    reason = solver_or_refusal("fem", "rough-patch", block).reason
    assert reason == (
        "methods.fem.element does nothing here: on this scene fem reads contact, mesh"
    )


READ = [
    ("paraboloid", "fem", {"contact": "penalty", "penalty": 10.0, "points": "quadrature"}),
    ("paraboloid", "fem", {"solver": "conjugate_gradients"}),
    ("rough-periodic", "fem", {"bottom": "impedance"}),
    ("rolling-ball", "fem", {"inertia": 0.1}),
    ("coated-ball", "reduced", {"layers": "effective"}),
    ("rough-free", "reduced", {"spectrum": "printed", "line_length": 2.0}),
    ("rolling-ball", "reduced", {"rolling": "matched"}),
    ("soft-ball-film", "reduced", {"film": "hertz"}),
    ("paraboloid", "mca", {"balance": 1e-5}),
    ("impact-ball", "fem", {"contact": "augmented_lagrangian", "penalty": 10.0}),
    ("rough-periodic", "fem", {"element": "linear", "contact": "penalty", "penalty": 10.0}),
    ("rough-patch", "fem", {"mesh": "block", "contact": "penalty", "penalty": 10.0}),
    ("rough-periodic", "bem_fft", {"kernel": "cells", "tolerance": 1e-6}),
    ("friction-steel", "bem_fft", {"tolerance": 1e-5}),
    ("impact-ball", "bem_dense", {"max_cells": 100}),
    ("paraboloid", "reduced", {"rule": "half_radius", "stress": "local", "edges": "nodal"}),
    ("friction-rough", "reduced", {"edges": "nodal", "line_points": 4096}),
    ("pair", "fem", {"coupling": "node_to_surface"}),
    ("pair", "fem", {"contact": "penalty"}),
    ("pair", "mca", {"coupling": "automata"}),
    ("paraboloid", "fem", {"mesh": "repeating"}),  # a default that is written down
]


@pytest.mark.parametrize(("source", "method", "options"), READ)
def test_options_that_are_read_are_taken(source, method, options):
    assert isinstance(solver_or_refusal(method, source, options), Solver)


def test_options_of_one_method_are_nothing_to_another():
    scene = load_scene("friction-steel", {"methods.fem.contact": "penalty"})
    assert all(isinstance(solver_for(name, scene), Solver) for name in ("reduced", "bem_fft"))


@pytest.mark.parametrize("method", ["reduced", "bem_dense", "bem_fft", "fem", "mca"])
def test_every_option_is_read_somewhere(method):
    read = {key for _, owner, options in READ for key in options if owner == method}
    assert read >= set(type(MethodOptions().of(method)).model_fields)


def test_claims_set_only_options_that_act():
    """Their judged method reads all that they change, at either end of the varied parameter."""
    changing = [claim for claim in load_claims() if any("methods." in key for key in claim.changes)]
    of_scenes = [claim for claim in changing if claim.scene is not None]
    assert of_scenes
    for claim in of_scenes:
        solver = solver_for(claim.method, scene_of(claim, claim.sides()[0]))
        assert "nothing here" not in getattr(solver, "reason", ""), claim.id
