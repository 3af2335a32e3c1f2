"""Tangential contact with Coulomb friction: springs 4G/(2 - nu) that stick and slip one by one.

Each spring has the tangential stiffness G* dx with G* = 4 G/(2 - nu) (19.18) and slips where its
force would exceed mu times its normal force (19.19; Popov & Hess 2015, sec. 5.2). Here the normal
load stays while any path of tangential force or displacement is followed; `stick_slip_line` follows
paths on which the penetration changes as well.

What the model leaves out: the coupling of normal and tangential displacements, unless the two
bodies are elastically similar (Dundurs' second constant zero; a rigid body on an incompressible
one), and slip across the direction of the load, which the friction law of a half-space has for
nu > 0. With both left out it is exact for every body of revolution (Jaeger 1995).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from reduced.arguments import positive_faults, refuse
from reduced.friction.slip_memory import Branches, accumulate, branches
from reduced.profiles.section import Profile
from reduced.rough.press import press
from reduced.springs.indent import indent

_SPENT = 8 * np.finfo(float).eps  # a force that the friction carries but for rounding


@dataclass(frozen=True)
class TangentialPath:
    """Answer along a tangential path at constant normal load.

    Arrays have shape (k,) for a single contact and (m, k) for m lines; `penetration` and `force`
    one dimension less.

    Attributes
    ----------
    penetration, force : float or ndarray
        The normal load that stays.
    tangential_force, tangential_displacement : ndarray
        F_x and the displacement u of the rigid indenter against the undeformed half-space.
    stick_length : ndarray
        Length of the springs that follow the indenter as the path arrives; half of it is the stick
        radius of a single contact.
    stiffness : ndarray
        dF_x/du as the path arrives, G* times `stick_length`.
    dissipation : ndarray
        Energy lost to friction since the start of the path.
    """

    penetration: float | np.ndarray
    force: float | np.ndarray
    tangential_force: np.ndarray
    tangential_displacement: np.ndarray
    stick_length: np.ndarray
    stiffness: np.ndarray
    dissipation: np.ndarray


@dataclass(frozen=True)
class _Levels:
    """Normal law N = F/E* of one row of springs, at the load that stays and at smaller ones.

    `at("penetration", levels)` returns penetration, force/E*, contact length and energy/E* at
    increasing positive levels, of which the last is always the load that stays.
    """

    penetration: float
    force: float
    at: Callable[[str, np.ndarray], tuple[np.ndarray, ...]]

    def respond(self, kind: str, levels: np.ndarray) -> np.ndarray:
        """Penetration, force/E*, length, energy/E* at any levels up to the load, shape (4, m)."""
        top = self.penetration if kind == "penetration" else self.force
        wanted, place = np.unique(np.append(np.clip(levels, 0.0, top), top), return_inverse=True)
        loaded = wanted > 0
        found = np.zeros((4, wanted.size))
        found[:, loaded] = self.at(kind, wanted[loaded])
        return found[:, place[:-1]]


def tangential_modulus(shear_modulus: float, poisson_ratio: float) -> float:
    """G* = 4 G/(2 - nu), stiffness of the tangential springs over their distance (19.18).

    Two bodies: 1/G* = (2 - nu1)/(4 G1) + (2 - nu2)/(4 G2) (Popov & Hess 2015, eq. (5.2)).

    Parameters
    ----------
    shear_modulus, poisson_ratio : float
        G > 0, -1 < nu <= 1/2.

    Examples
    --------
    >>> tangential_modulus(3.0, 0.5)
    8.0
    """
    refuse(positive_faults(shear_modulus=shear_modulus) + _poisson_faults(poisson_ratio))
    return 4 * shear_modulus / (2 - poisson_ratio)


def stiffness_ratio(poisson_ratio: float) -> float:
    """k_x/k_z = G*/E* = 2(1 - nu)/(2 - nu) of every contact that sticks (19.18, Mindlin 1949).

    >>> round(stiffness_ratio(0.5), 12)
    0.666666666667
    """
    refuse(_poisson_faults(poisson_ratio))
    return 2 * (1 - poisson_ratio) / (2 - poisson_ratio)


def slide(
    profile: Profile,
    effective_modulus: float,
    tangential_modulus: float,
    friction: float,
    *,
    penetration: float | None = None,
    force: float | None = None,
    tangential_displacement: Sequence[float] | np.ndarray | None = None,
    tangential_force: Sequence[float] | np.ndarray | None = None,
    springs: int = 40,
    spacing: float | None = None,
    edges: str = "sub_cell",
    offset: float = 0.5,
) -> TangentialPath:
    """Load a single contact tangentially, along any path, under a constant normal load.

    The springs are those of `springs.indent.indent`, sub-cell edges included; the border of stick
    lies where one of its levels lies, inside a cell, so that tangential force and stick radius
    converge as the normal force and radius do: dx^4 for smooth profiles ("nodal": dx^2 and dx).

    Parameters
    ----------
    profile : Profile
        Equivalent profile g(x), see `profiles`.
    effective_modulus, tangential_modulus : float
        E* and G* (`tangential_modulus`).
    friction : float
        Coefficient mu of Coulomb's law.
    penetration, force : float
        Exactly one: the normal load, reached before the path begins, without any tangential force.
    tangential_displacement, tangential_force : array_like, shape (k,)
        Exactly one: the values the path passes, in order, any sign; between them it is monotone.
    springs, spacing, edges, offset
        As for `springs.indent.indent`.

    Returns
    -------
    TangentialPath

    Raises
    ------
    ValueError
        Listing every argument that is wrong; a tangential force above mu F has no equilibrium.
    ConvergenceError
        If a force could not be inverted.

    Notes
    -----
    Under force control the displacement is the difference of two penetrations: a force of 1e-12 mu
    F leaves it four digits.

    Examples
    --------
    Cattaneo-Mindlin, stick radius c = a (1 - F_x/(mu F))^(1/3):

    >>> from reduced.profiles.shapes import paraboloid
    >>> path = slide(paraboloid(1.0), 1.0, 0.8, 0.5, penetration=1.0, tangential_force=[7 / 12])
    >>> round(float(path.stick_length[0]) / 2, 12)
    0.5
    """
    control, values = _path(tangential_displacement, tangential_force)
    _check(effective_modulus, tangential_modulus, friction)
    name, load = _one_load(penetration, force)
    options = {"springs": springs, "spacing": spacing, "edges": edges, "offset": offset}
    normal = indent(profile, effective_modulus, **{name: [load]}, **options)
    options["spacing"] = normal.spacing

    def at(kind: str, levels: np.ndarray) -> tuple[np.ndarray, ...]:
        found = indent(profile, 1.0, **{kind: levels}, **options)
        return found.penetration, found.force, 2 * found.contact_radius, found.energy

    levels = _Levels(float(normal.penetration[0]), normal.force[0] / effective_modulus, at)
    answers = _follow(levels, control, values, effective_modulus, tangential_modulus, friction)
    return TangentialPath(levels.penetration, float(normal.force[0]), *answers)


def slide_lines(
    lines: np.ndarray,
    spacing: float,
    effective_modulus: float,
    tangential_modulus: float,
    friction: float,
    *,
    force: float | None = None,
    penetration: float | None = None,
    tangential_displacement: Sequence[float] | np.ndarray | None = None,
    tangential_force: Sequence[float] | np.ndarray | None = None,
    edges: str = "sub_cell",
    periodic: bool = True,
) -> TangentialPath:
    """Load rough lines tangentially, along any path, under a constant normal load.

    The springs are those of `rough.press.press`: with ``"sub_cell"`` the line is straight between
    its points, and edges of contact and of stick are exact for that line.

    Parameters
    ----------
    lines, spacing, edges, periodic
        As for `rough.press.press`.
    effective_modulus, tangential_modulus, friction : float
        E*, G*, mu.
    force, penetration : float
        Exactly one: the normal load of every line.
    tangential_displacement, tangential_force : array_like, shape (k,)
        Exactly one: the same path for every line.

    Returns
    -------
    TangentialPath

    Raises
    ------
    ValueError, ConvergenceError
        As for `slide`.

    Examples
    --------
    >>> tent = np.array([0.0, 1.0, 0.0, 0.0])
    >>> path = slide_lines(tent, 1.0, 1.0, 0.8, 0.5, penetration=0.5, tangential_displacement=[9.0])
    >>> path.tangential_force  # mu F
    array([[0.125]])
    """
    control, values = _path(tangential_displacement, tangential_force)
    _check(effective_modulus, tangential_modulus, friction)
    name, load = _one_load(penetration, force)
    options = {"edges": edges, "periodic": periodic}
    heights = np.atleast_2d(np.asarray(lines, dtype=float))
    normal = press(heights, spacing, effective_modulus, **{name: [load]}, **options)

    def follow(row: int) -> list[np.ndarray]:
        def at(kind: str, levels: np.ndarray) -> tuple[np.ndarray, ...]:
            found = press(heights[row], spacing, 1.0, **{kind: levels}, **options)
            return found.penetration[0], found.force[0], found.contact_length[0], found.energy[0]

        own = _Levels(normal.penetration[row, 0], normal.force[row, 0] / effective_modulus, at)
        return _follow(own, control, values, effective_modulus, tangential_modulus, friction)

    answers = zip(*map(follow, range(len(heights))), strict=True)
    return TangentialPath(normal.penetration[:, 0], normal.force[:, 0], *map(np.array, answers))


def _follow(
    levels: _Levels, control: str, values: np.ndarray, E: float, G: float, friction: float
) -> list[np.ndarray]:
    """F_x, u, stick length, stiffness and dissipation at the points of a path of one row."""
    if control == "displacement":
        branch, force = _by_displacement(levels, values * (G / (friction * E)))
        given_force = friction * E * force[branch.given]
        given_displacement = values
    else:
        branch = _by_force(levels, values / (friction * E))
        given_displacement = friction * E / G * branch.value[branch.given]
        given_force = values
    depth = levels.penetration
    way, before = np.abs([branch.reach, branch.reach_before])
    length = levels.respond("penetration", depth - way)[2]
    lost = branch.factor * (_dissipated(levels, way) - _dissipated(levels, before))
    lost = friction * E / G * friction * E * np.cumsum(np.maximum(lost, 0.0))
    stick = length[branch.given]
    return [given_force, given_displacement, stick, G * stick, lost[branch.given]]


def _by_displacement(levels: _Levels, path: np.ndarray) -> tuple[Branches, np.ndarray]:
    """Branches of a path in w, and T at their nodes: phi(w) = N(d) - N(d - w)."""
    branch = branches(path)
    way = branch.reach
    rest = levels.respond("penetration", levels.penetration - np.abs(way))[1]
    return branch, accumulate(branch, np.sign(way) * (levels.force - rest))


def _by_force(levels: _Levels, path: np.ndarray) -> Branches:
    """Branches in w of a path in T: w = d - d(N - T), the inverse of phi."""
    if np.any(np.abs(path) > levels.force * (1 + _SPENT)):
        worst = np.max(np.abs(path)) / levels.force
        raise ValueError(
            f"tangential_force must not exceed friction times the normal force, {worst:.6g} times "
            "that was asked for: the contact would slide without end"
        )
    branch = branches(path)
    way = branch.reach
    rest = levels.respond("force", levels.force - np.abs(way))[0]
    gain = np.sign(way) * (levels.penetration - rest)
    return Branches(accumulate(branch, gain), branch.start, branch.given)


def _dissipated(levels: _Levels, way: np.ndarray) -> np.ndarray:
    """Loss of the first loading to w, over (mu E*)^2/G*: int over w_i < w of w_i (w - w_i) dx.

    With U the energy of the normal law, w [N(d) + N(d - w)] - 2 [U(d) - U(d - w)], which beyond
    w = d grows with N(d): sliding.
    """
    depth = levels.penetration
    within = np.minimum(way, depth)
    _, force, _, energy = levels.respond("penetration", depth - within)
    total = levels.respond("penetration", np.array([depth]))[3, 0]
    slipped = within * (levels.force + force) - 2 * (total - energy)
    return slipped + levels.force * (way - within)


def _path(displacement: object, force: object) -> tuple[str, np.ndarray]:
    """Kind and values of the only tangential path that was given."""
    if (displacement is None) == (force is None):
        raise ValueError("give exactly one of tangential_displacement, tangential_force")
    control, given = ("displacement", displacement) if force is None else ("force", force)
    values = np.array(given, dtype=float, ndmin=1)
    if values.ndim != 1 or values.size == 0 or not np.all(np.isfinite(values)):
        raise ValueError(f"tangential_{control} must be a non-empty finite 1-D list, got {given!r}")
    return control, values


def _one_load(penetration: float | None, force: float | None) -> tuple[str, float]:
    """Name and value of the only normal load that was given."""
    if (penetration is None) == (force is None):
        raise ValueError("give exactly one of penetration, force")
    name, load = ("penetration", penetration) if force is None else ("force", force)
    refuse(positive_faults(**{name: load}))
    return name, float(load)


def _check(effective_modulus: float, tangential_modulus: float, friction: float) -> None:
    refuse(
        positive_faults(
            effective_modulus=effective_modulus,
            tangential_modulus=tangential_modulus,
            friction=friction,
        )
    )


def _poisson_faults(poisson_ratio: float) -> list[str]:
    good = np.isfinite(poisson_ratio) and -1 < poisson_ratio <= 0.5
    return [] if good else [f"poisson_ratio must lie in (-1, 0.5], got {poisson_ratio!r}"]
