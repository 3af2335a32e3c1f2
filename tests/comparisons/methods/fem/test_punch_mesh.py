"""Flat faces of the method `fem`: mesh lines on their sides, planes of symmetry, memory."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest

from comparisons.methods.fem import punch_mesh
from comparisons.scene.scene import parse_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

TRIANGLE = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.75**0.5]]
ANGLE = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.5, 0.5], [0.5, 1.0], [0.0, 1.0]]
SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]


def plan_of(shape: str, options: str = "", body: str = "effective_modulus = 1.0"):
    text = f'name = "face"\n[half_space]\n{body}\n[indenter]\n{shape}\n'
    text += f"[loading]\npenetration = [1e-3]\n{options}"
    return plan_scene(parse_scene(text, "face", Path()))[0]


def fem_of(plan):
    (fem,) = (method for method in plan.methods if method.method == "fem")
    return fem


def polygon(corners) -> str:
    return f'shape = "polygon_punch"\nvertices = {corners}'


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


@pytest.mark.slow
def test_a_square_is_a_square_by_either_name():
    """Both are meshed as a quarter, with the same lines."""
    named = stiffness(plan_of('shape = "square_punch"\nside = 1.0'), 3)
    assert stiffness(plan_of(polygon(SQUARE)), 3) == pytest.approx(named, rel=1e-12)


def test_half_of_a_triangle_answers_as_the_whole(monkeypatch):
    """The plane x = 0 is one of symmetry: half of the unknowns, the same stiffness."""
    plan = plan_of(polygon(TRIANGLE))
    assert plan.geometry.indenter.even == (True, False)
    assert fem_of(plan).modelled.startswith("half of a block")
    half, few = stiffness(plan, 5)
    grid = punch_mesh.face_grid(plan.geometry, 5)
    mirrored = np.concatenate([-grid.x[:0:-1], grid.x])
    whole = replace(grid, x=mirrored, symmetry="none")
    monkeypatch.setattr(punch_mesh, "face_grid", lambda *_: whole)
    full, many = stiffness(plan, 5)
    assert half == pytest.approx(full, rel=1e-9)
    assert few < 0.6 * many


def test_a_needle_takes_an_even_grid_and_says_that_it_is_no_rubber():
    """Crowded lines all along 1:100 would be 400 000 unknowns; 8-node elements end at 0.4999."""
    needle = polygon([[0.0, 0.0], [1.0, 0.0], [1.0, 0.01], [0.0, 0.01]])
    plan = plan_of(needle)
    grid = punch_mesh.face_grid(plan.geometry, 5)
    assert (grid.order, grid.symmetry) == (1, "quarter")
    assert grid.unknowns < 70_000
    rubber = "youngs_modulus = 1.0\npoisson_ratio = 0.5"
    assert "incompressible" in fem_of(plan_of(needle, body=rubber)).reason


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
    expected = punch_mesh.face_grid(plan.geometry, resolution).unknowns
    _, slope = stiffness(plan, resolution)
    assert slope <= expected < 1.6 * slope


def test_a_mesh_that_does_not_fit_into_memory_is_refused_with_its_figure(monkeypatch):
    monkeypatch.setattr(psutil, "virtual_memory", lambda: SimpleNamespace(available=5.5e7))
    for shape in ('shape = "paraboloid"\nradius = 1.0', polygon(ANGLE)):
        fem = fem_of(plan_of(shape))
        assert "needs about" in fem.reason
        assert "0.1 GB are free" in fem.reason
        assert len(fem.resolutions) < 3


@pytest.mark.slow
def test_penalty_at_quadrature_points_is_an_option_of_the_scene():
    """Within its softness, 3e-3 at 1e3, of the same mesh in its nodes."""
    for shape in ('shape = "paraboloid"\nradius = 1.0', 'shape = "square_punch"\nside = 1.0'):
        options = '[methods.fem]\ncontact = "penalty"\npoints = "quadrature"'
        assert stiffness(plan_of(shape, options), 3)[0] == pytest.approx(
            stiffness(plan_of(shape), 3)[0], rel=3e-3
        )
