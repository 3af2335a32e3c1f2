"""Stored fields of large grids: means over blocks, that keep forces, positions and heights."""

import numpy as np
import pytest

from comparisons.methods.normal import grid as blocks


def test_a_large_pressure_is_stored_in_blocks_that_carry_its_force(rough, solved, monkeypatch):
    """48 x 40 cells in blocks of 5, the last ones of 3 and 5; quantities are of all cells."""
    scene = rough(
        points=[48, 40],
        short_cutoff=2e-7,
        periodic=True,
        loading={"force": {"values": [0.1], "relative_to": "E* A0 h'"}},
        compare={"quantities": ["force", "contact_area", "pressure"]},
    )
    whole = solved(scene, "bem_fft", 48)
    monkeypatch.setattr(blocks, "MOST_POINTS", 48 * 40 - 1)
    monkeypatch.setattr(blocks, "SIDE", 10)
    stored = solved(scene, "bem_fft", 48)
    assert stored.quantities["contact_area"] == whole.quantities["contact_area"]
    small, large = stored.fields, whole.fields
    assert tuple(small["pressure_shape"]) == (10, 8)
    assert small["heights"].shape == small["contact"].shape == (10, 8)
    carried = small["pressure"] @ small["pressure_weight"]
    assert carried == pytest.approx(large["pressure"] @ large["pressure_weight"], rel=1e-12)
    assert small["pressure_x"].max() == pytest.approx(large["pressure_x"][-120:].mean())
    gap = large["gap"].reshape(48, 40)[:5, 5:10].mean()
    assert small["gap"][1] == pytest.approx(gap, rel=1e-9)


def test_a_field_of_a_screen_is_stored_as_it_is():
    values = np.arange(6.0).reshape(2, 3)
    assert blocks.block_means(values, blocks.blocks_of(values.shape)) is values
