"""Why the area fails: the contact of a surface beside that of its line, moved by one slider."""

from dataclasses import replace

import numpy as np
import pytest

from comparisons.results import selection
from reports.plots.model import failure_view
from reports.plots.pressure import pressure_fields
from reports.plots.stored import slider_steps


@pytest.fixture
def rough(study):
    return study.scenes[1]


def test_surface_line_and_shares_move_with_one_slider(rough):
    figures = failure_view(rough)
    assert [figure.key for figure in figures] == [
        *("failure-surface", "reduced-line", "failure-fractions")
    ]
    for figure in figures:
        assert len(figure.earlier) == len(slider_steps(rough).steps) - 1


def test_the_map_has_a_contact_where_there_is_pressure_and_heights_elsewhere(rough):
    surface = failure_view(rough)[0]
    (item,) = [field for field in pressure_fields(rough) if field.rough]
    pressure = item.pressure.reshape(item.shape)
    values = surface.map.values
    assert values.shape == pressure.shape  # small: nothing is merged
    np.testing.assert_array_equal(values == 1.0, pressure > 0)
    heights = rough.load_fields(item.method, item.resolution)["heights"][pressure <= 0]
    order = np.argsort(heights)
    assert (np.diff(values[pressure <= 0][order]) >= 0).all()


def test_shares_are_areas_over_the_nominal_one_and_the_ring_stands_at_the_load(rough):
    """A/A0 with A0 the side squared: cells from the centre of the first to that of the last."""
    shares = failure_view(rough)[2]
    x = np.unique(pressure_fields(rough)[-1].x)
    side = np.ptp(x) * len(x) / (len(x) - 1)
    areas = selection.curve(rough, "reduced")["contact_area"]
    (model,) = [line for line in shares.series if line.look.label == "area, reduced model"]
    np.testing.assert_allclose(model.y, areas / side**2, rtol=1e-9)
    for step, figure in zip(slider_steps(rough).steps, (*shares.earlier, shares), strict=True):
        assert model.y[step] in figure.series[-1].y


def test_scenes_without_a_rough_surface_or_its_line_have_no_such_view(study, rough):
    assert failure_view(study.scenes[0]) == []
    alone = {key: path for key, path in rough.fields.items() if key[0] != "reduced"}
    assert failure_view(replace(rough, fields=alone)) == []
