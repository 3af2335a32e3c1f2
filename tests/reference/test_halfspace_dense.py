"""The dense oracle: complementarity, kept factors, and starts that mislead it."""

import numpy as np
import pytest
from scipy.linalg import cho_factor

from reference.contact.pivot import CELL_LIMIT
from reference.contact.press import press, sweep
from reference.halfspace import FreeOperator
from reference.loads import Load
from reference.surfaces import SelfAffine, self_affine


def rough(points: int) -> tuple[FreeOperator, np.ndarray]:
    height = self_affine(
        points,
        1.0,
        SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=4 / points),
        seed=4,
        realisation=0,
    )
    return FreeOperator((points, points), (1 / points,) * 2, 1.0), height.max() - height


@pytest.fixture
def factorisations(monkeypatch):
    """Sizes of the matrices that are factorised."""
    sizes: list[int] = []

    def counted(matrix, **arguments):
        sizes.append(matrix.shape[0])
        return cho_factor(matrix, **arguments)

    monkeypatch.setattr("reference.contact.pivot.cho_factor", counted)
    return sizes


@pytest.mark.slow
@pytest.mark.parametrize("control", ["penetration", "force"])
def test_a_sweep_keeps_its_factor_and_changes_only_its_border(control, factorisations):
    """Fewer than half of the rounds factorise, and the answers are those of single solves."""
    operator, gap = rough(48)
    loads = np.linspace(0.2, 0.6, 25) * (2e-2 if control == "force" else gap.mean())
    swept = list(sweep(operator, gap, Load(control, loads), by="pivot"))
    assert len(factorisations) < 0.5 * sum(contact.iterations for contact in swept)
    for load, contact in zip(loads[::6], swept[::6], strict=True):
        single = press(operator, gap, Load(control, load), by="pivot")
        np.testing.assert_array_equal(single.mask, contact.mask)
        scale = single.pressure.max()
        np.testing.assert_allclose(contact.pressure, single.pressure, atol=1e-11 * scale)


@pytest.mark.slow
def test_the_dense_solver_carries_five_thousand_contact_cells():
    """Hertz, 39 cells per radius: complementarity 1e-12, the FFT agrees to 1e-7 of the peak."""
    cells = 39.0
    x = np.arange(112) - 55.7
    operator = FreeOperator((112, 112), (1 / cells, 1 / cells), 1.0)
    gap = (x[:, None] ** 2 + x**2) / (2 * cells**2)
    exact = press(operator, gap, Load("penetration", 1.0), by="pivot")
    assert 4700 < exact.mask.sum() <= CELL_LIMIT
    assert exact.violation < 1e-12
    assert exact.force == pytest.approx(4 / 3, rel=2e-4)
    contact = press(operator, gap, Load("penetration", 1.0), tolerance=1e-10)
    np.testing.assert_allclose(contact.pressure, exact.pressure, atol=1e-7 * exact.pressure.max())
