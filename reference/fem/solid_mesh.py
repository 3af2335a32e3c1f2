"""Meshes of users' bodies: cells of one type, with checks, refinement and faces.

Nodes are numbered as in scikit-fem; files use the order of VTK (meshio), which `CellKind.from_vtk`
converts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from skfem import MeshHex, MeshHex2, MeshTet, MeshTet2
from skfem.quadrature import get_quadrature_tri

from reference.arrays import Array, Integers, Mask
from reference.errors import refuse
from reference.fem.element_stiffness import (
    gauss_rule,
    gauss_square,
    shape_functions,
    simplex_points,
)

# Relative Jacobian that counts as zero.
NO_VOLUME = 1e-9
# Under uniform pressure the corners of a ten-node tetrahedron carry no force.
NO_WEIGHT = 1e-6
RIGID_MOTIONS = (
    *("translation along x", "translation along y", "translation along z"),
    *("rotation about x", "rotation about y", "rotation about z"),
)

# Positions of VTK's nodes: corners, then the middles of these edges, faces and the cell.
CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)
_CUBE_EDGES = (
    *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)),
    *((0, 4), (1, 5), (2, 6), (3, 7)),
)
_CUBE_FACES = (
    *((0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)),
)
_TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_TETRAHEDRON_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
# The eight tetrahedra of Bey (1995, Computing 55, 355), by corners 0..3 and the middles above.
_BEY = (
    *((0, 4, 6, 7), (4, 1, 5, 8), (6, 5, 2, 9), (7, 8, 9, 3)),
    *((4, 6, 7, 8), (4, 6, 5, 8), (6, 7, 8, 9), (6, 5, 8, 9)),
)


def _vtk_locations(corners: Integers, *groups: tuple[tuple[int, ...], ...]) -> Array:
    middles = [corners[list(numbers)].mean(axis=0) for group in groups for numbers in group]
    return np.array([*corners.astype(float), *middles])


class CellKind:
    """A cell type: its name in meshio, and what scikit-fem knows of it.

    Of its mesh class `straight` is the straight-sided, linear version. Nodes have the reference
    positions `locations` (n, 3), corners first; `vtk` are these in VTK's order, where `from_vtk`
    finds ours. Faces have their corners in cyclic order, `face_nodes` all nodes.
    """

    def __init__(self, name: str, mesh: type[Any], straight: type[Any], vtk: Array) -> None:
        self.name, self.mesh, self.straight, self.vtk = name, mesh, straight, vtk
        self.order = 1 if mesh is straight else 2
        self.simplex = straight is MeshTet
        self.corners = 4 if self.simplex else 8
        self.locations: Array = np.asarray(mesh.elem.doflocs)
        self.from_vtk = np.linalg.norm(self.locations[:, None] - vtk, axis=-1).argmin(axis=1)
        self.faces: list[list[int]] = [list(face) for face in mesh.elem.refdom.facets]
        self.face_nodes = [
            np.flatnonzero(self._on_face(self.locations, face)) for face in range(len(self.faces))
        ]

    @cached_property
    def children(self) -> Array:
        """Origin and three axes (8, 4, 3) of the eight child cells."""
        if not self.simplex:
            axes = np.broadcast_to(0.5 * np.eye(3), (8, 3, 3))
            return np.concatenate([0.5 * CUBE[:, None], axes], axis=1)
        corners = _vtk_locations(_TETRAHEDRON, _TETRAHEDRON_EDGES)[np.array(_BEY)]
        frames = np.concatenate([corners[:, :1], corners[:, 1:] - corners[:, :1]], axis=1)
        mirrored = np.linalg.det(frames[:, 1:]) < 0.0
        frames[mirrored] = frames[mirrored][:, [0, 2, 1, 3]]
        return frames

    def in_child(self, child: int, points: Array) -> Array:
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

    def _on_face(self, points: Array, face: int) -> Mask:
        first, second, third = self.locations[self.faces[face][:3]]
        normal = np.cross(second - first, third - first)
        return np.abs((points - first) @ normal) < 1e-9  # reference cells have unit size


_CUBE_27 = _vtk_locations(CUBE, _CUBE_EDGES, _CUBE_FACES, (tuple(range(8)),))
KINDS = {
    kind.name: kind
    for kind in (
        CellKind("hexahedron", MeshHex, MeshHex, _vtk_locations(CUBE)),
        CellKind("hexahedron27", MeshHex2, MeshHex, _CUBE_27),
        CellKind("tetra", MeshTet, MeshTet, _vtk_locations(_TETRAHEDRON)),
        CellKind("tetra10", MeshTet2, MeshTet, _vtk_locations(_TETRAHEDRON, _TETRAHEDRON_EDGES)),
    )
}


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """A mesh with cells of one type.

    Cells (e, nodes) name points (n, 3) in the order of `kind.locations`. A face is a pair (cell,
    local face); arrays of faces have shape (k, 2).
    """

    kind: CellKind
    points: Array
    cells: Integers

    @classmethod
    def from_vtk(cls, name: str, points: Array, cells: Integers) -> SolidMesh:
        """Return a mesh from cells in VTK's numbering, as in meshio; unused points are dropped.

        ``hexahedron20`` become 27-node hexahedra: 20-node ones have negative weights at the corners
        of faces, which prevents nodal contact pressures. Other types raise ValueError.

        >>> cube = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
        >>> mesh = SolidMesh.from_vtk("hexahedron", cube, np.array([[0, 1, 3, 2, 4, 5, 7, 6]]))
        >>> len(mesh.boundary_faces), len(mesh.inverted())
        (6, 0)
        """
        points = np.asarray(points, dtype=float)
        cells = np.asarray(cells, dtype=np.int64)
        if name == "hexahedron20":
            # The centres of faces and cells by their interpolation: at the centre of a face corners
            # have the weight -1/4 and edges 1/2, at the centre of the cell -1/4 and 1/4.
            values, names = [], []
            for face, corners in enumerate(_CUBE_FACES):
                middle = _CUBE_27[20 + face]
                apart = np.abs(_CUBE_27[8:20] - middle).sum(axis=1)
                edges = 8 + np.flatnonzero(np.isclose(apart, 0.5))
                ours = cells[:, list(corners)]
                middles = 0.5 * points[cells[:, edges]].sum(axis=1)
                values.append(middles - 0.25 * points[ours].sum(axis=1))
                names.append(np.sort(ours, axis=1))
            # a face between two cells has one centre
            every = np.stack(names, axis=1).reshape(-1, 4)
            _, first, numbers = np.unique(every, axis=0, return_index=True, return_inverse=True)
            faces = np.stack(values, axis=1).reshape(-1, 3)[first]
            weights = np.concatenate([np.full(8, -0.25), np.full(12, 0.25)])
            centres = np.einsum("n,eni->ei", weights, points[cells])
            count = len(points)
            face_numbers = count + numbers.reshape(len(cells), 6)
            centre_numbers = count + len(faces) + np.arange(len(cells))[:, None]
            points = np.concatenate([points, faces, centres])
            cells = np.hstack([cells, face_numbers, centre_numbers])
            name = "hexahedron27"
        if name not in KINDS:
            raise ValueError(f"expected {', '.join(KINDS)} or hexahedron20, got {name!r}")
        kind = KINDS[name]
        used, numbers = np.unique(cells[:, kind.from_vtk], return_inverse=True)
        return cls(kind, points[used], numbers.reshape(len(cells), -1))

    @cached_property
    def face_corners(self) -> Integers:
        """Sorted corners (e, faces, 3 or 4) of all faces."""
        return np.sort(self.cells[:, np.array(self.kind.faces)], axis=-1)

    @cached_property
    def boundary_faces(self) -> Integers:
        """Faces (k, 2) of one cell only."""
        corners = self.face_corners.reshape(-1, self.face_corners.shape[-1])
        _, first, counts = np.unique(corners, axis=0, return_index=True, return_counts=True)
        return np.stack(np.divmod(np.sort(first[counts == 1]), len(self.kind.faces)), axis=1)

    def faces_within(self, inside: Mask) -> Integers:
        """Return the boundary faces (k, 2) with all corners among the marked nodes (n,)."""
        cells, faces = self.boundary_faces.T
        return self.boundary_faces[inside[self.face_corners[cells, faces]].all(axis=1)]

    def find(self, corners: Integers) -> Integers:
        """Return the boundary faces (k, 2) with these corners (m, 3 or 4), in any order."""
        cells, faces = self.boundary_faces.T
        ours = self.face_corners[cells, faces]
        if corners.shape[1] != ours.shape[1]:
            return np.zeros((0, 2), dtype=np.int64)
        both = np.concatenate([ours, np.sort(corners, axis=1)])
        _, names = np.unique(both, axis=0, return_inverse=True)
        names = names.reshape(-1)
        return self.boundary_faces[np.isin(names[: len(ours)], names[len(ours) :])]

    def nodes_of(self, faces: Integers) -> Integers:
        """Return all distinct nodes of the given faces in increasing order."""
        parts = [
            self.cells[faces[faces[:, 1] == face, 0]][:, nodes].ravel()
            for face, nodes in enumerate(self.kind.face_nodes)
        ]
        return np.unique(np.concatenate(parts))

    def inverted(self) -> Integers:
        """Return cells with a Jacobian < 0 at a node, or <= 0 at an integration point."""
        kind = self.kind
        gauss = simplex_points(kind.order) if kind.simplex else gauss_rule(kind.order + 1, 3)

        def jacobians(points: Array) -> Array:
            slopes = shape_functions(kind.mesh.elem, points.T)[1]
            gradient = np.einsum("eni,ndq->eqid", self.points[self.cells], slopes, optimize=True)
            return np.linalg.det(gradient)

        at_points, at_nodes = jacobians(gauss[0].T), jacobians(kind.locations)
        tiny = NO_VOLUME * np.median(np.abs(at_points))
        wrong = (at_points <= tiny).any(axis=1) | (at_nodes < -tiny).any(axis=1)
        return np.flatnonzero(wrong)

    def parts(self) -> int:
        """Return the number of pieces that are not connected by a face, edge or node."""
        start = np.repeat(self.cells[:, :1], self.cells.shape[1], axis=1)
        pairs = (start.ravel(), self.cells.ravel())
        graph = coo_matrix((np.ones(self.cells.size), pairs), shape=(len(self.points),) * 2)
        return int(connected_components(graph, directed=False)[0])

    def transformed(self, origin: Array, axes: Array) -> SolidMesh:
        """Return the mesh in coordinates ``axes @ (p - origin)``; the axes may be left-handed."""
        return replace(self, points=(self.points - origin) @ np.asarray(axes).T)

    def face_integrals(self, faces: Integers) -> list[tuple[Integers, Array, Array]]:
        """Return nodes (k, n), shape functions (n, m) and outward areas (k, m, 3) of faces.

        Area vectors at integration points, times weights; one entry per occurring local face.
        """
        kind, integrals = self.kind, []
        plane, weights = (
            get_quadrature_tri(2 * kind.order) if kind.simplex else gauss_square(kind.order + 1)
        )
        for face in np.unique(faces[:, 1]):
            cells = self.cells[faces[faces[:, 1] == face, 0]]
            origin, across, *_, along = kind.locations[kind.faces[face]]
            tangents = np.array([across - origin, along - origin])
            shapes, slopes = shape_functions(kind.mesh.elem, (origin + plane.T @ tangents).T)
            corners = self.points[cells]
            edges = np.einsum("kni,ndq,td->tkqi", corners, slopes, tangents, optimize=True)
            areas = np.cross(edges[0], edges[1]) * weights[:, None]
            outward = np.einsum("kni,nq->kqi", corners, shapes) - corners.mean(axis=1)[:, None]
            sign = np.sign(np.einsum("kqi,kqi->k", areas, outward))
            nodes = kind.face_nodes[face]
            integrals.append((cells[:, nodes], shapes[nodes], areas * sign[:, None, None]))
        return integrals

    def refined(self, *marked: Integers) -> tuple[SolidMesh, Integers, list[Integers]]:
        """Return the mesh with cells divided into eight along its curves.

        Also new numbers (n,) of the old nodes, and the marked faces, divided into four. Nodes of
        neighbours are identified by their interpolation weights (multiples of 1/512), not by
        position, so that cracks stay open. (`skfem.Mesh.refined` straightens quadratic cells and
        forgets faces.)
        """
        kind, nodes = self.kind, len(self.points)
        places = np.concatenate([kind.in_child(child, kind.locations) for child in range(8)])
        shapes, _ = shape_functions(kind.mesh.elem, places.T)
        weights = np.round(512.0 * shapes.T).astype(np.int64)
        # random numbers of the nodes, whose weighted sums name the new ones in any order
        keys = np.random.default_rng(0).integers(2**62, size=nodes, dtype=np.int64)
        names = keys[self.cells] @ weights.T  # integer overflow is intended (a hash)
        distinct, first, numbers = np.unique(names.ravel(), return_index=True, return_inverse=True)
        cell, place = np.divmod(first, len(places))
        points = np.einsum("pn,pni->pi", weights[place] / 512.0, self.points[self.cells[cell]])
        finer = replace(self, points=points, cells=numbers.reshape(8 * len(self.cells), -1))
        divided = []
        for faces in marked:
            pieces = np.array(kind.child_faces)[faces[:, 1]]
            cells = 8 * faces[:, 0, None] + pieces[..., 0]
            divided.append(np.stack([cells, pieces[..., 1]], axis=-1).reshape(-1, 2))
        return finer, np.searchsorted(distinct, 512 * keys), divided

    def to_scikit(self) -> tuple[MeshHex | MeshTet, Integers]:
        """Return the mesh in scikit-fem, and its numbers (n,) of our nodes."""
        corners = self.cells[:, : self.kind.corners]
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


@dataclass(frozen=True, eq=False)
class SupportedMesh:
    """The mesh of a supported body.

    Parameters
    ----------
    solid : SolidMesh
        z points into the body, away from the indenter.
    surface : (k, 2)
        Candidate contact faces.
    fixed : (n, 3) bool
        Zero displacement components of the nodes: they must leave no rigid motion free, nor hold
        the contact surface along z.
    """

    solid: SolidMesh
    surface: Integers
    fixed: Mask

    def __post_init__(self) -> None:
        points, fixed = self.solid.points, self.fixed
        if fixed.shape != points.shape:
            raise ValueError(f"fixed must have shape {points.shape}, not {fixed.shape}")
        faults, free = [], free_motions(points, fixed)
        if free:
            faults.append(f"the supports leave the body free: {', '.join(free)}")
        if fixed[self.solid.nodes_of(self.surface), 2].any():
            faults.append("nodes of the contact surface must not be held along z")
        refuse(faults)


def contact_nodes(mesh: SolidMesh, surface: Integers) -> Integers:
    """Return the surface nodes that can carry contact forces, ordered by x, then y.

    These have a tributary area: all nodes of hexahedra and linear tetrahedra, the mid-edge nodes of
    ten-node tetrahedra, whose corners carry no force under uniform pressure.
    """
    weights = tributary_areas(mesh, surface)
    nodes = np.flatnonzero(weights > NO_WEIGHT * weights.max())
    return nodes[np.lexsort(mesh.points[nodes, 1::-1].T)]


def free_motions(points: Array, fixed: Mask) -> list[str]:
    """Return the names of unsupported rigid motions, empty if the body is held.

    A body held along z at the bottom can still slide and rotate:

    >>> corners = np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]])
    >>> free_motions(corners, np.tile([False, False, True], (3, 1)))
    ['translation along x', 'translation along y', 'rotation about z']
    """
    centred = points - points.mean(axis=0)
    centred = centred / np.abs(centred).max()
    turns = np.cross(np.eye(3)[:, None], centred)
    shifts = np.broadcast_to(np.eye(3)[:, None], turns.shape)
    modes = np.concatenate([shifts, turns])[:, fixed].T
    if not len(modes):
        return list(RIGID_MOTIONS)
    _, values, directions = np.linalg.svd(modes, full_matrices=True)
    values = np.concatenate([values, np.zeros(6 - len(values))])
    null = directions[values <= 1e-9 * np.sqrt(len(points))]
    if not len(null):
        return []
    share = np.linalg.norm(null, axis=0)
    return [name for name, size in zip(RIGID_MOTIONS, share, strict=True) if size > 0.1]


def tributary_areas(mesh: SolidMesh, surface: Integers) -> Array:
    """Return the consistent tributary areas (n,) of the nodes, projected along z."""
    weights = np.zeros(len(mesh.points))
    for nodes, shapes, areas in mesh.face_integrals(surface):
        np.add.at(weights, nodes, np.abs(areas[..., 2]) @ shapes.T)
    return weights
