"""Distributions of a rough line on springs: pressures, gaps and sizes of contacts.

A region of length l stands for a round contact of the area (pi/4) l^2 (19.29), and a stretch dx of
it for (pi/4) l dx, which carries the force of its springs: the pressure is E* delta/((pi/4) l).
Force and area of all stretches add up to those of the line. Between its points the line is
straight, so both densities tend to constants at zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from comparisons.tasks.distributions import Stretches, of_values, wanted
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.rough.lines import RoughLines
from reduced.rough.regions import Regions, regions

# Lines that distributions are taken of: the mean of three hundred scatters by some per cent.
MOST_LINES = 300


class Springs(NamedTuple):
    """What the stretches of a line have: E*, and how contacts end."""

    modulus: float
    edges: str


def put_distributions(
    solution: Solution, task: Task, lines: RoughLines, springs: Springs, depths: np.ndarray
) -> None:
    """Store the distributions that a task asks for, of the first lines at the last load.

    Parameters
    ----------
    solution : Solution
    task : Task
    lines : RoughLines
    springs : Springs
    depths : ndarray, shape (lines,)
        Penetrations at the last load.
    """
    names = wanted(task)
    if not names or task.realisations[0] >= MOST_LINES:
        return
    for row, depth in enumerate(depths[:MOST_LINES]):
        values = line_values(lines[row], springs, float(depth), task.geometry.size)
        solution.put_distributions(row, of_values(task, {name: values[name] for name in names}))


def line_values(
    line: RoughLines, springs: Springs, depth: float, size: tuple[float, float]
) -> dict[str, Stretches]:
    """Return pressures, gaps and sizes of a line; weights as of a surface of the given sides."""
    contacts = regions(line, depth, edges=springs.edges)
    first, last, width, region = _stretches(line, depth, contacts)
    touching = region >= 0
    share = np.pi / 4 * contacts.lengths[region[touching]]
    stiff = springs.modulus / share
    area = size[0] * size[1]
    return {
        "pressure_distribution": Stretches(
            first[touching] * stiff,
            last[touching] * stiff,
            share * width[touching] / line.length**2,
        ),
        "gap_distribution": Stretches(-first, -last, width / line.length),
        "contact_sizes": Stretches.points(np.pi / 4 * contacts.lengths**2, area / line.length**2),
    }


def _stretches(
    line: RoughLines, depth: float, contacts: Regions
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return deflections at both ends of each stretch, its width, and its region (-1: none).

    A free line goes on for half a cell beyond its outer points, at their height.
    """
    heights = line.single()
    delta = heights - heights.max() + depth
    label = np.full(len(delta), -1)
    label[contacts.points] = contacts.region
    if line.periodic:
        begin, end = np.arange(len(delta)), np.roll(np.arange(len(delta)), -1)
        width = np.full(len(delta), line.spacing)
    else:
        points = np.arange(len(delta))
        begin, end = np.concatenate([[0], points]), np.concatenate([points, points[-1:]])
        width = np.full(len(delta) + 1, line.spacing)
        width[[0, -1]] /= 2
    return delta[begin], delta[end], width, np.maximum(label[begin], label[end])
