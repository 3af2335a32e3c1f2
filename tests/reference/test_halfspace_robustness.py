"""Contacts on which solvers stall: each must converge to 1e-8, or be refused with the reason.

Loads are relative to the pressure of full contact, p_f = -min of the linear answer, at which the
last point closes. Grids of 64 points by default and of 256 among the slow tests.
"""

import numpy as np
import pytest

from reference.contact.press import certify, press
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.loads import Load
from reference.surfaces import SelfAffine, self_affine

MODULUS = 3.0
# from one cell in contact through 99-100 % to far beyond full contact
FORCES = [1e-12, 1e-6, 1e-3, 0.1, 0.3, 0.9, 0.99, 0.9999, 1 - 1e-9, 1.0, 1 + 1e-9, 1.5, 100.0]
DEPTHS = [1e-12, 1e-6, 1e-3, 0.1, 0.5, 0.9, 0.99, 0.9999]
MEAN_GAPS = [0.01, 0.3, 0.9, 1 - 1e-6]
# The limit on iterations is 2000; beyond 300 a solver may be said to stall.
STALLED = 300


def rough(points, hurst, slope: float, short_cutoff: int) -> np.ndarray:
    """Surface of unit side; "white" is noise without any correlation."""
    if hurst == "white":
        return np.random.default_rng(1).standard_normal((points, points)) * slope / points
    return self_affine(
        points,
        1.0,
        SelfAffine(
            hurst=hurst, rms_slope=slope, long_cutoff=0.5, short_cutoff=short_cutoff / points
        ),
        seed=1,
        realisation=0,
    )


def full_contact_force(height: np.ndarray, spacing: tuple[float, float]) -> float:
    """Smallest force of full contact under periodic pressure, p^ = E* |q| h^/2."""
    q = np.hypot(
        2 * np.pi * np.fft.fftfreq(height.shape[0], spacing[0])[:, None],
        2 * np.pi * np.fft.fftfreq(height.shape[1], spacing[1])[None, :],
    )
    linear = np.fft.ifft2(MODULUS * q / 2 * np.fft.fft2(height)).real
    return float(-linear.min() * height.size * spacing[0] * spacing[1])


def check_all_loads(operator, height: np.ndarray) -> None:
    """Solve under each control: what was solved satisfies its conditions anew."""
    gap = height.max() - height
    scale = full_contact_force(height, operator.spacing)
    loads = [("force", scale * f) for f in FORCES]
    loads += [("penetration", float(gap.mean()) * f) for f in DEPTHS]
    loads += [("mean_gap", float(gap.mean()) * f) for f in MEAN_GAPS]
    for control, value in loads:
        load = Load(control, value)
        contact = press(operator, gap, load)
        # On the free half-space the depth of a mean gap is searched for, in several solves.
        solves = 12 if control == "mean_gap" and not operator.periodic else 1
        assert contact.iterations <= solves * STALLED, load
        rounding = 1e-14 * contact.pressure.max() / MODULUS / contact.penetration
        assert certify(operator, gap, load, contact) <= 1.01e-8 + rounding, load


@pytest.mark.parametrize("operator_class", [PeriodicOperator, FreeOperator])
@pytest.mark.parametrize(("hurst", "short_cutoff"), [(0, 2), (0.5, 16), (1.0, 2), ("white", 0)])
@pytest.mark.parametrize("points", [64, pytest.param(256, marks=pytest.mark.slow)])
def test_every_roughness_converges_under_every_load(points, hurst, short_cutoff, operator_class):
    """Hurst exponents 0 to 1 and white noise, cutoffs down to two cells."""
    height = rough(points, hurst, 0.1, short_cutoff)
    check_all_loads(operator_class((points, points), (1 / points,) * 2, MODULUS), height)


@pytest.mark.slow
@pytest.mark.parametrize("operator_class", [PeriodicOperator, FreeOperator])
@pytest.mark.parametrize(
    ("shape", "spacing"),
    [
        ((400, 8), (1.0, 1.0)),
        ((8, 400), (0.2, 0.2)),
        ((31, 97), (1.0, 0.1)),
        ((96, 30), (1.0, 16.0)),
    ],
)
def test_elongated_maps_and_rectangular_cells_converge(shape, spacing, operator_class):
    """Maps of 1:50, odd and prime lengths, cells of 1:10 and 1:16."""
    size = shape[0] * spacing[0], shape[1] * spacing[1]
    height = self_affine(shape, size, SelfAffine(hurst=0.8, rms_slope=0.1), seed=2, realisation=0)
    check_all_loads(operator_class(shape, spacing, MODULUS), height)


@pytest.mark.parametrize("kernel", ["continuum", "cells"])
def test_white_noise_on_needle_shaped_cells_converges(kernel):
    """Cells of 1:50 under noise of the cell's own length."""
    height = np.random.default_rng(3).standard_normal((64, 64))
    check_all_loads(PeriodicOperator((64, 64), (1.0, 50.0), MODULUS, kernel=kernel), height)
