"""Indentation of a row of independent springs by an equivalent profile, all loads at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reduced.arguments import choice_faults, count_faults, positive_faults, refuse
from reduced.errors import ConvergenceError
from reduced.loads import EDGES, one_load_list
from reduced.profiles.quadrature import gauss_legendre
from reduced.profiles.section import Profile, invert
from reduced.springs.line import NodalLine, SmoothLine

_NEWTON = 100


@dataclass(frozen=True)
class Indentation:
    """Load curve of a single contact on springs; all arrays have shape (k,).

    Attributes
    ----------
    penetration, force, contact_radius : ndarray
        d, F and half the contact length.
    stiffness : ndarray
        dF/dd on the fixed contact set, 2 E* a ((19.13), (19.14)).
    energy : ndarray
        Elastic energy of the springs, the integral of F over d.
    spacing : float
        Distance dx of the springs.
    springs : int
        Number of springs in contact at the largest load.
    """

    penetration: np.ndarray
    force: np.ndarray
    contact_radius: np.ndarray
    stiffness: np.ndarray
    energy: np.ndarray
    spacing: float
    springs: int


def indent(
    profile: Profile,
    effective_modulus: float,
    *,
    penetration: Sequence[float] | np.ndarray | None = None,
    force: Sequence[float] | np.ndarray | None = None,
    springs: int = 40,
    spacing: float | None = None,
    edges: str = "sub_cell",
    offset: float = 0.5,
) -> Indentation:
    """Press a profile onto springs of stiffness E* dx (19.14) at x_i = (i + offset) dx, all i.

    dx is the contact radius at the largest load over `springs`, or `spacing`. Two discrete laws:

    - ``"sub_cell"``: between springs the profile is the monotone cubic through the heights and
      slopes at the springs, at x = 0 and at the profile's own breakpoints, and the contact ends
      where that curve meets the surface, inside a cell. Interior springs then weigh E* dx each, as
      printed; all corrections sit in the edge cells. Force and radius converge as dx^4 for smooth
      profiles, parabola, cone and flat punch are exact for any alignment of the springs.
      (A profile ~ x^n near its tip or behind a breakpoint limits the order to n + 1.)
    - ``"nodal"``: the chapter's sums, F = E* dx sum (d - g_i) over springs with g_i < d, and
      a = dx/2 times their number: dx^2 in F and dx in a.

    With `force` the same discrete law is inverted, not its continuum limit. Every operation is
    homogeneous in length and modulus and every tolerance relative, so units do not matter.

    Parameters
    ----------
    profile : Profile
        Equivalent profile g(x), see `profiles`.
    effective_modulus : float
        E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
    penetration, force : array_like, shape (k,)
        Exactly one of them: positive, strictly increasing.
    springs : int
        Springs per contact radius at the largest load, >= 1.
    spacing : float, optional
        dx itself, in place of `springs`; at most the contact radius at the largest load.
    edges : {"sub_cell", "nodal"}
        The discrete law.
    offset : float
        Place of the first spring right of the axis, in [0, 1) spacings.

    Returns
    -------
    Indentation

    Raises
    ------
    ValueError
        Listing every argument that is wrong.
    ConvergenceError
        If the profile is not monotone, or the inversion of the force fails.

    Examples
    --------
    >>> from reduced.profiles.shapes import paraboloid
    >>> hertz = indent(paraboloid(1.0), 1.0, penetration=[0.25, 1.0])
    >>> np.round(hertz.force, 6)  # (4/3) E* sqrt(R) d^1.5
    array([0.166667, 1.333333])
    """
    name, loads = one_load_list(penetration=penetration, force=force)
    _check(effective_modulus, springs, spacing, edges, offset)
    if name == "penetration":
        largest = float(profile.contact_radius(loads[-1]))
    else:
        largest = continuum_radius(profile, loads[-1] / effective_modulus)
    if spacing is None:
        spacing = largest / springs
    elif spacing > largest:
        raise ValueError(f"spacing must be at most the contact radius {largest!r}, got {spacing!r}")
    kind = SmoothLine if edges == "sub_cell" else NodalLine
    line = kind(profile, spacing, offset, largest)
    d = loads if name == "penetration" else _invert(line, loads / effective_modulus)
    length, reduced_force, reduced_energy = line.respond(d)
    return Indentation(
        penetration=d,
        force=loads if name == "force" else effective_modulus * reduced_force,
        contact_radius=length / 2,
        stiffness=effective_modulus * length,
        energy=effective_modulus * reduced_energy,
        spacing=spacing,
        springs=line.count_springs(d[-1]),
    )


def _check(
    effective_modulus: float, springs: int, spacing: float | None, edges: str, offset: float
) -> None:
    """Raise one ValueError for everything wrong."""
    wrong = [] if spacing is None else positive_faults(spacing=spacing)
    wrong += positive_faults(effective_modulus=effective_modulus)
    wrong += count_faults(springs=springs) + choice_faults("edges", edges, EDGES)
    if not 0 <= offset < 1:
        wrong.append(f"offset must be in [0, 1), got {offset!r}")
    refuse(wrong)


def continuum_radius(profile: Profile, reduced_force: float) -> float:
    """Contact radius a with 2 int_0^a (g(a) - g(x)) dx = F/E*, for the spacing of the springs.

    To rounding for profiles with up to three breakpoints; of the many of a table a few will do.
    """
    every = max(1, -(-len(profile.breakpoints) // 3))
    marks = np.array([0.0, *profile.breakpoints[::every]])
    nodes, weights = gauss_legendre(12)

    def force(a: np.ndarray) -> np.ndarray:
        ends = np.minimum(np.column_stack([*np.broadcast_arrays(*marks, a)]), a[:, None])
        width = np.diff(ends, axis=1)[..., None]
        x = ends[:, :-1, None] + width * nodes
        height = profile.height(a)
        finite = np.isfinite(height)
        deflection = np.where(finite[:, None, None], height[:, None, None], 0) - profile.height(
            np.where(finite[:, None, None], x, 0.0)
        )
        return np.where(finite, 2 * (deflection * width * weights).sum(axis=(1, 2)), np.inf)

    def rate(a: np.ndarray) -> np.ndarray:
        return 2 * a * profile.slope(a)

    goal = np.array([reduced_force])
    return float(invert(force, rate, goal, profile.length, profile.edge)[0])


def _invert(line: SmoothLine | NodalLine, goal: np.ndarray) -> np.ndarray:
    """Penetrations at which the line carries F/E* = goal.

    F(d) is convex with slope equal to the contact length, so Newton's method from the deep side
    comes down monotonically; it stops where rounding stops the descent.
    """
    d = line.deep_start(goal)
    history = []
    for _ in range(_NEWTON):
        length, force, _ = line.respond(d)
        step = (force - goal) / length
        history.append(float(np.max(np.abs(step) / d)))
        d = d - step
        if history[-1] <= 4 * np.finfo(float).eps or (
            history[-1] < 1e-13 and len(history) > 1 and history[-1] >= history[-2]
        ):
            return d
    raise ConvergenceError("the force could not be inverted", history)
