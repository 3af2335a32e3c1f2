"""Peaks of random surfaces and lines: theory against theory, and against synthesised surfaces."""

import math

import numpy as np
import pytest

from reference import surfaces
from reference.closed_form import rough_theories
from reference.closed_form.rough_theories import line_peaks, surface_peaks
from reference.surfaces import hessian, summits


def test_summits_have_the_density_and_mean_curvature_of_nayak():
    """Density m4/(6 sqrt 3 pi m2) (Nayak 1971) against the number found on surfaces.

    The synthesised surfaces are band-limited Gaussian ones with known m2, m4 (many modes); 20 of
    them hold some 10^4 summits, so 4 % is about three standard errors with the grid's share.
    """
    points, result, curvatures = 128, 0, []
    for k in range(20):
        h = surfaces.self_affine(
            points,
            1.0,
            surfaces.SelfAffine(power=2.0, rms_slope=1.0, short_cutoff=1 / 16),
            seed=3,
            realisation=k,
        )
        fine = surfaces.refine(h, 2)
        part = summits(fine, (0.5 / points,) * 2).curvatures
        result += len(part)
        curvatures.append(part)
    amplitude = surfaces.amplitude_spectrum(
        points, 1.0, surfaces.SelfAffine(power=2.0, rms_slope=1.0, short_cutoff=1 / 16)
    )
    q = 2 * np.pi * np.hypot(*np.meshgrid(*[np.fft.fftfreq(points, 1 / points)] * 2))
    fourth = 3 / 8 * ((q**2 * amplitude) ** 2).sum()
    theory = surface_peaks(0.5, float(fourth))
    both = np.concatenate(curvatures)
    assert result / 20 == pytest.approx(theory.density, rel=0.04)
    assert both.mean() == pytest.approx(theory.mean_curvature, rel=0.02)
    assert both.prod(axis=1).mean() == pytest.approx(theory.gaussian_curvature, rel=0.04)
    radius = (1 / np.sqrt(both.prod(axis=1))).mean()
    # the mean of 1/sqrt has a heavy tail of flat summits
    assert radius == pytest.approx(theory.mean_radius, rel=0.05)


def test_the_line_of_the_rule_is_not_half_as_curved():
    """m4 of the line is <(lap h)^2> = (8/3) m4: its peak radii are 0.85 of the surface's, not 0.5.

    Line: sqrt(pi/2)/sqrt(8/3) by Kac-Rice; surface: 0.90055, here by random sampling of the
    hessian at summits (10^6 normal triples, weight |det|), an oracle without quadrature.
    """
    rng = np.random.default_rng(5)
    total = rng.normal(0, math.sqrt(8 / 3), 1_000_000)
    a, b = rng.normal(0, math.sqrt(4 / 3), (2, 1_000_000))
    gauss = (total**2 - a**2 - b**2) / 4
    convex = (total > 0) & (gauss > 0)
    weight = gauss[convex]
    radius = (weight / np.sqrt(gauss[convex])).sum() / weight.sum()
    assert surface_peaks(0.5, 1.0).mean_radius == pytest.approx(radius, rel=0.005)
    ratio = line_peaks(1.0, 8 / 3).mean_radius / surface_peaks(0.5, 1.0).mean_radius
    assert ratio == pytest.approx(0.852, abs=0.001)


def test_the_hessian_of_a_rotated_paraboloid_like_wave():
    """cos(2 x + y): second derivatives -4, -1, -2 times it, to round-off."""
    x = 2 * np.pi * np.arange(32) / 32
    h = np.cos(2 * x[:, None] + x)
    for result, factor in zip(hessian(h, (x[1], x[1])), (-4, -1, -2), strict=True):
        np.testing.assert_allclose(result, factor * h, atol=1e-12)


def test_curvatures_of_summits_converge_with_the_square_of_the_spacing():
    """A summit between grid points: curvature error O(dx^2), so at least order 1.8 observed."""
    errors = []
    for n in (16, 32, 64):
        x = 2 * np.pi * (np.arange(n) + 0.3) / n
        h = np.cos(x)[:, None] + 0.5 * np.cos(x)
        (only,) = summits(h, (2 * np.pi / n,) * 2).curvatures
        errors.append(abs(only - [1.0, 0.5]).max())
    assert np.log2(errors[0] / errors[2]) / 2 > 1.8


def test_bush_gibson_and_thomas_are_linear_and_refuse_negative_loads():
    """Kappa is sqrt(2 pi) = 2.51."""
    assert rough_theories.bush_gibson_thomas_area(1e-6) / 1e-6 == pytest.approx(2.5066, abs=1e-4)
    with pytest.raises(ValueError, match="relative_load"):
        rough_theories.bush_gibson_thomas_area(-1.0)
