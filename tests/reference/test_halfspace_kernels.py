"""Influence coefficients against 50 digits, lattice sums and Boussinesq's point load."""

from pathlib import Path

import mpmath
import numpy as np
import pytest

from reference.contact import body as contact_body
from reference.halfspace import FreeOperator, PeriodicOperator, kernels
from reference.halfspace.traction import Compliance, NormalAndTangential
from reports.tables.written import markdown_rows


def love_with_50_digits(i: int, j: int, dx: float, dy: float):
    """Love's integral of 1/r over a cell from its antiderivative at the corners."""
    with mpmath.workdps(50):
        half = mpmath.mpf(1) / 2
        a, b, c, d = (i + half) * dx, (i - half) * dx, (j + half) * dy, (j - half) * dy

        def corner(x, y):
            return x * mpmath.asinh(y / abs(x)) + y * mpmath.asinh(x / abs(y))

        return (corner(a, c) - corner(b, c) - corner(a, d) + corner(b, d)) / mpmath.pi


@pytest.mark.parametrize(
    "spacing", [(1.0, 1.0), (1.0, 3.0), (10.0, 1.0), (0.25, 16.0), (1.0, 50.0), (100.0, 1.0)]
)
def test_love_keeps_twelve_digits_from_the_own_cell_to_a_hundred_thousand_cells(spacing):
    """Also on the axes and just beside them, where the printed logarithms cancel."""
    rng = np.random.default_rng(7)
    for reach in (1, 3, 15, 17, 100, 10_000, 100_000):
        offsets = rng.integers(-reach, reach + 1, size=(12, 2))
        offsets[0, 0] = offsets[1, 1] = 0
        offsets[2] = -reach, reach
        for i, j in offsets.tolist():
            exact = love_with_50_digits(i, j, *spacing)
            value = float(kernels.love(i, j, spacing, 1.0))
            assert abs(value / exact - 1) < 1e-12, (i, j)


def test_on_the_edge_of_the_loaded_cell_loves_formula_is_finite():
    """There two or four cells meet, each with its share of the larger one's displacement."""
    side, corner = (float(kernels.love(0.5, j, (1.0, 1.0), 1.0)) for j in (0.0, 0.5))
    halves = kernels.love(0, 0, (2.0, 1.0), 1.0) / 2
    assert side == pytest.approx(float(halves), rel=1e-14)
    assert corner == pytest.approx(float(kernels.love(0, 0, (2.0, 2.0), 1.0)) / 4, rel=1e-14)


@pytest.mark.parametrize("mode", [(1, 0), (3, 5), (0, 4)])
def test_cosine_pressure_gives_johnsons_cosine_displacement(mode):
    """Displacement 2 p/(E* q) for p = cos(q.x) (Johnson 1985, sec. 13.2)."""
    shape, spacing, modulus = (12, 16), (0.5, 0.25), 3.0
    x = np.arange(12)[:, None] * 0.5
    y = np.arange(16)[None, :] * 0.25
    qx, qy = 2 * np.pi * mode[0] / 6.0, 2 * np.pi * mode[1] / 4.0
    p = np.cos(qx * x + qy * y)
    u = PeriodicOperator(shape, spacing, modulus).apply(p)
    np.testing.assert_allclose(u, 2 * p / (modulus * np.hypot(qx, qy)), atol=1e-14)


def test_cell_kernel_is_loves_kernel_summed_over_all_periodic_images():
    """Independent lattice sum: a loaded cell and its images on a uniform opposite pressure.

    With the load in the centre of its period the tail of the sum is that of quadrupoles, so the
    part that varies over the period falls as n^-3 in the number n of periods each way: 4e-7 of the
    largest value at n = 20. The mean is a matter of datum and subtracted.
    """
    shape, spacing, n = (6, 4), (1.0, 1.3), 20
    i = (np.arange(6)[:, None] + 3) % 6 - 3
    j = (np.arange(4)[None, :] + 2) % 4 - 2
    lengths = 6 * spacing[0] * (2 * n + 1), 4 * spacing[1] * (2 * n + 1)
    total = (
        -kernels.love(i * spacing[0] / lengths[0], j * spacing[1] / lengths[1], lengths, 1.0) / 24
    )
    for k in range(-n, n + 1):
        for m in range(-n, n + 1):
            total += kernels.love(i + 6 * k, j + 4 * m, spacing, 1.0)
    unit = np.zeros(shape)
    unit[0, 0] = 1.0
    result = PeriodicOperator(shape, spacing, 1.0, kernel="cells").apply(unit)
    np.testing.assert_allclose(result, total - total.mean(), atol=2e-6 * result.max())


def test_the_kernels_on_the_page_are_those_of_the_code(script):
    """The table of cells over continuum in docs/half-space.md is written by its script."""
    page = (Path(__file__).parents[2] / "docs" / "half-space.md").read_text(encoding="utf-8")
    assert markdown_rows(script("half_space_tables").transfer_ratio()) in page


@pytest.mark.parametrize(
    "operator",
    [
        FreeOperator((32, 32), (1.0, 1.0), 1.0),
        NormalAndTangential((32, 32), (1.0, 1.0), Compliance.of(1.0, 0.3)),
    ],
)
def test_of_the_windows_of_a_sweep_the_last_are_kept(operator, monkeypatch):
    """Thirty kernels of growing windows took twice what the plan allows for a solve."""
    monkeypatch.setattr(contact_body, "LARGEST_KEPT", 32 * 16)
    first, second, third = (operator.restrict((n, 16)) for n in (8, 16, 24))
    assert operator.restrict((24, 16)) is third  # 24 x 16 cells, and room for 8 x 16 more
    assert operator.restrict((8, 16)) is not first
    assert operator.restrict((24, 16)) is third
    assert operator.restrict((16, 16)) is not second
