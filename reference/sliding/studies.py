"""Sliding contacts on several grids: values with an error bar."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse
from reference.errors import ConvergenceError
from reference.loads import Load
from reference.sliding.rubber import SlidingContact, slide_on_rubber
from reference.sliding.travelling import Travelling
from reference.viscoelastic.materials import GeneralisedMaxwell

Array = NDArray[np.float64]

_COARSE = 24  # cells across the window on which a depth is determined from a force
_SECANTS = 30


@dataclass(frozen=True)
class GridStudy:
    """One quantity on three grids with successively halved spacing.

    Attributes
    ----------
    values : ndarray, shape (3,)
        Values from coarse to fine.
    estimate : float
        Extrapolated value with the observed order, limited to [1, 2]; the finest value if the
        changes have different signs.
    uncertainty : float
        Change from the second grid to the third, or half of the previous change if larger: an upper
        bound of the remaining error at order 1, the lowest order at contact edges.
    """

    values: Array
    estimate: float
    uncertainty: float

    @classmethod
    def of(cls, values: list[float]) -> GridStudy:
        """Return the study of three values."""
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
        The prescribed quantity is constant.
    contacts : list of SlidingContact
        Contacts on the three grids.
    """

    penetration: GridStudy
    force: GridStudy
    friction_coefficient: GridStudy
    contacts: list[SlidingContact]


def paraboloid(
    radius: float,
    material: GeneralisedMaxwell,
    speed: float,
    load: Load,
    cells: int = 96,
) -> SlidingParaboloid:
    """Return the sliding of a rigid paraboloid f = r^2/(2R) on a viscoelastic half-space, nu = 1/2.

    The grid is a square around |x|, |y| <= sqrt(2 R d), which contains the contact. If the
    relaxation length v tau is below a cell, friction is of the order of the grid's error; the exact
    limit is mu = (eta/G) v/R, eta = sum G_i tau_i, G relaxed (half of that of the reduced model,
    which counts slopes in all directions).

    Parameters
    ----------
    radius : float
        R.
    material : GeneralisedMaxwell
        A solid.
    speed : float
        v.
    load : Load
        Force or penetration, one value.
    cells : int
        Cells across the window of the finest of three grids; a multiple of 16.

    Returns
    -------
    SlidingParaboloid

    Raises
    ------
    ValueError
        Lists all invalid arguments.
    ConvergenceError
        If a contact does not converge, or no depth carries the force.
    """
    if cells < 48 or cells % 16:
        raise ValueError(f"cells must be a multiple of 16, at least 48, not {cells!r}")
    refuse(positive_faults(radius=radius))

    def gap(x: Array, y: Array) -> Array:
        return (x**2 + y**2) / (2 * radius)

    def reach(depth: float) -> tuple[float, float]:
        return (float(np.sqrt(2 * radius * depth)),) * 2

    depth = window_depth(gap, reach, material, speed, load)
    contacts = [
        slide_shape(gap, reach(depth), material, speed, count, load)
        for count in (cells // 4, cells // 2, cells)
    ]
    depth_study, force_study, friction_study = (
        GridStudy.of([getattr(contact, name) for contact in contacts])
        for name in ("penetration", "force", "friction_coefficient")
    )
    return SlidingParaboloid(depth_study, force_study, friction_study, contacts)


def slide_shape(
    gap: Callable[[Array, Array], Array],
    window: tuple[float, float],
    material: GeneralisedMaxwell,
    speed: float,
    cells: int,
    load: Load,
) -> SlidingContact:
    """Return the sliding of a shape on square cells around the origin, with slopes over a cell.

    Parameters
    ----------
    gap : callable
        g(x, y).
    window : (float, float)
        Half-widths that contain the contact.
    cells : int
        Cells across the wider side of the window; the other side has the necessary number, up to 8
        more.
    material, speed, load
        As for `rubber.slide_on_rubber`.
    """
    step = 2 * max(window) / cells
    shape = [8 * max(1, int(np.ceil(half / (4 * step) - 1e-9))) for half in window]
    rows, columns = (np.asarray((np.arange(n) - (n - 1) / 2) * step, float) for n in shape)
    x, y = rows[:, None], columns[None, :]
    slope = (gap(x + step / 2, y) - gap(x - step / 2, y)) / step
    operator = Travelling((shape[0], shape[1]), (step, step), material, speed)
    return slide_on_rubber(operator, gap(x, y), load, slope=slope)


def window_depth(
    gap: Callable[[Array, Array], Array],
    reach: Callable[[float], tuple[float, float]],
    material: GeneralisedMaxwell,
    speed: float,
    load: Load,
) -> float:
    """Return a depth whose overlap contains the contact: the penetration, or 5 % above the need.

    The depth of a force is computed on a coarse grid, by secant steps in logarithms.

    Raises
    ------
    ValueError
        If not exactly one load is given, or it is not positive.
    ConvergenceError
        If no depth carries the force.
    """
    force = load.single()
    if load.one_of("force", "penetration") == "penetration":
        return force

    def excess(depth: float) -> float:
        contact = slide_shape(
            gap, reach(depth), material, speed, _COARSE, Load("penetration", depth)
        )
        return float(np.log(contact.force / force))

    # a disc of E* under the force: 2 E* a d, with the overlap's own width for a
    depth = 1.0
    for _ in range(_SECANTS):
        depth = force / (8 * material.equilibrium_modulus * max(reach(depth)))
    history: list[float] = []
    exponent, before = 1.5, None
    for _ in range(_SECANTS):
        ratio = excess(depth)
        history.append(abs(ratio))
        if history[-1] < 0.01:
            return 1.05 * depth
        if before is not None and ratio != before[1]:
            slope = (ratio - before[1]) / float(np.log(depth / before[0]))
            exponent = min(max(slope, 0.5), 3.0)
        before = depth, ratio
        depth *= float(np.exp(-ratio / exponent))
    raise ConvergenceError("no depth of the shape carries the force", history)
