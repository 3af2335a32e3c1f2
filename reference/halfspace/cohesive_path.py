"""The equilibrium path of an adhesive contact: stable branches, folds and unstable branches.

The path is followed by arc length in penetration and force, beyond folds of either; jumps and
hysteresis under prescribed penetration or force are derived from it afterwards. Folds are refined
by parabolas through three points, whose error is of the third order in the step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import ConvergenceError
from reference.halfspace.cohesive import CohesiveContact, CohesiveProblem, Constraint

Field = NDArray[np.float64]

_SHRINKS = 12
_MOST = 2000  # largest number of points of a path
_EASY, _ITERATIONS = 6, 30
# Sharper turns than this cosine are taken in smaller steps, down to those of a corner of the path,
# because a step over a fold would reach another branch.
_TURN, _CORNER = 0.7, 0.05


@dataclass(frozen=True)
class CohesivePath:
    """Equilibria in the order of the path, from compression to separation; arrays of shape (k,).

    Attributes
    ----------
    penetration, force : ndarray
        d and F.
    contact_area : ndarray
        Area of the cells in contact.
    points : tuple of CohesiveContact
        The equilibria.
    """

    penetration: Field
    force: Field
    contact_area: Field
    points: tuple[CohesiveContact, ...]

    def follow(self, control: str, loads: ArrayLike) -> list[tuple[int, float]]:
        """Return the positions of loads on the path from separation: (segment, fraction of it).

        An increasing load moves towards compression, a decreasing one towards separation, to the
        first position with this load; across folds this is a jump. Loads without equilibrium stay
        at the end.
        """
        curve = self._load(control)
        place = (curve.size - 2, 1.0)
        places = []
        for load in np.asarray(loads, dtype=float):
            i, part = place
            now = curve[i] + part * (curve[i + 1] - curve[i])
            if load > now:
                ahead = np.flatnonzero(curve[: i + 1] >= load)
                place = self._between(curve, int(ahead[-1]), load) if ahead.size else (0, 0.0)
            elif load < now:
                ahead = np.flatnonzero(curve[i + 1 :] <= load)
                last = (curve.size - 2, 1.0)
                place = self._between(curve, i + int(ahead[0]), load) if ahead.size else last
            places.append(place)
        return places

    @staticmethod
    def _between(curve: Field, i: int, load: float) -> tuple[int, float]:
        """Return segment i and the fraction of it at which linear interpolation gives the load."""
        return i, float((load - curve[i]) / (curve[i + 1] - curve[i]))

    def _load(self, control: str) -> Field:
        if control not in ("force", "penetration"):
            raise ValueError(f"control must be 'force' or 'penetration', not {control!r}")
        return self.force if control == "force" else self.penetration

    def pull_off(self, control: str = "force") -> tuple[float, float] | None:
        """Return penetration and force at which a decreasing load is lost; None without a fold.

        It is the lowest fold on unloading; under penetration control, long-range attraction has
        none.
        """
        load = self._load(control)
        folds = np.flatnonzero((load[1:-1] <= load[:-2]) & (load[1:-1] < load[2:])) + 1
        return self._around(load, int(folds[np.argmin(load[folds])])) if folds.size else None

    def snap_in(self) -> tuple[float, float] | None:
        """Return penetration and force of the jump into contact on approach; None without a jump.

        It is the last maximum of the penetration on the path, the first on approach.
        """
        load = self.penetration
        folds = np.flatnonzero((load[1:-1] >= load[:-2]) & (load[1:-1] > load[2:])) + 1
        return self._around(load, int(folds[-1])) if folds.size else None

    def _around(self, load: Field, at: int) -> tuple[float, float]:
        """Return penetration and force at the extremum of a parabola of the load about a point."""
        three = slice(at - 1, at + 2)
        d, force = self.penetration[three], self.force[three]
        span_d, span_f = np.ptp(self.penetration), np.ptp(self.force)
        steps = np.hypot(np.diff(d) / span_d, np.diff(force) / span_f)
        s = np.array([-steps[0], 0.0, steps[1]])
        curve = np.polyfit(s, load[three], 2)
        extreme = -curve[1] / (2 * curve[0])
        place = [float(np.polyval(np.polyfit(s, part, 2), extreme)) for part in (d, force)]
        return place[0], place[1]


@dataclass(frozen=True)
class Ending:
    """End of the path of an adhesive contact, in fractions of its lowest force.

    Parameters
    ----------
    parted : float
        Without contact, the path ends when the force has decreased to this fraction.
    risen : float
        The path ends when the force has increased again by this fraction, which suffices for the
        pull-off force.
    """

    parted: float = 1e-3
    risen: float = np.inf


PARTED = Ending()


def trace(
    problem: CohesiveProblem,
    penetration: float,
    lowest: float,
    *,
    steps: int = 40,
    tolerance: float = 1e-7,
    ending: Ending = PARTED,
) -> CohesivePath:
    """Return the equilibria from a penetration in compression to separation.

    Parameters
    ----------
    problem : CohesiveProblem
    penetration : float
        Initial penetration.
    lowest : float
        Lowest penetration of interest.
    steps : int
        Points between the two on a straight path; folds and jumps of the grid take more.
    tolerance : float
        Tolerance of every equilibrium, see `CohesiveContact.residual`.
    ending : Ending
        End of the path.

    Returns
    -------
    CohesivePath

    Raises
    ------
    ConvergenceError
        If the path is lost, because the grid is too coarse for the range of the law.
    """
    first = problem.at_penetration(penetration, tolerance=tolerance, max_iterations=100)
    stride = (penetration - lowest) / steps
    units = stride, problem.stiffness(first) * stride
    points = [first]
    previous = problem.at_penetration(penetration - stride, first.pressure, tolerance)
    points.append(previous)
    length = 1.0
    while True:
        last, pulled = points[-1], min(point.force for point in points)
        risen = pulled < 0 and last.force - pulled > ending.risen * abs(pulled)
        parted = not last.mask.any() and (
            last.penetration < lowest or abs(last.force) <= ending.parted * abs(pulled)
        )
        if risen or parted:
            break
        if len(points) >= _MOST:
            raise ConvergenceError(
                f"the path has not ended after {_MOST} points: the grid may be too coarse "
                "for the range of the law",
                [],
            )
        contact, length = _next(problem, points, units, length, tolerance)
        points.append(contact)
        length = min(1.0, 1.5 * length) if contact.iterations <= _EASY else length
    return CohesivePath(
        np.array([point.penetration for point in points]),
        np.array([point.force for point in points]),
        np.array([point.mask.sum() for point in points]) * problem.operator.cell_area,
        tuple(points),
    )


def _next(
    problem: CohesiveProblem,
    points: list[CohesiveContact],
    units: tuple[float, float],
    length: float,
    tolerance: float,
) -> tuple[CohesiveContact, float]:
    """Return the equilibrium one step of arc length further, with bisections as needed."""
    last = points[-1]
    # an earlier point far enough to define the direction
    for before in reversed(points[:-1]):
        moved = last.penetration - before.penetration, last.force - before.force
        way = np.array(moved) / units
        if np.hypot(*way) >= _CORNER:
            break
    done = float(np.hypot(*way))
    way /= done
    for _ in range(_SHRINKS):
        ratio = length / done
        pressure = last.pressure + ratio * (last.pressure - before.pressure)
        depth = last.penetration + length * way[0] * units[0]
        force = last.force + length * way[1] * units[1]
        # the plane normal to the path: (d - d_predicted, F - F_predicted) . way = 0
        normal = way[0] / units[0], way[1] / units[1]
        plane = Constraint(*normal, normal[0] * depth + normal[1] * force)
        try:
            equilibrium = problem.newton(pressure, depth, plane, tolerance, _ITERATIONS)
        except ConvergenceError as failure:
            history = failure.history
        else:
            moved = (equilibrium.penetration - last.penetration, equilibrium.force - last.force)
            step = np.array(moved) / units
            if step @ way > _TURN * np.hypot(*step) or (length < _CORNER and step @ way > 0):
                return equilibrium, length
            history = [equilibrium.residual]
        length /= 2
    raise ConvergenceError(
        "the path of an adhesive contact was lost: the grid is too coarse for the range of the law",
        history,
    )
