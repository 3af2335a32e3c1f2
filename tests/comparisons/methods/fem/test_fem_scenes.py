"""The method `fem`: flat faces, two bodies, part of a map, what a bounded mesh lacks."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from comparisons.judging.fields import pressure_bar, pressure_difference, true_pressure
from comparisons.judging.levels import Levels
from comparisons.judging.truth import TRUNCATION, truths
from comparisons.methods.fem import indenter as adapter
from comparisons.scene.scene import load_scene, parse_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference import fem
from reference.loads import Load

TRIANGLE = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.75**0.5]]
ANGLE = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.5, 0.5], [0.5, 1.0], [0.0, 1.0]]
SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]


def plan_of(shape: dict, changes: dict | None = None):
    face = {"half_space": {"effective_modulus": 1.0}, "indenter": shape}
    face |= {"loading": {"penetration": [1e-3]}, "compare": {"quantities": ["stiffness"]}}
    return plan_scene(load_scene("square-punch", face | (changes or {})))[0]


def fem_of(plan):
    (fem,) = (method for method in plan.methods if method.method == "fem")
    return fem


def polygon(corners) -> dict:
    return {"shape": "polygon_punch", "vertices": corners}


def stiffness(plan, resolution: int) -> tuple[float, int]:
    solution = execute(task_of(plan, "fem", resolution), 1)
    return solution.quantities["stiffness"][0, 0], solution.unknowns


@pytest.mark.slow
def test_an_l_shape_has_mesh_lines_on_all_its_sides():
    """k/E* = 1.0356 sides from the boundary elements (docs/half-space.md).

    From above, as contact in nodes of a Ritz method: 2.7, 1.2 and 0.8 % at 3, 4 and 5 elements, and
    at least second order: corners are crowded by the square.
    """
    plan = plan_of(polygon(ANGLE))
    coarse, fine = (stiffness(plan, n)[0] / 1.035581 - 1 for n in (3, 4))
    assert 0 < fine < 0.015
    assert np.log(coarse / fine) / np.log(4 / 3) > 2


def test_half_of_a_triangle_answers_as_the_whole(monkeypatch):
    """The plane x = 0 is one of symmetry: half of the unknowns, the same stiffness."""
    plan = plan_of(polygon(TRIANGLE))
    assert plan.geometry.indenter.even == (True, False)
    assert fem_of(plan).modelled.startswith("half of a block")
    half, few = stiffness(plan, 3)
    grid = adapter.face_grid(plan.geometry, 3)
    mirrored = np.concatenate([-grid.x[:0:-1], grid.x])
    whole = replace(grid, x=mirrored, symmetry="none")
    monkeypatch.setattr(adapter, "face_grid", lambda *_: whole)
    full, many = stiffness(plan, 3)
    assert half == pytest.approx(full, rel=1e-9)
    assert few < 0.6 * many


@pytest.mark.slow
def test_the_bar_of_a_pressure_below_a_square_covers_how_it_is_read(solved):
    """Force over area at corners of elements lacks h^2 p''/20: 2 to 4 % on 3 to 6 elements."""
    square = {"shape": "square_punch", "side": 1.0}
    plan = plan_of(square, {"compare": {"quantities": ["pressure"]}})
    grid = {("bem_fft", 64): solved(plan.scene, "bem_fft", 64)}
    meshes = {("fem", n): solved(plan.scene, "fem", n) for n in (3, 4, 6)}
    (exact,), (truth,) = (truths(known, "penetration") for known in (grid, meshes))
    fields = meshes["fem", 6].fields
    pressure, keep = true_pressure(plan, exact, fields)
    error = pressure_difference(fields["pressure"], fields["pressure_weight"], pressure, keep)
    assert 0.01 < error < pressure_bar(plan, truth)


def test_a_needle_takes_an_even_grid_and_says_that_it_is_no_rubber():
    """Crowded lines all along 1:100 would be 400 000 unknowns; 8-node elements end at 0.4999."""
    needle = polygon([[0.0, 0.0], [1.0, 0.0], [1.0, 0.01], [0.0, 0.01]])
    plan = plan_of(needle)
    grid = adapter.face_grid(plan.geometry, 5)
    assert (grid.order, grid.symmetry) == (1, "quarter")
    assert grid.unknowns < 70_000
    rubber = {"half_space": {"youngs_modulus": 1.0, "poisson_ratio": 0.5}}
    assert "incompressible" in fem_of(plan_of(needle, rubber)).reason


@pytest.mark.parametrize(
    ("corners", "even"),
    [
        (SQUARE, (True, True)),
        (ANGLE, (False, False)),
        ([[0.0, 0.0], [2.0, 0.5], [2.0, -0.5]], (False, True)),
        ([[0.0, 0.0], [1.0, 0.3], [2.0, 0.0], [1.0, -0.3]], (True, True)),
        ([[0.0, 0.0], [1.0, 0.0], [1.5, 1.0], [0.5, 1.0]], (False, False)),
    ],
)
def test_planes_of_symmetry_of_polygons_are_found(corners, even):
    assert plan_of(polygon(corners)).geometry.indenter.even == even


@pytest.mark.slow
@pytest.mark.parametrize(
    ("corners", "resolution"), [(ANGLE, 2), (TRIANGLE, 7), (SQUARE, 4)], ids=str
)
def test_the_unknowns_are_known_before_the_mesh_is_made(corners, resolution):
    """The count is that of all displacements: the far rim comes off it."""
    plan = plan_of(polygon(corners))
    expected = adapter.face_grid(plan.geometry, resolution).unknowns
    _, slope = stiffness(plan, resolution)
    assert slope <= expected < 1.6 * slope


@pytest.mark.slow
def test_penalty_at_quadrature_points_is_an_option_of_the_scene():
    """Within its softness, 3e-3 at 1e3, of the same mesh in its nodes."""
    options = {"methods.fem.contact": "penalty", "methods.fem.points": "quadrature"}
    for shape in ({"shape": "paraboloid", "radius": 1.0}, {"shape": "square_punch", "side": 1.0}):
        assert stiffness(plan_of(shape, options), 3)[0] == pytest.approx(
            stiffness(plan_of(shape), 3)[0], rel=3e-3
        )


TABLES = {
    "half_space": {"youngs_modulus": 2e9, "poisson_ratio": 0.3},
    "counter_body": {"youngs_modulus": 1e9, "poisson_ratio": 0.2},
    "loading": {"penetration": [1e-7, 1e-5]},
    "compare": {"quantities": ["force", "contact_area", "pressure"]},
}
MORTAR = {"fem": {"coupling": "mortar"}}
COMBINED = 1 / ((1 - 0.3**2) / 2e9 + (1 - 0.2**2) / 1e9)
HERTZ = 4 / 3 * COMBINED * np.sqrt(0.01) * np.array([1e-7, 1e-5]) ** 1.5


def scene(**changes):
    return load_scene("paraboloid", TABLES | changes)


def test_compliances_of_two_half_spaces_add():
    """Johnson 1985, eq. (4.5); the canonical text keeps both bodies."""
    made = scene()
    assert made.effective_modulus == pytest.approx(COMBINED, rel=1e-14)
    assert parse_scene(made.text, "test", Path(made.directory)) == made
    (plan,) = plan_scene(made)
    assert "both bodies are elastic: their compliances 1/E* add" in plan.notes


@pytest.mark.slow
@pytest.mark.parametrize(("coupling", "tolerance"), [("mortar", 1e-3), ("node_to_surface", 5e-3)])
def test_finite_elements_find_the_sum_by_meshing_both_bodies(solved, coupling, tolerance):
    """The addition is a result here, not an input: at loads a thousandfold apart.

    The same digits at both loads, because each scales the grids to its contact.
    """
    solution = solved(scene(methods={"fem": {"coupling": coupling}}), "fem", 3, with_body=True)
    error = solution.quantities["force"][0] / HERTZ - 1
    assert np.abs(error).max() < tolerance
    assert error[0] == pytest.approx(error[1], rel=1e-6)
    fields = solution.fields
    total = (fields["pressure"] * fields["pressure_weight"]).sum()
    assert total == pytest.approx(solution.quantities["force"][0, -1], rel=1e-12)
    assert fields["mesh_von_mises"].max() > 0


@pytest.mark.slow
def test_a_rounded_edge_within_an_element_does_not_lift_the_face_beside_it(solved):
    """Nearly a flat punch, d = F/(2 E* a), on elements of which the edge is a hundredth.

    Weights of both signs turned its height into a negative gap of the face, half of this d.
    """
    radius, force = 3.5e-3, 10.0
    punch = {"shape": "rounded_punch", "flat_radius": radius, "edge_radius": 0.5e-3}
    pressed = scene(indenter=punch, loading={"force": [force, 10 * force]}, methods=MORTAR)
    penetration = solved(pressed, "fem", 3).quantities["penetration"][0]
    flat = np.array([force, 10 * force]) / (2 * COMBINED * radius)
    np.testing.assert_allclose(penetration, flat, rtol=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("stiffer", [1.0, 3.0])
def test_bars_of_two_meshed_bodies_reach_hertz(solved, stiffer):
    """Their meshes are not fitted to the contact: at 4 elements the stiffness errs by 2 %."""
    body = {"youngs_modulus": 1e9 * stiffer, "poisson_ratio": 0.3}
    made = scene(half_space=body | {"youngs_modulus": 1e9}, counter_body=body, methods=MORTAR)
    depths, modulus = np.array(TABLES["loading"]["penetration"]), made.effective_modulus
    exact = {
        "force": 4 / 3 * modulus * np.sqrt(0.01) * depths**1.5,
        "contact_area": np.pi * 0.01 * depths,
        "stiffness": 2 * modulus * np.sqrt(0.01 * depths),
    }
    solutions = {("fem", n): solved(made, "fem", n) for n in (2, 3, 4)}
    levels = Levels.of(solutions, "fem")
    for name, values in exact.items():
        error = np.abs(levels.curves(4)[name] / values - 1)
        bar = levels.discretisation(name)
        assert (error < bar).all(), name
        # each load scales the meshes onto its contact
        assert bar[0] == pytest.approx(bar[1], rel=1e-6)
    assert error.max() > 0.01
    assert bar.max() < 0.06


def test_one_body_with_both_compliances_is_planned_where_no_meshes_are_asked_for(solved, planned):
    """Without friction it is exact (Johnson 1985, section 4.2), and so what is planned."""
    assert "a quarter of both bodies" in planned(scene(methods=MORTAR))["fem"].modelled
    assert "compliances of both bodies, which add exactly" in planned(scene())["fem"].modelled
    rubber = scene(counter_body={"youngs_modulus": 1e6, "poisson_ratio": 0.5})
    for made in (scene(), rubber):
        force = solved(made, "fem", 3).quantities["force"][0]
        hertz = HERTZ * made.effective_modulus / COMBINED
        np.testing.assert_allclose(force, hertz, rtol=1e-3)


def hertz_force(elements, extent):
    body = fem.half_space_body(
        fem.RingMesh(1.0, elements=elements, edge=1.0, extent=extent), fem.Material(1.0, 0.3)
    )
    ((_, contact),) = fem.indent(
        body, lambda x, y: (x**2 + y**2) / 2, Load("penetration", np.array([1.0]))
    )
    return contact.force


def square_force(order, quarter, extent):
    nodes = np.linspace(0, 1, 6) if quarter else np.linspace(-1, 1, 9)
    lines = 1 - (1 - nodes) ** 2 if quarter else nodes
    how = {"symmetry": "quarter" if quarter else "none", "order": order}
    body = fem.half_space_body(
        fem.TensorMesh(lines, lines, extent=extent, **how), fem.Material(1.0, 0.3)
    )
    gap = np.where(np.abs(body.points).max(axis=1) <= 1 + 1e-9, 0.0, np.inf)
    (contact,) = fem.press(body, gap, Load("penetration", np.array([1.0])))
    return contact.force


@pytest.mark.parametrize("elements", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_a_fitted_mesh_of_twice_the_extent_differs_by_less_than_declared(elements):
    change = hertz_force(elements, 2.5) / hertz_force(elements, 5.0) - 1
    assert abs(change) < adapter.TRUNCATION_SMOOTH / elements**3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "quarter", "declared"),
    [(2, True, adapter.TRUNCATION_SQUARE), (1, False, adapter.TRUNCATION_GRID)],
)
def test_a_straight_mesh_of_twice_the_extent_differs_by_less_than_declared(
    order, quarter, declared
):
    change = square_force(order, quarter, 3.0) / square_force(order, quarter, 6.0) - 1
    assert abs(change) < declared


def test_the_truncation_is_a_source_of_the_bar(solved):
    """Finite elements only: the half-space solvers' kernels reach to infinity."""
    ball = load_scene("paraboloid", {"loading": {"penetration": [1e-6, 2e-6]}})
    levels = (("fem", 2), ("bem_fft", 8))
    known = truths({key: solved(ball, *key) for key in levels}, "penetration")
    parts = {part.method: part.sources["force"][TRUNCATION] for part in known}
    assert parts["fem"] == pytest.approx(adapter.TRUNCATION_SMOOTH / 2**3)
    assert not parts["bem_fft"].any()
