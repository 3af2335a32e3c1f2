"""Contact area and radius from nodal results."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipk

from reference.fem.body import CondensedBody


def best_area(
    body: CondensedBody,
    reactions: NDArray[np.float64],
    active: NDArray[np.bool_],
    *,
    sharp: bool,
) -> float:
    """Return the best estimate of the total contact area on a fixed mesh.

    - Contact at exactly the nodes of the mesh circle, with the shape ending there (`sharp`): the
      area of the circle.
    - One round or elliptic contact: from `contact_radius`.
    - Else the tributary area of the active nodes, uncertain by half a node spacing along the edge.
    """
    raw = float(body.symmetry * body.weights[active].sum())
    if body.ring is None or not active.any():
        return raw
    if sharp and np.array_equal(active, body.inside_ring):
        return _ellipse(body, body.ring * body.length)
    radius = contact_radius(body, reactions, active)
    return raw if radius is None else _ellipse(body, radius)


def fitted_area(body: CondensedBody, stiffness: float) -> float:
    """Return the area of a smooth contact with its edge on the mesh circle, or a node beside it.

    The area of the flat punch with the stiffness ``pi E* a / K(1 - b^2/a^2)`` (Johnson 1985) of
    the contact set: nodes on the circle carry load slightly beyond it, 0.2 % of the radius.
    """
    minor, major = sorted(body.stretch)
    assert body.ring is not None, "only meshes with a ring are fitted"
    radius = body.ring * body.length
    exact = np.pi * body.effective_modulus * major * radius / ellipk(1.0 - (minor / major) ** 2)
    return _ellipse(body, radius * stiffness / exact)


def _ellipse(body: CondensedBody, radius: float) -> float:
    return float(np.pi * body.stretch[0] * body.stretch[1] * radius * radius)


def contact_radius(
    body: CondensedBody, reactions: NDArray[np.float64], active: NDArray[np.bool_]
) -> float | None:
    """Return the radius of a round contact from the moments of its pressure.

    With ``p = sqrt(a^2 - r^2) (c_0 + c_1 r^2)``, exact for a paraboloid (Hertz) and for
    ``f = c r^4`` (Johnson 1985, sec. 5.3), the force-weighted means of r^2 and r^4 give
    ``a^2 = (7 <r^2> - sqrt(49 <r^2>^2 - 63/2 <r^4>)) / 2``. Moments are as accurate as the force,
    while the set of active nodes jumps by whole spacings.

    Returns
    -------
    float or None
        Radius before stretching. None for a tensor body, and if the pressure is not of this form:
        the contact is not a full disc, or the result differs from the active nodes by more than a
        spacing (cone, flat punch).
    """
    if body.ring is None or not active.any():
        return None
    radii = body.scaled_radii
    reach = radii[active].max()
    radius = radius_from_moments(radii, reactions)
    if radius is None or not active[radii < 0.8 * reach].all():
        return None
    spacing = body.spacing_scaled / np.sqrt(body.stretch[0] * body.stretch[1])
    return float(radius * body.length) if abs(radius - reach) < spacing else None


def radius_from_moments(radii: NDArray[np.float64], reactions: NDArray[np.float64]) -> float | None:
    """Return `moment_radius` of nodal forces at the given radii."""
    second, fourth = (reactions @ radii**k / reactions.sum() for k in (2, 4))
    return moment_radius(second, fourth)


def moment_radius(second: float, fourth: float) -> float | None:
    """Return the radius of ``p = sqrt(a^2 - r^2) (c_0 + c_1 r^2)`` from its means of r^2 and r^4.

    None if such a pressure cannot have these means.

    Examples
    --------
    Hertz's pressure of radius one:

    >>> round(moment_radius(2.0 / 5.0, 8.0 / 35.0), 12)
    1.0
    """
    root = 49.0 * second**2 - 31.5 * fourth
    return None if root < 0.0 else float(np.sqrt(0.5 * (7.0 * second - np.sqrt(root))))
