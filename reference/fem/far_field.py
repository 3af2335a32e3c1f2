"""The exterior of the half-space: fields of point forces outside the meshed region.

Outside the mesh the displacement is a combination of a few exact solutions for point forces on the
surface. These have a traction-free surface and vanish at infinity, so the energy of the
unmeshed exterior is an integral over the common boundary, and mesh and exterior together are one
Ritz approximation of the *whole* half-space: symmetric, positive definite, with an error in the
compliance of higher order in (contact radius / mesh radius) than a prescribed far displacement.

All fields are for a unit Young's modulus, z into the half-space.
"""

import numpy as np

from reference.arrays import Array


def boussinesq(points: Array, poisson_ratio: float) -> tuple[Array, Array]:
    """Return displacement and its gradient for a unit force into the half-space at the origin.

    ``u = [-z grad(1/r) - (1 - 2 nu) grad ln(r + z) + (3 - 4 nu) e_z / r] / (4 pi mu)`` (Boussinesq;
    Johnson 1985, eq. 3.18) and ``gradient[..., i, j] = d u_i / d x_j``, at points (..., 3) except
    the origin. On the surface ``u_z = (1 - nu^2)/(pi E r)``:

    >>> u, _ = boussinesq(np.array([2.0, 0.0, 0.0]), 0.5)
    >>> round(float(u[2] * np.pi * 2.0), 12)
    0.75
    """
    shear = 0.5 / (1.0 + poisson_ratio)
    soft, hard = 1 - 2 * poisson_ratio, 3 - 4 * poisson_ratio
    z = points[..., 2, None]
    r = np.linalg.norm(points, axis=-1)[..., None]
    # phi = 1/r and psi = ln(r + z)
    grad_phi = -points / r**3
    grad_psi = points / (r * (r + z))
    grad_psi[..., 2] = 1.0 / r[..., 0]
    vertical = np.array([0.0, 0.0, 1.0])
    displacement = -z * grad_phi - soft * grad_psi + hard * vertical / r
    outer = points[..., :, None] * points[..., None, :]
    r, z = r[..., None], z[..., None]
    hess_phi = 3.0 * outer / r**5 - np.eye(3) / r**3
    hess_psi = np.eye(3) / (r * (r + z)) - outer * (2 * r + z) / (r**3 * (r + z) ** 2)
    hess_psi[..., 2, :] = grad_phi
    hess_psi[..., :, 2] = grad_phi
    gradient = -grad_phi[..., :, None] * vertical - z * hess_phi - soft * hess_psi
    gradient = gradient + hard * vertical[:, None] * grad_phi[..., None, :]
    factor = 1.0 / (4.0 * np.pi * shear)
    return factor * displacement, factor * gradient


def cerruti(points: Array, poisson_ratio: float) -> Array:
    """Return the displacement (..., 3) for a unit force along x at the origin.

    Cerruti 1882; Johnson 1985, eqs. (3.76). On the surface, transverse to the force, ``u_x = (1 -
    nu)/(2 pi G r)`` with ``G = E/(2 (1 + nu))``:

    >>> u = cerruti(np.array([0.0, 2.0, 0.0]), 0.25)
    >>> round(float(u[0] * 2 * np.pi * 2.0), 12)
    1.875
    """
    x, y, z = np.moveaxis(np.asarray(points, dtype=float), -1, 0)
    r = np.sqrt(x * x + y * y + z * z)
    soft, beyond = 1 - 2 * poisson_ratio, r + z
    along = 1 / r + x * x / r**3 + soft * (1 / beyond - x * x / (r * beyond**2))
    across = x * y / r**3 - soft * x * y / (r * beyond**2)
    inwards = x * z / r**3 + soft * x / (r * beyond)
    return (1 + poisson_ratio) / (2 * np.pi) * np.stack([along, across, inwards], axis=-1)


def source_groups(half_x: float, half_y: float, planes: tuple[bool, bool]) -> list[Array]:
    """Return positions of the point forces, one group (n, 2) per far-field unknown.

    One force at the centre carries the load; the others, at a distance comparable with the loaded
    region, carry its first, second and (1, 1) mixed moments. Mirror images in planes of symmetry
    (x = 0, y = 0) belong to one unknown.
    """
    sides = [(0, 1) if plane else (0, 1, -1) for plane in planes]
    offsets = [(i * half_x, j * half_y) for i in sides[0] for j in sides[1]]
    x_signs, y_signs = [(1, -1) if plane else (1,) for plane in planes]
    images = np.array([[sx, sy] for sy in y_signs for sx in x_signs])
    return [images * np.array(offset) for offset in offsets]


def group_field(points: Array, group: Array, poisson_ratio: float) -> tuple[Array, Array]:
    """Return `boussinesq` for a unit force divided equally among the positions of a group."""
    fields = [boussinesq(points - np.array([x, y, 0.0]), poisson_ratio) for x, y in group]
    displacement = np.sum([u / len(group) for u, _ in fields], axis=0)
    gradient = np.sum([du / len(group) for _, du in fields], axis=0)
    return displacement, gradient


def exterior_stiffness(
    points: Array, areas: Array, groups: list[Array], poisson_ratio: float
) -> Array:
    """Return the stiffness of the exterior on the far-field unknowns, one for each group.

    It is twice the elastic energy outside, by Clapeyron's theorem ``-int t(u_k) . u_l dS`` over the
    outer boundary of a convex region around the origin, given by points (..., 3) and the area
    vectors that belong to them, of either sign.
    """
    areas = areas * np.sign((areas * points).sum(axis=-1))[..., None]  # outward
    shear = 0.5 / (1.0 + poisson_ratio)
    displacements, tractions = [], []
    for group in groups:
        u, du = group_field(points, group, poisson_ratio)
        # lambda div u = -nu z / (pi r^3), finite also for nu = 1/2
        pressed = np.zeros(points.shape[:-1])
        for x, y in group:
            radius = np.linalg.norm(points - np.array([x, y, 0.0]), axis=-1)
            pressed -= poisson_ratio * points[..., 2] / (np.pi * radius**3) / len(group)
        stress = shear * (du + np.swapaxes(du, -1, -2)) + pressed[..., None, None] * np.eye(3)
        displacements.append(u.reshape(-1, 3))
        tractions.append(np.einsum("...ij,...j->...i", stress, areas).reshape(-1, 3))
    work = -np.einsum("kqi,lqi->kl", np.array(tractions), np.array(displacements))
    return 0.5 * (work + work.T)
