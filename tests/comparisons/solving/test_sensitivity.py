"""Measured maps prepared otherwise: trends, cut-offs and quarters, at one nominal pressure."""

import numpy as np
import pytest

from comparisons.errors import InputError
from comparisons.formatting import with_unit
from comparisons.geometry.prepare import prepare
from comparisons.solving.map_scenes import prepared_otherwise
from comparisons.solving.planning import plan_all


@pytest.fixture
def measured(mapped):
    heights = 1e-6 * np.random.default_rng(0).random((40, 36))

    def make(force=4.0, **surface):
        return mapped(heights, {"force": force}, size="1 mm", detrend=None, **surface)

    return make


def words_of(scenes):
    return [scene.sweep["preparation"] for scene in scenes]


CUTOFFS = [f"cut-off {with_unit(n * 1e-3 / 36, 'm')}" for n in (4, 8)]  # of the larger cells
QUARTERS = ["crop at 0, 0", "crop at 0, 18", "crop at 20, 0", "crop at 20, 18"]


def test_a_free_patch_is_solved_with_other_trends_and_cut_offs_and_by_quarters(measured):
    scenes = prepared_otherwise(measured())
    trends = ["as given", "detrend mean", "detrend curvature"]
    assert words_of(scenes) == trends + CUTOFFS + QUARTERS
    assert len({scene.name for scene in scenes}) == len(scenes)
    whole, quarter = (prepare(scene)[0] for scene in (scenes[0], scenes[-1]))
    # the same nominal pressure: a quarter of the area, a quarter of the force
    assert quarter.area / whole.area == pytest.approx(0.25)
    assert scenes[-1].loading.force.values == (1.0,)


def test_a_relative_load_is_that_of_the_map_as_given(measured):
    """A filter takes slopes away, and F/(E* A0 h') would be another force."""
    scenes = prepared_otherwise(measured({"value": 0.01, "relative_to": "E* A0 h'"}))
    forces = np.array([prepare(scene)[1].values[0] for scene in scenes])
    slopes = [prepare(scene)[0].rms_slope for scene in scenes]
    assert forces[:-4] == pytest.approx(forces[0])
    assert forces[-4:] == pytest.approx(forces[0] / 4)
    assert slopes[4] < slopes[3] < 0.6 * slopes[0]  # white noise lives in its shortest waves


def test_a_quarter_of_a_crop_lies_in_the_crop(measured):
    crops = [scene.surface.crop for scene in prepared_otherwise(measured(crop=[4, 2, 32, 32]))]
    assert crops[-4:] == [(4, 2, 16, 16), (4, 18, 16, 16), (20, 2, 16, 16), (20, 18, 16, 16)]


def test_a_periodic_map_has_no_quarters_and_no_plane(measured):
    assert words_of(prepared_otherwise(measured(periodic=True))) == ["as given", *CUTOFFS]


def test_what_is_no_map_is_told():
    with pytest.raises(InputError, match="paraboloid: --sensitivity"):
        plan_all(["paraboloid"], {}, "quick", sensitivity=True)


def test_a_plan_of_a_map_has_all_of_them(measured):
    plans = plan_all([measured()], {}, "quick", sensitivity=True)
    assert len(plans) == 9
