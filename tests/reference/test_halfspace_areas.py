"""Counted and corrected areas, patches across seams, stiffness and energy of contacts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from reference.contact.press import sweep
from reference.halfspace import FreeOperator, PeriodicOperator, areas
from reference.loads import Load

MASKS = st.integers(0, 2**32).map(lambda seed: np.random.default_rng(seed).random((7, 9)) < 0.5)


def test_perimeter_correction_formula_on_single_cells_and_blocks():
    """S counts cell edges: 4 for a cell, 2 (a + b) for an a x b block, 0 inside."""
    factor = (np.pi - 1 + np.log(2)) / 24
    block = np.zeros((8, 8), dtype=bool)
    block[2:4, 3:6] = True
    expected = 6 * 0.25 - factor * 10 * 0.25
    assert areas.corrected_area(block, (0.5, 0.5)) == pytest.approx(expected, rel=1e-14)


def test_rectangular_cells_are_a_stretched_grid():
    """Stretching one axis multiplies raw and corrected areas alike."""
    mask = np.random.default_rng(22).random((6, 5)) < 0.5
    square = areas.corrected_area(mask, (1.0, 1.0))
    assert areas.corrected_area(mask, (1.0, 3.0)) == pytest.approx(3 * square)


@settings(max_examples=30, deadline=None)
@given(mask=MASKS, shift=st.tuples(st.integers(0, 6), st.integers(0, 8)))
def test_periodic_areas_and_patches_do_not_depend_on_the_origin(mask, shift):
    moved = np.roll(mask, shift, axis=(0, 1))
    before, after = (areas.patches(m, (1.0, 2.0), periodic=True) for m in (mask, moved))
    assert before.count == after.count
    assert sorted(before.areas) == sorted(after.areas)
    assert areas.corrected_area(mask, (1.0, 1.0), True) == pytest.approx(
        areas.corrected_area(moved, (1.0, 1.0), True)
    )


@settings(max_examples=30, deadline=None)
@given(mask=MASKS)
def test_corrected_area_lies_between_half_and_all_of_the_raw_area(mask):
    raw = areas.raw_area(mask, (1.0, 0.5))
    corrected = areas.corrected_area(mask, (1.0, 0.5), periodic=True)
    assert 0.52 * raw <= corrected <= raw


def test_patches_meet_across_edges_not_corners_and_across_seams_when_periodic():
    mask = np.array([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0]], dtype=bool)
    free = areas.patches(mask)
    assert free.count == 4
    assert free.areas.tolist() == [1.0, 1.0, 1.0, 1.0]
    periodic = areas.patches(mask, (0.5, 0.5), periodic=True)
    assert periodic.count == 2
    assert sorted(periodic.areas) == [0.25, 0.75]
    assert areas.patches(np.zeros((3, 3)), periodic=True).count == 0


def test_stiffness_is_the_slope_of_the_load_curve():
    """dF/dd at fixed contact: exact between two depths with the same contact set (F is linear)."""
    height = np.random.default_rng(23).standard_normal((20, 20))
    operator = FreeOperator((20, 20), (1.0, 1.0), 3.0)
    low, high = sweep(
        operator, height.max() - height, Load("penetration", [0.8, 0.8 + 1e-6]), by="pivot"
    )
    np.testing.assert_array_equal(low.mask, high.mask)
    slope = (high.force - low.force) / (high.penetration - low.penetration)
    assert areas.contact_stiffness(operator, low.mask) == pytest.approx(slope, rel=1e-7)


@pytest.mark.parametrize("operator_class", [FreeOperator, PeriodicOperator])
def test_stiffness_errs_by_the_square_of_what_the_displacement_does(operator_class):
    """Below the exact one, as the functional has its maximum there; 1e-13 is for rounding."""
    height = ndimage.gaussian_filter(np.random.default_rng(5).standard_normal((48, 48)), 1.5)
    mask = height > np.quantile(height, 0.9)
    operator = operator_class(mask.shape, (1.0, 1.0), 2.0)
    exact = areas.contact_stiffness(operator, mask, 1e-9)
    for tolerance in (1e-2, 1e-3, 1e-4):
        stiffness = areas.contact_stiffness(operator, mask, tolerance)
        assert exact * (1 - tolerance**2) <= stiffness < exact * (1 + 1e-13)


def test_stiffness_of_nearly_full_periodic_contact_diverges():
    """One open strip of Westergaard's wave: stiffer without bound as the strip closes."""
    operator = PeriodicOperator((256, 1), (1 / 256, 1.0), 1.0)
    stiffness = [
        areas.contact_stiffness(operator, (np.arange(256) >= width)[:, None])
        for width in (64, 16, 4, 1)
    ]
    assert (np.diff(stiffness) > 0).all()
    assert stiffness[-1] > 100 * stiffness[0]
    assert areas.contact_stiffness(operator, np.ones((256, 1), dtype=bool)) == np.inf


def test_what_is_no_mask_is_refused():
    for measure in (areas.raw_area, areas.corrected_area, areas.patches):
        with pytest.raises(ValueError, match=r"two dimensions.*two positive lengths"):
            measure(np.ones(3), (1.0, -1.0))
        with pytest.raises(ValueError, match="1 undefined"):
            measure([[np.nan, 1.0]], (1.0, 1.0))


def test_stiffness_refuses_other_grids_and_vanishes_without_contact():
    operator = FreeOperator((4, 4), (1.0, 1.0), 1.0)
    assert areas.contact_stiffness(operator, np.zeros((4, 4), dtype=bool)) == 0.0
    with pytest.raises(ValueError, match=r"shape \(3, 4\)"):
        areas.contact_stiffness(operator, np.ones((3, 4), dtype=bool))
