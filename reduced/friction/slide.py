"""Tangential contact with Coulomb friction: independent springs 4G/(2 - nu) with stick and slip.

Each spring has the tangential stiffness G* dx with G* = 4 G/(2 - nu) (19.18) and slips where its
force would exceed mu times its normal force (19.19; Popov & Hess 2015, sec. 5.2). Here the normal
load is constant along any path of tangential force or displacement (`slide`), or the penetration
changes on the way, too (`follow`). Exact for every body of revolution, but for the coupling of
normal and tangential displacements and slip across the load (Jaeger 1995; docs/friction.md).

**Constant normal load.** A row of springs is a Prandtl-Ishlinskii model, determined by its first
loading curve phi: after a reversal every spring needs twice its threshold w(x) = d - g(x), so the
force changes from the turning point by 2 phi(half the displacement) (Masing 1926); a closed loop is
forgotten, and the interrupted curve continues (Madelung's rules; Visintin, *Differential Models of
Hysteresis*, 1994, sec. III); force and displacement may be exchanged, because phi increases. With w
= G* u/(mu E*) and T = F_x/(mu E*), phi(w) = N(d) - N(d - w), N = F/E* the normal law of the same
springs (Jaeger 1995; Ciavarella 1998; Popov & Hess 2015, sec. 5.3).

**Any path of penetration and tangential displacement.** The gap is linear between the points of the
line, and so are the friction bounds +-(d - g) and the tangential forces of springs that stick or
slip together. A step changes d and u in proportion: a spring that makes contact starts without
tangential force, one that reaches its bound stays on it, one that loses contact forgets its force.
As rates are constant, the end of the step determines the result:

    t -> clip(t + v, -w, w)                   springs in contact throughout, w = d - g at the end,
    t  = clip(v (d - g)/(d - d_before), -w, w)    springs touched in the step,

with v = G* u/(mu E*) the increment and t = f_x/(mu E* dx). Where a boundary of contact or slip is
between two points, a knot is inserted, so the forces are exact for the piecewise linear gap and
converge as dx^2 for a curved one. Knots inside a slipping or free part are removed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from reduced.errors import poisson_faults, positive_faults, refuse
from reduced.loads import Load, LoadPath
from reduced.rough.press import RoughLines, press
from reduced.springs.indent import indent
from reduced.springs.line import Springs

CONTROLS = ("tangential_displacement", "tangential_force")
_SPENT = 8 * np.finfo(float).eps  # tolerance for forces at the friction limit


@dataclass(frozen=True)
class TangentialPath:
    """Response along a tangential path at constant normal load.

    Arrays have shape (k,) for a single contact and (m, k) for m lines; `penetration` and `force`
    have one dimension less. The displacement is that of the indenter against the undeformed
    half-space. `stick_length` is twice the stick radius of a single contact; `stiffness` is
    dF_x/du, G* times it; `dissipation` is lost since the start of the path.
    """

    penetration: float | np.ndarray
    force: float | np.ndarray
    tangential_force: np.ndarray
    tangential_displacement: np.ndarray
    stick_length: np.ndarray
    stiffness: np.ndarray
    dissipation: np.ndarray


@dataclass(frozen=True)
class Friction:
    """Tangential springs of stiffness G* dx, with Coulomb's law (19.18), (19.19)."""

    tangential_modulus: float
    coefficient: float

    def __post_init__(self) -> None:
        wrong = positive_faults(tangential_modulus=self.tangential_modulus)
        refuse(wrong + positive_faults(coefficient=self.coefficient))


def tangential_modulus(shear_modulus: float, poisson_ratio: float) -> float:
    """Return G* = 4 G/(2 - nu), the stiffness of tangential springs per length (19.18).

    Two bodies: 1/G* = (2 - nu1)/(4 G1) + (2 - nu2)/(4 G2) (Popov & Hess 2015, eq. (5.2)).

    >>> tangential_modulus(3.0, 0.5)
    8.0
    """
    refuse(positive_faults(shear_modulus=shear_modulus) + poisson_faults(poisson_ratio))
    return 4 * shear_modulus / (2 - poisson_ratio)


def stiffness_ratio(poisson_ratio: float) -> float:
    """Return k_x/k_z = G*/E* = 2(1 - nu)/(2 - nu) of a sticking contact (19.18, Mindlin 1949).

    >>> round(stiffness_ratio(0.5), 12)
    0.666666666667
    """
    refuse(poisson_faults(poisson_ratio))
    return 2 * (1 - poisson_ratio) / (2 - poisson_ratio)


def slide(springs: Springs, friction: Friction, load: Load, path: LoadPath) -> TangentialPath:
    """Solve a single contact along any tangential path at constant normal load.

    The stick boundary is inside a cell like the edge of contact, so that tangential force and stick
    radius converge like normal force and radius: dx^4 for smooth profiles ("nodal": dx^2 and dx).

    The load, one penetration or force, is applied before the path begins. The path has
    ``"tangential_displacement"`` or ``"tangential_force"`` of any sign, monotone in between; under
    force control the displacement is the difference of two penetrations: for a force of 1e-12 mu F
    four digits remain.

    Cattaneo-Mindlin, stick radius c = a (1 - F_x/(mu F))^(1/3):

    >>> from reduced.profiles.equivalents import paraboloid
    >>> path = slide(Springs(paraboloid(1.0), 1.0), Friction(0.8, 0.5), Load("penetration", 1.0),
    ...              LoadPath("tangential_force", 7 / 12))
    >>> round(float(path.stick_length[0]) / 2, 12)
    0.5
    """
    path.one_of(*CONTROLS)
    load.single()
    normal = indent(springs, load)
    reduced = replace(springs, effective_modulus=1.0, spacing=normal.spacing)

    def at(kind: str, levels: np.ndarray) -> tuple[np.ndarray, ...]:
        contact = indent(reduced, Load(kind, levels))
        return contact.penetration, contact.force, 2 * contact.contact_radius, contact.energy

    modulus, depth, force = springs.effective_modulus, normal.penetration[0], normal.force[0]
    answers = _hysteresis(float(depth), force / modulus, at, path, modulus, friction)
    return TangentialPath(float(depth), float(force), *answers)


def slide_lines(
    lines: RoughLines,
    effective_modulus: float,
    friction: Friction,
    load: Load,
    path: LoadPath,
    *,
    edges: str = "sub_cell",
) -> TangentialPath:
    """Solve rough lines along any tangential path at constant normal load, that of one line.

    With ``"sub_cell"`` the line is straight between its points, and edges of contact and of stick
    are exact for that line. Path as for `slide`.

    >>> tent = RoughLines([0.0, 1.0, 0.0, 0.0], 1.0)
    >>> path = slide_lines(tent, 1.0, Friction(0.8, 0.5), Load("penetration", 0.5),
    ...                    LoadPath("tangential_displacement", 9.0))
    >>> path.tangential_force  # mu F
    array([[0.125]])
    """
    path.one_of(*CONTROLS)
    load.single()
    normal = press(lines, effective_modulus, load, edges=edges)

    def of_line(row: int) -> list[np.ndarray]:
        line = lines[row]

        def at(kind: str, levels: np.ndarray) -> tuple[np.ndarray, ...]:
            contact = press(line, 1.0, Load(kind, levels), edges=edges)
            length, energy = contact.contact_length[0], contact.energy[0]
            return contact.penetration[0], contact.force[0], length, energy

        depth, force = normal.penetration[row, 0], normal.force[row, 0] / effective_modulus
        return _hysteresis(depth, force, at, path, effective_modulus, friction)

    answers = zip(*map(of_line, range(len(lines))), strict=True)
    return TangentialPath(normal.penetration[:, 0], normal.force[:, 0], *map(np.array, answers))


def _hysteresis(
    depth: float,
    pressed: float,
    at: Callable[[str, np.ndarray], tuple[np.ndarray, ...]],
    path: LoadPath,
    E: float,
    friction: Friction,
) -> list[np.ndarray]:
    """Return F_x, u, stick length, stiffness and dissipation along the path of one row.

    Penetration and F/E* of the normal load are `depth` and `pressed`; `at("penetration", levels)`
    returns penetration, F/E*, contact length and energy/E* at increasing positive levels, of which
    the last is always that of the load.
    """
    mu, G = friction.coefficient, friction.tangential_modulus

    def normal(kind: str, levels: np.ndarray) -> np.ndarray:
        top = depth if kind == "penetration" else pressed
        distinct, place = np.unique(np.append(np.clip(levels, 0.0, top), top), return_inverse=True)
        loaded = distinct > 0
        responses = np.zeros((4, distinct.size))
        responses[:, loaded] = at(kind, distinct[loaded])
        return responses[:, place[:-1]]

    def dissipated(way: np.ndarray) -> np.ndarray:
        # Loss over (mu E*)^2/G* of loading to w: int over w_i < w of w_i (w - w_i) dx. With U the
        # energy of the normal law it is w [N(d) + N(d - w)] - 2 [U(d) - U(d - w)], which beyond
        # w = d (sliding) grows with N(d).
        within = np.minimum(way, depth)
        _, force, _, energy = normal("penetration", depth - within)
        total = normal("penetration", np.array([depth]))[3, 0]
        return within * (pressed + force) - 2 * (total - energy) + pressed * (way - within)

    if path.control == "tangential_displacement":
        # T = phi(w) = N(d) - N(d - w) on the branches of w
        branch = branches(path.values * (G / (mu * E)))
        way = branch.reach
        stuck_force = normal("penetration", depth - np.abs(way))[1]
        force = accumulate(branch, np.sign(way) * (pressed - stuck_force))
        given_force, given_displacement = mu * E * force[branch.points], path.values
    else:
        # w = d - d(N - T), the inverse of phi, on the branches of T
        values = path.values / (mu * E)
        if np.any(np.abs(values) > pressed * (1 + _SPENT)):
            raise ValueError(
                "tangential_force must not exceed friction times the normal force, got "
                f"{np.max(np.abs(values)) / pressed:.6g} times this limit: full sliding"
            )
        branch = branches(values)
        way = branch.reach
        stuck_depth = normal("force", pressed - np.abs(way))[0]
        shift = accumulate(branch, np.sign(way) * (depth - stuck_depth))
        branch = Branches(shift, branch.start, branch.points)
        given_force, given_displacement = path.values, mu * E / G * shift[branch.points]
    # of each node, and of the preceding one, which is on the same branch
    preceding = np.concatenate([[0.0], branch.value[:-1]])
    way, before = np.abs([branch.reach, branch.way_of(preceding)])
    stick = normal("penetration", depth - way)[2][branch.points]
    lost = branch.factor * (dissipated(way) - dissipated(before))
    lost = mu * E / G * mu * E * np.cumsum(np.maximum(lost, 0.0))
    return [given_force, given_displacement, stick, G * stick, lost[branch.points]]


@dataclass(frozen=True)
class Branches:
    """A path divided into parts that follow one branch; arrays over the m nodes."""

    value: np.ndarray  # (m,), the path with inserted points at which loops close
    start: np.ndarray  # (m,), first node of the branch that leads here; -1 for the first loading
    points: np.ndarray  # (k,), nodes of the original points of the path

    @property
    def factor(self) -> np.ndarray:
        """1 for the first loading, 2 (Masing) for all other branches."""
        return np.where(self.start < 0, 1.0, 2.0)

    @property
    def reach(self) -> np.ndarray:
        """Signed distance from the start of the branch to the node, over the branch's factor."""
        return self.way_of(self.value)

    def way_of(self, value: np.ndarray) -> np.ndarray:
        """Return the same for values on the branches of the nodes."""
        origin = np.append(self.value, 0.0)[self.start]
        return (value - origin) / self.factor


def branches(path: np.ndarray) -> Branches:
    """Return the branches of a path of force or displacement from zero, by its turning points.

    A loop inside the first loading closes at 2 and is forgotten:

    >>> loop = branches(np.array([2.0, 1.0, 3.0]))
    >>> loop.value, loop.start
    (array([2., 1., 2., 3.]), array([-1, 0, 1, -1]))
    """
    value: list[float] = []
    start: list[int] = []
    points: list[int] = []
    turns: list[int] = []  # first nodes of the open loops, oldest first

    def at(node: int) -> float:
        return value[node] if node >= 0 else 0.0

    for goal in path:
        last = at(len(value) - 1)
        origin = at(turns[-1]) if turns else 0.0
        if np.sign(goal - last) * np.sign(last - origin) < 0:  # products of values may underflow
            turns.append(len(value) - 1)
        while turns:
            # the first loop closes where the first loading of the other sign continues
            close = at(turns[-2]) if len(turns) > 1 else -at(turns[0])
            if abs(goal - at(turns[-1])) <= abs(close - at(turns[-1])):
                break
            value.append(close)
            start.append(turns[-1])
            del turns[-2:]
        value.append(float(goal))
        start.append(turns[-1] if turns else -1)
        points.append(len(value) - 1)
    return Branches(np.array(value), np.array(start), np.array(points))


def accumulate(branch: Branches, gain: np.ndarray) -> np.ndarray:
    """Return the response at every node: that at the start of its branch plus factor times gain.

    `gain` (m,) is the signed first-loading response to `branch.reach`.
    """
    answer = np.zeros(branch.value.size + 1)
    for node, (start, step) in enumerate(zip(branch.start, branch.factor * gain, strict=True)):
        answer[node] = answer[start] + step
    return answer[:-1]


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


_PLACE, _GAP, _TRACTION, _IS_POINT = range(4)  # of a knot; whether it is a point of the line


def _split(knots: np.ndarray, zero: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Insert knots where a function, linear in between, is zero; return all, and where they are."""
    sign = np.sign(zero)
    first = np.flatnonzero(sign[:-1] * sign[1:] < 0)
    share = zero[first] / (zero[first] - zero[first + 1])
    between = knots[:, first] + share * (knots[:, first + 1] - knots[:, first])
    between[_IS_POINT] = False
    return np.insert(knots, first + 1, between, axis=1), first + 1 + np.arange(first.size)


def _advance(knots: np.ndarray, before: float, d: float, step: float) -> np.ndarray:
    """Return the knots after a move to penetration d and by v = step."""
    for level in (before, d):
        knots, new = _split(knots, knots[_GAP] - level)
        knots[_GAP, new] = level

    def unslipped() -> np.ndarray:
        """Return the tangential forces if no spring slipped in the step."""
        if d <= before:
            return knots[_TRACTION] + step
        gap = knots[_GAP]
        return knots[_TRACTION] + step * np.where(gap >= before, (d - gap) / (d - before), 1.0)

    for side in (-1.0, 1.0):
        width = d - knots[_GAP]
        knots, _ = _split(knots, np.where(width >= 0, unslipped() - side * width, 0.0))
    trial, width = unslipped(), np.maximum(d - knots[_GAP], 0.0)
    knots[_TRACTION] = np.clip(trial, -width, width)
    # inner knots of a free or slipping part go
    sign = np.where(width > 0, np.sign(trial) * (np.abs(trial) >= width), 2.0)
    same = (sign[1:-1] == sign[:-2]) & (sign[1:-1] == sign[2:]) & (sign[1:-1] != 0)
    inner = ~same | (knots[_IS_POINT, 1:-1] > 0)
    return knots[:, np.concatenate([[True], inner, [True]])]


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
    both change in proportion between two points. `gap` (n,) is that over springs at distances
    `spacing` at first touch: a profile's height, or the depth of a rough line below its highest
    peak. A free line ends half a cell beyond its outer points, at constant height.

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
    knots = np.array([place, gap, np.zeros(gap.size), np.ones(gap.size)])
    mu = friction.coefficient
    ratio = friction.tangential_modulus / (mu * effective_modulus)
    before = min(depth[0], 0.0)
    rows = []
    for d, step in zip(depth, np.diff(ratio * shift, prepend=0.0), strict=True):
        knots, before = _advance(knots, before, d, step), d
        # integrals over the cells between the knots
        cell, traction = np.diff(knots[_PLACE]), knots[_TRACTION]
        width = np.maximum(d - knots[_GAP], 0.0)
        touching = (width[:-1] > 0) | (width[1:] > 0)
        margin = (width - np.abs(traction)) * 2
        slips = margin[:-1] + margin[1:] <= 1e-12 * (width[:-1] + width[1:])
        sums = [cell[touching].sum(), cell[touching & ~slips].sum(), cell.size + 1]
        for v in (width, traction):
            square = v[:-1] * v[:-1] + v[:-1] * v[1:] + v[1:] * v[1:]
            sums += [np.sum((v[:-1] + v[1:]) / 2 * cell), np.sum(square / 3 * cell) / 2]
        rows.append(sums)
    contact, stick, count, normal, energy, tangential, energy_x = np.array(rows).T
    unit = effective_modulus * spacing
    energy = unit * (energy + mu / ratio * energy_x)
    return LinePath(
        *(depth, shift, unit * normal, mu * unit * tangential),
        *(spacing * contact, spacing * stick, energy, count.astype(int)),
    )
