"""What the proofs allow for rounding, against more digits."""

import mpmath
import numpy as np
import pytest
from numba import njit
from scipy import fft

from reference.bounds.duality import mutual_energies
from reference.bounds.interval import EPSILON, complete, first_kind_above
from reference.bounds.trigonometric import transform_rounding


@pytest.mark.parametrize("complement", [1.0, 0.7, 0.1, 1e-3, 1e-8, 1e-14, 1e-30])
def test_complete_elliptic_integrals_lie_between_bounds_a_few_roundings_apart(complement):
    with mpmath.workdps(60):
        m = 1 - mpmath.mpf(complement)
        first, second = mpmath.ellipk(m), mpmath.ellipe(m)
        other = (first - second) / m if m else mpmath.pi / 4
        for cosine, sine in ((1.0, 1.0), (1.0, complement), (0.0, 1.0), (2.0, complement)):
            exact = cosine * (first - other) + sine * other
            lower, upper = complete(complement, cosine, sine)
            assert lower <= exact <= upper
            assert upper / lower - 1 < 200 * EPSILON


@pytest.mark.parametrize("at", [(0.1, 0.5, 1.0), (1e-6, 0.3, 2.0), (1e-20, 1.0, 1e3)])
def test_carlsons_integral_is_not_above_its_bound(at):
    exact = mpmath.elliprf(*at)
    assert exact <= float(first_kind_above(*map(np.array, at))) <= exact * (1 + 1e-10)


def test_energies_of_discs_that_nearly_agree_lie_within_their_errors():
    """K - E and the like cancel as the radii agree: a few roundings of each are not enough."""
    radii = np.array([0.5, 1 - 1e-7, 1.0])
    energies, errors = mutual_energies(radii)
    with mpmath.workdps(40):
        for b, a, energy, error in zip(
            radii[:2], radii[1:], np.diag(energies, 1), np.diag(errors, 1), strict=True
        ):
            m = (mpmath.mpf(b) / mpmath.mpf(a)) ** 2
            first, second = mpmath.ellipk(m), mpmath.ellipe(m)
            bracket = first - (first - second) / m + second
            exact = 8 * mpmath.pi / 3 * a * mpmath.mpf(b) ** 2 * bracket
            assert abs(energy - exact) <= error < 1e-13 * energy


@pytest.mark.parametrize("count", [2, 30, 48, 53, 101, 128, 211])
def test_transforms_err_by_less_than_the_theorem_says(count):
    """Of small factors; of a prime taken directly, and by a convolution (101 and 211)."""
    values = np.random.default_rng(0).standard_normal(count)
    rows = range(0, count, -(-count // 40))
    with mpmath.workdps(30):
        turn = [mpmath.expjpi(mpmath.mpf(-2) * k / count) for k in range(count)]
        exact = [mpmath.fsum(x * turn[j * k % count] for j, x in enumerate(values)) for k in rows]
        off = [abs(e - mpmath.mpc(v)) for e, v in zip(exact, fft.fft(values)[rows], strict=True)]
        size = mpmath.sqrt(sum(abs(e) ** 2 for e in exact))
        assert mpmath.sqrt(sum(o**2 for o in off)) < transform_rounding(count) * size
        # the factors themselves: an impulse goes through all passes
        impulse = fft.fft(np.eye(1, count, 1)[0])
        amiss = max(abs(t - mpmath.mpc(f)) for t, f in zip(turn, impulse, strict=True))
        assert amiss < transform_rounding(count)


_SERIES = np.concatenate([np.geomspace(1e-12, 1e6, 150), np.linspace(0.01, 12.0, 150)])


@njit
def _compiled(x):
    return np.arcsinh(x)


@pytest.mark.parametrize(
    ("library", "exact"),
    [
        (np.arcsinh, mpmath.asinh),
        (_compiled, mpmath.asinh),
        (np.log1p, mpmath.log1p),
        (np.sin, mpmath.sin),
        (np.cos, mpmath.cos),
        (np.exp, lambda x: mpmath.exp(x)),
        (lambda x: x**1.7, lambda x: mpmath.mpf(x) ** mpmath.mpf(1.7)),
        (lambda x: np.hypot(x, 1.3), lambda x: mpmath.hypot(x, mpmath.mpf(1.3))),
    ],
)
def test_the_c_library_is_within_four_units_in_the_last_place(library, exact):
    places = _SERIES[_SERIES < 700] if library is np.exp else _SERIES
    with mpmath.workdps(40):
        for x, value in zip(places, library(places), strict=True):
            true = exact(mpmath.mpf(float(x)))
            assert abs(true - mpmath.mpf(float(value))) <= 4 * EPSILON * abs(true)


def test_gauss_points_are_known_to_rounding():
    for count in (4, 8):
        nodes, weights = np.polynomial.legendre.leggauss(count)
        for degree in range(0, 2 * count, 2):
            assert (weights * nodes**degree).sum() == pytest.approx(2 / (degree + 1), rel=1e-15)
