"""Scenes with [lubrication]: what methods answer, what they refuse, what a scene must say."""

import numpy as np
import pytest

from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refusal
from comparisons.scene.scene import SceneError, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.planning import plan_scene
from comparisons.tasks.task import Task
from reference.lubrication.formulas import squeezed_film

SOFT = {
    "name": "film",
    "half_space": {"effective_modulus": 1e6},
    "indenter": {"shape": "paraboloid", "radius": 0.01},
    "lubrication": {"viscosity": 1.0, "speed": [1e-3, 1e-2]},
    "loading": {"force": 0.2},
}
SQUEEZED = SOFT | {
    "lubrication": {"viscosity": 1.0},
    "loading": {"force": [0.01, 0.1], "squeeze_speed": 1e-3},
}


def solved(tables, name, resolution):
    """Return the curves of a method on a scene."""
    (plan, *_) = plan_scene(load_scene(tables))
    asked = ("film_central", "film_minimum", "lubrication_force", "friction_force")
    task = Task(plan.scene, plan.geometry, plan.loads, name, resolution, asked)
    return {key: curve[0] for key, curve in execute(task).quantities.items()}


FLAT = {"waviness": {"amplitude": 0, "wavelength": 1}}
WAVY = {"waviness": {"amplitude": 1e-6, "wavelength": 1e-3}}
ROUGH = {"roughness": {"rms_height": 1e-6, "longest": 1e-3, "shortest": 1e-5}}


@pytest.mark.parametrize(
    ("oil", "loading", "expected"),
    [
        ({"viscosity": 0, "speed": 1}, {}, "viscosity: expected a positive"),
        ({"viscosity": -1, "speed": 1} | FLAT, {}, "viscosity: expected a positive"),
        ({"speed": 1} | FLAT, {}, "amplitude: expected a positive"),
        ({}, {}, "expected speed or loading.squeeze_speed, got none"),
        ({"speed": 1}, {"squeeze_speed": 1}, "or loading.squeeze_speed, got both"),
        ({"speed": 1}, {"force": None, "penetration": 1e-6}, "expected a force with"),
        ({"speed": [2, 1]}, {}, "strictly increasing"),
        ({"speed": 1, "slide_to_roll": 1} | WAVY, {}, "expected 2: a rough ball that moves"),
        ({"speed": 1} | ROUGH, {}, "expected from 1 to 16 times shortest"),
    ],
)
def test_a_scene_says_what_the_film_needs(oil, loading, expected):
    """Each fault by its path: no film without viscosity, one way of moving, a load."""
    loading = {key: value for key, value in ({"force": 1} | loading).items() if value is not None}
    with pytest.raises(SceneError) as caught:
        load_scene(SOFT | {"lubrication": {"viscosity": 1} | oil, "loading": loading})
    assert expected in "\n".join(caught.value.problems)


def test_a_squeeze_speed_needs_oil():
    dry = {k: v for k, v in SQUEEZED.items() if k != "lubrication"}
    with pytest.raises(SceneError, match="there is no film"):
        load_scene(dry)


def test_the_fit_is_refused_outside_its_range():
    """Hamrock & Dowson's speeds and loads; the rigid closed form where the film bends rubber."""
    fast = load_scene(SOFT)
    fit = solver_for("hamrock_dowson", fast)
    assert isinstance(fit, Refusal)
    assert "5×10⁻⁹" in fit.reason
    slow = load_scene(SOFT | {"lubrication": {"viscosity": 1.0, "speed": 5e-4}})
    assert not isinstance(solver_for("hamrock_dowson", slow), Refusal)
    assert isinstance(solver_for("closed_form", load_scene(SQUEEZED)), Refusal)


@pytest.mark.parametrize("method", ["bem_fft", "reduced", "closed_form", "hamrock_dowson"])
@pytest.mark.parametrize("forces", [[0.01, 10.0], [10.0, 1e9]])
def test_no_method_answers_where_the_ball_is_no_paraboloid(method, forces):
    """A film thicker than the ball at the first load, or a contact wider at the last one."""
    if method == "hamrock_dowson":
        tables = SOFT | {"lubrication": {"viscosity": 1.0, "speed": [1e-3, 1e3]}}
    else:
        loading = {"force": forces, "squeeze_speed": 0.1}
        stiff = {"effective_modulus": 1e14}
        tables = SQUEEZED | {"loading": loading, "half_space": stiff}
    refusal = solver_for(method, load_scene(tables))
    assert isinstance(refusal, Refusal)
    assert "no ball of radius" in refusal.reason


def test_methods_without_films_say_so():
    """Dry methods and shapes that are no paraboloids: a reason, no answer."""
    scene = load_scene(SOFT)
    for method in ("fem", "bem_dense"):
        assert solver_for(method, scene) is None or isinstance(solver_for(method, scene), Refusal)
    cone = load_scene(SOFT | {"indenter": {"shape": "cone", "slope": 0.1}})
    refused = solver_for("bem_fft", cone)
    assert isinstance(refused, Refusal)
    assert "paraboloids" in refused.reason


def test_waves_too_short_for_cells_are_refused_and_formulas_are_for_smooth_balls():
    """The grid, the fit: reasons in words; the line has no such limit."""
    waves = {"amplitude": 1e-7, "wavelength": 5e-5}
    scene = load_scene(SOFT | {"lubrication": {"viscosity": 1.0, "speed": 5e-4, "waviness": waves}})
    for method, reason in (("bem_fft", "waves so short"), ("hamrock_dowson", "smooth balls")):
        refusal = solver_for(method, scene)
        assert isinstance(refusal, Refusal)
        assert reason in refusal.reason
    assert not isinstance(solver_for("reduced", scene), Refusal)


@pytest.mark.slow
def test_the_line_sees_the_section_of_a_wavy_ball():
    """Long waves are pressed flat: the middle changes by less than the crest."""
    films = {}
    for amplitude in (1e-12, 1e-6):
        waves = {"amplitude": amplitude, "wavelength": 1e-3}
        scene = SOFT | {"lubrication": {"viscosity": 1.0, "speed": 1e-2, "waviness": waves}}
        films[amplitude] = [
            solved(scene, method, n)["film_central"][0]
            for method, n in (("bem_fft", 10), ("reduced", 32))
        ]
    smooth = SOFT | {"lubrication": {"viscosity": 1.0, "speed": 1e-2}}
    for i, (method, n) in enumerate((("bem_fft", 10), ("reduced", 32))):
        assert films[1e-12][i] == pytest.approx(solved(smooth, method, n)["film_central"][0], 1e-6)
        assert 1e-9 < abs(films[1e-12][i] - films[1e-6][i]) < 1e-6


def test_line_and_half_space_carry_the_load():
    """The force of the film is the load; the line's central film is within a third of the truth."""
    scene = SOFT | {"lubrication": {"viscosity": 1.0, "speed": 1e-2}}
    truth, line = (solved(scene, method, n) for method, n in (("bem_fft", 8), ("reduced", 64)))
    for film in (truth, line):
        assert film["lubrication_force"] == pytest.approx([0.2], rel=1e-8)
        assert 0 < film["film_minimum"][0] < film["film_central"][0]
    assert line["film_central"][0] == pytest.approx(truth["film_central"][0], rel=0.3)
    assert line["friction_force"][0] < truth["friction_force"][0]


@pytest.mark.slow
def test_a_stiff_squeeze_is_the_closed_form():
    """Closed form, half-space and the line of the rigid width agree where nothing bends."""
    scene = SQUEEZED | {
        "half_space": {"effective_modulus": 1e13},
        "loading": {"force": [0.05, 0.1], "squeeze_speed": 1e-4},
        "methods": {"reduced": {"film": "rigid"}},
    }
    exact = [squeezed_film(0.01, 1.0, 1e-4, load) for load in (0.05, 0.1)]
    for method, n in (("closed_form", 1), ("bem_fft", 16), ("reduced", 64)):
        # the cells' error on 16 of them, and the ball that ends at r = R
        assert np.array(solved(scene, method, n)["film_minimum"]) == pytest.approx(exact, rel=4e-3)
