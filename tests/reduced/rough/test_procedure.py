"""Section 19.7 from map to contact: the pieces fit, and the two variants differ as they must."""

import numpy as np
import pytest

from reduced.rough.procedure import CORRECTED, LITERAL, calculate, side_by_side
from reduced.rough.surface_spectrum import measured

FORCE = np.array([1e-2, 1e-1, 1.0])


@pytest.fixture(scope="module")
def both():
    """Both variants on a self-affine map without roll-off, H = 0.8."""
    rng = np.random.default_rng(5)
    k = np.fft.fftfreq(32, 1 / 32)
    q = np.hypot(k[:, None], k)
    amplitude = np.where((q > 0) & (q < 16), np.maximum(q, 1) ** -1.8, 0.0)
    noise = np.fft.fft2(rng.normal(size=(32, 32)))
    height = np.fft.ifft2(amplitude * np.exp(1j * np.angle(noise)), norm="forward").real
    return height, side_by_side(measured(height, 1.0, periodic=True), 1.0, FORCE, realisations=30)


def test_distributions_add_up_to_the_curves(both):
    """(pi/4) sum l^2 and sum l over the pooled contacts are the ensemble's area and length."""
    for part in both[1]:
        for step in range(FORCE.size):
            sizes = part.contact_sizes[step]
            area, length = (part.ensemble[n].mean[step] for n in ("contact_area", "contact_length"))
            assert np.pi / 4 * np.sum(sizes**2) / 30 == pytest.approx(area, rel=1e-11)
            assert sizes.sum() / 30 == pytest.approx(length, rel=1e-11)
            assert sizes.size == part.ensemble.samples["contact_count"][:, step].sum()
        mean = np.mean(FORCE / part.ensemble.samples["contact_area"], axis=0)
        np.testing.assert_allclose(part.mean_pressure, mean, rtol=1e-13)


def test_options_reach_the_lines(both):
    """Seeds give other lines; the literal line has the spacing of the map."""
    height, (literal, _) = both
    surface = measured(height, 1.0, periodic=True)
    other = calculate(surface, 1.0, FORCE, LITERAL, realisations=30, seed=1)
    assert np.all(other.ensemble["contact_area"].mean != literal.ensemble["contact_area"].mean)
    lengths = np.concatenate(literal.contact_sizes) * 32
    np.testing.assert_allclose(lengths, np.rint(lengths), atol=1e-9)
    assert CORRECTED.refinement > LITERAL.refinement
    # points that are no maxima have no radius of their own, and no stress
    assert (literal.undefined_share[1:] > 0.01).all()


def test_the_example_runs(script):
    """It prints five loads as printed, then five as corrected."""
    module = script("procedure_19_7")
    for result in (module.literal, module.corrected):
        _, _, *rows = module.table(result).splitlines()
        assert len(rows) == 5


def test_the_table_of_convergence_has_a_row_for_each_shape_and_edge(script):
    rows = script("reduced_tables").convergence(draws=40)
    assert len(rows) == 15
    orders = {(row[0], row[1]): row[3] for row in rows[1:]}
    assert orders["cylinder", "sub_cell"] == "exact"
