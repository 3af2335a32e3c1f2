"""The continuation of fields from a contact to all cells, and what it is for."""

import numpy as np
import pytest

from reference import surfaces
from reference.contact import press as pressing
from reference.contact.extension import Extension
from reference.contact.press import press
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.loads import Load


@pytest.mark.parametrize(
    ("shape", "period"),
    [((16, 16), (16, 16)), ((7, 9), (7, 9)), ((12, 20), (17, 23)), ((1, 5),) * 2],
)
def test_restriction_is_the_transpose_of_extension(shape, period):
    """r.E^T y = E r.y to rounding: conjugate gradients need a symmetric preconditioner."""
    random = np.random.default_rng(1)
    free = (random.random(shape) < 0.2).astype(np.uint8)
    free[0, 0] = 1
    values, field = random.random(shape) * free, random.random(period)
    extension = Extension(shape, period, np.float64)
    extended = extension.extend(values, free, np.empty(period))
    restricted = extension.restrict(field, free, np.empty(shape))
    assert np.vdot(extended, field) == pytest.approx(np.vdot(values, restricted), rel=1e-13)
    assert not restricted[free == 0].any()
    # as a mean of means, and unchanged on the contact
    assert extended.max() <= values.max() * (1 + 1e-12)
    assert np.allclose(extended[: shape[0], : shape[1]][free > 0], values[free > 0], rtol=1e-14)


@pytest.mark.parametrize("operator_class", [PeriodicOperator, FreeOperator])
def test_convolutions_do_not_grow_with_the_grid(operator_class):
    """Four times the points a side, of the same waves in cells, take as many convolutions.

    By zeros in place of the extension they took 44 and 51 (free), 48 and 46 (periodic).
    """
    single = []
    for points in (96, 384):
        waves = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=16 / points)
        heights = surfaces.self_affine((points, points), (1.0, 1.0), waves, seed=1, realisation=0)
        operator = operator_class(heights.shape, (1 / points, 1 / points), 1.0)
        load = Load("force", 0.225 * 0.1 / 2)
        contact = press(operator, heights.max() - heights, load, tolerance=1e-8)
        assert contact.convolutions[1] <= 3
        single.append(contact.convolutions[0])
    assert max(single) <= 34
    assert single[1] <= 1.3 * single[0]


@pytest.mark.slow
@pytest.mark.parametrize("shape", [(8192, 256), (16384, 128)])
def test_long_periods_take_as_many_convolutions_as_short_ones(shape):
    """512 and 1024 shortest waves along one side: coarser grids are solved to what waves need.

    Where all grids stopped at 1 % of the penetration, which grows with the period, the finest got
    the errors of four: 37 and 99 convolutions. Where directions were kept across changes of the
    contact, 20 and 38.
    """
    step = 1 / shape[0]
    waves = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=16 * step)
    lengths = (1.0, shape[1] * step)
    heights = surfaces.self_affine(shape, lengths, waves, seed=1, realisation=0)
    body = PeriodicOperator(shape, (step, step), 1.0)
    load = Load("force", 0.225 * 0.1 / 2 * lengths[1])
    contact = press(body, heights.max() - heights, load, tolerance=1e-8)
    assert contact.convolutions[0] <= 25


def test_a_coarser_grid_that_misses_its_tolerance_is_still_a_start(monkeypatch):
    """One iteration on each coarser grid leaves most of what they save beside the overlap."""
    points = 256
    waves = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=4 / points)
    heights = surfaces.self_affine((points, points), (1.0, 1.0), waves, seed=1, realisation=0)
    body = PeriodicOperator(heights.shape, (1 / points,) * 2, 1.0)
    gap, load = heights.max() - heights, Load("force", 0.225 * 0.1 / 2)

    def violation() -> float:
        return press(body, gap, load, tolerance=1e-8).history[0]

    with monkeypatch.context() as patch:
        patch.setattr(pressing, "_SHORTEST_COARSENED", 2 * points)
        overlap = violation()
    monkeypatch.setattr(pressing, "_COARSE_ITERATIONS", 1)
    assert violation() < overlap / 2
