"""Synthesis of rough surfaces: what is prescribed is what comes out, mode by mode."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference import surfaces


def synthesis(points, size, seed=0, realisation=0, **recipe):
    spectrum = surfaces.SelfAffine(**recipe)
    return surfaces.self_affine(points, size, spectrum, seed=seed, realisation=realisation)


def modes(height, size):
    """Amplitudes and wavenumbers of a map by plain numpy."""
    nx, ny = height.shape
    amplitude = np.abs(np.fft.fft2(height)) / height.size
    qx = 2 * np.pi * np.fft.fftfreq(nx, size[0] / nx)
    qy = 2 * np.pi * np.fft.fftfreq(ny, size[1] / ny)
    return amplitude, np.hypot(qx[:, None], qy[None, :])


@settings(max_examples=25, deadline=None)
@given(
    points=st.tuples(st.integers(5, 40), st.integers(5, 40)),
    hurst=st.floats(0, 1),
    seed=st.integers(0, 1000),
    short=st.sampled_from([None, 0.3]),
)
def test_every_realisation_has_exactly_the_prescribed_slope(points, hurst, seed, short):
    """h'^2 = sum |q|^2 |B|^2 = <|grad h|^2>: amplitudes are fixed, only phases are random."""
    size = (1.0, 1.4)
    height = synthesis(
        points, size, hurst=hurst, rms_slope=0.2, short_cutoff=short, seed=seed, realisation=1
    )
    amplitude, wavenumber = modes(height, size)
    assert np.sqrt(((wavenumber * amplitude) ** 2).sum()) == pytest.approx(0.2, rel=1e-12)
    assert abs(height.mean()) < 1e-14
    spacing = (size[0] / points[0], size[1] / points[1])
    assert surfaces.rms_gradient_spectral(height, spacing) == pytest.approx(0.2, rel=1e-12)


@pytest.mark.parametrize("points", [(32, 32), (33, 32), (32, 27)])
def test_spectrum_follows_the_power_law_between_circular_cutoffs(points):
    """C2D ~ B^2 ~ q^(-2(1+H)) up to the cutoff circle, constant above the roll-off wavelength."""
    size = (1.0, 1.0)
    height = synthesis(
        points, size, hurst=0.7, rms_slope=0.1, long_cutoff=0.25, short_cutoff=0.1, seed=5
    )
    amplitude, q = modes(height, size)
    inside = (q > 0) & (q <= 2 * np.pi / 0.1)
    np.testing.assert_allclose(amplitude[~inside], 0, atol=1e-16)
    law = np.maximum(q[inside], 2 * np.pi / 0.25) ** -1.7
    np.testing.assert_allclose(amplitude[inside] / law, (amplitude[inside] / law)[0], rtol=1e-9)


def test_self_conjugate_modes_are_zero_even_when_the_cutoff_lets_them_in():
    """At Nyquist a mode that is its own conjugate cannot have a random phase."""
    B = surfaces.amplitude_spectrum(
        8, 1.0, surfaces.SelfAffine(hurst=0.5, rms_slope=1.0, short_cutoff=0.1)
    )
    assert [B[0, 0], B[4, 0], B[0, 4], B[4, 4]] == [0, 0, 0, 0]
    assert B[4, 1] > 0
    # the Nyquist rows and columns that remain must still give a real surface of the right slope
    height = synthesis(8, 1.0, hurst=0.5, rms_slope=1.0, short_cutoff=0.1, seed=1)
    assert surfaces.rms_gradient_spectral(height, (1 / 8, 1 / 8)) == pytest.approx(1.0, rel=1e-12)


def test_phases_are_uniform_and_independent_between_realisations():
    """Heights of many modes are nearly Gaussian: kurtosis 3, no correlation between surfaces.

    64 surfaces with 32^2 points and a white spectrum; standard errors 0.02 and 0.004.
    """
    stack = np.array(
        [
            synthesis(
                32, 1.0, hurst=0.0, rms_height=1.0, long_cutoff=0.0625, seed=9, realisation=k
            ).ravel()
            for k in range(64)
        ]
    )
    assert np.mean(stack**4) == pytest.approx(3.0, abs=0.1)
    correlation = stack @ stack.T / stack.shape[1]
    np.testing.assert_allclose(correlation - np.eye(64), 0, atol=0.25)
    assert abs((correlation - np.eye(64)).mean()) < 0.02


def test_streams_are_those_of_the_scene_format():
    """Surface k draws from SeedSequence(seed, spawn_key=(0, k)); another seed, another surface."""
    spectrum = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1)
    first = surfaces.self_affine(16, 1.0, spectrum, seed=4, realisation=2)
    again = surfaces.self_affine(16, 1.0, spectrum, seed=4, realisation=2)
    other = surfaces.self_affine(16, 1.0, spectrum, seed=2, realisation=4)
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.1 * first.std()
    stream = np.random.default_rng(np.random.SeedSequence(4, spawn_key=(0, 2)))
    phases = stream.uniform(0, 2 * np.pi, (16, 16))
    spectrum = np.fft.fft2(first)
    assert np.exp(1j * np.angle(spectrum[3, 2])) == pytest.approx(np.exp(1j * phases[3, 2]))


@pytest.mark.parametrize("points", [(12, 12), (9, 16), (1, 8)])
@pytest.mark.parametrize("factor", [1, 2, 3])
def test_refinement_keeps_the_points_and_the_slope(points, factor):
    """Interpolation of a band-limited map: original points and rms gradient are unchanged."""
    rng = np.random.default_rng(6)
    height = rng.standard_normal(points)
    # without Nyquist modes, whose gradient the two grids see differently
    spectrum = np.fft.fft2(height)
    for axis, n in enumerate(points):
        if n % 2 == 0:
            np.moveaxis(spectrum, axis, 0)[n // 2] = 0
    height = np.fft.ifft2(spectrum).real
    fine = surfaces.refine(height, factor)
    assert fine.shape == (points[0] * factor, points[1] * factor)
    np.testing.assert_allclose(fine[::factor, ::factor], height, atol=1e-14 * np.abs(height).max())
    slopes = [
        surfaces.rms_gradient_spectral(h, (1.0 / h.shape[0], 2.0 / h.shape[1]))
        for h in (height, fine)
    ]
    assert slopes[1] == pytest.approx(slopes[0], rel=1e-12)


@pytest.mark.parametrize("factor", [2, 3, 4])
def test_a_subdivided_map_is_the_function_at_the_middles_of_finer_cells(factor):
    """To round-off, for waves below Nyquist; the coarse cells are those about the points."""
    n, m = 12, 8
    places = [(np.arange(factor * k) + 0.5) / (factor * k) - 0.5 / k for k in (n, m)]

    def function(x, y):
        return np.cos(2 * np.pi * (5 * x[:, None] - 3 * y) + 0.4) + np.sin(2 * np.pi * x)[:, None]

    fine = surfaces.subdivide(function(np.arange(n) / n, np.arange(m) / m), factor)
    np.testing.assert_allclose(fine, function(*places), atol=1e-13)


def test_difference_gradient_converges_to_the_spectral_one():
    """Forward differences of a smooth map lose (q dx)^2/24 of the slope: second order."""
    coarse = synthesis(16, 1.0, hurst=0.8, rms_slope=0.1, short_cutoff=0.25, seed=2)
    errors = []
    for factor in (4, 8, 16):
        fine = surfaces.refine(coarse, factor)
        closed = np.pad(fine, ((0, 1), (0, 1)), mode="wrap")
        squares = [
            np.mean((np.diff(closed, axis=0)[:, :-1] * fine.shape[0]) ** 2),
            np.mean((np.diff(closed, axis=1)[:-1, :] * fine.shape[1]) ** 2),
        ]
        errors.append(1 - np.sqrt(sum(squares)) / 0.1)
        spacing = (1 / fine.shape[0], 1 / fine.shape[1])
        # the map as measured lacks the step across its rims
        assert surfaces.rms_gradient_differences(fine, spacing) == pytest.approx(0.1, rel=0.1)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.05)
