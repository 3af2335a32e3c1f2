"""Springs with friction on any path of penetration and tangential displacement, event by event.

The gap is linear between the points of the line, and so are the friction bounds +-(d - g) and the
tangential forces of springs that stick or slip together. A step of the path changes d and u in
proportion. During the step a spring that makes contact starts without tangential force, one that
reaches its bound stays on it, and one that loses contact forgets its force. As rates are constant,
the end of the step determines the result:

    t -> clip(t + v, -w, w)                   springs in contact throughout, w = d - g at the end,
    t  = clip(v (d - g)/(d - d_before), -w, w)    springs touched in the step,

with v = G* u/(mu E*) the increment and t = f_x/(mu E* dx). Where a boundary of contact or slip is
between two points, a knot is inserted, so the forces are exact for the piecewise linear gap and
converge as dx^2 for a curved one. Knots inside a slipping or free part are removed, so their number
is bounded by the boundaries in the memory of the path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reduced.errors import positive_faults, refuse
from reduced.friction.slide import Friction
from reduced.loads import LoadPath


@dataclass(frozen=True)
class LinePath:
    """Response at the points of a path; all arrays have shape (k,).

    `stick_length` is the part of `contact_length` with springs below their bounds, `elastic_energy`
    is normal and tangential, and `knots` is the number of points of the state.
    """

    penetration: np.ndarray
    tangential_displacement: np.ndarray
    force: np.ndarray
    tangential_force: np.ndarray
    contact_length: np.ndarray
    stick_length: np.ndarray
    elastic_energy: np.ndarray
    knots: np.ndarray


@dataclass
class _State:
    """Knots: position, gap, tangential force t, and whether the knot is a point of the line."""

    place: np.ndarray
    gap: np.ndarray
    traction: np.ndarray
    is_point: np.ndarray

    def split(self, zero: np.ndarray) -> np.ndarray:
        """Insert knots where a function, linear between knots, is zero; return their indices."""
        sign = np.sign(zero)
        first = np.flatnonzero(sign[:-1] * sign[1:] < 0)
        share = zero[first] / (zero[first] - zero[first + 1])
        for name in ("place", "gap", "traction"):
            values = getattr(self, name)
            between = values[first] + share * (values[first + 1] - values[first])
            setattr(self, name, np.insert(values, first + 1, between))
        self.is_point = np.insert(self.is_point, first + 1, False)
        return first + 1 + np.arange(first.size)

    def advance(self, before: float, d: float, step: float) -> None:
        """Move to penetration d and by v = step, and update the tangential forces."""
        for level in (before, d):
            new = self.split(self.gap - level)
            self.gap[new] = level
        for side in (-1.0, 1.0):
            trial = self._unslipped(before, d, step)
            self.split(np.where(self.gap <= d, trial - side * (d - self.gap), 0.0))
        trial = self._unslipped(before, d, step)
        width = np.maximum(d - self.gap, 0.0)
        self.traction = np.clip(trial, -width, width)
        # inner knots of a free or slipping part go
        sign = np.where(width > 0, np.sign(trial) * (np.abs(trial) >= width), 2.0)
        same = (sign[1:-1] == sign[:-2]) & (sign[1:-1] == sign[2:]) & (sign[1:-1] != 0)
        kept = np.concatenate([[True], ~same | self.is_point[1:-1], [True]])
        for name in ("place", "gap", "traction", "is_point"):
            setattr(self, name, getattr(self, name)[kept])

    def _unslipped(self, before: float, d: float, step: float) -> np.ndarray:
        """Return the tangential forces if no spring slipped in the step."""
        if d <= before:
            return self.traction + step
        share = np.where(self.gap >= before, (d - self.gap) / (d - before), 1.0)
        return self.traction + step * share

    def sums(self, d: float) -> tuple[float, ...]:
        """Return integrals over the line in cells: w, t, contact and stick length, energies."""
        width, traction = np.maximum(d - self.gap, 0.0), self.traction
        cell = np.diff(self.place)
        in_contact = (width[:-1] > 0) | (width[1:] > 0)
        margin = (width - np.abs(traction)) * 2
        slips = margin[:-1] + margin[1:] <= 1e-12 * (width[:-1] + width[1:])

        def integral(values: np.ndarray) -> float:
            return float(np.sum((values[:-1] + values[1:]) / 2 * cell))

        def square(values: np.ndarray) -> float:
            first, last = values[:-1], values[1:]
            return float(np.sum((first * first + first * last + last * last) / 3 * cell))

        lengths = float(cell[in_contact].sum()), float(cell[in_contact & ~slips].sum())
        return (
            *(integral(width), integral(traction)),
            *lengths,
            *(square(width) / 2, square(traction) / 2),
        )


def follow(
    gap: ArrayLike,
    spacing: float,
    effective_modulus: float,
    friction: Friction,
    penetration: ArrayLike,
    tangential_displacement: ArrayLike,
    *,
    periodic: bool = False,
) -> LinePath:
    """Move a line with stick and slip along a path of penetration and displacement, shape (k,).

    Any sign and order; the path starts at d = 0 (or the negative first penetration), u = 0, and
    both change in proportion between two points.

    Parameters
    ----------
    gap : array_like, shape (n,)
        Gap over springs at distances `spacing` at first touch: a profile's height there, or the
        depth of a rough line below its highest peak; finite, n >= 2.
    periodic : bool
        Whether the last point is a neighbour of the first; a free line ends half a cell beyond its
        outer points, at constant height.

    Examples
    --------
    A flat punch, pressed and shifted simultaneously with u G* < mu d E*: full stick.

    >>> flat = follow(np.zeros(4), 0.5, 1.0, Friction(0.8, 0.5), [1.0], [0.5])
    >>> flat.force, flat.tangential_force
    (array([2.]), array([0.8]))
    """
    wrong = positive_faults(spacing=spacing, effective_modulus=effective_modulus)
    shape = np.shape(gap)
    if len(shape) != 1 or shape[0] < 2 or not np.all(np.isfinite(gap)):
        wrong.append(f"gap must be finite, of shape (n,), n >= 2, got shape {shape}")
    refuse(wrong)
    depth = LoadPath("penetration", penetration).values
    shift = LoadPath("tangential_displacement", tangential_displacement).values
    if depth.shape != shift.shape:
        raise ValueError(
            "penetration and tangential_displacement must be lists of one length, "
            f"got shapes {depth.shape} and {shift.shape}"
        )
    gap = np.asarray(gap, dtype=float)
    place = np.arange(gap.size, dtype=float)
    if periodic:
        place, gap = np.append(place, gap.size), np.append(gap, gap[0])
    else:
        place = np.concatenate([[-0.5], place, [gap.size - 0.5]])
        gap = np.concatenate([gap[:1], gap, gap[-1:]])
    state = _State(place, gap.copy(), np.zeros(gap.size), np.ones(gap.size, dtype=bool))
    mu = friction.coefficient
    ratio = friction.tangential_modulus / (mu * effective_modulus)
    before = min(depth[0], 0.0)
    rows = []
    for d, step in zip(depth, np.diff(ratio * shift, prepend=0.0), strict=True):
        state.advance(before, d, step)
        rows.append([*state.sums(d), state.place.size])
        before = d
    normal, tangential, contact, stick, energy, energy_x, knots = np.array(rows).T
    unit = effective_modulus * spacing
    energy = unit * (energy + mu / ratio * energy_x)
    return LinePath(
        *(depth, shift, unit * normal, mu * unit * tangential),
        *(spacing * contact, spacing * stick, energy, knots.astype(int)),
    )
