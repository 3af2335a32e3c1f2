"""Tangential contact with Coulomb friction: independent springs 4G/(2 - nu) with stick and slip.

Each spring has the tangential stiffness G* dx with G* = 4 G/(2 - nu) (19.18) and slips where its
force would exceed mu times its normal force (19.19; Popov & Hess 2015, sec. 5.2). Here the normal
load is constant along any path of tangential force or displacement; `stick_slip` also permits
changes of the penetration.

The model neglects the coupling of normal and tangential displacements, unless the two
bodies are elastically similar (Dundurs' second constant zero; a rigid body on an incompressible
one), and slip transverse to the load, which occurs on a half-space for nu > 0. Apart from both
effects it is exact for every body of revolution (Jaeger 1995).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from reduced.arguments import poisson_faults, positive_faults, refuse
from reduced.friction.slip_memory import Branches, accumulate, branches
from reduced.loads import Load, LoadPath
from reduced.rough.lines import RoughLines
from reduced.rough.press import press
from reduced.springs.indent import indent
from reduced.springs.line import Springs

CONTROLS = ("tangential_displacement", "tangential_force")
_SPENT = 8 * np.finfo(float).eps  # tolerance for forces at the friction limit


@dataclass(frozen=True)
class TangentialPath:
    """Response along a tangential path at constant normal load.

    Arrays have shape (k,) for a single contact and (m, k) for m lines; `penetration` and `force`
    have one dimension less.

    Attributes
    ----------
    penetration, force : float or ndarray
        The constant normal load.
    tangential_force, tangential_displacement : ndarray
        F_x and the displacement u of the rigid indenter against the undeformed half-space.
    stick_length : ndarray
        Length of the sticking springs on arrival at the point; half of it is the stick radius of a
        single contact.
    stiffness : ndarray
        dF_x/du on arrival at the point, G* times `stick_length`.
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
class Friction:
    """Tangential springs of stiffness G* dx, with Coulomb's law (19.18), (19.19).

    Parameters
    ----------
    tangential_modulus : float
        G*, see `tangential_modulus`.
    coefficient : float
        Coulomb's mu.
    """

    tangential_modulus: float
    coefficient: float

    def __post_init__(self) -> None:
        wrong = positive_faults(tangential_modulus=self.tangential_modulus)
        refuse(wrong + positive_faults(coefficient=self.coefficient))


@dataclass(frozen=True)
class _Levels:
    """Normal law N = F/E* of one row of springs, at the constant load and below.

    `at("penetration", levels)` returns penetration, force/E*, contact length and energy/E* at
    increasing positive levels, of which the last is always the constant load.
    """

    penetration: float
    force: float
    at: Callable[[str, np.ndarray], tuple[np.ndarray, ...]]

    def respond(self, kind: str, levels: np.ndarray) -> np.ndarray:
        """Return penetration, force/E*, length, energy/E* at levels up to the load, (4, m)."""
        top = self.penetration if kind == "penetration" else self.force
        distinct, place = np.unique(np.append(np.clip(levels, 0.0, top), top), return_inverse=True)
        loaded = distinct > 0
        responses = np.zeros((4, distinct.size))
        responses[:, loaded] = self.at(kind, distinct[loaded])
        return responses[:, place[:-1]]


def tangential_modulus(shear_modulus: float, poisson_ratio: float) -> float:
    """Return G* = 4 G/(2 - nu), the stiffness of tangential springs per length (19.18).

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

    The springs are those of `springs.indent.indent`, sub-cell edges included; the stick boundary is
    also inside a cell, so that tangential force and stick radius converge like the normal force and
    radius: dx^4 for smooth profiles ("nodal": dx^2 and dx).

    Parameters
    ----------
    springs : Springs
        The profile, and the springs under it.
    friction : Friction
        G* and mu.
    load : Load
        Penetration or force, one value, applied before the path begins, without tangential force.
    path : LoadPath
        Values of ``"tangential_displacement"`` or ``"tangential_force"`` along the path, in order,
        any sign, shape (k,); monotone in between.

    Raises
    ------
    ConvergenceError
        If a force could not be inverted.

    Notes
    -----
    Under force control the displacement is the difference of two penetrations: for a force of 1e-12
    mu F four digits remain.

    Examples
    --------
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

    modulus = springs.effective_modulus
    levels = _Levels(float(normal.penetration[0]), normal.force[0] / modulus, at)
    answers = _follow(levels, path, modulus, friction)
    return TangentialPath(levels.penetration, float(normal.force[0]), *answers)


def slide_lines(
    lines: RoughLines,
    effective_modulus: float,
    friction: Friction,
    load: Load,
    path: LoadPath,
    *,
    edges: str = "sub_cell",
) -> TangentialPath:
    """Solve rough lines along any tangential path at constant normal load.

    The springs are those of `rough.press.press`: with ``"sub_cell"`` the line is straight between
    its points, and edges of contact and of stick are exact for that line.

    Parameters
    ----------
    lines, effective_modulus, edges
        As for `rough.press.press`.
    friction, load, path
        As for `slide`, equal for all lines; the load is that of one line.

    Examples
    --------
    >>> tent = RoughLines([0.0, 1.0, 0.0, 0.0], 1.0)
    >>> path = slide_lines(tent, 1.0, Friction(0.8, 0.5), Load("penetration", 0.5),
    ...                    LoadPath("tangential_displacement", 9.0))
    >>> path.tangential_force  # mu F
    array([[0.125]])
    """
    path.one_of(*CONTROLS)
    load.single()
    normal = press(lines, effective_modulus, load, edges=edges)

    def follow(row: int) -> list[np.ndarray]:
        line = lines[row]

        def at(kind: str, levels: np.ndarray) -> tuple[np.ndarray, ...]:
            contact = press(line, 1.0, Load(kind, levels), edges=edges)
            length, energy = contact.contact_length[0], contact.energy[0]
            return contact.penetration[0], contact.force[0], length, energy

        levels = _Levels(normal.penetration[row, 0], normal.force[row, 0] / effective_modulus, at)
        return _follow(levels, path, effective_modulus, friction)

    answers = zip(*map(follow, range(len(lines))), strict=True)
    return TangentialPath(normal.penetration[:, 0], normal.force[:, 0], *map(np.array, answers))


def _follow(levels: _Levels, path: LoadPath, E: float, friction: Friction) -> list[np.ndarray]:
    """Return F_x, u, stick length, stiffness and dissipation along the path of one row."""
    mu, G, depth = friction.coefficient, friction.tangential_modulus, levels.penetration
    if path.control == "tangential_displacement":
        # T = phi(w) = N(d) - N(d - w) on the branches of w
        branch = branches(path.values * (G / (mu * E)))
        way = branch.reach
        stuck_force = levels.respond("penetration", depth - np.abs(way))[1]
        force = accumulate(branch, np.sign(way) * (levels.force - stuck_force))
        given_force, given_displacement = mu * E * force[branch.points], path.values
    else:
        # w = d - d(N - T), the inverse of phi, on the branches of T
        values = path.values / (mu * E)
        if np.any(np.abs(values) > levels.force * (1 + _SPENT)):
            worst = np.max(np.abs(values)) / levels.force
            raise ValueError(
                "tangential_force must not exceed friction times the normal force, got "
                f"{worst:.6g} times this limit: full sliding"
            )
        branch = branches(values)
        way = branch.reach
        stuck_depth = levels.respond("force", levels.force - np.abs(way))[0]
        shift = accumulate(branch, np.sign(way) * (depth - stuck_depth))
        branch = Branches(shift, branch.start, branch.points)
        given_force, given_displacement = path.values, mu * E / G * shift[branch.points]
    way, before = np.abs([branch.reach, branch.reach_before])
    length = levels.respond("penetration", depth - way)[2]
    lost = branch.factor * (_dissipated(levels, way) - _dissipated(levels, before))
    lost = mu * E / G * mu * E * np.cumsum(np.maximum(lost, 0.0))
    stick = length[branch.points]
    return [given_force, given_displacement, stick, G * stick, lost[branch.points]]


def _dissipated(levels: _Levels, way: np.ndarray) -> np.ndarray:
    """Return the loss over (mu E*)^2/G* of loading to w: int over w_i < w of w_i (w - w_i) dx.

    With U the energy of the normal law it is w [N(d) + N(d - w)] - 2 [U(d) - U(d - w)], which
    beyond w = d (sliding) grows with N(d).
    """
    depth = levels.penetration
    within = np.minimum(way, depth)
    _, force, _, energy = levels.respond("penetration", depth - within)
    total = levels.respond("penetration", np.array([depth]))[3, 0]
    slipped = within * (levels.force + force) - 2 * (total - energy)
    return slipped + levels.force * (way - within)
