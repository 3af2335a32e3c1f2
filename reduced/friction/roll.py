r"""Rolling on independent springs: they enter the contact unstretched and leave it stretched.

A line that rolls with creep xi meets springs that have no tangential force yet; on its way back
from the leading edge each is stretched by xi per distance rolled and slips where its force would
exceed mu times its normal force:

    f(x) = min over x' >= x of [mu E* w(x') + G* xi (x' - x)],    w = d - g,

per length, for creep of constant direction: a spring that slips keeps its bound until the bound
grows faster than its stretch. For a parabola, with R the radius of the body (19.17),

    F_x/(mu F) = 1 - (1 - xi/xi_full)^3,    xi_full = 2 mu a E*/(G* R).

With the friction used up nowhere, F_x = 2 G* a^2 xi: in Kalker's terms C11 = C22 = 4/(2 - nu),
whereas the half-space has 3.40 (nu = 0) to 5.20 (nu = 1/2). `Friction.tangential_modulus` may
therefore be chosen for the initial slope C instead: G* = C G, G that of one elastic body on a rigid
one.

A spring under a rough roller has a height of its own, which travels with it: it rolls under the
smooth profile at the penetration d + h (`roll_rough`).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from reduced.errors import finite_faults, positive_faults, refuse
from reduced.friction.slide import Friction
from reduced.loads import Load
from reduced.springs.indent import indent
from reduced.springs.line import Springs


@dataclass(frozen=True)
class RollingLine:
    """Steady rolling at k creeps: forces of the sign of the creep, stick length, shape (k,)."""

    penetration: float
    force: float
    contact_radius: float
    tangential_force: np.ndarray
    lateral_force: np.ndarray
    stick_length: np.ndarray


def roll(
    springs: Springs,
    friction: Friction,
    load: Load,
    creep: ArrayLike,
    lateral_creep: ArrayLike = 0.0,
) -> RollingLine:
    """Roll a single contact steadily at several creeps.

    Creeps are fractions of any sign, shape (k,) or numbers. `per_radius` springs roll to either
    side of the middle, the ends of the contact among them. The load is one penetration or force.

    A parabola at half the creep of full slip, 1 - 1/8:

    >>> from reduced.profiles.equivalents import paraboloid
    >>> line = Springs(paraboloid(1.0), 1.0, per_radius=200)
    >>> half = roll(line, Friction(0.8, 0.5), Load("penetration", 1.0), 0.625)
    >>> round(float(half.tangential_force[0] / (0.5 * half.force)), 4)
    0.875
    """
    load.single()
    along, across = np.broadcast_arrays(
        np.atleast_1d(np.asarray(creep, dtype=float)), np.asarray(lateral_creep, dtype=float)
    )
    if along.ndim != 1 or not (np.isfinite(along).all() and np.isfinite(across).all()):
        raise ValueError("creep and lateral_creep must be finite numbers or lists of one length")
    normal = indent(springs, load)
    depth, radius = float(normal.penetration[0]), float(normal.contact_radius[0])
    x = np.linspace(radius, -radius, 2 * springs.per_radius + 1)
    width = np.maximum(depth - np.asarray(springs.profile.height(np.abs(x))), 0.0)
    # at a sharp edge the profile ends, and the springs there carry their full depth
    width[[0, -1]] = width[[1, -2]] if springs.profile.edge <= radius else 0.0
    spacing = 2 * radius / (x.size - 1)
    unit = friction.coefficient * springs.effective_modulus
    force = float(normal.force[0])
    # what slips has its share of the whole force, which `indent` knows better than a sum of cells
    whole = force / springs.effective_modulus / np.trapezoid(width, dx=spacing)
    size = np.hypot(along, across)
    rates = friction.tangential_modulus / unit * size
    sticks, slips, stick = np.array([_walk(width, spacing, rate) for rate in rates]).T
    pulled = unit * (sticks + whole * slips) / np.where(size > 0, size, 1.0)
    return RollingLine(depth, force, radius, pulled * along, pulled * across, stick)


@dataclass(frozen=True)
class RollingRough:
    """A rough line that rolls: penetration of the smooth profile, mean forces over the way.

    `scatter` is the standard deviation of the tangential force along it.
    """

    penetration: float
    force: float
    tangential_force: float
    scatter: float


def roll_rough(
    gap: ArrayLike,
    roughness: ArrayLike,
    spacing: float,
    effective_modulus: float,
    friction: Friction,
    force: float,
    creep: float,
) -> RollingRough:
    """Roll along a roughness at the one penetration that carries the force on average.

    `gap` (n,) is that of the smooth profile on a window, from its trailing end to the leading one;
    `roughness` (m,), m >= n, has heights in the order in which the window meets them, positive
    towards the springs, with which they travel.

    Without roughness it is `roll`:

    >>> x = np.arange(-120, 121) / 100
    >>> smooth = roll_rough(x**2, np.zeros(400), 0.01, 1.0, Friction(0.8, 0.5), 4 / 3, 0.625)
    >>> round(smooth.tangential_force / (0.5 * smooth.force), 2)
    0.88
    """
    gap, heights = np.asarray(gap, dtype=float), np.asarray(roughness, dtype=float)
    wrong = positive_faults(spacing=spacing, effective_modulus=effective_modulus, force=force)
    wrong += finite_faults(creep=creep)
    if gap.ndim != 1 or heights.ndim != 1 or not 2 <= gap.size <= heights.size:
        wrong.append(
            "gap and roughness must be lists, the latter at least as long, got shapes "
            f"{gap.shape} and {heights.shape}"
        )
    elif not (np.isfinite(gap).all() and np.isfinite(heights).all()):
        wrong.append("gap and roughness must be finite")
    refuse(wrong)
    stiffness = effective_modulus * spacing
    # the way from first touch at which the mean of the normal forces is the given one; at most one
    # on which each spring bears twice its share, and no less than its share
    carried = force / stiffness
    touch = float(gap.min() - heights.max())
    below, raised = gap - gap.min(), heights - heights.max()
    farthest = 2 * carried / gap.size + float(below.max() - raised.min())

    def excess(way: float) -> float:
        return float(_windows(below, raised, way, 0.0)[0].mean()) - carried

    way = brentq(excess, 0.0, farthest, xtol=1e-15 * carried / gap.size, rtol=1e-15)
    unit = friction.coefficient * stiffness
    step = friction.tangential_modulus * creep * spacing * spacing / unit
    normal, pulled = _windows(below, raised, way, step)
    return RollingRough(
        touch + way,
        float(normal.mean() * stiffness),
        float(pulled.mean() * unit),
        float(pulled.std() * unit),
    )


@njit(cache=True)
def _walk(width, spacing, rate):
    """Return the integrals of the force over mu E* in stick and in slip, and the stick length.

    The springs lie in the order in which they are met; between two of them the force is that of
    stick up to where it meets the bound, and the bound behind.
    """
    force, sticks, slips, stick = 0.0, 0.0, 0.0, 0.0
    for i in range(1, width.size):
        tried, bound = force + rate * spacing, width[i]
        if tried <= bound:
            sticks += (force + tried) / 2 * spacing
            stick += spacing
            force = tried
            continue
        # where stretch and bound meet, both straight between the springs
        left = max(width[i - 1] - force, 0.0)
        share = left / (left + tried - bound)
        middle = force + share * rate * spacing
        sticks += share * (force + middle) / 2 * spacing
        slips += (1 - share) * (middle + bound) / 2 * spacing
        stick += share * spacing
        force = bound
    return sticks, slips, stick


@njit(cache=True)
def _windows(gap, heights, depth, step):
    """Return normal and tangential force over E* dx and mu E* dx for each place of the window."""
    count, size = heights.size - gap.size + 1, gap.size
    normal, pulled = np.zeros(count), np.zeros(count)
    # a spring's force depends on its own height and place only: walk with each through the window
    for spring in range(heights.size):
        force = 0.0
        for place in range(size - 1, -1, -1):
            window = spring - place
            width = depth + heights[spring] - gap[place]
            if width <= 0:
                force = 0.0
                continue
            tried = force + step
            force = min(abs(tried), width) * np.sign(tried)
            if 0 <= window < count:
                normal[window] += width
                pulled[window] += force
    return normal, pulled
