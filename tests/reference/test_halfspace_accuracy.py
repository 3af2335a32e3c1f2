"""Error estimates from a coarser grid against true errors."""

from __future__ import annotations

import numpy as np
import pytest

from reference.halfspace import FreeOperator, PeriodicOperator, accuracy, areas, fft
from reference.surfaces import refine, self_affine


def test_hertz_errors_lie_within_the_estimates():
    """Random grids: the estimate of the force is three times its second-order error.

    Force and corrected area also scatter with the grid's offset, which is another one on the
    coarser grid: one grid in twenty lay outside.
    """
    rng = np.random.default_rng(31)
    within, sharpness = [], []
    for cells in rng.uniform(8, 24, 40):
        n = 2 * int(1.5 * cells)
        x, y = (np.arange(n) - n / 2 + rng.uniform(0, 1, (2, 1))) / cells
        operator = FreeOperator((n, n), (1 / cells, 1 / cells), 1.0)
        contact = fft.solve(operator, (x[:, None] ** 2 + y**2) / 2, penetration=1.0)
        bar = accuracy.discretisation_error(contact, "penetration")
        area = areas.corrected_area(contact.mask, operator.spacing)
        force_error, area_error = abs(contact.force - 4 / 3), abs(area - np.pi)
        within.append((force_error < bar.force, area_error < bar.contact_area))
        sharpness.append(bar.force / force_error)
    share = np.mean(within, axis=0)
    assert (share >= 0.9).all()
    assert np.median(sharpness) == pytest.approx(3, rel=0.3)


def test_rough_errors_lie_within_the_estimates():
    """Truth: the same surface on four times as many points a side (Fourier interpolation)."""
    within = []
    for realisation in range(5):
        height = self_affine(
            64, 1.0, hurst=0.8, rms_slope=0.1, short_cutoff=1 / 8, seed=7, realisation=realisation
        )
        found = []
        for factor in (1, 4):
            finer = refine(height, factor)
            operator = PeriodicOperator(finer.shape, (1 / len(finer),) * 2, 1.0)
            found.append(fft.solve(operator, finer.max() - finer, force=5e-3))
        contact, truth = found
        bar = accuracy.discretisation_error(contact, "force")
        energies = [areas.elastic_energy(c.operator, c.pressure) for c in found]
        within.append(abs(energies[0] - energies[1]) < bar.energy)
        within.append(
            abs(contact.mean_gap - truth.mean_gap) < bar.penetration + 2 * bar.energy / 5e-3
        )
        assert bar.force == 0.0
    assert np.mean(within) == 1.0


def test_grids_without_a_coarser_one_are_refused():
    operator = PeriodicOperator((9, 8), (1.0, 1.0), 1.0)
    height = np.random.default_rng(32).standard_normal((9, 8))
    contact = fft.solve(operator, height.max() - height, force=1.0)
    with pytest.raises(ValueError, match=r"\(9, 8\) cells has no coarser grid"):
        accuracy.discretisation_error(contact)
    with pytest.raises(ValueError, match="control"):
        accuracy.discretisation_error(contact, "mean_gap")
    gap = np.full((8, 8), 2.0)
    gap[3, 3] = 0.0
    contact = fft.solve(FreeOperator((8, 8), (1.0, 1.0), 1.0), gap, penetration=1.0)
    with pytest.raises(ValueError, match="no point of the coarser grid"):
        accuracy.discretisation_error(contact, "penetration")
