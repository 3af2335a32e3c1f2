"""Part of a measured map, the same heights to finite elements and to the half-space solver."""

from pathlib import Path

import numpy as np
import pytest

from comparisons.scene.scene import parse_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

MAP = Path(__file__).resolve().parents[5] / "shared" / "data" / "di-6.di"
BLOCKS = 4  # a side: what the grids resolve of the pressure


def plan():
    pytest.importorskip("SurfaceTopography")
    if not MAP.exists():
        pytest.skip(f"{MAP} is not here")
    text = (
        'name = "patch"\n[half_space]\nyoungs_modulus = "70 GPa"\npoisson_ratio = 0.3\n'
        f'[surface]\nkind = "map"\nfile = "{MAP}"\ncrop = [200, 200, 16, 16]\n'
        '[loading]\nforce = { values = [0.005, 0.02, 0.05, 0.1], relative_to = "E* A0 h\'" }\n'
        '[compare]\nquantities = ["force", "penetration", "contact_area", "pressure"]\n'
    )
    return plan_scene(parse_scene(text, "patch", Path()))[0]


def block_forces(fields) -> np.ndarray:
    """Shares of the last force on BLOCKS x BLOCKS parts of the patch."""
    size = fields["size"]
    i, j = (
        np.minimum((fields[f"pressure_{axis}"] / side * BLOCKS).astype(int), BLOCKS - 1)
        for axis, side in zip("xy", size, strict=True)
    )
    force = fields["pressure"] * fields["pressure_weight"]
    return np.bincount(i * BLOCKS + j, force, minlength=BLOCKS**2) / force.sum()


@pytest.mark.slow
def test_measured_patch_agrees_with_the_half_space_solver_within_the_summed_estimates():
    """Penetration and area at four forces, force on 16 parts of the patch at the largest.

    The estimate of each is the change from the grid of half the points; the two share no code.
    For the parts, where both changes may be small by chance, their rms stands for all.
    """
    made = plan()
    result = {
        method: [execute(task_of(made, method, n, with_body=False), 1) for n in resolutions]
        for method, resolutions in {"fem": (16, 32), "bem_fft": (32, 64)}.items()
    }
    for coarse, fine in result.values():
        assert coarse.converged.all()
        assert fine.converged.all()
    for name in ("penetration", "contact_area"):
        (coarse, fine), (cells, more) = (
            [part.quantities[name][0] for part in result[method]] for method in ("fem", "bem_fft")
        )
        estimate = np.abs(fine - coarse) + np.abs(more - cells)
        assert np.all(np.abs(fine - more) <= estimate), name
        assert np.all(estimate < 0.35 * more), name  # the estimates say something
    (coarse, fine), (cells, more) = (
        [block_forces(part.fields) for part in result[method]] for method in ("fem", "bem_fft")
    )
    changes = [np.sqrt(np.mean(part**2)) for part in (fine - coarse, more - cells)]
    assert np.sqrt(np.mean((fine - more) ** 2)) <= sum(changes)
    assert np.corrcoef(fine, more)[0, 1] > 0.98
