"""Peak pressure and stresses inside, as every method gives them."""

from functools import partial

import numpy as np
import pytest

from comparisons.methods.normal import grid
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

PEAK = {"quantities": ["pressure", "pressure_peak"]}
NAMES = ["pressure_mean", "pressure_peak", "shear_max", "von_mises_max", "von_mises_depth"]


def quantities(plan, method, resolution):
    """Return what a method gives at the last load, for which N is chosen."""
    solution = execute(task_of(plan, method, resolution), 1)
    assert solution.converged.all(), solution.reasons
    return {name: values[0, -1] for name, values in solution.quantities.items()}


@pytest.mark.slow
def test_every_method_finds_what_hertz_says_of_a_ball(scene):
    """p0 = 3 F/(2 pi a^2); 0.310 p0 of shear and 0.620 p0 of von Mises, 0.48 a deep, at nu = 0.3.

    Closed form and springs are laid on 32 cells per radius: 3e-4. On 16 cells stresses err by
    1.2e-3, the largest of the pressures by a quarter of a cell's square, 1e-3; four elements per
    radius by per cents.
    """
    table = {"youngs_modulus": 210e9, "poisson_ratio": 0.3}
    (plan,) = plan_scene(scene(half_space=table, compare={"quantities": ["force", *NAMES]}))
    for method, resolution, share in (
        *(("closed_form", 1, 1e-3), ("reduced", 100, 1e-3)),
        *(("bem_fft", 16, 5e-3), ("fem", 4, 0.05)),
    ):
        got = quantities(plan, method, resolution)
        radius = np.sqrt(got["contact_area"] / np.pi)
        mean = got["force"] / (np.pi * radius**2)
        assert got["pressure_mean"] == pytest.approx(mean)
        assert got["pressure_peak"] == pytest.approx(1.5 * mean, rel=share)
        assert got["shear_max"] == pytest.approx(0.310 * 1.5 * mean, rel=share)
        assert got["von_mises_max"] == pytest.approx(0.620 * 1.5 * mean, rel=share)
        assert got["von_mises_depth"] == pytest.approx(0.481 * radius, rel=0.02 + share)


def test_what_is_unbounded_below_a_sharp_edge_or_tip_is_not_given(scene):
    for indenter in ({"shape": "cylinder", "radius": 1e-2}, {"shape": "cone", "slope": 0.1}):
        (plan,) = plan_scene(scene(indenter=indenter, compare={"quantities": NAMES}))
        assert set(NAMES) & set(quantities(plan, "closed_form", 1)) == {"pressure_mean"}


def test_the_peak_is_that_of_all_cells_where_fields_are_means_over_blocks(scene, monkeypatch):
    """As it is on maps of more than 2^20 cells, on a small one."""
    rough = {"kind": "self_affine", "size": 1e-3, "points": 32, "hurst": 0.8, "rms_height": 1e-6}
    plan = partial(plan_scene, scene(surface=rough, loading={"pressure": 1e8}, compare=PEAK))
    whole = quantities(plan()[0], "bem_fft", 32)["pressure_peak"]
    monkeypatch.setattr(grid, "MOST_POINTS", 256)
    monkeypatch.setattr(grid, "SIDE", 16)
    solution = execute(task_of(plan()[0], "bem_fft", 32), 1)
    # a field is kept in single precision, where it is kept
    assert solution.quantities["pressure_peak"][0, -1] == pytest.approx(whole, rel=1e-6)
    assert solution.fields["pressure"].max() < 0.9 * whole


def test_of_a_rough_surface_cells_and_waves_give_the_stress(scene):
    """A light load, periodic and on a free patch: stresses are of the order of pressures."""
    rough = {"kind": "self_affine", "size": 1e-3, "points": 16, "hurst": 0.8, "rms_height": 1e-6}
    for periodic in (True, False):
        table = rough | {"seed": 1, "periodic": periodic}
        loading = {"pressure": 1e8}
        (plan,) = plan_scene(scene(surface=table, loading=loading, compare={"quantities": NAMES}))
        got = quantities(plan, "bem_fft", 16)
        assert got["pressure_peak"] > got["pressure_mean"] > 1e8
        # principal stresses differ by no more than the largest pressure, but at edges
        assert 0.2 < got["von_mises_max"] / got["pressure_peak"] < 1.0
        assert got["shear_max"] == pytest.approx(got["von_mises_max"] / np.sqrt(3), rel=0.16)
