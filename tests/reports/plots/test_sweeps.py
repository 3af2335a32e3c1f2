"""Errors along a sweep: what differs is the axis."""

import numpy as np
import pytest

import roughline
from reports.pages.study import page
from reports.plots.sweeps import sweeps

ELLIPSOIDS = {
    "name": "ellipsoids",
    "half_space": {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
    "indenter": {"shape": "ellipsoid", "radius_x": "10 mm", "radius_y": "10 mm"},
    "loading": {"force": ["100 N", "200 N"]},
}


@pytest.fixture
def of(tmp_path):
    def solved(sweep):
        tables = ELLIPSOIDS | {"sweep": sweep}
        study = roughline.Study(tables, tmp_path / "out", methods=["closed_form", "reduced"])
        return study.run().record

    return solved


def test_the_springs_of_a_round_line_err_more_the_longer_the_ellipse(of):
    """Force at equal depth: (19.17) for an ellipse errs by -1, -5 % at radii of 2, 5 to one."""
    record = of({"indenter.radius_x": ["20 mm", "50 mm", "10 mm"]})
    force = next(figure for figure in sweeps(record.scenes) if figure.quantity == "force")
    assert force.x.ticks == ((0.01, "10 mm"), (0.02, "20 mm"), (0.05, "50 mm"))
    model = next(series for series in force.series if "reduced" in series.look.label)
    np.testing.assert_array_equal(model.x, [0.01, 0.02, 0.05])
    np.testing.assert_allclose(model.y[1:], [0.0099, 0.051], rtol=0.02)
    assert "Along the sweep" in page(record, with_pictures=False)


def test_words_stand_one_after_the_other(of):
    record = of({"methods.reduced.rule": ["mdr", "half_radius"]})
    (first, *_) = sweeps(record.scenes)
    assert first.x.ticks == ((1.0, "mdr"), (2.0, "half_radius"))


def test_every_tolerance_of_a_sweep_has_its_line(of):
    (first, *_) = sweeps(of({"compare.tolerance": [0.05, 0.001]}).scenes)
    assert [level.value for level in first.levels] == [0.001, 0.05]


def test_no_sweep_no_figure(study):
    assert sweeps(study.scenes) == []
