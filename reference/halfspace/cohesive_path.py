"""The whole equilibrium path of an adhesive contact: stable branches, folds, and what lies between.

Penetration and force along the path are followed by their common arc length, so that neither fold
stops the way; what a prescribed penetration or force does on it, jumps and hysteresis, is read off
afterwards. Folds are refined by parabolas through three points, whose error is of the third order
in the step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import ConvergenceError
from reference.halfspace.cohesive import CohesiveContact, CohesiveProblem, Constraint

Field = NDArray[np.float64]

_SHRINKS = 12
_MOST = 2000  # points of a way
_EASY, _ITERATIONS = 6, 30
# Sharper turns than this cosine are taken in smaller steps, down to those of a corner of the path:
# a step over a fold would land on another branch.
_TURN, _CORNER = 0.7, 0.05


@dataclass(frozen=True)
class CohesivePath:
    """Equilibria in the order of the path, from pressed on to parted; arrays of shape (k,).

    Attributes
    ----------
    penetration, force : ndarray
        d and F.
    contact_area : ndarray
        Area of the cells in contact.
    points : tuple of CohesiveContact
        The equilibria themselves.
    """

    penetration: Field
    force: Field
    contact_area: Field
    points: tuple[CohesiveContact, ...]

    def follow(self, control: str, loads: ArrayLike) -> list[tuple[int, float]]:
        """Where on the path a list of loads leads, from its parted end: (segment, part of it).

        A rising load moves towards the pressed end, a falling one towards the parted end, to the
        first place that carries the load: over folds that is a jump. Loads that nothing carries
        stay at the end.
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
        """Segment i and the part of it at which a straight line carries the load."""
        return i, float((load - curve[i]) / (curve[i + 1] - curve[i]))

    def _load(self, control: str) -> Field:
        if control not in ("force", "penetration"):
            raise ValueError(f"control must be 'force' or 'penetration', not {control!r}")
        return self.force if control == "force" else self.penetration

    def pull_off(self, control: str = "force") -> tuple[float, float] | None:
        """Penetration and force at which a falling load is lost; None where the path has no fold.

        The lowest fold on the way down: under penetration control a force of long range falls to
        nothing without any.
        """
        load = self._load(control)
        folds = np.flatnonzero((load[1:-1] <= load[:-2]) & (load[1:-1] < load[2:])) + 1
        return self._around(load, int(folds[np.argmin(load[folds])])) if folds.size else None

    def snap_in(self) -> tuple[float, float] | None:
        """Penetration and force at which an approaching body jumps into contact; None: it does not.

        The last maximum of the penetration on the path, the first on the way in.
        """
        load = self.penetration
        folds = np.flatnonzero((load[1:-1] >= load[:-2]) & (load[1:-1] > load[2:])) + 1
        return self._around(load, int(folds[-1])) if folds.size else None

    def _around(self, load: Field, at: int) -> tuple[float, float]:
        """Penetration and force where the parabola of the load about a point is extreme."""
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
    """Where the way of an adhesive contact ends, in shares of its lowest force.

    Parameters
    ----------
    parted : float
        Without contact, where the force has fallen to this share.
    risen : float
        Where the force has risen again by this share: enough, if only the pull-off force is wanted.
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
    """Follow the equilibria from a penetration at which the body is pressed on until it is parted.

    Parameters
    ----------
    problem : CohesiveProblem
    penetration : float
        Where to begin.
    lowest : float
        Penetration below which nothing is of interest.
    steps : int
        Points between the two on a straight way; folds and jumps of the grid take more.
    tolerance : float
        Of every equilibrium, see `CohesiveContact.residual`.
    ending : Ending
        Where the way ends.

    Returns
    -------
    CohesivePath

    Raises
    ------
    ConvergenceError
        If the path is lost: the grid is too coarse for the range of the law.
    """
    first = problem.at_penetration(penetration, tolerance=tolerance, max_iterations=100)
    stride = (penetration - lowest) / steps
    units = stride, problem.stiffness(first) * stride
    points = [first]
    previous = problem.at_penetration(penetration - stride, first.pressure, tolerance)
    points.append(previous)
    length = 1.0
    while not _ended(points, lowest, ending):
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


def _ended(points: list[CohesiveContact], lowest: float, ending: Ending) -> bool:
    last = points[-1]
    pulled = min(point.force for point in points)
    if pulled < 0 and last.force - pulled > ending.risen * abs(pulled):
        return True
    if last.mask.any():
        return False
    return last.penetration < lowest or abs(last.force) <= ending.parted * abs(pulled)


def _way_behind(
    points: list[CohesiveContact], units: tuple[float, float]
) -> tuple[CohesiveContact, Field]:
    """Last point but those too close to tell the direction, and the way from it to the last."""
    last = points[-1]
    for before in reversed(points[:-1]):
        moved = last.penetration - before.penetration, last.force - before.force
        way = np.array(moved) / units
        if np.hypot(*way) >= _CORNER:
            break
    return before, way


def _next(
    problem: CohesiveProblem,
    points: list[CohesiveContact],
    units: tuple[float, float],
    length: float,
    tolerance: float,
) -> tuple[CohesiveContact, float]:
    """Equilibrium one step of arc length further, with as many halvings as it takes."""
    last = points[-1]
    before, way = _way_behind(points, units)
    done = float(np.hypot(*way))
    way /= done
    for _ in range(_SHRINKS):
        ratio = length / done
        pressure = last.pressure + ratio * (last.pressure - before.pressure)
        depth = last.penetration + length * way[0] * units[0]
        force = last.force + length * way[1] * units[1]
        # the plane across the way: (d - d_predicted, F - F_predicted) . way = 0
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
