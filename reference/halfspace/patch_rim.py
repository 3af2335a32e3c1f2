r"""Contact that the rim of a free patch cuts off: what whole cells leave out there.

Pressure does not fall to zero there, it is singular as at the edge of a flat face, and whole cells
act as a face whose edge is e = 0.175 cells inside theirs (`edge_cells.EDGE_OFFSET`). At the same
depth the patch carries the load of that strip besides. An edge with p = K / sqrt(2 pi t) gains
elastic energy K^2/(2 E*) as it moves by a unit of length; the mean pressure p_r of a cell h wide
there stands for K^2 = 2 c h p_r^2, c = 1.724 (`edge_cells.EDGE_COMPLIANCE`). Differentiated along
the load:

    dF = (e c/E*) sum over the rim of h^2 l p_r x_r,    x = dp/dd,

with l the length of a cell along the rim, x the response of the fixed contact to a unit of depth,
and a cell in a corner counted half for either side. No number is fitted. At the same load the
penetration is less by dF/k, with k the stiffness: that is all of the first order in h that
penetrations of free patches have. Patches of 16 to 32 points on grids of 4 and
8 cells to a point then err by .10 and .035 % (median of fifty, loads of .002 to .2 E* A0 h'), with
the strip left out by .23 and .11 %.

Of the mean gap at the same depth the load on the strip adds little, for beside it the surface is
held by contact and beyond it the patch has ended: (1 - 0.85) of what as much load spread over the
contact would. That share is measured, on fifty patches, and leaves a third of the first order at
the heaviest loads, where a tenth of the surface is open.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special

from reference.contact.press import Contact
from reference.halfspace.areas import Response
from reference.halfspace.edge_cells import EDGE_COMPLIANCE, EDGE_OFFSET

# Share of the mean displacement of a load that it does not give where the strip carries it.
HELD = 0.85


@dataclass(frozen=True)
class WholePatch:
    """Quantities with the load on the strip."""

    penetration: float
    force: float
    mean_gap: float
    contact_area: float


def reaches_rim(mask: NDArray[np.bool_]) -> bool:
    """Whether contact reaches the rim of a grid."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())


def uncounted_cells(contact: Contact, hardness: float = np.inf) -> float:
    """Return the cells by which counting is too many, at a given load.

    The load of the strip is carried elsewhere, where the area grows with it: as many times d ln
    A/d ln F of the strip are not counted. Cells under the hardness have no singular pressure.
    """
    ends = contact.mask & (contact.pressure < hardness)
    number = sum(np.count_nonzero(ends[at]) for at, _ in _sides(contact))
    return EDGE_OFFSET * _growth(contact.mask) * number


def on_whole_patch(contact: Contact, response: Response, control: str, area: float) -> WholePatch:
    """Return the contact with the load on the strip.

    Parameters
    ----------
    contact : Contact
        Elastic, of a free patch.
    response : Response
        Of its contact cells to a unit of depth.
    control : {"force", "penetration", "mean_gap"}
        What was prescribed, and stays.
    area : float
        Its area, at its force.
    """
    extra = 0.0
    for at, across in _sides(contact):
        product = contact.pressure[at] * response.pressure[at]
        extra += across * float(product.sum() - (product[0] + product[-1]) / 2)
    operator = contact.operator
    extra *= EDGE_OFFSET * EDGE_COMPLIANCE * operator.cell_area / operator.effective_modulus
    depth, spread = extra / response.stiffness, response.mean_displacement
    # at the same depth, then along the curve to what was prescribed
    opened = (1 - HELD) * spread * depth
    further = -depth if control == "force" else 0.0
    if control == "mean_gap":
        further = opened / (1 - spread)
    more = extra + response.stiffness * further if control != "force" else 0.0
    return WholePatch(
        penetration=contact.penetration + further,
        force=contact.force + more,
        mean_gap=contact.mean_gap + opened - (1 - spread) * further,
        contact_area=area * (1 + _growth(contact.mask) * more / contact.force),
    )


def _growth(mask: NDArray[np.bool_]) -> float:
    """Return d ln A/d ln F: 1 at light loads, 0 at full contact.

    Of random surfaces, A/A0 = erf(x), x in proportion to F (B. N. J. Persson, J. Chem. Phys. 115
    (2001) 3840).
    """
    share = np.count_nonzero(mask) / mask.size
    x = special.erfinv(share)
    return float(2 / np.sqrt(np.pi) * x * np.exp(-(x**2)) / share) if share < 1 else 0.0


def _sides(contact: Contact) -> Iterator[tuple[Any, float]]:
    """Yield where the cells along each side of a grid are, and their size across it."""
    across, along = contact.operator.spacing
    yield from ((np.s_[0], across), (np.s_[-1], across))
    yield from ((np.s_[:, 0], along), (np.s_[:, -1], along))
