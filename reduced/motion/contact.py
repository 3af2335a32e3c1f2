"""The contact of Fig. 19.4: force and energy of springs under a rigid mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reduced.arguments import positive_faults, refuse
from reduced.errors import ConvergenceError
from reduced.profiles.section import Profile
from reduced.springs.line import NodalLine, SmoothLine, Springs

_MARGIN = 1.01
_LEAST, _MOST = 1e-150, 1e150  # beyond this, energies exceed the range of floating point


@dataclass(frozen=True)
class SpringContact:
    """A profile on springs of stiffness E* dx (19.14), constructed by `spring_contact`.

    Attributes
    ----------
    line : SmoothLine or NodalLine
        The springs.
    effective_modulus : float
        E*.
    deepest : float
        Penetration for which the springs were created; beyond it, the last cell is continued.
    """

    line: SmoothLine | NodalLine
    effective_modulus: float
    deepest: float

    def respond(self, penetration: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return force, energy and stiffness dF/dd = E* times the contact length; 0 for d <= 0."""
        d = np.asarray(penetration, dtype=float)
        flat = d.ravel()
        touching = flat > 0
        out = np.zeros((3, flat.size))
        out[:, touching] = self.effective_modulus * np.array(self.line.respond(flat[touching]))
        stiffness, force, energy = (row.reshape(d.shape) for row in out)
        return force, energy, stiffness


def spring_contact(springs: Springs, deepest: float) -> SpringContact:
    """Return a profile on springs for penetrations up to `deepest`.

    Parameters
    ----------
    springs : Springs
        The profile and its springs; `per_radius` refers to the largest penetration.
    deepest : float
        Largest penetration of the motion; `impact_depth` estimates that of an impact.

    Examples
    --------
    >>> from reduced.profiles.equivalents import paraboloid
    >>> ball = spring_contact(Springs(paraboloid(1.0), 1.0), 0.25)
    >>> force, energy, stiffness = ball.respond(0.25)
    >>> round(float(force), 12), round(float(stiffness), 12)  # (4/3) E* sqrt(R) d^1.5, 2 E* a
    (0.166666666667, 1.0)
    """
    refuse(positive_faults(deepest=deepest))
    line = springs.lay(float(springs.profile.contact_radius(deepest)))
    return SpringContact(line, float(springs.effective_modulus), float(deepest))


def impact_depth(
    profile: Profile, effective_modulus: float, kinetic_energy: float, load: float = 0.0
) -> float:
    """Return a penetration at most 1 % beyond that at which the springs stop the mass.

    It uses few springs and only sizes the springs for the motion.

    Parameters
    ----------
    profile, effective_modulus
        g(x) and E*.
    kinetic_energy : float
        m v^2/2 at first touch; 0 if only the load moves the mass.
    load : float
        Constant force on the mass (its weight), >= 0.

    Raises
    ------
    ConvergenceError
        If no finite depth is enough.
    """
    wrong = positive_faults(effective_modulus=effective_modulus)
    if not (min(kinetic_energy, load) >= 0 and 0 < kinetic_energy + load < np.inf):
        wrong.append(f"expected kinetic energy or load, got {kinetic_energy!r} and {load!r}")
    refuse(wrong)
    few = Springs(profile, effective_modulus, per_radius=8)

    def stops(depth: float) -> bool:
        contact = spring_contact(few, depth)
        return bool(contact.respond(depth)[1] - load * depth >= kinetic_energy)

    depth, factor = float(profile.length), 4.0
    while stops(depth) and depth > _LEAST:
        depth /= factor
    while factor > _MARGIN:
        while not stops(depth):
            depth *= factor
            if not depth < _MOST:
                raise ConvergenceError("the contact stops the mass at no depth", [kinetic_energy])
        depth, factor = depth / factor, np.sqrt(factor)
    return depth * factor**2
