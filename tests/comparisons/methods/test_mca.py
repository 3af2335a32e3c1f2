"""The method `mca`: closed forms, rough patches, what it refuses, when it runs, pictures."""

from functools import partial

import numpy as np
import pytest

from comparisons.methods.registry import solver_for
from comparisons.results.record import field_problems
from comparisons.results.store import mesh_of
from comparisons.scene.scene import load_scene
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene, refusal
from reports.pictures import pictures, turning

STEEL = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
COMPARED = {"methods": ["closed_form", "mca"], "quantities": ["force", "contact_area"]}


@pytest.fixture
def asked(scene):
    """Return a maker of scenes that ask for automata."""
    return partial(scene, loading={"penetration": [2e-6]}, compare=COMPARED)


BALL = {"shape": "paraboloid", "radius": "10 mm"}
# Errors of force and area with three automata per radius, measured and rounded up.
SHAPES = {
    "paraboloid": (BALL, 6e-3, 0.02),
    "sphere": ({"shape": "sphere", "radius": "10 mm"}, 6e-3, 0.02),
    "cone": ({"shape": "cone", "slope": 0.1}, 7e-3, 0.02),
    "cylinder": ({"shape": "cylinder", "radius": "1 mm"}, 3e-3, 1e-12),
    "ellipsoid": ({"shape": "ellipsoid", "radius_x": "10 mm", "radius_y": "4 mm"}, 0.011, 0.02),
    "rounded punch": (
        {"shape": "rounded_punch", "flat_radius": "0.2 mm", "edge_radius": "10 mm"},
        6e-3,
        0.09,
    ),
    "power law": ({"shape": "power_law", "exponent": 4, "coefficient": 1e6}, 6e-3, 0.11),
    "elliptic punch": ({"shape": "elliptic_punch", "semi_axes": ["1 mm", "0.5 mm"]}, 0.021, 1e-12),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_shapes_with_three_automata_per_radius_against_closed_forms(asked, curves, name):
    indenter, force, area = SHAPES[name]
    made = asked(indenter=indenter)
    found, true = curves(made, "mca", 3), curves(made, "closed_form")
    np.testing.assert_allclose(found["force"], true["force"], rtol=force)
    np.testing.assert_allclose(found["contact_area"], true["contact_area"], rtol=area)


# Of side 1 mm, penetration 2 um: 1.15230 E* for the square, and the half-space on 96 cells.
CORNERED = {
    "square": ({"shape": "square_punch", "side": "1 mm"}, 531.83),
    "triangle": (
        {
            "shape": "polygon_punch",
            "vertices": [["0 mm", "0 mm"], ["1 mm", "0 mm"], ["0.5 mm", "0.866 mm"]],
        },
        363.74,
    ),
}


@pytest.mark.parametrize("name", CORNERED)
def test_faces_with_corners_are_too_soft_by_some_per_cent(asked, curves, name):
    """Three automata across half of them have no corners: -4.5 %."""
    indenter, force = CORNERED[name]
    assert -0.046 < curves(asked(indenter=indenter), "mca", 3)["force"][0] / force - 1 < 0


def test_loads_of_many_decades_err_alike(asked, curves):
    """The packing is scaled to each contact, and the answer with it."""
    made = asked(loading={"penetration": [1e-12, 1e-6]})
    errors = curves(made, "mca", 2)["force"] / curves(made, "closed_form")["force"] - 1
    assert errors[0] == pytest.approx(errors[1], abs=1e-6)


@pytest.mark.slow
def test_stiffness_is_that_of_the_contact_set(asked, curves):
    made = asked(compare=COMPARED | {"quantities": ["stiffness", "energy"]})
    found, true = curves(made, "mca", 3), curves(made, "closed_form")
    assert found["stiffness"] == pytest.approx(true["stiffness"], rel=0.01)
    assert found["energy"] == pytest.approx(true["energy"], rel=0.02)


def test_a_counter_body_is_put_into_the_same_half_space(asked, curves):
    single, pair = curves(asked(), "mca", 2), curves(asked(counter_body=STEEL), "mca", 2)
    assert pair["force"][0] == pytest.approx(single["force"][0] / 2, rel=1e-9)


RUBBER = {"youngs_modulus": "30 GPa", "poisson_ratio": -0.2}
BOTH = {"methods": {"mca": {"coupling": "automata"}}}


@pytest.mark.slow
def test_two_bodies_of_automata_have_the_force_of_the_sum_of_their_compliances(asked, solved):
    """1/E* is nowhere in their equations; Hertz' force is, within the error of two automata."""
    made = asked(counter_body=RUBBER, **BOTH)
    pair, true = solved(made, "mca", 2), solved(made, "closed_form").quantities
    np.testing.assert_allclose(pair.quantities["force"], true["force"], rtol=0.02)
    one = solved(asked(counter_body=RUBBER), "mca", 2)
    assert pair.unknowns == 2 * one.unknowns
    np.testing.assert_allclose(pair.quantities["force"], one.quantities["force"], rtol=0.01)
    np.testing.assert_allclose(pair.quantities["contact_area"], true["contact_area"], rtol=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("points", [12, 13])
def test_a_rough_patch_against_the_half_space(rough, curves, points):
    """Automata and Love's cells differ on waves of five points: by 3.5 per cent on 13 points.

    The half-space's force is that of the whole patch; automata leave out a part at the rim.
    """
    compared = {"methods": ["bem_fft", "mca"], "quantities": ["force", "mean_gap"]}
    long_waves = {"points": points, "rms_slope": 0.05, "short_cutoff": "0.4 um", "seed": None}
    made = rough(loading={"penetration": [10e-9]}, compare=compared, **long_waves)
    found, truth = (curves(made, method, points) for method in ("mca", "bem_fft"))
    assert found["force"] == pytest.approx(truth["force"], rel=0.036)
    assert found["mean_gap"] == pytest.approx(truth["mean_gap"], rel=0.01)


def test_bodies_of_too_many_automata_are_refused_before_any_is_made(asked, planned):
    (plan, *_) = plan_scene(asked())
    solver = solver_for("mca", plan.scene)
    assert "automata, more than 200000" in solver.refusal(task_of(plan, "mca", 20))
    assert refusal(plan, "mca", 20)
    needle = {"shape": "ellipsoid", "radius_x": "10 m", "radius_y": "1 mm"}
    refused = planned(asked(indenter=needle))["mca"]
    assert not refused.supported
    assert "across the narrow side" in refused.reason


def test_it_runs_only_where_it_is_named(planned):
    """A load takes seconds; the plan of a scene that names no methods says so."""
    for name in ("mca", "ngsolve"):
        method = planned(load_scene("paraboloid"))[name]
        if method.reason.startswith("not installed"):
            continue
        assert not method.supported
        assert method.reason == "takes seconds per load: runs only if named"


def test_particles_go_into_files_and_pictures(asked, solved):
    compare = {"methods": ["mca"], "quantities": ["force", "pressure"]}
    solution = solved(asked(compare=compare), "mca", 2, with_body=True)
    fields = solution.fields
    assert not field_problems(fields)
    assert field_problems(fields | {"particle_von_mises": np.zeros(3)}) == [
        "particle_places, particle_displacement, particle_von_mises: expected a row for each "
        "particle"
    ]
    mesh = mesh_of(fields)
    assert mesh.cells[0].type == "vertex"
    assert len(mesh.points) == len(mesh.point_data["von_mises"]) == solution.unknowns / 6
    # stress is largest below the surface, where Hertz has it (0.48 a deep): within a layer
    deepest = mesh.points[np.argmax(mesh.point_data["von_mises"])]
    radius = float(solution.quantities["contact_radius"][0, 0])
    assert 0 < deepest[2] < radius
    job = pictures.particle_job("MCA, N = 2", fields)
    assert "a quarter of them taken away" in job.caption
    assert turning.view(job.shape)["data"][0]["type"] == "scatter3d"
    # what cannot be seen is not drawn
    assert len(job.shape.points) < 0.75 * len(mesh.points)
