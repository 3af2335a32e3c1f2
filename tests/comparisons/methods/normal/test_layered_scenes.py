"""Scenes with layers, a rigid base or a graded modulus: keys, readings, solvers, refusals."""

import numpy as np
import pytest

from comparisons.geometry.prepare import elastic_body, prepare
from comparisons.methods.fem import rough_surface
from comparisons.methods.registry import solver_for
from comparisons.questions.single import solve_scene
from comparisons.scene.scene import load_scene
from comparisons.solving import execution
from comparisons.solving.execution import execute
from comparisons.tasks.task import Task
from reference.layered import Stack

COATING = {"thickness": "2 um", "youngs_modulus": "400 GPa", "poisson_ratio": 0.2}
BALL = {"shape": "paraboloid", "radius": "100 um"}
DEPTHS = {"penetration": ["100 nm", "200 nm"]}


def scene(half_space=None, **tables):
    base = {"youngs_modulus": "70 GPa", "poisson_ratio": 0.3}
    chosen = {"name": "layered", "half_space": base | (half_space or {}), "loading": DEPTHS}
    if "surface" not in tables:
        chosen["indenter"] = BALL
    return load_scene(chosen | tables)


def test_units_and_digests_know_the_layers():
    made = scene({"layers": [COATING], "thickness": "1 mm"})
    body = elastic_body(made)
    assert body.thicknesses == (2e-6, 1e-3)
    assert body.base is None
    assert load_scene(made, {"name": "again"}).half_space == made.half_space
    assert "thickness = 2e-06" in made.text
    graded = elastic_body(scene({"grading": {"exponent": 0.5, "depth": "1 mm"}}))
    assert (graded.exponent, graded.depth) == (0.5, 1e-3)


def test_readings_of_layers(curves):
    """The printed one is blind to the coating; the effective one goes from one E* to the other."""
    made = scene({"layers": [COATING]})
    plain = curves(scene(), "reduced", 40)["force"]
    reading = {"substrate": plain, "layer": plain * (400 / (1 - 0.04)) / (70 / (1 - 0.09))}
    for name, force in reading.items():
        chosen = load_scene(made, {"methods.reduced.layers": name})
        np.testing.assert_allclose(curves(chosen, "reduced", 40)["force"], force, rtol=1e-12)
    effective = load_scene(made, {"methods.reduced.layers": "effective"})
    force = curves(effective, "reduced", 40)["force"]
    assert (reading["substrate"] < force).all()
    assert (force < reading["layer"]).all()
    tables = made.model_dump(exclude_none=True, exclude_defaults=True, exclude={"loading"})
    tables |= {"loading": {"force": force.tolist()}}
    by_force = load_scene(tables, {"methods.reduced.layers": "effective"})
    depth = curves(by_force, "reduced", 40)["penetration"]
    np.testing.assert_allclose(depth, [100e-9, 200e-9], rtol=1e-10)


def test_rough_surfaces_on_layers(curves, rough):
    """A period on a stiff base sinks by the mean pressure; layers of one material are none."""
    same = {"thickness": "0.1 um", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
    for periodic in (False, True):
        made = rough(points=32, periodic=periodic)
        alike = load_scene(made, {"half_space.layers": [same]})
        plain = curves(made, "bem_fft", 32)
        layered, elements = curves(alike, "bem_fft", 32), curves(alike, "fem", 32)
        for name in ("force", "contact_area", "penetration"):
            np.testing.assert_allclose(layered[name], plain[name], rtol=1e-6)
            # the same 32 points, of which the shortest wave has two
            np.testing.assert_allclose(elements[name], plain[name], rtol=5e-2)
        thin = curves(load_scene(made, {"half_space.thickness": "0.1 um"}), "bem_fft", 32)
        if not periodic:
            assert (thin["penetration"] < plain["penetration"]).all()
    assert isinstance(elastic_body(alike), Stack)


def test_code_is_warmed_up_on_cells_of_the_scene(monkeypatch):
    """On cells of a metre rubber of micrometres is nothing: no iteration ended."""
    made = scene({"poisson_ratio": 0.5, "thickness": "6 um"}, indenter=BALL | {"radius": "10 mm"})
    task = Task(made, *prepare(made), "fem", 16, quantities=frozenset({"force"}))
    monkeypatch.setattr(execution, "_compiled", {})
    assert execute(task).converged.all()  # of a warm-up that fails all loads are lost


def test_elements_may_end_on_a_half_space_and_say_so(curves):
    """The mesh ends eight cells down."""
    ended = {"methods": {"fem": {"bottom": "impedance"}}}
    answers = [curves(scene({"layers": [COATING]}, **end), "fem", 8) for end in ({}, ended)]
    np.testing.assert_allclose(answers[1]["force"], answers[0]["force"], rtol=1e-4)
    solver = solver_for("fem", scene({"layers": [COATING]}, **ended))
    assert "theory shared with bem_fft" in solver.model(prepare(solver.scene)[0])


@pytest.mark.parametrize("name", ["coated-ball", "layer-on-base", "graded-ball"])
def test_closed_forms_of_layers_and_powers_of_the_depth_are_what_the_grid_approaches(curves, name):
    """32 cells per radius at the largest load, half as many at the smallest."""
    exact, grid = curves(name, "closed_form"), curves(name, "bem_fft", 32)
    np.testing.assert_allclose(grid["force"], exact["force"], rtol=3e-3)
    np.testing.assert_allclose(grid["contact_area"], exact["contact_area"], rtol=2e-2)


def test_flat_circle_on_a_graded_half_space_is_a_limit_of_powers(curves):
    face = {"shape": "cylinder", "radius": "3 um"}
    graded = {"grading": {"exponent": 0.4, "depth": "2 um"}}
    made = scene(graded, indenter=face)
    exact = curves(made, "closed_form", 1, "energy")
    springs = curves(made, "reduced", 40)["force"]
    np.testing.assert_allclose(springs, exact["force"], rtol=1e-9)
    np.testing.assert_allclose(exact["energy"], exact["force"] * exact["penetration"] / 2)


@pytest.mark.slow
def test_stress_below_a_hard_coating_jumps_at_the_interface():
    """Strains along it are continuous, so that a coating 10 times as stiff bears more.

    Of 64 cells per radius the pressure is taken by blocks, of 16 by cells: 2 % for the coarser one.
    """
    made = load_scene("coated-ball")
    geometry, loads = prepare(made)
    sides = []
    for cells in (16, 64):
        task = Task(made, geometry, loads, "fem", cells, quantities=frozenset(), with_body=True)
        fields = solver_for("fem", made).solve(task).body_fields()
        place = np.searchsorted(fields["von_mises_depth"], 4e-6)
        assert np.ptp(fields["von_mises_depth"][place - 1 : place + 1]) < 1e-5 * 4e-6
        sides.append(fields["von_mises_highest"][place - 1 : place + 1])
    np.testing.assert_allclose(*sides, rtol=0.02)
    above, below = sides[1]
    assert 2 * below < above < 10 * below


@pytest.mark.slow
@pytest.mark.parametrize(("name", "widest"), [("rough-patch", 128), ("rough-periodic", 32)])
def test_stress_below_a_large_surface_is_that_below_the_highest_pressure(name, widest, monkeypatch):
    """Of a quarter of the cells, at the surface: what presses further away adds 5 %."""
    made = load_scene(name)
    geometry, loads = prepare(made)
    task = Task(made, geometry, loads, "fem", 64, quantities=frozenset(), with_body=True)
    solution = solver_for("fem", made).solve(task)
    whole = solution.body_fields()
    monkeypatch.setattr(rough_surface, "_WIDEST", widest)
    part = solution.body_fields()
    assert part["stressed_cells"].tolist() == [32, 32]
    surfaces = []
    for fields in (whole, part):
        count = len(fields["mesh_von_mises"]) // len(fields["von_mises_depth"])
        surfaces.append((fields["mesh_points"][:count, :2], fields["mesh_von_mises"][:count]))
    (everywhere, exact), (places, stress) = surfaces
    at = stress.argmax()
    period = np.array(made.surface.size)
    away = (everywhere - places[at] + period / 2) % period - period / 2
    same = np.hypot(*away.T).argmin()
    assert np.hypot(*away[same]) < 1e-9 * period[0]
    assert stress[at] == pytest.approx(exact[same], rel=0.05)


def test_stress_below_a_ball_on_a_graded_body_is_told(tmp_path):
    """A file with von Mises stresses, of the size of the largest pressure."""
    made = load_scene("graded-ball", {"loading.penetration": ["160 nm"]})
    result = solve_scene(made, "fem", 4, with_fields=True)
    result.to_vtu(tmp_path / "below.vtu")
    assert b"von_mises" in (tmp_path / "below.vtu").read_bytes()
    fields = result.solution.fields
    assert 0.4 < fields["mesh_von_mises"].max() / fields["pressure"].max() < 0.8
