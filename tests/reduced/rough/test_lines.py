"""Many rough lines: their statistics, and the regions of their contacts."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reduced.loads import Load
from reduced.rough import ensemble
from reduced.rough.ensemble import RandomLines, press_ensemble
from reduced.rough.line_spectrum import LineSpectrum, prescribed
from reduced.rough.press import RoughLines, press
from reduced.rough.regions import line_stress, regions
from reduced.rough.surface_spectrum import SelfAffineLaw

SPECTRUM = prescribed(64, 1.0, SelfAffineLaw(hurst=0.8, rms_slope=0.1))
FORCE = [1e-4, 1e-3, 1e-2]


def run(count=12, seed=0, **options):
    lines = RandomLines(SPECTRUM, 256, count, seed)
    return press_ensemble(lines, 2.0, Load("force", FORCE), **options)


def test_statistics_are_those_of_the_lines_pressed_one_by_one():
    """Streams spawn_key = (1, k), as the scene format promises; s/sqrt(m) by hand."""
    outcome = run(seed=3)
    areas = []
    for k in range(12):
        line = RandomLines(SPECTRUM, 256, 12, seed=3).draw([k])
        assert line.spacing == 1 / 256
        areas.append(press(line, 2.0, Load("force", FORCE)).contact_area[0])
    area = np.array(areas)
    np.testing.assert_array_equal(outcome.samples["contact_area"], area)
    mean = area.sum(axis=0) / 12
    error = np.sqrt(((area - mean) ** 2).sum(axis=0) / 11 / 12)
    np.testing.assert_allclose(outcome["contact_area"].mean, mean, rtol=1e-13)
    np.testing.assert_allclose(outcome["contact_area"].standard_error, error, rtol=1e-12)


def test_blocks_change_no_bit(monkeypatch):
    whole = run()
    monkeypatch.setattr(ensemble, "_MEMORY", 8 * 256 * 5)
    np.testing.assert_array_equal(run().samples["contact_area"], whole.samples["contact_area"])


def test_a_larger_ensemble_begins_with_the_smaller_and_seeds_differ():
    small, large = run(4), run(9)
    np.testing.assert_array_equal(large.samples["force"][:4], small.samples["force"])
    np.testing.assert_array_equal(large.samples["contact_area"][:4], small.samples["contact_area"])
    assert not np.any(run(4, seed=1).samples["contact_area"] == small.samples["contact_area"])


def test_memory_does_not_grow_with_the_number_of_lines(monkeypatch):
    """Eight times the lines, the same peak but for the curves kept (24 bytes a line)."""
    monkeypatch.setattr(ensemble, "_MEMORY", 2**18)
    peaks = []
    for count in (100, 800):
        tracemalloc.start()
        run(count, quantities=["contact_area"])
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # All lines at once would take 1.4 MB more.
    assert peaks[1] - peaks[0] < 2**18


@pytest.mark.parametrize("hurst", [0.3, 0.6, 1.0])
def test_stiffness_of_long_lines_grows_as_the_load_to_one_over_one_plus_hurst(hurst):
    """Pohrt & Popov (PRL 2012): k ~ F^(1/(1+H)), 2^15 points, between 30 dx and 3 % in contact.

    Within five standard errors of 60 lines, or 3 %: the power law ends at the spacing, which lowers
    the exponent (docs/reduced-model.md).
    """
    points, mode = 2**15, np.arange(1, 2**14)
    line = LineSpectrum(2 * np.pi * mode, mode ** (-1 - 2 * hurst), 1.0)
    scale = np.sqrt(2 * line.power.sum())
    lines = RandomLines(line, points, 60, seed=4)
    load = Load("force", scale * np.geomspace(1e-9, 1e-1, 100))
    result = press_ensemble(lines, 1.0, load).samples
    slopes = []
    for length, force in zip(result["contact_length"], result["force"], strict=True):
        inner = (length > 30 / points) & (length < 0.03)
        slopes.append(np.polyfit(np.log(force[inner]), np.log(length[inner]), 1)[0])
    error = np.std(slopes, ddof=1) / np.sqrt(60)
    expected = 1 / (1 + hurst)
    assert error < 0.02
    assert abs(np.mean(slopes) - expected) < max(5 * error, 0.03 * expected)


EDGES = ["sub_cell", "nodal"]
LINES = st.lists(st.integers(-40, 40), min_size=2, max_size=60).filter(lambda v: len(set(v)) > 1)


@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("periodic", [True, False])
@settings(max_examples=30, deadline=None)
@given(values=LINES, level=st.integers(0, 90))
def test_regions_add_up_to_what_press_counts(edges, periodic, values, level):
    """Number, sum and sum of squares, from two implementations that share no code.

    Levels lie halfway between possible heights, where touching decides nothing.
    """
    line = np.array(values, dtype=float)
    lines = RoughLines(line, 0.25, periodic)
    contacts = regions(lines, level + 0.5, edges=edges)
    c = press(lines, 1.0, Load("penetration", level + 0.5), edges=edges)
    assert contacts.lengths.size == c.contact_count[0, 0]
    assert contacts.lengths.sum() == pytest.approx(c.contact_length[0, 0], rel=1e-12)
    assert np.pi / 4 * np.sum(contacts.lengths**2) == pytest.approx(c.contact_area[0, 0], rel=1e-12)
    assert np.all(contacts.deflection > 0)
    assert np.unique(contacts.region).size == contacts.lengths.size


@pytest.mark.parametrize("rule", ["own_curvature", "one_radius"])
def test_the_rule_on_a_sampled_parabola_is_hertz(rule):
    """Pressure (2 E* a/(pi R)) sqrt(1 - x^2/a^2) on g = x^2/R, off the grid at the edges.

    Second differences of a parabola are exact but for rounding, which loses h/(dx^2 h'') = 1e4.
    One radius takes length and depth of the sampled contact: of second order in dx, 1e-4 here.
    """
    spacing, modulus, radius, a = 0.01, 3.0, 2.0, 0.5037
    x = spacing * np.arange(-100, 101)
    line = RoughLines(-(x**2) / radius, spacing, periodic=False)
    stress = line_stress(line, modulus, a**2 / radius, rule=rule)
    at = x[stress.regions.points]
    hertz = 2 * modulus * a / (np.pi * radius) * np.sqrt(1 - (at / a) ** 2)
    assert stress.undefined_share == 0
    tolerance = 1e-10 if rule == "own_curvature" else 1e-4
    np.testing.assert_allclose(stress.pressure, hertz, rtol=tolerance)


def test_hollow_and_straight_points_have_no_value():
    """A tent is straight but for its tip; a crown of two tips is hollow between them."""
    tent = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 0.0])
    stress = line_stress(RoughLines(tent, 1.0), 1.0, 2.5)
    assert stress.regions.points.tolist() == [1, 2, 3, 4, 5]
    assert stress.valid.tolist() == [False, False, True, False, False]
    assert stress.undefined_share == pytest.approx(0.8)
    assert line_stress(RoughLines(tent, 1.0), 1.0, 2.5, rule="one_radius").undefined_share == 0
    crown = np.array([0.0, 3.0, 2.0, 3.0, 0.0, 0.0])
    assert line_stress(RoughLines(crown, 1.0), 1.0, 1.5).valid.tolist() == [True, False, True]


def test_no_contact_has_no_undefined_points():
    stress = line_stress(RoughLines(np.array([0.0, 1.0, 0.0]), 1.0), 1.0, -0.5)
    assert (stress.pressure.size, stress.undefined_share, stress.regions.lengths.size) == (
        0,
        0.0,
        0,
    )


@given(st.integers(-60, 60), st.integers(-60, 60))
@settings(max_examples=15, deadline=None)
def test_units_by_powers_of_two_are_bit_identical(height, stiff):
    line = np.random.default_rng(1).normal(size=64)
    unit, modulus = 2.0**height, 2.0**stiff
    for rule in ("own_curvature", "one_radius"):
        one = line_stress(RoughLines(line, 1.0), 1.0, 1.5, rule=rule)
        two = line_stress(RoughLines(line * unit, unit), modulus, 1.5 * unit, rule=rule)
        np.testing.assert_array_equal(two.pressure, one.pressure * modulus)
        np.testing.assert_array_equal(two.regions.lengths, one.regions.lengths * unit)
