"""Spectra: what the two-to-one-dimensional rule keeps, and what synthesis keeps."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from reduced.rough.line_spectrum import (
    LineSpectrum,
    line_of,
    prescribed,
    resample,
    sum_rules,
    synthesise,
)
from reduced.rough.surface_spectrum import SelfAffineLaw, measured

KEPT = 1e-12


@settings(max_examples=40)
@given(
    nx=st.integers(2, 40),
    ny=st.integers(2, 40),
    aspect=st.floats(0.2, 5.0),
    periodic=st.booleans(),
    seed=st.integers(0, 99),
)
def test_ring_sums_keep_the_mean_square_height(nx, ny, aspect, periodic, seed):
    """Any map, any pixels: Parseval, since every mode but the mean is in exactly one ring."""
    height = 5.0 + np.random.default_rng(seed).normal(size=(nx, ny))
    spectrum = line_of(measured(height, (1.0, aspect), periodic))
    assert 2 * spectrum.power.sum() == pytest.approx(np.var(height), rel=KEPT)
    assert spectrum.length == max(1.0, aspect)
    np.testing.assert_allclose(np.diff(spectrum.wavenumber), 2 * np.pi / spectrum.length)


def synthetic_map(points, size, seed, exponent=3.6, long=None):
    """Random-phase map built here with full complex FFT, as an independent sample of (19.22)."""
    rng = np.random.default_rng(seed)
    k = np.fft.fftfreq(points, size / points)
    q = 2 * np.pi * np.hypot(k[:, None], k)
    kept = (q > 0) & (q <= np.pi * points / size * (1 + 1e-10))
    kept[points // 2, :] = kept[:, points // 2] = False
    low = 2 * np.pi / long if long else 0.0
    amplitude = np.where(kept, np.maximum(np.where(kept, q, 1.0), low) ** (-exponent / 2), 0.0)
    amplitude *= 0.1 / np.sqrt(np.sum(q**2 * amplitude**2))
    noise = np.fft.fft2(rng.normal(size=(points, points)))
    return np.fft.ifft2(amplitude * np.exp(1j * np.angle(noise)), norm="forward").real


@pytest.mark.parametrize("long", [None, 0.25])
def test_parameters_and_map_give_the_same_spectrum(long):
    """`prescribed` without synthesis against ring sums of a synthesised map, mode by mode."""
    h = synthetic_map(64, 2.0, 1, long=long)
    from_map = line_of(measured(h, 2.0, periodic=True))
    alone = prescribed(64, 2.0, SelfAffineLaw(hurst=0.8, rms_slope=0.1, long_cutoff=long))
    size = max(from_map.power.size, alone.power.size)
    padded = [np.pad(s.power, (0, size - s.power.size)) for s in (from_map, alone)]
    np.testing.assert_allclose(*padded, rtol=1e-10, atol=1e-14 * padded[0].max())
    same = prescribed(
        64, 2.0, SelfAffineLaw(power=3.6, rms_height=float(np.std(h)), long_cutoff=long)
    )
    np.testing.assert_allclose(same.power, alone.power, rtol=1e-10)


@settings(max_examples=40)
@example(nx=2, ny=2, aspect=1.0, seed=37)
@given(
    nx=st.integers(2, 40), ny=st.integers(2, 40), aspect=st.floats(0.2, 5.0), seed=st.integers(0)
)
def test_split_rings_keep_height_and_gradient(nx, ny, aspect, seed):
    """Any map, any pixels: <h^2> and <|grad h|^2> to rounding; the curvature from above.

    Of a mode between rings a and b its square is at most (a^2 + b^2)^2/(4 a^2 b^2) too large: 25/16
    between the first two, 5/4 of the root.
    """
    height = np.random.default_rng(seed % 99).normal(size=(nx, ny))
    surface = measured(height, (1.0, aspect), periodic=True)
    ratio = sum_rules(surface, line_of(surface, "split")).ratio
    np.testing.assert_allclose(ratio[:2], 1.0, rtol=KEPT)
    assert 1 - KEPT <= ratio[2] <= 1.25 + KEPT


def test_sum_rules_of_the_surface_are_those_of_its_heights():
    """Moments in the spectrum against derivatives of one wave in closed form, pixels not square."""
    x, y = np.arange(32) / 32, 3 * np.arange(20) / 20
    h = 0.7 * np.cos(2 * np.pi * (2 * x[:, None] + y / 3))
    q2 = (4 * np.pi) ** 2 + (2 * np.pi / 3) ** 2
    surface = measured(h, (1.0, 3.0), periodic=True)
    expected = 0.7 / np.sqrt(2) * np.array([1, np.sqrt(q2), q2])
    result = sum_rules(surface, line_of(surface)).surface
    np.testing.assert_allclose(result, expected, rtol=KEPT)


def midway(shape):
    """Twice the place of the modes midway between rings at sides 2 : 3, in whole numbers; else 0.

    (|q| L/2 pi)^2 = (3/2 i)^2 + j^2 = (k + 1/2)^2: nine i^2 and four j^2 add up to an odd square.
    """
    i, j = (np.rint(np.fft.fftfreq(n, 1 / n)).astype(int) for n in shape)
    square = 9 * i[:, None] ** 2 + 4 * j**2
    root = np.rint(np.sqrt(square)).astype(int)
    return np.where((root**2 == square) & (root % 2 == 1), root, 0)


# Sides off by the last digit of double and of single precision. A mode's place times the steepest
# sharing of "split" is some hundred times as far off.
@pytest.mark.parametrize(("off", "rtol"), [(1e-15, 1e-11), (6e-8, 1e-4)])
@pytest.mark.parametrize("rule", ["rings", "split", "printed"])
def test_no_ring_hangs_on_the_last_digit_of_a_side(rule, off, rtol):
    """At 3 : 2 modes lie midway between rings."""
    height = np.random.default_rng(3).normal(size=(16, 24))
    spectra = [
        line_of(measured(height, (1.0 * x, 1.5 * y), periodic=True), rule).power
        for x in (1 - off / 2, 1.0, 1 + off / 2)
        for y in (1 - off / 2, 1.0, 1 + off / 2)
    ]
    for power in spectra[1:]:
        np.testing.assert_allclose(power, spectra[0], rtol=rtol)


def test_a_mode_midway_between_two_rings_counts_half_in_each():
    """By whole numbers, and the sum rule: <h^2> is kept to rounding."""
    shape, size = (16, 24), (2e-6, 3e-6)
    height = np.random.default_rng(4).normal(size=shape)
    surface = measured(height, size, periodic=True)
    twice = midway(shape)
    assert np.count_nonzero(twice) > 10  # (1, 0) at 3/2, (1, 2) at 5/2, (3, 0) at 9/2, ...
    place = surface.magnitude * size[1] / (2 * np.pi)
    expected = []
    for ring in range(1, 20):
        whole = (twice == 0) & (np.abs(place - ring) < 0.5)
        half = np.abs(twice - 2 * ring) == 1
        expected.append(surface.power[whole].sum() / 2 + surface.power[half].sum() / 4)
    line = line_of(surface)
    np.testing.assert_allclose(line.power, expected[: line.power.size], rtol=1e-12)
    assert line.rms_height == pytest.approx(np.std(height), rel=KEPT)
    assert surface.radial_average().count.sum() == height.size - 1


def test_radial_average_counts_modes():
    """Rings of an 8 x 8 map by hand: count and mean of (L/2 pi)^2 |B2D|^2."""
    height = np.random.default_rng(2).normal(size=(8, 8))
    average = measured(height, 3.0, periodic=True).radial_average()
    k = np.fft.fftfreq(8, 1 / 8)
    density = (3.0 / (2 * np.pi)) ** 2 * np.abs(np.fft.fft2(height, norm="forward")) ** 2
    for number in range(1, 7):
        inside = density[np.abs(np.hypot(k[:, None], k) - number) < 0.5]
        assert average.count[number - 1] == inside.size
        assert average.density[number - 1] == pytest.approx(inside.mean(), rel=1e-12)
    assert average.count.sum() == 63
    np.testing.assert_allclose(average.wavenumber, 2 * np.pi / 3.0 * np.arange(1, 7))


def test_printed_steps_average_over_rings():
    """Problem 1, steps 3 and 4: B1D^2 = pi k times the mean of |B2D|^2 on the ring."""
    h = synthetic_map(32, 1.5, 3)
    k = np.fft.fftfreq(32, 1 / 32)
    ring = np.rint(np.hypot(k[:, None], k))
    square = np.abs(np.fft.fft2(h, norm="forward")) ** 2
    expected = [np.pi * j * square[ring == j].mean() for j in range(1, 16)]
    power = line_of(measured(h, 1.5, periodic=True), "printed").power
    np.testing.assert_allclose(power, expected, rtol=1e-9)
    # and <h^2> is not kept
    assert abs(np.sqrt(2 * power.sum()) / np.std(h) - 1) > 0.02


def test_printed_rule_samples_the_density():
    """B1D^2 = (2 pi/L) pi q C2D with C2D = (L/2 pi)^2 |B2D|^2 at the mode (k, 0): pi k |B2D|^2."""
    h = synthetic_map(32, 1.5, 4)
    square = np.abs(np.fft.fft2(h, norm="forward")) ** 2
    spectrum = prescribed(
        32, 1.5, SelfAffineLaw(power=3.6, rms_height=float(np.std(h))), rule="printed"
    )
    k = np.arange(1, 16)
    np.testing.assert_allclose(spectrum.power, np.pi * k * square[k, 0], rtol=1e-9)


def test_hann_window_removes_the_jump_of_a_measured_map():
    """A ramp: without the window the jump at the seam fills high rings as q^-2, with it q^-6."""
    ramp = np.linspace(0, 1, 64)[:, None] * np.ones(64)
    share = {}
    for periodic in (True, False):
        power = line_of(measured(ramp, 1.0, periodic)).power
        share[periodic] = power[15:].sum() / power.sum()
    assert share[True] > 1e-2
    assert share[False] < 1e-5


@settings(max_examples=40)
@given(
    count=st.integers(1, 40),
    extra=st.integers(1, 50),
    seed=st.integers(0, 99),
    length=st.floats(0.1, 10),
)
def test_synthesis_keeps_mean_square_height_and_slope(count, extra, seed, length):
    """Fixed amplitudes: <h^2> of every line is 2 sum B^2, its spectral slope 2 sum q^2 B^2."""
    rng = np.random.default_rng(seed)
    q = 2 * np.pi / length * np.arange(1, count + 1)
    spectrum = LineSpectrum(q, rng.uniform(0.1, 1, count), length)
    line = synthesise(spectrum, 2 * count + extra, rng)
    assert line.size == 2 * count + extra
    assert np.mean(line**2) == pytest.approx(spectrum.rms_height**2, rel=KEPT)
    modes = np.fft.rfft(line, norm="forward")
    np.testing.assert_allclose(np.abs(modes[1 : count + 1]) ** 2, spectrum.power, rtol=1e-10)
    slope = np.sqrt(2 * np.sum(q**2 * np.abs(modes[1 : count + 1]) ** 2))
    assert slope == pytest.approx(spectrum.rms_slope, rel=1e-10)
    assert abs(modes[0]) < 1e-14 * spectrum.rms_height


def test_more_points_resolve_the_same_line():
    """Equal generators: the finer line passes through the coarser one's points."""
    spectrum = prescribed(64, 1.0, SelfAffineLaw(hurst=0.8, rms_slope=0.1))
    coarse = synthesise(spectrum, 128, np.random.default_rng(7))
    fine = synthesise(spectrum, 512, np.random.default_rng(7))
    np.testing.assert_allclose(fine[::4], coarse, atol=1e-14 * np.ptp(coarse) * 100)


def test_phases_are_random_and_heights_gaussian_like():
    """Mean and correlation over 400 lines vanish within five standard errors of the ensemble."""
    spectrum = prescribed(64, 1.0, SelfAffineLaw(hurst=0.8, rms_height=1.0))
    rng = np.random.default_rng(8)
    lines = np.array([synthesise(spectrum, 128, rng) for _ in range(400)])
    assert np.all(np.abs(lines.mean(axis=0)) < 5 / np.sqrt(400))
    covariance = np.mean(lines[:, 0] * lines[:, 40])
    expected = 2 * np.sum(spectrum.power * np.cos(spectrum.wavenumber * 40 / 128))
    assert abs(covariance - expected) < 5 / np.sqrt(400)


@pytest.mark.parametrize("ratio", [2.0, 2.5, 7.3])
def test_longer_lines_keep_density_height_and_slope(ratio):
    """Power integrates over bands: <h^2> is exact, the slope up to the width of a band over q.

    Least above a roll-off (1 % without, as much of the slope then sits in the lowest modes).
    """
    spectrum = prescribed(128, 1.0, SelfAffineLaw(hurst=0.5, rms_slope=0.1, long_cutoff=0.25))
    longer = resample(spectrum, ratio)
    assert longer.rms_height == pytest.approx(spectrum.rms_height, rel=KEPT)
    assert longer.rms_slope == pytest.approx(spectrum.rms_slope, rel=2e-3)
    middle = np.interp(100.0, spectrum.wavenumber, spectrum.density)
    # Constant inside bands of the old spectrum, which falls as q^-2 there: 6 % per band.
    assert np.interp(100.0, longer.wavenumber, longer.density) == pytest.approx(middle, rel=0.06)
    line = synthesise(spectrum, 4096, np.random.default_rng(1), length=ratio)
    assert np.std(line) == pytest.approx(spectrum.rms_height, rel=KEPT)


def test_default_points_resolve_the_highest_mode():
    spectrum = prescribed(
        (32, 64), (1.0, 1.0), SelfAffineLaw(hurst=0.8, rms_slope=0.1, short_cutoff=0.02)
    )
    line = synthesise(spectrum, rng=np.random.default_rng(0))
    assert line.size % 2 == 0
    assert np.std(line) == pytest.approx(spectrum.rms_height, rel=KEPT)
    with pytest.raises(ValueError, match="points"):
        synthesise(spectrum, 2 * np.count_nonzero(spectrum.power), np.random.default_rng(0))
