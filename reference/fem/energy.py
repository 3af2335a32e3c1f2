"""Where the elastic energy of a contact is."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.fem.body import CondensedBody
from reference.fem.elasticity import element_order, gauss_points, shape_gradients
from reference.fem.recovery import recover


def energy_within(
    body: CondensedBody, reactions: ArrayLike, radii: ArrayLike
) -> tuple[NDArray[np.float64], float]:
    """Elastic energy within some distances of the centre of the contact, and all of it.

    The chapter's (19.10) argues that the energy of a contact sits within a distance of the order
    of its size: the far field decays as u ~ F/(E* r), with an energy of order F^2/(E* r) beyond r.
    Integrated at the Gauss points, so that a radius cuts elements in steps of a Gauss point; the
    total ``1/2 sum R u`` contains the unmeshed exterior.

    Parameters
    ----------
    body : CondensedBody
        A half-space, with ``nu <= 0.4999``.
    reactions : (n,)
        `Contact.reactions`.
    radii : (k,)
        In consistent units, up to the extent of the mesh.

    Returns
    -------
    within : (k,)
    total : float
        Both of all symmetric parts together.

    Raises
    ------
    ValueError
        For a radius that is not positive or leaves the mesh, and for incompressible bodies.
    """
    radii = np.atleast_1d(np.asarray(radii, dtype=float))
    mesh = body.grid.mesh
    reach = float(np.abs(mesh.p).max(axis=1).min()) * body.length
    wrong = []
    if not (np.isfinite(radii).all() and (radii > 0.0).all() and radii.max() <= reach):
        wrong.append(f"radii must be positive and at most the mesh's {reach:.6g}, got {radii!r}")
    if len(body.system.mean_stresses):
        wrong.append(f"poisson_ratio must be at most 0.4999, got {body.poisson_ratio!r}")
    if wrong:
        raise ValueError("; ".join(wrong))
    body, reactions = body.at_nodes(reactions)
    fields = recover(body, reactions)
    places, energies = _gauss_energies(body, fields.displacement / body.length)
    distance = np.linalg.norm(places, axis=-1) * body.length
    unit = body.symmetry * body.youngs_modulus * body.length * body.length * body.length
    within = np.array([energies[distance <= radius].sum() for radius in radii]) * unit
    pushed = fields.displacement[body.nodes, 2]
    total = 0.5 * body.symmetry * float(reactions @ pushed)
    return within, total


def _gauss_energies(
    body: CondensedBody, displacement: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places and energies of the Gauss points, scaled.

    Each element's energy ``1/2 u K u`` (with its reduced integration) is shared out in proportion
    to the density at its Gauss points.
    """
    mesh = body.grid.mesh
    order = element_order(mesh)
    elements = mesh.dofs.element_dofs.T
    nodal = displacement[elements]
    flat = nodal.reshape(len(elements), -1)
    whole = 0.5 * np.einsum("ei,eij,ej->e", flat, body.system.matrices, flat, optimize=True)
    gradients, volumes = shape_gradients(mesh, order + 1)
    gradient = np.einsum("eqaj,eai->eqij", gradients, nodal, optimize=True)
    strain = 0.5 * (gradient + np.swapaxes(gradient, -1, -2))
    density = (strain**2).sum(axis=(-1, -2)) * volumes
    total = density.sum(axis=1, keepdims=True)
    share = np.divide(density, total, out=np.zeros_like(density), where=total > 0.0)
    points, _ = gauss_points(order + 1)
    element = mesh.elem()
    shapes = np.array([element.lbasis(points, i)[0] for i in range(elements.shape[1])])
    places = np.einsum("aq,eai->eqi", shapes, mesh.doflocs.T[elements])
    return places, share * whole[:, None]
