"""Scenes with [lubrication]: what methods answer, what they refuse, what a scene must say."""

import numpy as np
import pytest

from reference.lubrication.formulas import squeezed_film

SOFT = {
    "name": "film",
    "half_space": {"effective_modulus": 1e6},
    "indenter": {"shape": "paraboloid", "radius": 0.01},
    "lubrication": {"viscosity": 1.0, "speed": [1e-3, 1e-2]},
    "loading": {"force": 0.2},
    "compare": {
        "quantities": ["film_central", "film_minimum", "lubrication_force", "friction_force"]
    },
}
SQUEEZED = SOFT | {
    "lubrication": {"viscosity": 1.0},
    "loading": {"force": [0.01, 0.1], "squeeze_speed": 1e-3},
}


@pytest.mark.slow
def test_the_line_sees_the_section_of_a_wavy_ball(curves):
    """Long waves are pressed flat: the middle changes by less than the crest."""
    films = {}
    for amplitude in (1e-12, 1e-6):
        waves = {"amplitude": amplitude, "wavelength": 1e-3}
        scene = SOFT | {"lubrication": {"viscosity": 1.0, "speed": 1e-2, "waviness": waves}}
        films[amplitude] = [
            curves(scene, method, n)["film_central"][0]
            for method, n in (("bem_fft", 10), ("reduced", 32))
        ]
    smooth = SOFT | {"lubrication": {"viscosity": 1.0, "speed": 1e-2}}
    for i, (method, n) in enumerate((("bem_fft", 10), ("reduced", 32))):
        assert films[1e-12][i] == pytest.approx(curves(smooth, method, n)["film_central"][0], 1e-6)
        assert 1e-9 < abs(films[1e-12][i] - films[1e-6][i]) < 1e-6


def test_line_and_half_space_carry_the_load(curves):
    """The force of the film is the load; the line's central film is within a third of the truth."""
    scene = SOFT | {"lubrication": {"viscosity": 1.0, "speed": 1e-2}}
    truth, line = (curves(scene, method, n) for method, n in (("bem_fft", 8), ("reduced", 64)))
    for film in (truth, line):
        assert film["lubrication_force"] == pytest.approx([0.2], rel=1e-8)
        assert 0 < film["film_minimum"][0] < film["film_central"][0]
    assert line["film_central"][0] == pytest.approx(truth["film_central"][0], rel=0.3)
    assert line["friction_force"][0] < truth["friction_force"][0]


@pytest.mark.slow
def test_a_stiff_squeeze_is_the_closed_form(curves):
    """Closed form, half-space and the line of the rigid width agree where nothing bends."""
    scene = SQUEEZED | {
        "half_space": {"effective_modulus": 1e13},
        "loading": {"force": [0.05, 0.1], "squeeze_speed": 1e-4},
        "methods": {"reduced": {"film": "rigid"}},
    }
    exact = [squeezed_film(0.01, 1.0, 1e-4, load) for load in (0.05, 0.1)]
    for method, n in (("closed_form", 1), ("bem_fft", 16), ("reduced", 64)):
        # the cells' error on 16 of them, and the ball that ends at r = R
        assert np.array(curves(scene, method, n)["film_minimum"]) == pytest.approx(exact, rel=4e-3)
