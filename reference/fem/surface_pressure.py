"""Pressure from nodal forces for a contact that fills the mesh circle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from skfem.element import ElementQuad1, ElementQuad2

from reference.fem.body import CondensedBody
from reference.fem.contact_area import fitted_area
from reference.fem.mesh import facet_quadrature

GAUSS_POINTS = 6  # per direction; error by the root at the rim 1e-5 of its force


class RingPressure:
    """Weighted projection of nodal forces onto ``p = q sqrt(1 - rho^2)``.

    Nodal forces are the moments ``R_i = int N_i p dA`` of the pressure. Force over tributary area
    mixes values over an element, and with nodal contact conditions on quadratic elements
    neighbouring forces alternate by some per cent. Solving ``int M_i M_j sqrt(1 - rho^2) dA q_j =
    sum_k M_i(x_k) R_k`` for a q that is bilinear between the corners of the elements (shape
    functions M) averages over patches of elements, conserves force and first moments, and separates
    the known root at the edge from the interpolation: for Hertz q is constant. Rho is the radius
    over that of the contact, which is slightly larger than the mesh circle.

    Parameters
    ----------
    body : CondensedBody
        A body of any size, because the projection depends only on the mesh.
    stiffness : float
        dF/dd of the body with all nodes within the mesh circle in contact.
    """

    def __init__(self, body: CondensedBody, stiffness: float) -> None:
        mesh = body.grid.mesh
        self.inside = body.inside_ring
        place = np.full(mesh.p.shape[1], -1)
        place[body.nodes[self.inside]] = np.arange(int(self.inside.sum()))
        area = fitted_area(body, stiffness) / (body.length * body.length)
        self.reach = np.sqrt(area / (np.pi * np.prod(body.stretch)))
        self.root = self._root(body, body.scaled_points[self.inside])
        nodes, _, points, areas = facet_quadrature(mesh, body.grid.surface, GAUSS_POINTS)
        covered = (place[nodes] >= 0).all(axis=1)
        nodes = place[nodes[covered]]
        weight = np.abs(areas[covered, :, 2]) * self._root(body, points[covered, :, :2])
        used, corners = np.unique(nodes[:, :4], return_inverse=True)
        corners = corners.reshape(-1, 4)
        line, _ = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        local = 0.5 * (np.stack(np.meshgrid(line, line)).reshape(2, -1) + 1.0)
        shapes = _bilinear(local)
        matrix = np.zeros((len(used), len(used)))
        blocks = np.einsum("nq,fq,mq->fnm", shapes, weight, shapes, optimize=True)
        np.add.at(matrix, (corners[:, :, None], corners[:, None, :]), blocks)
        self.factor = cho_factor(matrix, overwrite_a=True)
        self.interpolation = np.zeros((len(self.root), len(used)))
        self.interpolation[nodes[:, None, :], corners[:, :, None]] = _bilinear(
            ElementQuad2().doflocs.T
        )

    def _root(self, body: CondensedBody, points: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y = (points[..., axis] / body.stretch[axis] / self.reach for axis in (0, 1))
        return np.asarray(np.sqrt(np.clip(1.0 - x**2 - y**2, 0.0, None)))

    def pressure(self, body: CondensedBody, reactions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the pressure at the candidates (n,) of the (scaled) body; zero outside."""
        result = np.zeros_like(reactions)
        moments = self.interpolation.T @ reactions[self.inside]
        smooth = self.interpolation @ cho_solve(self.factor, moments)
        result[self.inside] = smooth * self.root / (body.length * body.length)
        return result


def _bilinear(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values (4, points) of the bilinear shape functions on the unit square."""
    return np.array([ElementQuad1().lbasis(points, i)[0] for i in range(4)])
