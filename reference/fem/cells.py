"""Cell types of users' meshes, with their properties for contact.

Nodes are numbered as in scikit-fem; files use the order of VTK (meshio), which `CellKind.from_vtk`
converts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex, MeshHex2, MeshTet, MeshTet2
from skfem.quadrature import get_quadrature_tri

from reference.fem.element_stiffness import gauss_points, simplex_points

# Positions of VTK's nodes: corners, then the middles of these edges, faces and the cell.
_CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)
_CUBE_EDGES = (
    *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)),
    *((0, 4), (1, 5), (2, 6), (3, 7)),
)
CUBE_FACES = (
    *((0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)),
)
_TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_TETRAHEDRON_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
# The eight tetrahedra of Bey (1995, Computing 55, 355), by corners 0..3 and the middles above.
_BEY = (
    *((0, 4, 6, 7), (4, 1, 5, 8), (6, 5, 2, 9), (7, 8, 9, 3)),
    *((4, 6, 7, 8), (4, 6, 5, 8), (6, 7, 8, 9), (6, 5, 8, 9)),
)


def _vtk_locations(corners: NDArray[np.int64], *groups: tuple[tuple[int, ...], ...]) -> NDArray:
    middles = [
        corners[list(corner_numbers)].mean(axis=0) for group in groups for corner_numbers in group
    ]
    return np.array([*corners.astype(float), *middles])


@dataclass(frozen=True, eq=False)
class CellKind:
    """A cell type.

    Attributes
    ----------
    name : str
        Name in meshio.
    mesh : type
        Mesh class in scikit-fem.
    straight : type
        The mesh class of its straight-sided, linear version.
    vtk : (n, 3)
        Reference positions of the nodes in VTK's order.
    """

    name: str
    mesh: type[Any]
    straight: type[Any]
    vtk: NDArray[np.float64]

    @property
    def order(self) -> int:
        """Polynomial order of the displacement."""
        return 1 if self.mesh is self.straight else 2

    @property
    def simplex(self) -> bool:
        """Whether it is a tetrahedron."""
        return self.straight is MeshTet

    @property
    def locations(self) -> NDArray[np.float64]:
        """Reference positions (n, 3) of the nodes."""
        return np.asarray(self.mesh.elem.doflocs)

    @property
    def corners(self) -> int:
        """Number of corners, which come first."""
        return 4 if self.simplex else 8

    @property
    def faces(self) -> list[list[int]]:
        """Corners of the faces, in cyclic order."""
        return [list(face) for face in self.mesh.elem.refdom.facets]

    @cached_property
    def face_nodes(self) -> list[NDArray[np.int64]]:
        """All nodes of the faces."""
        return [
            np.flatnonzero(self._on_face(self.locations, face)) for face in range(len(self.faces))
        ]

    @cached_property
    def from_vtk(self) -> NDArray[np.int64]:
        """Positions of our nodes in VTK's order."""
        return _nearest(self.vtk, self.locations)

    def shapes(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray]:
        """Shape functions (n, m) and their reference gradients (n, 3, m) at points (m, 3)."""
        element = self.mesh.elem()
        both = [element.lbasis(points.T, i) for i in range(len(self.locations))]
        return np.array([value for value, _ in both]), np.array([slope for _, slope in both])

    @property
    def gauss_points(self) -> NDArray[np.float64]:
        """Integration points (m, 3) of the full stiffness."""
        rule = simplex_points(self.order) if self.simplex else gauss_points(self.order + 1)
        return rule[0].T

    def face_rule(self, face: int) -> tuple[NDArray[np.float64], NDArray, NDArray]:
        """Return integration points (m, 3) on a face, weights (m,), and tangents (2, 3)."""
        corners = self.locations[self.faces[face]]
        origin, across, along = corners[0], corners[1], corners[2 if self.simplex else -1]
        tangents = np.array([across - origin, along - origin])
        if self.simplex:
            plane, weights = get_quadrature_tri(2 * self.order)
        else:
            line, weight = np.polynomial.legendre.leggauss(self.order + 1)
            plane = 0.5 * (np.stack(np.meshgrid(line, line)).reshape(2, -1) + 1.0)
            weights = 0.25 * np.outer(weight, weight).ravel()
        return origin + plane.T @ tangents, weights, tangents

    @cached_property
    def children(self) -> NDArray[np.float64]:
        """Origin and three axes (8, 4, 3) of the eight child cells."""
        if not self.simplex:
            offsets = 0.5 * _CUBE
            axes = np.broadcast_to(0.5 * np.eye(3), (8, 3, 3))
            return np.concatenate([offsets[:, None], axes], axis=1)
        corners = _vtk_locations(_TETRAHEDRON, _TETRAHEDRON_EDGES)[np.array(_BEY)]
        frames = np.concatenate([corners[:, :1], corners[:, 1:] - corners[:, :1]], axis=1)
        mirrored = np.linalg.det(frames[:, 1:]) < 0.0
        frames[mirrored] = frames[mirrored][:, [0, 2, 1, 3]]
        return frames

    def in_child(self, child: int, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the positions of reference points of a child in the parent cell."""
        return self.children[child, 0] + points @ self.children[child, 1:]

    @cached_property
    def child_faces(self) -> list[list[tuple[int, int]]]:
        """The (child, face) pairs of every divided face."""
        return [
            [
                (child, child_face)
                for child in range(8)
                for child_face, corners in enumerate(self.faces)
                if self._on_face(self.in_child(child, self.locations[corners]), face).all()
            ]
            for face in range(len(self.faces))
        ]

    def _on_face(self, points: NDArray[np.float64], face: int) -> NDArray[np.bool_]:
        first, second, third = self.locations[self.faces[face][:3]]
        normal = np.cross(second - first, third - first)
        return np.abs((points - first) @ normal) < 1e-9  # reference cells have unit size


def _nearest(points: NDArray[np.float64], targets: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.linalg.norm(targets[:, None] - points, axis=-1).argmin(axis=1)


KINDS = {
    kind.name: kind
    for kind in (
        CellKind("hexahedron", MeshHex, MeshHex, _vtk_locations(_CUBE)),
        CellKind(
            "hexahedron27",
            MeshHex2,
            MeshHex,
            _vtk_locations(_CUBE, _CUBE_EDGES, CUBE_FACES, (tuple(range(8)),)),
        ),
        CellKind("tetra", MeshTet, MeshTet, _vtk_locations(_TETRAHEDRON)),
        CellKind("tetra10", MeshTet2, MeshTet, _vtk_locations(_TETRAHEDRON, _TETRAHEDRON_EDGES)),
    )
}
