"""Connected contacts of a rough line at one depth, and the local stress rule."""

from dataclasses import dataclass

import numpy as np

from reduced.errors import choice_faults, finite_faults, positive_faults, refuse
from reduced.loads import EDGES
from reduced.rough.press import RoughLines

RULES = ("own_curvature", "one_radius")


@dataclass(frozen=True)
class Regions:
    """Contact of one line at one penetration, region by region and point by point."""

    lengths: np.ndarray  # (regions,), lengths l_j; (pi/4) l_j^2 is the area of a region (19.29)
    # points, region, deflection: (m,), indices of the points in contact, their regions, and
    # spring deflections delta there
    points: np.ndarray
    region: np.ndarray
    deflection: np.ndarray


@dataclass(frozen=True)
class LineStress:
    """Stress (19.37) at the m points of a rough line in contact, 0 without a real value.

    `undefined_share` is the fraction of contact points without a real value; 0 without contact.
    """

    pressure: np.ndarray
    valid: np.ndarray
    undefined_share: float
    regions: Regions


def regions(line: RoughLines, penetration: float, *, edges: str = "sub_cell") -> Regions:
    """Return the connected contacts of a line, as counted by `rough.press.press`.

    Contacts at d after first touch end where the linear interpolant meets the surface ("sub_cell"),
    or half a cell beyond the last spring ("nodal").

    >>> regions(RoughLines([0.0, 1.0, 0.0, 0.0], 1.0), 0.5).lengths
    array([1.])
    """
    h, spacing, periodic = line.single(), line.spacing, line.periodic
    refuse(choice_faults("edges", edges, EDGES) + finite_faults(penetration=penetration))
    n = h.size
    delta = h - h.max() + penetration
    touching = delta > 0
    if touching.all():
        return Regions(np.array([n * spacing]), np.arange(n), np.zeros(n, int), delta)
    # Start from a point out of contact, so that no contact of a periodic line is divided.
    start = int(np.argmin(touching)) if periodic else 0
    order = np.roll(np.arange(n), -start)
    inside = touching[order]
    opens = inside & ~np.concatenate([[False], inside[:-1]])
    closes = inside & ~np.concatenate([inside[1:], [False]])
    first, last = np.flatnonzero(opens), np.flatnonzero(closes)
    lengths = (last - first).astype(float)
    if edges == "nodal":
        lengths += 1.0
    else:
        along = delta[order]
        for ends, step in ((first, -1), (last, 1)):  # how far contacts reach into the next cell
            beyond = ends + step
            outside = along[beyond % n]
            part = along[ends] / np.where(outside <= 0, along[ends] - outside, 1.0)
            off_line = (beyond < 0) | (beyond >= n)
            lengths += part if periodic else np.where(off_line, 0.5, part)
    region = (np.cumsum(opens) - 1)[inside]
    points = order[inside]
    return Regions(lengths * spacing, points, region, delta[points])


def line_stress(
    line: RoughLines,
    effective_modulus: float,
    penetration: float,
    *,
    rule: str = "own_curvature",
    edges: str = "sub_cell",
) -> LineStress:
    """Return the stress on a rough line by (19.37), sigma = E* sqrt(2 delta/R1)/pi.

    By the rule ``"own_curvature"`` R1 = -1/h'' at the point, by second differences: without a real
    value where the line is straight or concave, a large part of the contact on rough lines, and at
    the ends of a free line. By ``"one_radius"`` it is that of the parabola of the same length and
    depth as the region, R1 = l^2/(8 delta_max), which is always defined.
    """
    refuse(
        choice_faults("rule", rule, RULES) + positive_faults(effective_modulus=effective_modulus)
    )
    contacts = regions(line, penetration, edges=edges)
    if contacts.points.size == 0:
        return LineStress(np.zeros(0), np.zeros(0, bool), 0.0, contacts)
    if rule == "own_curvature":
        bend = curvature(line)[contacts.points]
    else:
        deepest = np.zeros(contacts.lengths.size)
        np.maximum.at(deepest, contacts.region, contacts.deflection)
        bend = (8 * deepest / contacts.lengths / contacts.lengths)[contacts.region]
    valid = bend > 0
    stress = effective_modulus / np.pi * np.sqrt(2 * contacts.deflection * np.where(valid, bend, 0))
    return LineStress(stress, valid, float(np.mean(~valid)), contacts)


def curvature(line: RoughLines) -> np.ndarray:
    """Return -h'' of a single line by second differences; 0 (no radius) at the ends of a free one.

    >>> curvature(RoughLines([0.0, 1.0, 0.0, 0.0], 0.5)).tolist()
    [-4.0, 8.0, -4.0, 0.0]
    """
    h, spacing = line.single(), line.spacing
    second = (2 * h - np.roll(h, 1) - np.roll(h, -1)) / spacing / spacing
    if not line.periodic:
        second[[0, -1]] = 0.0
    return second
