"""Contact areas: counted, corrected, and with the rim located inside the cells."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from reference import surfaces
from reference.contact.press import press, sweep
from reference.halfspace import FreeOperator, PeriodicOperator, areas
from reference.halfspace.areas import euler_characteristic, located_area
from reference.halfspace.punches import EDGE_OFFSET
from reference.loads import Load

RANDOM = np.random.default_rng(5)


def _hertz(radius: float, spacing: tuple[float, float] = (1.0, 1.0)):
    """Hertz contact of a radius, its centre anywhere in a cell; E* = 1, R = 100 radius."""
    counts = [2 * int(1.3 * radius / step) + 4 for step in spacing]
    x, y = (
        (np.arange(n) - n / 2 + RANDOM.uniform(0, 1)) * step
        for n, step in zip(counts, spacing, strict=True)
    )
    gap = (x[:, None] ** 2 + y**2) / (200 * radius)
    operator = FreeOperator(gap.shape, spacing, 1.0)
    return press(operator, gap, Load("penetration", radius / 100), tolerance=1e-9)


def _errors(radius: float, count: int, measure, **grid) -> np.ndarray:
    true = np.pi * radius**2
    return np.array([measure(_hertz(radius, **grid)) / true - 1 for _ in range(count)])


@pytest.mark.parametrize(("radius", "allowed"), [(3.3, 0.02), (6.4, 0.007), (12.7, 0.002)])
def test_hertz_areas_are_second_order_anywhere_on_the_grid(radius, allowed):
    """Bounds of 20 contacts, fourfold from line to line; corrected for the perimeter: 8, 3, 1 %."""
    assert np.abs(_errors(radius, 20, located_area)).max() < allowed


def test_gaps_in_any_order_of_memory_are_read_by_the_same_code():
    """Interpolated surfaces have another: compiled for it, the loop would spoil a timed solve."""
    hertz = _hertz(6.4)
    turned = dataclasses.replace(hertz, initial_gap=np.asfortranarray(hertz.initial_gap))
    assert located_area(turned) == located_area(hertz)
    read = [argument for made in areas._shift.nopython_signatures for argument in made.args]
    assert {array.layout for array in read if hasattr(array, "layout")} == {"C"}


def test_rectangular_cells_are_located_along_both_sides():
    """Cells of 1 x 2: the scatter is that of the longer side, six cells to the radius."""
    assert np.abs(_errors(12.0, 10, located_area, spacing=(1.0, 2.0))).max() < 0.01


def test_a_ring_has_no_curvature_in_total():
    """Annular contact, three cells wide at r = 12 cells: 1 % to a grid three times finer."""

    def ring(factor: int) -> float:
        x = (np.arange(36 * factor) - 17.5 * factor - 0.2) / factor
        gap = (np.hypot(x[:, None], x) - 12) ** 2 / 50
        operator = FreeOperator(gap.shape, (1 / factor, 1 / factor), 1.0)
        contact = press(operator, gap - gap.min(), Load("force", 6.0))
        assert euler_characteristic(contact.mask, periodic=False) == 0
        return located_area(contact)

    assert ring(1) == pytest.approx(ring(3), rel=1e-2)


def test_the_rim_of_pressures_through_the_cells_is_that_of_hertz():
    """To 0.008 cells in the mean over the grid; the law of Love's cells is 0.016 too far out."""
    rng, errors = np.random.default_rng(4), []
    for radius in np.linspace(4, 9, 8):
        x, y = (np.arange(128) - 63.5 + rng.uniform(-0.5, 0.5) for _ in range(2))
        gap = (x[:, None] ** 2 + y**2) / 200
        operator = PeriodicOperator((128, 128), (1.0, 1.0), 1.0, kernel="continuum")
        load = Load("force", 4 / 3 * radius**3 / 100)
        area = located_area(press(operator, gap - gap.min(), load))
        errors.append((area / (np.pi * radius**2) - 1) * radius / 2)
    assert abs(np.mean(errors)) < 0.008


@pytest.mark.slow
@pytest.mark.parametrize("kernel", ["continuum", "cells"])
def test_rough_areas_need_no_grid_eight_times_finer(kernel):
    """Two points per shortest wave refined fourfold: 2 %; counted cells miss by 5 %."""
    native = surfaces.self_affine(
        32, 1.0, surfaces.SelfAffine(hurst=0.8, rms_slope=1.0), seed=3, realisation=1
    )

    def contact(factor: int):
        heights = surfaces.refine(native, factor)
        n = len(heights)
        operator = PeriodicOperator((n, n), (1 / n, 1 / n), 1.0, kernel=kernel)
        return press(operator, heights.max() - heights, Load("force", 0.05))

    fine, coarse = contact(16), contact(4)
    true = located_area(fine)
    assert located_area(coarse) == pytest.approx(true, rel=0.02)
    assert areas.raw_area(coarse.mask, coarse.operator.spacing) > 1.04 * true


def _rough_patch(factor: int, skipped: tuple[int, int]):
    """Press a free patch of 32 x 32 points, eight to the shortest wave, on finer cells."""
    waves = surfaces.SelfAffine(hurst=0.8, rms_slope=1.0, short_cutoff=8 / 32)
    native = surfaces.self_affine(32, 1.0, waves, seed=3, realisation=0)
    heights = surfaces.refine(native, factor)
    heights = heights[:: skipped[0], :: skipped[1]]
    spacing = tuple(1 / n for n in heights.shape)
    operator = FreeOperator(heights.shape, spacing, 1.0)
    return press(operator, heights.max() - heights, Load("force", 0.1))


@pytest.mark.parametrize("skipped", [(1, 1), (1, 2)])
def test_contact_on_the_rim_of_a_patch_ends_inside_it(skipped):
    """Fine cells and four times coarser ones, square and 1 : 2: 0.5 %; with the strip 2 % and more.

    The errors of the fine cells are a quarter of these and less.
    """
    coarse, fine = (_rough_patch(factor, skipped) for factor in (2, 8))
    strip = _rim_cells(coarse) * EDGE_OFFSET * coarse.operator.cell_area
    area, true = (located_area(contact, patch=True) for contact in (coarse, fine))
    assert area == pytest.approx(true, rel=5e-3)
    assert area + strip > 1.02 * true


def test_a_strip_across_a_patch_loses_half_as_much_at_the_rim():
    """A cylinder's area goes with the root of its load: half the strip is to be taken away.

    The law takes nearly all of it, as for random surfaces. Half of it is within 0.4 % of cells of a
    quarter, all and nothing of it are 0.8 % off.
    """

    def area(factor: int, part: float) -> float:
        sizes = 32 * factor, 16 * factor
        x = (np.arange(sizes[0]) + 0.5) / factor
        gap = np.repeat((x[:, None] - 15.7) ** 2 / 40, sizes[1], axis=1)
        operator = FreeOperator(sizes, (1 / factor, 1 / factor), 1.0)
        contact = press(operator, gap, Load("force", 80.0))
        area = located_area(contact, patch=True)
        return area + part * EDGE_OFFSET * _rim_cells(contact) / factor**2

    # what is left on cells of a half and a quarter falls with them, whatever part is taken away
    true = 2 * area(4, 0.0) - area(2, 0.0)
    assert area(1, 0.5) == pytest.approx(true, rel=4e-3)
    assert area(1, 0.0) < (1 - 8e-3) * true
    assert area(1, 1.0) > (1 + 8e-3) * true


def _rim_cells(contact) -> int:
    mask = contact.mask
    return sum(int(line.sum()) for line in (mask[0], mask[-1], mask[:, 0], mask[:, -1]))


def test_full_contact_is_the_whole_period_and_none_is_nothing():
    operator = PeriodicOperator((8, 8), (0.5, 0.5), 1.0)
    full = press(operator, np.zeros((8, 8)), Load("force", 1.0))
    assert located_area(full) == 16.0
    free = FreeOperator((4, 4), (1.0, 1.0), 1.0)
    assert located_area(press(free, np.ones((4, 4)), Load("penetration", 0.5))) == 0.0


def test_contact_that_ends_with_the_material_ends_between_cells():
    """A flat face of 6 x 6 cells, and a wall beside a free patch: nothing is to be located."""
    gap = np.full((10, 10), np.inf)
    gap[2:8, 2:8] = 0.0
    contact = press(
        FreeOperator((10, 10), (1.0, 1.0), 1.0), gap, Load("penetration", 1.0), by="pivot"
    )
    assert located_area(contact) == 36.0
    covered = press(
        FreeOperator((6, 6), (1.0, 1.0), 1.0), gap[2:8, 2:8], Load("penetration", 1.0), by="pivot"
    )
    assert located_area(covered) == 36.0


def test_patches_less_holes_are_counted_across_seams():
    mask = np.zeros((6, 6), dtype=bool)
    mask[[0, -1], 2] = True
    assert euler_characteristic(mask, periodic=True) == 1
    assert euler_characteristic(mask, periodic=False) == 2
    mask[:] = True
    mask[3, 3] = False
    # the whole torus has characteristic 0, and one hole
    assert euler_characteristic(mask, periodic=True) == -1
    assert euler_characteristic(mask, periodic=False) == 0


def test_an_edge_sharper_than_the_grid_is_counted():
    """Flat to r = 1, then of radius 10, barely pressed: counting errs by 0.6 % at 10 cells.

    The pressure rises towards the edge within the cells that are in contact: the law of a smooth
    line would be wrong by up to half a cell all round, 4 % of the area.
    """
    x = (np.arange(40) - 19.5) / 10
    gap = np.maximum(np.hypot(x[:, None], x) - 1, 0.0) ** 2 / 20
    operator = FreeOperator(gap.shape, (0.1, 0.1), 1.0)
    punch = press(operator, gap, Load("penetration", 1e-9))
    assert located_area(punch) == pytest.approx(np.pi, rel=0.01)


@pytest.mark.parametrize("penetration", [0.001, 0.0015])
def test_a_rounding_of_symmetric_pressures_moves_no_area(penetration):
    """A rounded punch, flat to 3.9 cells, whose rows at the rim have four cells.

    The two inner ones have the same pressure but for rounding, which is no rise towards an edge.
    """
    x = (np.arange(14) - 6.5) / 3.9
    gap = np.maximum(np.hypot(x[:, None], x) - 1, 0.0) ** 2 / 20
    contact = press(
        FreeOperator(gap.shape, (1 / 3.9, 1 / 3.9), 1.0),
        gap,
        Load("penetration", penetration),
        by="pivot",
    )
    even = (contact.pressure + contact.pressure[::-1]) / 2
    even = (even + even[:, ::-1]) / 2
    rounded = even * (1 + 1e-12 * np.random.default_rng(3).uniform(-1, 1, gap.shape))
    exact, moved = (
        located_area(dataclasses.replace(contact, pressure=pressure))
        for pressure in (even, rounded)
    )
    assert moved == pytest.approx(exact, rel=1e-9)


MASKS = st.integers(0, 2**32).map(lambda seed: np.random.default_rng(seed).random((7, 9)) < 0.5)


def test_perimeter_correction_formula_on_single_cells_and_blocks():
    """S counts cell edges: 4 for a cell, 2 (a + b) for an a x b block, 0 inside."""
    factor = (np.pi - 1 + np.log(2)) / 24
    block = np.zeros((8, 8), dtype=bool)
    block[2:4, 3:6] = True
    expected = 6 * 0.25 - factor * 10 * 0.25
    assert areas.corrected_area(block, (0.5, 0.5)) == pytest.approx(expected, rel=1e-14)


@settings(max_examples=30, deadline=None)
@given(mask=MASKS, shift=st.tuples(st.integers(0, 6), st.integers(0, 8)))
def test_periodic_areas_and_patches_do_not_depend_on_the_origin(mask, shift):
    moved = np.roll(mask, shift, axis=(0, 1))
    before, after = (areas.patches(m, (1.0, 2.0), periodic=True) for m in (mask, moved))
    assert before.count == after.count
    assert sorted(before.areas) == sorted(after.areas)
    # the same cells are together, whatever their labels: each is as large as its patch says
    for spots in (before, after):
        cells = np.bincount(spots.labels.ravel(), minlength=spots.count + 1)
        np.testing.assert_array_equal(2.0 * cells[1:], spots.areas)
    pairs = np.stack([np.roll(before.labels, shift, axis=(0, 1)), after.labels])
    assert len(np.unique(pairs.reshape(2, -1), axis=1).T) == before.count + (not mask.all())
    assert areas.corrected_area(mask, (1.0, 1.0), True) == pytest.approx(
        areas.corrected_area(moved, (1.0, 1.0), True)
    )


def test_patches_meet_across_edges_not_corners_and_across_seams_when_periodic():
    mask = np.array([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0]], dtype=bool)
    free = areas.patches(mask)
    assert free.count == 4
    assert free.areas.tolist() == [1.0, 1.0, 1.0, 1.0]
    periodic = areas.patches(mask, (0.5, 0.5), periodic=True)
    assert periodic.count == 2
    assert sorted(periodic.areas) == [0.25, 0.75]
    corners, inside = periodic.labels[0, 0], periodic.labels[1, 1]
    expected = [[corners, 0, 0, corners], [0, inside, 0, 0], [0, 0, 0, 0], [corners, 0, 0, 0]]
    assert periodic.labels.tolist() == expected
    assert periodic.areas[[corners - 1, inside - 1]].tolist() == [0.75, 0.25]
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
