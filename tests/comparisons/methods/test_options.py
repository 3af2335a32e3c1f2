"""Options of methods: what a solver does not read is refused, never recorded as if it had acted."""

import pytest

from comparisons.methods import Solver
from comparisons.methods.registry import solver_for
from comparisons.questions.claims.claim import load_claims, scene_of
from comparisons.scene.options import MethodOptions
from comparisons.scene.scene import load_scene

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
