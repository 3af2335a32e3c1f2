"""Make the table of rough surfaces in docs/half-space.md: the errors of grids, each quantity.

Run from the repository's root (three minutes on one core); what lies between the markers of the
page is written anew::

    python docs/examples/rough_areas.py
"""

# %%
from itertools import product
from pathlib import Path

import numpy as np

from reference.contact.press import sweep
from reference.halfspace import Contact, FreeOperator, PeriodicOperator, areas
from reference.halfspace.areas import located_area
from reference.loads import Load
from reference.surfaces import SelfAffine, refine, self_affine
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "half-space.md"
POINTS = 32
FACTORS = (1, 2, 4, 8, 16)
LOADS = np.array([0.001, 0.003, 0.01, 0.03, 0.1, 0.2])
SURFACES = list(product((0.3, 0.5, 0.8, 0.9), (1, 4), (False, True)))
# Orders with which the last two grids are extrapolated to the truth.
ORDERS = {
    "counted": 1,
    "corrected": 1,
    "located": 2,
    "penetration": 2,
    "stiffness": 1.5,
    "mean gap": 1.5,
}


# %% [markdown]
# All quantities of one surface at all loads and on all grids, in units of the side, E* and h'.


# %%
def measured(contact: Contact) -> list[float]:
    """Return the quantities of a contact, in the order of ORDERS."""
    operator, mask = contact.operator, contact.mask
    return [
        areas.raw_area(mask, operator.spacing),
        areas.corrected_area(mask, operator.spacing, operator.periodic),
        located_area(contact, patch=True),
        contact.penetration,
        areas.contact_stiffness(operator, mask, tolerance=1e-4),
        contact.mean_gap,
    ]


def on_grids(hurst: float, roll_off: float, periodic: bool, shortest: int) -> np.ndarray:
    """Return the quantities of a surface, (grids, loads, quantities)."""
    native = self_affine(
        POINTS,
        1.0,
        SelfAffine(
            hurst=hurst,
            rms_slope=1.0,
            long_cutoff=1 / roll_off if roll_off > 1 else None,
            short_cutoff=shortest / POINTS,
        ),
        seed=1,
        realisation=0,
    )
    kind = PeriodicOperator if periodic else FreeOperator
    quantities = []
    for factor in FACTORS:
        heights = refine(native, factor)
        n = len(heights)
        operator = kind((n, n), (1 / n, 1 / n), 1.0)
        steps = sweep(operator, heights.max() - heights, Load("force", LOADS), tolerance=1e-7)
        quantities.append([measured(contact) for contact in steps])
    return np.array(quantities)


def errors(shortest: int) -> np.ndarray:
    """Return relative errors on all grids but the finest, (surfaces, grids, loads, quantities)."""
    rows = []
    for hurst, roll_off, periodic in SURFACES:
        values = on_grids(hurst, roll_off, periodic, shortest)
        order = np.array(list(ORDERS.values()))
        true = values[-1] + (values[-1] - values[-2]) / (2**order - 1)
        # one truth for the three estimators of the area
        true[:, :2] = true[:, 2:3]
        rows.append(values[:-1] / true - 1)
    return np.array(rows)


# %% [markdown]
# The grids are named by their cells per shortest wave.


# %%
def table() -> list[list[str]]:
    """Return a row for each number of cells per shortest wave and the range of loads."""
    by_cutoff = {shortest: errors(shortest) for shortest in (2, 4)}
    rows = [["cells per shortest wave", "loads / (E\\* A0 h')", *ORDERS]]
    for shortest, quantities in by_cutoff.items():
        for grid, factor in enumerate(FACTORS[:-1]):
            for loads, load_range in ((slice(0, 3), "0.001 to 0.01"), (slice(3, 6), "0.03 to 0.2")):
                part = quantities[:, grid, loads].reshape(-1, len(ORDERS))
                cells = [
                    f"{100 * mean:+.2f} ± {100 * spread:.2f} %"
                    for mean, spread in zip(part.mean(axis=0), part.std(axis=0), strict=True)
                ]
                rows.append([f"{shortest * factor} (cutoff {shortest} points)", load_range, *cells])
    return rows


if __name__ == "__main__":
    rewrite(PAGE, {"rough-areas": table})
