"""Sliding contacts on several grids: values with an error bar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.sliding.contact import SlidingContact, solve
from reference.sliding.operators import Travelling
from reference.viscoelastic.materials import GeneralisedMaxwell

_COARSE = 24  # cells across the window on which a force is turned into a depth
_SECANTS = 30


@dataclass(frozen=True)
class GridStudy:
    """One quantity on three grids, each of half the spacing of the one before.

    Attributes
    ----------
    values : ndarray, shape (3,)
        Coarse to fine.
    estimate : float
        Extrapolated with the order that the three show, kept between 1 and 2; the finest value if
        the changes have different signs.
    uncertainty : float
        Change from the second grid to the third, or half of that before if it is larger: more than
        is left of the error at order 1, the least there is at the edges of a contact.
    """

    values: NDArray[np.float64]
    estimate: float
    uncertainty: float

    @classmethod
    def of(cls, values: list[float]) -> GridStudy:
        """Extrapolate three values."""
        coarse, middle, fine = values
        first, second = middle - coarse, fine - middle
        bar = max(abs(second), abs(first) / 2)
        if first * second <= 0:
            return cls(np.array(values), fine, bar)
        ratio = min(max(first / second, 2.0), 4.0)  # 2^order
        return cls(np.array(values), fine + second / (ratio - 1), bar)


@dataclass(frozen=True)
class SlidingParaboloid:
    """A paraboloid sliding steadily.

    Attributes
    ----------
    penetration, force, friction_coefficient : GridStudy
        The one that was prescribed does not change.
    contacts : list of SlidingContact
        On the three grids.
    """

    penetration: GridStudy
    force: GridStudy
    friction_coefficient: GridStudy
    contacts: list[SlidingContact]


def paraboloid(
    radius: float,
    material: GeneralisedMaxwell,
    speed: float,
    *,
    force: float | None = None,
    penetration: float | None = None,
    cells: int = 96,
) -> SlidingParaboloid:
    """Slide a rigid paraboloid f = r^2/(2R) over a viscoelastic half-space, nu = 1/2.

    The grid is a square around |x|, |y| <= sqrt(2 R d), outside of which nothing can touch. Where
    the way in which the material relaxes, v tau, is below a cell, friction is of the order of the
    grid's error: exactly, mu tends to (eta/G) v/R there, eta = sum G_i tau_i, G relaxed (half of
    what the reduced model says, which counts slopes in all directions).

    Parameters
    ----------
    radius : float
        R.
    material : GeneralisedMaxwell
        A solid.
    speed : float
        v.
    force, penetration : float
        Exactly one.
    cells : int
        Across the window of the finest of three grids; a multiple of 16.

    Returns
    -------
    SlidingParaboloid

    Raises
    ------
    ValueError
        Listing what is wrong.
    ConvergenceError
        From a contact, or if no depth was found for the window.
    """
    if cells < 48 or cells % 16:
        raise ValueError(f"cells must be a multiple of 16, at least 48, not {cells!r}")
    if not (np.isfinite(radius) and radius > 0):
        raise ValueError(f"radius must be positive and finite, not {radius!r}")
    if (force is None) == (penetration is None):
        raise ValueError("give exactly one of force, penetration")
    load = {"force": force, "penetration": penetration}
    # a little more than the depth on a coarse grid: the window only has to be large enough
    depth = penetration or 1.05 * _depth(radius, material, speed, force)
    window = np.sqrt(2 * radius * depth)
    contacts = [
        _on_window(radius, material, speed, window, count, load)
        for count in (cells // 4, cells // 2, cells)
    ]
    studies = (
        GridStudy.of([getattr(each, name) for each in contacts])
        for name in ("penetration", "force", "friction_coefficient")
    )
    return SlidingParaboloid(*studies, contacts)


def _on_window(
    radius: float,
    material: GeneralisedMaxwell,
    speed: float,
    window: float,
    count: int,
    load: dict[str, float | None],
) -> SlidingContact:
    step = 2 * window / count
    x = (np.arange(count) - (count - 1) / 2) * step
    operator = Travelling((count, count), (step, step), material, speed)
    gap = (x[:, None] ** 2 + x**2) / (2 * radius)
    slope = np.broadcast_to(x[:, None] / radius, gap.shape)
    return solve(operator, gap, slope=slope, **load)


def _depth(radius: float, material: GeneralisedMaxwell, speed: float, force: float) -> float:
    """Depth that carries a force on a coarse grid, secant steps in logarithms from Hertz's."""
    if not (np.isfinite(force) and force > 0):
        raise ValueError(f"force must be positive and finite, not {force!r}")
    modulus = 4 * material.equilibrium_modulus

    def carried(depth: float) -> float:
        window = np.sqrt(2 * radius * depth)
        load = {"penetration": depth}
        return _on_window(radius, material, speed, window, _COARSE, load).force

    depth = float((0.75 * force / (modulus * np.sqrt(radius))) ** (2 / 3))
    history: list[float] = []
    exponent, before = 1.5, None
    for _ in range(_SECANTS):
        ratio = np.log(carried(depth) / force)
        history.append(float(abs(ratio)))
        if history[-1] < 0.01:
            return depth
        if before is not None and ratio != before[1]:
            slope = (ratio - before[1]) / np.log(depth / before[0])
            exponent = min(max(slope, 0.5), 3.0)
        before = depth, ratio
        depth *= float(np.exp(-ratio / exponent))
    raise ConvergenceError("no depth of the paraboloid carries the force", history)
