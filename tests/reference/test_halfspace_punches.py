"""Flat faces by area fractions: the edge law derived anew, closed forms, invariance to the grid."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve, toeplitz
from scipy.optimize import brentq
from scipy.special import ellipk

from reference.contact.pivot import pairs
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator
from reference.halfspace.punches import EDGE_COMPLIANCE, EDGE_OFFSET, respond, respond_dense


def strip_coefficients(cells: int) -> np.ndarray:
    """Return the displacement at the middle of strip j, plane strain, E* = 1, but for a constant.

    u = -(2/pi) int ln|x - s| ds over the first strip: what rows of square cells under equal
    pressures sum up to.
    """
    j = np.arange(cells, dtype=float)
    upper, lower = j + 0.5, j - 0.5
    primitive = upper * np.log(upper) - upper - (lower * np.log(np.abs(lower)) - lower)
    return -(2 / np.pi) * primitive


def half_width(cells: int, extra: float) -> float:
    """Return b of the strip with the same compliance: d/P = (2/pi) ln(2/b) (Johnson 1985, 2.35)."""
    matrix = toeplitz(strip_coefficients(cells))
    matrix[0, 0] += extra
    matrix[-1, -1] += extra
    force = solve(matrix, np.ones(cells), assume_a="sym").sum()
    return 2 * np.exp(-np.pi / (2 * force))


def test_whole_cells_put_the_edge_of_a_strip_a_sixth_of_a_cell_too_far_in():
    """The offset of wide strips goes with 1/N to its limit: two widths give it to 1e-5."""
    offsets = [half_width(n, 0.0) - n / 2 for n in (200, 400)]
    limit = 2 * offsets[1] - offsets[0]
    assert -limit == pytest.approx(EDGE_OFFSET, abs=1e-5)


@pytest.mark.parametrize("phi", [0.02, 0.3, 0.5, 0.8, 0.97])
def test_the_extra_compliance_keeps_that_offset_at_every_fraction(phi):
    """One constant in c (1/phi - 1) serves all phi: to 2e-4 of two widths, extrapolated in 1/N."""

    def constant(n: int) -> float:
        wanted = half_width(n, 0.0) - 1 + phi
        result = brentq(lambda w: half_width(n, w) - wanted, 0, 200)
        return result / (1 / phi - 1)

    limit = 2 * constant(400) - constant(200)
    assert limit == pytest.approx(EDGE_COMPLIANCE, rel=2e-4)


def disc_fractions(cells: int, shift: tuple[float, float], aspect: float = 1.0) -> np.ndarray:
    """Shares of unit cells under an ellipse of half-width `cells` + offset, by 64^2 sub-cells."""
    n, fine = int(np.ceil(cells)) + 2, 64
    axis = (np.arange(2 * n * fine) + 0.5) / fine - n
    x, y = axis[:, None] - shift[0], axis - shift[1]
    a, b = cells + EDGE_OFFSET, aspect * cells + EDGE_OFFSET
    inside = (x / a) ** 2 + (y / b) ** 2 <= 1
    return inside.reshape(2 * n, fine, 2 * n, fine).mean(axis=(1, 3))


def stiffness(fraction: np.ndarray) -> float:
    return respond(FreeOperator(fraction.shape, (1.0, 1.0), 1.0), fraction).stiffness


@pytest.mark.parametrize("aspect", [1.0, 0.5])
def test_discs_and_ellipses_converge_to_their_closed_form(aspect):
    """K = 2 E* a, and pi E* a/K(m) with m = 1 - (b/a)^2 (Johnson 1985, 3.4; Sneddon).

    The first-order error of whole cells, 17 % dx/a, is gone: 1.1 % and 2.2 % there at 16 cells
    (staircases aside). What is left is below 0.05 % from 16 cells per semi-axis on.
    """
    for cells in (16, 32):
        exact = np.pi * cells / ellipk(1 - aspect**2)
        values = [stiffness(disc_fractions(cells, s, aspect)) for s in ((0, 0), (0.3, 0.45))]
        np.testing.assert_allclose(values, exact, rtol=5e-4 * (16 / cells) / aspect)


def test_aligned_squares_agree_wherever_the_grid_lies():
    """Phi from nearly 0 to 1 at their edges; k = pi 0.36679 E* L.

    The capacitance of the square, C = 0.36679 (4 pi eps0 L): Hwang & Mascagni, J. Appl. Phys. 95
    (2004) 3798. By k = pi E* C (Gaussian), the disc has C = 2a/pi.
    """
    cells = 48
    for shift in (0.0, 0.013, 0.25, 0.5, 0.777):
        edges = np.arange(cells + 5) - 2 - shift
        low, high = -EDGE_OFFSET, cells + EDGE_OFFSET
        cover = np.clip(np.minimum(edges[1:], high) - np.maximum(edges[:-1], low), 0, 1)
        # Fewer than 2e-4 at 48 cells per side: corners have an order of 1.6.
        assert stiffness(np.outer(cover, cover)) == pytest.approx(np.pi * 0.36679 * cells, rel=5e-4)


def faces(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.where(rng.random((7, 9)) < 0.3, 0.0, rng.random((7, 9)))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_conjugate_gradients_agree_with_the_factorisation(seed):
    """Any fractions, connected or not: to the tolerance of the iteration times the condition."""
    fraction = faces(seed)
    operator = FreeOperator(fraction.shape, (0.1, 0.1), 3.0)
    one, other = respond(operator, fraction), respond_dense(operator, fraction)
    assert one.stiffness == pytest.approx(other.stiffness, rel=1e-8)
    assert one.residual < 2e-9
    assert other.residual < 1e-12
    # More of a cell under the face is stiffer: the law of the compliance falls with phi.
    more = respond_dense(operator, np.minimum(1.2 * fraction, 1.0))
    assert more.stiffness > other.stiffness


def test_the_factorisation_holds_one_matrix():
    """8 bytes of an entry, one more while they are checked; the rest is of the cells."""
    cells = 24
    operator, fraction = FreeOperator((cells, cells), (1.0, 1.0), 1.0), np.ones((cells, cells))
    respond_dense(operator, fraction)  # compiles
    tracemalloc.start()
    respond_dense(operator, fraction)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10 * cells**4


def test_coefficients_of_a_face_are_looked_up_by_the_code_of_all_contacts():
    """For another order of memory it would be compiled in the middle of a solve that is timed."""
    respond_dense(FreeOperator((7, 9), (0.1, 0.1), 3.0), faces(0))
    arrays = [array for made in pairs.nopython_signatures for array in made.args]
    assert {array.layout for array in arrays} == {"C"}


def test_an_iteration_that_is_cut_short_says_so():
    operator = FreeOperator((7, 9), (1.0, 1.0), 1.0)
    with pytest.raises(ConvergenceError, match="flat face") as caught:
        respond(operator, faces(2), max_iterations=3)
    assert len(caught.value.history) == 3
