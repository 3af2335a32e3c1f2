"""Theories of rough contact and of random peaks: limits, published numbers, each other."""

import math

import numpy as np
import pytest

from reference import surfaces
from reference.closed_form import rough_theories
from reference.closed_form.rough_theories import (
    BushGibsonThomas,
    Moments,
    Persson,
    PerssonXu,
    greenwood_williamson,
    line_peaks,
    surface_peaks,
)
from reference.surfaces import summits


def self_affine(points=400):
    """Return the rings of Xu, Zhou, Mueser et al. (2024): C ~ q^-3.6, 1e4 to 1e6 /m, 6 um rms."""
    edges = np.geomspace(1e4, 1e6, points + 1)
    power = edges[:-1] ** -1.6 - edges[1:] ** -1.6
    return np.sqrt(edges[1:] * edges[:-1]), power * (6e-6) ** 2 / power.sum()


THEORY = Persson(*self_affine())
XU = PerssonXu(*self_affine())
MOMENTS = Moments(1.0, 1.0, 10.0)


def test_persson_s_area_is_the_closed_form():
    """A/A0 = erf(sqrt(2) p/(E* h')): J. Chem. Phys. 115 (2001) 3840."""
    slope = math.sqrt(float(np.sum(THEORY.wavenumber**2 * THEORY.power)))
    assert slope == pytest.approx(0.2766, rel=1e-3)  # as published
    for load in (1e-3, 0.1, 1.0):
        assert THEORY.area(load * slope) == pytest.approx(math.erf(math.sqrt(2) * load), rel=1e-12)


def test_persson_s_mean_gap_falls_by_its_stiffness_and_is_near_the_published_gaps():
    """Molecular dynamics of the same surfaces: the theory with gamma = 0.45 is 3 to 20 % wider."""
    published = {1e-4: 2.629, 1e-3: 1.883, 5e-3: 1.181, 1e-2: 0.8540, 2.5e-2: 0.4398}
    for pressure, gap in published.items():
        ratio = THEORY.mean_gap(pressure) / 6e-6 / gap
        assert 1.0 < ratio < 1.21
        step = 1e-5 * pressure
        slope = (THEORY.mean_gap(pressure + step) - THEORY.mean_gap(pressure - step)) / (2 * step)
        assert THEORY.stiffness(pressure) * slope == pytest.approx(-1, rel=1e-5)


def test_the_gap_of_one_wave_vanishes_in_full_contact():
    one = Persson(np.array([1.0]), np.array([1.0]))
    gaps = [one.mean_gap(p) for p in (0.1, 1.0, 3.0)]
    assert gaps == sorted(gaps, reverse=True)
    assert gaps[-1] < 1e-4
    assert (one.mean_gap(60.0), one.stiffness(60.0)) == (0.0, math.inf)


def test_persson_s_distributions_hold_the_area_the_pressure_and_the_gap():
    """Contact and gap together cover the surface; the mean pressure is the nominal one."""
    p = 0.005
    limits = np.concatenate([[0.0], np.geomspace(1e-9, 10, 4000)])
    pressed = THEORY.pressure_below(p, limits)
    assert pressed[-1] == pytest.approx(THEORY.area(p), rel=1e-9)
    middle = (limits[1:] + limits[:-1]) / 2
    assert np.diff(pressed) @ middle == pytest.approx(p, rel=1e-4)
    # P(p) ~ p: the share below p goes with its square
    assert THEORY.pressure_below(p, 2e-5) / THEORY.pressure_below(p, 1e-5) == pytest.approx(4, 1e-3)
    gaps = np.concatenate([[0.0], np.geomspace(1e-10, 1e-3, 4000)])
    opened = THEORY.gap_below(p, gaps)
    assert opened[-1] + THEORY.area(p) == pytest.approx(1, rel=1e-9)
    # folding Gaussians at zero widens their mean by some per cent
    mean = np.diff(opened) @ ((gaps[1:] + gaps[:-1]) / 2)
    assert 1.0 < mean / THEORY.mean_gap(p) < 1.08


def test_asperities_have_nayak_s_heights():
    """Mean height 4 sqrt(m0/(pi alpha)), variance (1 - 0.8968/alpha) m0 (McCool 1986)."""
    model = greenwood_williamson(MOMENTS)
    assert model.mean == pytest.approx(4 / math.sqrt(math.pi * MOMENTS.breadth), rel=1e-6)
    assert model.deviation**2 == pytest.approx(1 - 0.8968 / MOMENTS.breadth, rel=1e-4)


def test_bush_gibson_and_thomas_tend_to_their_limit_far_from_the_surface():
    """A = sqrt(2 pi) F/(E* h'), reached from below, the sooner the narrower the spectrum."""
    ratios = []
    for separation in (2.0, 4.0, 6.0):
        model = BushGibsonThomas(Moments(1.0, 1.0, 1.6))
        load = model.pressure(separation) / math.sqrt(2 * model.moments.slope)
        ratios.append(model.area(separation) / (math.sqrt(2 * math.pi) * load))
    assert ratios == sorted(ratios)
    assert 0.9 < ratios[-1] < 1.0


def test_asperities_carry_more_as_they_come_nearer_and_stiffness_is_the_slope():
    model = BushGibsonThomas(MOMENTS)
    assert model.pressure(model.separation(1e-3)) == pytest.approx(1e-3, rel=1e-9)
    slope = (model.pressure(1.5 + 1e-5) - model.pressure(1.5 - 1e-5)) / 2e-5
    assert model.stiffness(1.5) == pytest.approx(-slope, rel=1e-7)


def test_xu_s_area_lies_between_persson_s_and_that_over_the_root_of_gamma():
    """At light loads W = gamma V; in full contact W = V. Published: 8 to 14 % smaller areas."""
    published = {1e-4: 0.000826, 1e-3: 0.007822, 1e-2: 0.074426}
    for pressure, area in published.items():
        ratio = XU.area(pressure) / THEORY.area(pressure)
        assert 1 < ratio < PerssonXu.gamma**-0.5
        assert 1.07 < XU.area(pressure) / area < 1.15
    assert XU.area(1e-6) / THEORY.area(1e-6) == pytest.approx(PerssonXu.gamma**-0.5, rel=1e-3)
    assert XU.area(1.0) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.slow
def test_xu_s_pressures_carry_the_load_and_the_gap_falls_by_the_stiffness():
    """Mean pressure to the width of 4000 bins; below 1e-7 h' the gap goes on with ln p."""
    p = 0.005
    limits = np.concatenate([[0.0], np.geomspace(1e-9, 10, 4000)])
    pressed = XU.pressure_below(p, limits)
    assert pressed[-1] == pytest.approx(XU.area(p), rel=1e-6)
    assert np.diff(pressed) @ ((limits[1:] + limits[:-1]) / 2) == pytest.approx(p, rel=1e-4)
    for pressure in (1e-9, 1e-4, p):
        slope = (XU.mean_gap(1.001 * pressure) - XU.mean_gap(0.999 * pressure)) / 0.002 / pressure
        assert XU.stiffness(pressure) * slope == pytest.approx(-1, rel=1e-3)
    assert XU.mean_gap(10.0) == 0.0
    # all of one wave in contact: the energy q h^2/4 is that of the mean gap's integral
    one = PerssonXu(np.array([1.0]), np.array([1.0]))
    loads = np.geomspace(1e-6, 6, 500)
    gaps = np.array([one.mean_gap(load) for load in loads])
    work = np.sum((loads[1:] + loads[:-1]) / 2 * -np.diff(gaps))
    assert work == pytest.approx(0.25, rel=2e-3)


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
    radius = (1 / np.sqrt(both.prod(axis=1))).mean()
    # the mean of 1/sqrt has a heavy tail of flat summits
    assert radius == pytest.approx(theory.mean_radius, rel=0.05)


def test_maxima_of_lines_are_sharper_than_the_summits_of_their_surface():
    """Line: sqrt(pi/2)/sqrt(8/3) by Kac-Rice; surface: 0.90055, by sampling at summits."""
    ratio = line_peaks(1.0, 8 / 3).mean_radius / surface_peaks(0.5, 1.0).mean_radius
    assert ratio == pytest.approx(0.852, abs=0.001)


def test_curvatures_of_summits_converge_with_the_square_of_the_spacing():
    """A summit between grid points: curvature error O(dx^2), so at least order 1.8 observed."""
    errors = []
    for n in (16, 32, 64):
        x = 2 * np.pi * (np.arange(n) + 0.3) / n
        h = np.cos(x)[:, None] + 0.5 * np.cos(x)
        (only,) = summits(h, (2 * np.pi / n,) * 2).curvatures
        errors.append(abs(only - [1.0, 0.5]).max())
    assert np.log2(errors[0] / errors[2]) / 2 > 1.8


def test_bush_gibson_and_thomas_are_linear():
    """Kappa is sqrt(2 pi) = 2.51."""
    assert rough_theories.bush_gibson_thomas_area(1e-6) / 1e-6 == pytest.approx(2.5066, abs=1e-4)
