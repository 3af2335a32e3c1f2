"""A half-space that is elastic and perfectly plastic: its pressure is capped at a hardness.

Cells under the hardness give way as far as the shape asks for: their displacement beyond the
elastic one is plastic, and stays (A. Almqvist, F. Sahlin, R. Larsson and S. Glavatskih, Tribol.
Int. 40 (2007) 574). At each load

    minimise  1/2 p.K p - p.(d - g - w)  over 0 <= p <= H,

w the plastic displacement so far; what p = H leaves of an overlap is added to it. The dented
surface, g + w, is in elastic contact at every step, along which it unloads and loads again. No
volume is kept: what sinks below a peak comes up nowhere.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array, Mask
from reference.contact.body import ElasticBody
from reference.contact.press import Contact, check_gap, press
from reference.errors import positive_faults, refuse
from reference.loads import Load, LoadPath

# Pressures that agree so well are the same: where contact is loaded again to where it was.
_SAME = 1e-6


@dataclass(frozen=True)
class Dent:
    """A contact with a half-space that has yielded, at one load of a path.

    `contact` is the elastic one with the dented surface: its initial gap is g + w. `sunk` is the
    plastic displacement w so far, `saturated` are the cells under the hardness. `work` of the force
    is by the trapezoidal rule over the steps, `dissipated` H int w so far.
    """

    contact: Contact
    sunk: Array
    saturated: Mask
    work: float
    dissipated: float

    @property
    def residual_depth(self) -> float:
        """Penetration at which contact is lost if the shape is lifted off from here."""
        gap = self.contact.initial_gap
        return float(gap.min() - (gap - self.sunk).min())

    @property
    def elastic(self) -> float:
        """Elastic energy, half of int p u."""
        contact = self.contact
        density = np.vdot(contact.pressure, contact.displacement)
        return float(0.5 * density * contact.operator.cell_area)

    @property
    def plastic_share(self) -> float:
        """Share of the cells in contact that are under the hardness."""
        return float(self.saturated.sum() / max(self.contact.mask.sum(), 1))


def along(
    body: ElasticBody, gap: ArrayLike, hardness: float, path: LoadPath, *, tolerance: float = 1e-8
) -> Iterator[Dent]:
    """Yield the contact at each load of a path of penetrations or forces.

    Penetrations count from first touch; forces must not be negative, nor more than the hardness
    carries. The tolerance is that of `reference.contact.press.press`.
    """
    control = path.one_of("penetration", "force")
    if control == "force" and (path.values < 0).any():
        raise ValueError("force must not be negative: nothing holds the shape")
    undented = check_gap(body, gap)
    faults = [] if hardness > 0 else [f"hardness must be positive, not {hardness!r}"]
    refuse(faults + positive_faults(tolerance=tolerance))
    nothing = np.zeros(body.shape)
    before = Contact(0.0, 0.0, nothing, 0, 0.0, body, undented)
    sunk, work = nothing, 0.0
    for load in path.values.tolist():
        # elastic contact with the surface as it is dented, its pressure capped
        dented = undented + sunk
        lowest = float(dented.min())
        if (load == 0) if control == "force" else (load <= lowest):
            depth = lowest if control == "force" else load
            contact = Contact(depth, 0.0, nothing, 0, 0.0, body, dented)
        else:
            start = before if before.mask.any() else None
            contact = press(
                body, dented, Load(control, load), cap=hardness, tolerance=tolerance, start=start
            )
        # overlaps under the hardness have become plastic
        overlap = np.where(contact.pressure >= hardness, np.maximum(-contact.gap, 0.0), 0.0)
        sunk = sunk + overlap
        whole = replace(contact, initial_gap=contact.initial_gap + overlap)
        whole = whole.with_displacement(contact.displacement)
        work += 0.5 * (contact.force + before.force) * (contact.penetration - before.penetration)
        yield Dent(
            whole,
            sunk,
            contact.pressure >= (1 - _SAME) * hardness,
            work,
            float(hardness * sunk.sum() * body.cell_area) if sunk.any() else 0.0,
        )
        before = whole
