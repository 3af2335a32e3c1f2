"""Rough lines whose springs yield, under a path of loads.

The readings of `reduced.plasticity.caps` need a radius of curvature R1 at each spring, and a rough
line has none that is always defined (`reduced.rough.regions.line_stress`):

- "own_curvature": -1/h'' at the point; where the line is straight or concave there is no stress by
  (19.37), and the spring stays elastic.
- "one_radius": that of the parabola of the connected contact's length and depth, l^2/(8 delta_max),
  with "stress" only. A contact in full yield then has the mean pressure (pi/4) H on its area
  (19.29). With "elastic_root" the forces would fall as contacts deepen.

The line less what its springs have lost is a rough line in elastic contact: its force and its area
are those of that line. Along it the springs unload, and yield again beyond the deepest penetration.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.optimize import brentq

from reduced.arguments import choice_faults, positive_faults, refuse
from reduced.errors import ConvergenceError
from reduced.loads import Load, LoadPath
from reduced.plasticity.caps import READINGS, Reading, elastic_limit, is_forced
from reduced.rough.lines import RoughLines
from reduced.rough.press import LineContact, press
from reduced.rough.regions import RULES, curvature, regions

# Penetrations and deflections that agree so well are the same.
_SAME = 1e-6
# How often a penetration is doubled until the springs carry a force.
_DOUBLINGS = 60


@dataclass(frozen=True)
class YieldedLines:
    """Contact of m lines at k loads of a path; every array has shape (m, k).

    `contact` is the elastic contact of the lines less what they have lost; its penetrations count
    from the first touch of the lines as they were. `residual_depth` is where contact would be lost
    if it were unloaded from here, `plastic_share` the share of the points in contact whose springs
    carry all they can.
    """

    contact: LineContact
    residual_depth: np.ndarray
    plastic_share: np.ndarray


@dataclass(frozen=True)
class Yielding:
    """How springs yield: reading of the yield criterion, rule for the radius of curvature."""

    effective_modulus: float
    hardness: float
    reading: Reading = "stress"
    rule: str = "one_radius"
    edges: str = "sub_cell"

    def __post_init__(self) -> None:
        faults = positive_faults(
            effective_modulus=self.effective_modulus, hardness=self.hardness
        ) + choice_faults("reading", self.reading, READINGS)
        faults += choice_faults("rule", self.rule, RULES)
        if self.reading == "elastic_root" and self.rule == "one_radius":
            faults.append("one_radius is for the reading 'stress' only")
        refuse(faults)


def walk(lines: RoughLines, springs: Yielding, path: LoadPath) -> YieldedLines:
    """Follow a path of penetrations or forces on every line.

    A parabola in full yield has the mean pressure (pi/4) H:

    >>> x = np.arange(-200, 200) / 100
    >>> ball = RoughLines(-x * x / 2, 0.01, periodic=False)
    >>> soft = Yielding(1.0, 1e-4)
    >>> pressed = walk(ball, soft, LoadPath("penetration", 0.5)).contact
    >>> round(float(pressed.force[0, 0] / pressed.contact_area[0, 0]) / 1e-4, 3)
    0.785
    """
    control = "force" if is_forced(path, "line") else "penetration"
    steps = []
    for row in range(len(lines)):
        line = _Line(lines[row], springs)
        steps += [line.step(control, float(load)) for load in path.values]
    contacts, left, share = zip(*steps, strict=True)
    shape = len(lines), len(path.values)
    columns = (
        np.concatenate([getattr(c, f.name) for c in contacts]).reshape(shape)
        for f in fields(LineContact)
    )
    contact = LineContact(*columns)
    return YieldedLines(contact, np.reshape(left, shape), np.reshape(share, shape))


class _Line:
    """A single line with the memory of its springs."""

    def __init__(self, line: RoughLines, springs: Yielding) -> None:
        self.line, self.springs = line, springs
        self.gap = line.single().max() - line.single()
        self.bend = curvature(line)
        self.lost, self.deepest = np.zeros(self.gap.shape), 0.0

    def step(self, control: str, load: float) -> tuple[LineContact, float, float]:
        """Go to the next load; return the contact, what would remain, and the share that yields."""
        depth = load
        if control == "force":
            depth = float(self._pressed(self.lost, "force", load).penetration[0, 0])
        if control == "force" and (self._shortened(depth)[0] > self.lost).any():
            depth = self._depth(load, depth)
        lost, full = self._shortened(depth)
        touching = int(np.count_nonzero(depth - self.gap > lost))
        self.lost, self.deepest = lost, max(self.deepest, depth)
        value = load if control == "force" else depth - self._left(lost)
        share = np.count_nonzero(full) / touching if touching else 0.0
        return self._pressed(lost, control, value), self._left(lost), share

    def _left(self, lost: np.ndarray) -> float:
        return float((self.gap + lost).min())

    def _shortened(self, depth: float) -> tuple[np.ndarray, np.ndarray]:
        """Return what the springs will have lost at a penetration, and which are at their cap."""
        if depth < self.deepest * (1 - _SAME) or depth <= 0:
            return self.lost, np.zeros(self.gap.shape, dtype=bool)
        total = depth - self.gap
        springs, bend = self.springs, self.bend
        if springs.rule == "one_radius":
            contacts = regions(self.line, depth, edges=springs.edges)
            deepest = np.zeros(contacts.lengths.size)
            np.maximum.at(deepest, contacts.region, contacts.deflection)
            bend = np.zeros(self.gap.shape)
            bend[contacts.points] = (8 * deepest / contacts.lengths**2)[contacts.region]
        radius = np.divide(1.0, bend, out=np.full(bend.shape, np.inf), where=bend > 0)
        root = np.pi * springs.hardness / springs.effective_modulus * np.sqrt(radius / 2)
        limit = elastic_limit(springs.reading, root, total)
        lost = np.maximum(self.lost, total - limit)
        return lost, (lost > 0) & (total > lost) & (total - lost >= limit * (1 - _SAME))

    def _pressed(self, lost: np.ndarray, control: str, load: float) -> LineContact:
        """Return the elastic contact of the line less what it has lost, under a load above that."""
        line = RoughLines(self.line.heights - lost, self.line.spacing, self.line.periodic)
        left, springs = self._left(lost), self.springs
        if load > 0:
            load_of = Load(control, load)
            contact = press(line, springs.effective_modulus, load_of, edges=springs.edges)
            return replace(contact, penetration=contact.penetration + left)
        nothing = {f.name: np.zeros((1, 1)) for f in fields(LineContact)}
        depth = left + (load if control == "penetration" else 0.0)
        nothing["penetration"] = np.array([[depth]])
        nothing["mean_gap"] = np.array([[float((self.gap + lost).mean()) - depth]])
        return LineContact(**nothing)

    def _depth(self, force: float, least: float) -> float:
        """Return the penetration at a force that some springs yield under."""

        def excess(depth: float) -> float:
            lost, _ = self._shortened(depth)
            pressed = self._pressed(lost, "penetration", depth - self._left(lost))
            return float(pressed.force[0, 0]) - force

        high = least
        for _ in range(_DOUBLINGS):
            high *= 2
            if excess(high) >= 0:
                return float(brentq(excess, least * (1 - 1e-9), high, xtol=1e-12 * high))
        raise ConvergenceError("the springs never carry this force")
