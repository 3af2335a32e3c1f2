"""A user's mesh of a body: cells of one type, with checks, refinement and faces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from skfem import MeshHex, MeshTet

from reference.fem.cells import CUBE_FACES, KINDS, CellKind

# Relative Jacobian that counts as zero.
NO_VOLUME = 1e-9


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """A mesh with cells of one type.

    A face is a pair (cell, local face); arrays of faces have shape (k, 2).

    Attributes
    ----------
    kind : CellKind
    points : (n, 3)
    cells : (e, nodes)
        Nodes in the order of `kind.locations`.
    """

    kind: CellKind
    points: NDArray[np.float64]
    cells: NDArray[np.int64]

    @classmethod
    def from_vtk(
        cls, name: str, points: NDArray[np.float64], cells: NDArray[np.int64]
    ) -> SolidMesh:
        """Return a mesh from cells in VTK's numbering, as in meshio.

        ``hexahedron20`` become 27-node hexahedra: 20-node ones have negative weights at the corners
        of faces, which prevents nodal contact pressures. Unused points are dropped.

        Raises
        ------
        ValueError
            For an unsupported cell type.

        Examples
        --------
        >>> cube = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
        >>> mesh = SolidMesh.from_vtk("hexahedron", cube, np.array([[0, 1, 3, 2, 4, 5, 7, 6]]))
        >>> len(mesh.boundary_faces), len(mesh.inverted())
        (6, 0)
        """
        points = np.asarray(points, dtype=float)
        cells = np.asarray(cells, dtype=np.int64)
        if name == "hexahedron20":
            points, cells = _with_middles(points, cells)
            name = "hexahedron27"
        if name not in KINDS:
            raise ValueError(f"expected {', '.join(KINDS)} or hexahedron20, got {name!r}")
        kind = KINDS[name]
        used, numbers = np.unique(cells[:, kind.from_vtk], return_inverse=True)
        return cls(kind, points[used], numbers.reshape(len(cells), -1))

    @property
    def corner_cells(self) -> NDArray[np.int64]:
        """Corners (e, 4 or 8) of the cells."""
        return self.cells[:, : self.kind.corners]

    @cached_property
    def face_corners(self) -> NDArray[np.int64]:
        """Sorted corners (e, faces, 3 or 4) of all faces."""
        return np.sort(self.cells[:, np.array(self.kind.faces)], axis=-1)

    @cached_property
    def boundary_faces(self) -> NDArray[np.int64]:
        """Faces (k, 2) of one cell only."""
        corners = self.face_corners.reshape(-1, self.face_corners.shape[-1])
        _, first, counts = np.unique(corners, axis=0, return_index=True, return_counts=True)
        return np.stack(np.divmod(np.sort(first[counts == 1]), len(self.kind.faces)), axis=1)

    def faces_within(self, inside: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Return the boundary faces (k, 2) with all corners among the marked nodes (n,)."""
        cells, faces = self.boundary_faces.T
        return self.boundary_faces[inside[self.face_corners[cells, faces]].all(axis=1)]

    def nodes_of(self, faces: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return all distinct nodes of the given faces in increasing order."""
        parts = [
            self.cells[faces[faces[:, 1] == face, 0]][:, nodes].ravel()
            for face, nodes in enumerate(self.kind.face_nodes)
        ]
        return np.unique(np.concatenate(parts))

    def inverted(self) -> NDArray[np.int64]:
        """Return cells with a Jacobian < 0 at a node, or <= 0 at an integration point."""
        at_points = self._jacobians(self.kind.gauss_points)
        tiny = NO_VOLUME * np.median(np.abs(at_points))
        at_nodes = self._jacobians(self.kind.locations)
        wrong = (at_points <= tiny).any(axis=1) | (at_nodes < -tiny).any(axis=1)
        return np.flatnonzero(wrong)

    def _jacobians(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        _, slopes = self.kind.shapes(points)
        gradient = np.einsum("eni,ndq->eqid", self.points[self.cells], slopes, optimize=True)
        return np.linalg.det(gradient)

    def parts(self) -> int:
        """Return the number of pieces that are not connected by a face, edge or node."""
        start = np.repeat(self.cells[:, :1], self.cells.shape[1], axis=1)
        pairs = (start.ravel(), self.cells.ravel())
        graph = coo_matrix((np.ones(self.cells.size), pairs), shape=(len(self.points),) * 2)
        return int(connected_components(graph, directed=False)[0])

    def transformed(self, origin: NDArray[np.float64], axes: NDArray[np.float64]) -> SolidMesh:
        """Return the mesh in coordinates ``axes @ (p - origin)``; the axes may be left-handed."""
        return replace(self, points=(self.points - origin) @ np.asarray(axes).T)

    def face_integrals(
        self, faces: NDArray[np.int64]
    ) -> list[tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]]:
        """Return nodes, shape functions and outward area vectors at integration points of faces.

        Returns
        -------
        list of (nodes (k, n), shapes (n, m), areas (k, m, 3))
            One entry per occurring local face; the areas include the weights.
        """
        integrals = []
        for face in np.unique(faces[:, 1]):
            cells = self.cells[faces[faces[:, 1] == face, 0]]
            points, weights, tangents = self.kind.face_rule(int(face))
            shapes, slopes = self.kind.shapes(points)
            corners = self.points[cells]
            edges = np.einsum("kni,ndq,td->tkqi", corners, slopes, tangents, optimize=True)
            areas = np.cross(edges[0], edges[1]) * weights[:, None]
            outward = np.einsum("kni,nq->kqi", corners, shapes) - corners.mean(axis=1)[:, None]
            sign = np.sign(np.einsum("kqi,kqi->k", areas, outward))
            nodes = self.kind.face_nodes[int(face)]
            integrals.append((cells[:, nodes], shapes[nodes], areas * sign[:, None, None]))
        return integrals

    def find(self, corners: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the boundary faces (k, 2) with the given corners (m, 3 or 4), if they exist.

        Corners may be in any order.
        """
        cells, faces = self.boundary_faces.T
        if corners.shape[1] != self.face_corners.shape[-1]:
            return np.zeros((0, 2), dtype=np.int64)
        keys = _keys(len(self.points))
        sums = keys[self.face_corners[cells, faces]].sum(axis=1)
        return self.boundary_faces[np.isin(sums, keys[corners].sum(axis=1))]

    def refined(
        self, *marked: NDArray[np.int64]
    ) -> tuple[SolidMesh, NDArray[np.int64], list[NDArray[np.int64]]]:
        """Return the mesh with cells divided into eight along its curves, and the marked faces.

        Nodes of neighbours are identified by their interpolation weights (multiples of 1/512), not
        by position, so that cracks stay open.

        Returns
        -------
        SolidMesh
        numbers : (n,)
            New numbers of the old nodes.
        list of (k, 2)
            The marked faces, divided into four.
        """
        kind = self.kind
        places = np.concatenate([kind.in_child(child, kind.locations) for child in range(8)])
        weights = np.round(512.0 * kind.shapes(places)[0].T).astype(np.int64)
        keys = _keys(len(self.points))
        names = keys[self.cells] @ weights.T  # integer overflow is intended (a hash)
        distinct, first, numbers = np.unique(names.ravel(), return_index=True, return_inverse=True)
        cell, place = np.divmod(first, len(places))
        points = np.einsum("pn,pni->pi", weights[place] / 512.0, self.points[self.cells[cell]])
        cells = numbers.reshape(8 * len(self.cells), -1)
        old = np.searchsorted(distinct, 512 * keys)
        finer = replace(self, points=points, cells=cells)
        return finer, old, [self._cut(faces) for faces in marked]

    def _cut(self, faces: NDArray[np.int64]) -> NDArray[np.int64]:
        pieces = np.array(self.kind.child_faces)[faces[:, 1]]
        cells = 8 * faces[:, 0, None] + pieces[..., 0]
        return np.stack([cells, pieces[..., 1]], axis=-1).reshape(-1, 2)

    def to_scikit(self) -> tuple[MeshHex | MeshTet, NDArray[np.int64]]:
        """Return the mesh in scikit-fem, and its numbers (n,) of our nodes."""
        corners = self.corner_cells
        used, t = np.unique(corners, return_inverse=True)
        t = np.ascontiguousarray(t.reshape(corners.shape).T)
        mesh = self.kind.straight(np.ascontiguousarray(self.points[used].T), t)
        if self.kind.order == 2:
            mesh = self.kind.mesh.from_mesh(mesh)
            locations = np.array(mesh.doflocs)
            locations[:, mesh.dofs.element_dofs] = self.points[self.cells].transpose(2, 1, 0)
            mesh = self.kind.mesh(locations, mesh.t)
        numbers = np.empty(len(self.points), dtype=np.int64)
        numbers[self.cells.T] = mesh.dofs.element_dofs
        return mesh, numbers


def _keys(count: int) -> NDArray[np.int64]:
    """Return random numbers per node, whose sums identify sets of nodes in any order."""
    return np.random.default_rng(0).integers(2**62, size=count, dtype=np.int64)


def _with_middles(
    points: NDArray[np.float64], cells: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Add the centres of faces and cells to 20-node hexahedra, by their interpolation.

    At the centre of a face corners have the weight -1/4 and edges 1/2; at the centre of the cell
    -1/4 and 1/4.
    """
    middle_weights = np.concatenate([np.full(8, -0.25), np.full(12, 0.25)])
    vtk = KINDS["hexahedron27"].vtk
    columns, new = [cells], [points]
    count = len(points)
    face_values, face_names = [], []
    for face, corners in enumerate(CUBE_FACES):
        middle = vtk[20 + face]
        edges = [k for k in range(8, 20) if np.isclose(np.abs(vtk[k] - middle).sum(), 0.5)]
        values = 0.5 * points[cells[:, edges]].sum(axis=1)
        face_values.append(values - 0.25 * points[cells[:, list(corners)]].sum(axis=1))
        face_names.append(np.sort(cells[:, list(corners)], axis=1))
    names = np.stack(face_names, axis=1).reshape(-1, 4)
    _, first, numbers = np.unique(names, axis=0, return_index=True, return_inverse=True)
    new.append(np.stack(face_values, axis=1).reshape(-1, 3)[first])
    columns.append(count + numbers.reshape(len(cells), 6))
    count += len(first)
    new.append(np.einsum("n,eni->ei", middle_weights, points[cells]))
    columns.append(count + np.arange(len(cells))[:, None])
    return np.concatenate(new), np.concatenate(columns, axis=1)
