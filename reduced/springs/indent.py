"""Indentation of independent springs by an equivalent profile, all loads at once."""

from dataclasses import dataclass

import numpy as np

from reduced.errors import ConvergenceError
from reduced.loads import Load
from reduced.profiles.quadrature import gauss_legendre
from reduced.profiles.section import Curve, Profile, invert
from reduced.springs.line import Springs


@dataclass(frozen=True)
class Indentation:
    """Load curve of a single contact on springs; all arrays have shape (k,).

    Stiffness is dF/dd on the fixed contact set, 2 E* a ((19.13), (19.14)); energy that of the
    springs, the integral of F over d. `spacing` is dx, `springs` how many make up the contact
    length at the largest load.
    """

    penetration: np.ndarray
    force: np.ndarray
    contact_radius: np.ndarray
    stiffness: np.ndarray
    energy: np.ndarray
    spacing: float
    springs: int


def indent(springs: Springs, load: Load) -> Indentation:
    """Solve the contact of a profile on springs, for all penetrations or forces at once.

    A prescribed force is met by the discrete law, not by its continuum limit.

    >>> from reduced.profiles.equivalents import paraboloid
    >>> hertz = indent(Springs(paraboloid(1.0), 1.0), Load("penetration", [0.25, 1.0]))
    >>> np.round(hertz.force, 6)  # (4/3) E* sqrt(R) d^1.5
    array([0.166667, 1.333333])
    """
    control, loads = load.one_of("penetration", "force"), load.values
    modulus = springs.effective_modulus
    if control == "penetration":
        largest = float(springs.profile.contact_radius(loads[-1]))
    else:
        largest = continuum_radius(springs.profile, loads[-1] / modulus)
    line = springs.lay(largest)
    d = loads
    if control == "force":
        # F(d) is convex with slope equal to the contact length
        goal = loads / modulus

        def step(d: np.ndarray) -> np.ndarray:
            length, force, _ = line.respond(d)
            return (force - goal) / length

        d = fall(step, line.deep_start(goal), "the force could not be inverted")
    length, reduced_force, reduced_energy = line.respond(d)
    return Indentation(
        penetration=d,
        force=loads if control == "force" else modulus * reduced_force,
        contact_radius=length / 2,
        stiffness=modulus * length,
        energy=modulus * reduced_energy,
        spacing=line.spacing,
        springs=round(length[-1] / line.spacing),
    )


def fall(step: Curve, start: np.ndarray, failure: str) -> np.ndarray:
    """Return the roots d of a convex function by Newton's method from beyond them.

    The steps f/f' go down monotonically, until rounding stops them; `failure` is the message of the
    ConvergenceError if it does not.
    """
    d, history = start, list[float]()
    for _ in range(200):
        way = step(d)
        history.append(float(np.max(np.abs(way) / d)))
        d = d - way
        stalled = history[-1] < 1e-13 and len(history) > 1 and history[-1] >= history[-2]
        if history[-1] <= 4 * np.finfo(float).eps or stalled:
            return d
    raise ConvergenceError(failure, history)


def continuum_radius(profile: Profile, reduced_force: float) -> float:
    """Return a with 2 int_0^a (g(a) - g(x)) dx = F/E*, for the spacing of the springs.

    Exact to rounding for up to three breakpoints; of a table only a few breakpoints are used.
    """
    stride = max(1, -(-len(profile.breakpoints) // 3))
    marks = np.array([0.0, *profile.breakpoints[::stride]])
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
