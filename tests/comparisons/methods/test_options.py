"""Options of methods: what a solver does not read is refused, never recorded as if it had acted."""

import pytest

from comparisons.methods import Solver
from comparisons.methods.registry import solver_for
from comparisons.questions.claims.claim import load_claims, scene_of
from comparisons.scene.options import MethodOptions
from comparisons.scene.scene import load_scene

COUNTER_BODY = {"counter_body.youngs_modulus": "5 GPa", "counter_body.poisson_ratio": 0.3}
PENALTY = {"methods.fem.contact": "penalty"}


def solver_or_refusal(method, source, options, more=None):
    changes = {f"methods.{method}.{key}": value for key, value in options.items()}
    return solver_for(method, load_scene(source, changes | (more or {})))


@pytest.mark.parametrize(
    ("source", "method", "options", "reads"),
    [
        ("paraboloid", "fem", {"mesh": "block"}, "contact, points, solver"),
        ("paraboloid", "fem", {"element": "linear"}, "contact, points, solver"),
        ("paraboloid", "fem", {"coupling": "effective_modulus"}, "contact, points, solver"),
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
    ],
)
def test_an_option_that_does_nothing_is_refused_with_those_that_do(source, method, options, reads):
    assert isinstance(solver_or_refusal(method, source, {}), Solver)
    refusal = solver_or_refusal(method, source, options)
    (key,) = options
    start = f"methods.{method}.{key} does nothing here: on this scene {method} reads {reads}"
    assert refusal.reason.startswith(start)


def test_all_that_does_nothing_is_told_at_once():
    mesh = {"mesh": "block", "element": "linear"}
    reason = solver_or_refusal("fem", "paraboloid", mesh).reason
    assert reason.startswith("methods.fem.element and methods.fem.mesh do nothing here")


def test_an_element_is_that_of_the_repeating_mesh_only():
    block = {"element": "linear", "mesh": "block"}
    reason = solver_or_refusal("fem", "rough-patch", block).reason
    assert reason == (
        "methods.fem.element does nothing here: on this scene fem reads contact, mesh"
    )


def test_two_meshed_bodies_take_their_coupling_and_nothing_else():
    """How contact is enforced is said by the coupling there, and on one mesh by `contact`."""
    coupled = {"coupling": "node_to_surface"}
    assert isinstance(solver_or_refusal("fem", "paraboloid", coupled, COUNTER_BODY), Solver)
    reason = solver_or_refusal("fem", "paraboloid", {"contact": "penalty"}, COUNTER_BODY).reason
    assert reason.endswith("on this scene fem reads coupling")
    one = {"coupling": "effective_modulus", "contact": "penalty"}
    assert isinstance(solver_or_refusal("fem", "paraboloid", one, COUNTER_BODY), Solver)


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
]


@pytest.mark.parametrize(("source", "method", "options"), READ)
def test_options_that_are_read_are_taken(source, method, options):
    assert isinstance(solver_or_refusal(method, source, options), Solver)


def test_a_default_that_is_written_down_changes_nothing():
    assert isinstance(solver_or_refusal("fem", "paraboloid", {"mesh": "repeating"}), Solver)


def test_options_of_one_method_are_nothing_to_another():
    scene = load_scene("friction-steel", PENALTY)
    assert all(isinstance(solver_for(name, scene), Solver) for name in ("reduced", "bem_fft"))


@pytest.mark.parametrize("method", ["reduced", "bem_dense", "bem_fft", "fem", "mca"])
def test_every_option_is_read_somewhere(method):
    """By those above; `coupling` by whoever meshes or packs the other body."""
    read = {key for _, owner, options in READ for key in options if owner == method}
    assert read | {"coupling"} >= set(type(MethodOptions().of(method)).model_fields)


@pytest.mark.parametrize(
    ("method", "coupling"), [("fem", "effective_modulus"), ("mca", "automata")]
)
def test_a_coupling_is_read_where_there_is_a_counter_body(method, coupling):
    taken = solver_or_refusal(method, "paraboloid", {"coupling": coupling}, COUNTER_BODY)
    assert isinstance(taken, Solver)


def test_claims_set_only_options_that_act():
    """Their judged method reads all that they change, at either end of the varied parameter."""
    changing = [claim for claim in load_claims() if any("methods." in key for key in claim.changes)]
    of_scenes = [claim for claim in changing if claim.scene is not None]
    assert of_scenes
    for claim in of_scenes:
        solver = solver_for(claim.method, scene_of(claim, claim.sides()[0]))
        assert "nothing here" not in getattr(solver, "reason", ""), claim.id
