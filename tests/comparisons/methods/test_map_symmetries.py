"""Symmetries of the contact of a map: what turns, mirrors or shifts a map and nothing else.

No solver is trusted: each is compared with itself on the same surface in another place or
position. Free and periodic maps, square and 3 : 2, every method that takes them.
"""

from typing import NamedTuple

import numpy as np
import pytest

from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference import surfaces

SIDE = 1e-6
# At 3 : 2 rings of the reduced model have modes midway between them. Finite elements take half the
# points: their cost grows as the fourth power.
SHAPES = {"square": ((12, 12), (SIDE, SIDE)), "3:2": ((8, 12), (SIDE, 1.5 * SIDE))}
PERIODIC_METHODS = ("reduced", "bem_fft")
FREE_METHODS = ("reduced", "bem_fft", "bem_dense", "fem")
CASES = [
    *[(method, False, shape) for method in FREE_METHODS for shape in SHAPES],
    *[(method, True, shape) for method in PERIODIC_METHODS for shape in SHAPES],
]
FINER = [(method, periodic, shape) for method, periodic, shape in CASES if method[:3] == "bem"]
QUANTITIES = ("penetration", "contact_area", "mean_gap", "stiffness", "energy")
# Relative differences that are allowed, with their reasons:
TOLERANCES = {
    # the spectrum to round-off, which the contact edges of the line magnify
    "reduced": 1e-10,
    # the iteration ends at a residual of 1e-8 of the penetration
    "bem_fft": 1e-6,
    # exact to round-off of its matrix, on one contact set
    "bem_dense": 1e-10,
    # elimination in another order: round-off times the condition of the mesh
    "fem": 1e-8,
}
# What cells leave out of these at the rim, up to a tenth, is from a response solved to 1e-6.
AT_THE_RIM = {"penetration": 1e-7, "mean_gap": 1e-7}


class Surface(NamedTuple):
    """Heights on a rectangle."""

    heights: np.ndarray
    size: tuple[float, float]


# scipy's splines mirror a line of n points at its ends to 0.27^(2 n): 1e-9 for the 8 points here.
SPLINES = 1e-8


def surface(shape, method=""):
    """Random heights without any symmetry, smooth enough for every mesh."""
    points, size = SHAPES[shape]
    if method == "fem":
        points = tuple(n // 2 for n in points)
    heights = surfaces.self_affine(
        points,
        size,
        surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=SIDE / 3),
        seed=5,
        realisation=0,
    )
    return Surface(heights + 0.02 * np.ptp(heights), size)


MOVES = {
    "flip x": lambda m: Surface(m.heights[::-1].copy(), m.size),
    "flip y": lambda m: Surface(m.heights[:, ::-1].copy(), m.size),
    "swap axes": lambda m: Surface(m.heights.T.copy(), m.size[::-1]),
    "a side longer by 1e-15": lambda m: Surface(m.heights, (m.size[0] * (1 + 1e-15), m.size[1])),
    "a side shorter by 1e-15": lambda m: Surface(m.heights, (m.size[0], m.size[1] * (1 - 1e-15))),
    "raised": lambda m: Surface(m.heights + 0.3 * np.ptp(m.heights), m.size),
}
ROLLS = {"roll by 1 and -3": lambda m: Surface(np.roll(m.heights, (1, -3), (0, 1)), m.size)}


@pytest.fixture
def pressed(mapped):
    """Return a function that solves a map with one method at one factor of its own points."""

    def press(map_, method, periodic, factor=1):
        body = {"half_space": {"youngs_modulus": 1e9, "poisson_ratio": 0.3}}
        asked = {"compare": {"quantities": list(QUANTITIES)}}
        kind = {"detrend": "mean", "periodic": periodic, "realisations": 2}
        forces = {"force": [3e-6, 3e-5]}
        made = mapped(map_.heights, forces, body | asked, size=list(map_.size), **kind)
        (plan, *_) = plan_scene(made)
        own = max(map_.heights.shape) if method == "reduced" else map_.heights.shape[0]
        rows = (0, 1) if method == "reduced" else (0,)
        solution = execute(task_of(plan, method, factor * own, rows), 1)
        assert solution.converged.all(), solution.reasons
        return {name: solution.quantities[name] for name in QUANTITIES}

    return press


def assert_same(result, expected, method, tolerance, why):
    for name, values in expected.items():
        rim = AT_THE_RIM.get(name, 0.0) if tolerance and method != "reduced" else 0.0
        np.testing.assert_allclose(
            result[name], values, rtol=max(tolerance, rim), err_msg=f"{name}, {why}"
        )


def assert_symmetric(press, map_, method, periodic, tolerance, factor=1):
    """Compare a map with its images; name the image that differs."""
    expected = press(map_, method, periodic, factor)
    for name, move in (MOVES | (ROLLS if periodic else {})).items():
        assert_same(press(move(map_), method, periodic, factor), expected, method, tolerance, name)


@pytest.mark.parametrize(("method", "periodic", "shape"), CASES)
def test_a_map_turned_mirrored_or_raised_is_the_same_surface(pressed, method, periodic, shape):
    """The half-space looks alike from all sides, and first touch is where the map is highest."""
    map_ = surface(shape, method)
    assert_symmetric(pressed, map_, method, periodic, TOLERANCES[method])


@pytest.mark.slow
@pytest.mark.parametrize(("method", "periodic", "shape"), FINER)
def test_a_finer_grid_of_a_map_turns_with_it(pressed, method, periodic, shape):
    """Interpolation between the points has the symmetries too: wrapped or mirrored at the sides."""
    tolerance = TOLERANCES[method] if periodic else max(TOLERANCES[method], SPLINES)
    assert_symmetric(pressed, surface(shape, method), method, periodic, tolerance, factor=2)
