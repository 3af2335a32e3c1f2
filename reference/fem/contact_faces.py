"""Contact faces of a condensed body: quadrilaterals with candidates as nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skfem import MeshTet
from skfem.element import ElementQuad1, ElementQuad2

from reference.errors import ConvergenceError
from reference.fem.body import CondensedBody
from reference.fem.element_stiffness import element_order
from reference.fem.mesh import facet_quadrature

# Largest deviation of nodes from the straight-sided face, as a fraction of its size.
STRAIGHT = 1e-7
_ELEMENTS = {1: ElementQuad1, 2: ElementQuad2}


@dataclass(frozen=True, eq=False)
class ContactFaces:
    """Faces in the plane of the contact.

    Attributes
    ----------
    nodes : (m, 4) or (m, 9)
        Candidates of the body at the nodes.
    corners : (m, 4, 2)
        In cyclic order, as the reference square (0, 0), (1, 0), (1, 1), (0, 1).
    order : int
        1 bilinear, 2 biquadratic.
    """

    nodes: NDArray[np.int64]
    corners: NDArray[np.float64]
    order: int

    @classmethod
    def of(cls, body: CondensedBody, length: float) -> ContactFaces:
        """Return the faces with candidates at all nodes, in units of `length`.

        Raises
        ------
        ValueError
            For tetrahedra, and for faces with curved sides (those of `RingMesh`), because overlaps
            have straight sides.
        """
        mesh = body.grid.mesh
        if isinstance(mesh, MeshTet):
            raise ValueError("two bodies need quadrilateral faces: hexahedra, not tetrahedra")
        order = element_order(mesh)
        numbers = facet_quadrature(mesh, body.grid.surface, 1)[0]
        candidate = np.full(mesh.p.shape[1], -1)
        candidate[body.nodes] = np.arange(len(body.nodes))
        numbers = numbers[(candidate[numbers] >= 0).all(axis=1)]
        if not len(numbers):
            raise ValueError("no face has only candidates as nodes")
        places = (mesh.p[:2, numbers] + body.offset[:, None, None]).transpose(1, 2, 0)
        corners = places[:, :4]
        at_nodes = _values(1, _ELEMENTS[order].doflocs.T)
        beside = np.abs(np.einsum("mcd,cn->mnd", corners, at_nodes) - places).max(axis=(1, 2))
        if (beside > STRAIGHT * np.ptp(corners, axis=1).max(axis=1)).any():
            raise ValueError("two bodies need contact faces with straight sides and even nodes")
        return cls(candidate[numbers], corners * (body.length / length), order)

    def shapes(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        """Shape functions (..., 4 or 9) at reference points (..., 2)."""
        return _values(self.order, local.reshape(-1, 2).T).T.reshape(*local.shape[:-1], -1)

    def local(self, face: NDArray[np.int64], points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return reference coordinates (k, ..., 2) of points (k, ..., 2) of faces (k,).

        By Newton's method on the bilinear map; one step for parallelograms.
        """
        flat = points.reshape(len(face), -1, 2)
        a, b, c, d = np.moveaxis(self.corners[face][:, :, None], 1, 0)
        result = np.full(flat.shape, 0.5)
        for _ in range(30):
            s, t = result[..., :1], result[..., 1:]
            place = a + s * (b - a) + t * (d - a) + s * t * (a - b + c - d)
            across = b - a + t * (a - b + c - d)
            along = d - a + s * (a - b + c - d)
            error = flat - place
            det = across[..., 0] * along[..., 1] - across[..., 1] * along[..., 0]
            step = np.stack(
                [
                    error[..., 0] * along[..., 1] - error[..., 1] * along[..., 0],
                    across[..., 0] * error[..., 1] - across[..., 1] * error[..., 0],
                ],
                axis=-1,
            )
            result = result + step / det[..., None]
            if np.abs(step / det[..., None]).max(initial=0.0) < 1e-14:
                return result.reshape(points.shape)
        raise ConvergenceError("a point was not found in its face: a face is too distorted")


def _values(order: int, local: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shape functions (4 or 9, k) of a face at reference points (2, k)."""
    element = _ELEMENTS[order]()
    return np.array([element.lbasis(local, i)[0] for i in range(len(element.doflocs))])
