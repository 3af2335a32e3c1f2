"""Two deformable bodies in frictionless contact, by node-to-surface or mortar coupling.

Both bodies are condensed onto the normal displacements of their contact nodes, so the pair is one
symmetric compliance between contact pressures. The coupling determines the quality of the
pressures: the mortar method weights gap and traction over the faces of one body, with exact
integrals over all overlaps with faces of the other (Puso & Laursen 2004, *Comput. Methods Appl.
Mech. Eng.* 193, 601), while node-to-surface contact collocates at nodes and fails the patch test.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numba
import numpy as np
from scipy.sparse import csr_matrix
from skfem import MeshTet
from skfem.element import ElementQuad1, ElementQuad2
from skfem.quadrature import get_quadrature_tri

from reference.arrays import Array, Integers
from reference.errors import ConvergenceError, choice_faults, refuse
from reference.fem.condensed_body import CondensedBody, DenseFlexibility
from reference.fem.contact import NodalContact, press
from reference.fem.element_stiffness import element_order, facet_quadrature, shape_functions
from reference.loads import LoadPath

COUPLINGS = ("mortar", "node_to_surface")
MULTIPLIERS = ("dual", "standard")
Gap = Callable[[Array, Array], Array]
NO_OVERLAP = "the contact surfaces of the two bodies do not overlap"
# Products of biquadratic functions have degree 8 on parallelograms; on other quadrilaterals they
# are rational, for which degree 12 is exact to rounding.
DEGREE = 12
# Largest deviation of nodes from the straight-sided face, as a fraction of its size.
STRAIGHT = 1e-7
# The intersection of two convex quadrilaterals has at most eight corners.
MOST_CORNERS = 8
# Slivers below this fraction of a face are rounding at shared edges and are dropped.
SLIVER = 1e-12


@dataclass(frozen=True, eq=False)
class BodyPair:
    """Two coupled bodies; contact pressures are defined on the slave.

    `onto_slave` and `onto_master` give nodal forces on the bodies for unit forces of the n pressure
    unknowns, their transposes the corresponding normal displacements; `combined` is the sum of the
    flexibilities between these unknowns, in the units of the slave.
    """

    slave: CondensedBody
    master: CondensedBody
    onto_slave: csr_matrix  # (n, candidates of the slave)
    onto_master: csr_matrix  # (n, candidates of the master)
    combined: CondensedBody
    points: Array  # (k, 2), of the initial gap
    sampling: csr_matrix  # (n, k), weighted gaps of the unknowns from the gap at `points`

    def press(self, gap: Gap, load: LoadPath) -> Iterator[NodalContact]:
        """Solve the contact of the bodies, load by load, as `reference.fem.press` does.

        Parameters
        ----------
        gap : callable
            Initial gap ``g(x, y)`` of the two surfaces, finite everywhere.
        load : LoadPath
            Penetration is the approach of points far from the contact (of the supports of finite
            bodies).
        """
        weighted = self.sampling @ np.asarray(gap(*self.points.T), dtype=float)
        return press(self.combined, weighted, load)

    def scaled(self, factor: float) -> BodyPair:
        """Return the pair of half-spaces scaled by `factor` (see `CondensedBody`)."""
        return replace(
            self,
            slave=self.slave.scaled(factor),
            master=self.master.scaled(factor),
            combined=self.combined.scaled(factor),
            points=self.points * factor,
        )

    def forces(self, contact: NodalContact) -> tuple[Array, Array]:
        """Return nodal normal forces on the candidates of slave and master."""
        return self.onto_slave.T @ contact.reactions, self.onto_master.T @ contact.reactions


def couple(
    slave: CondensedBody,
    master: CondensedBody,
    *,
    coupling: str = "mortar",
    multipliers: str = "dual",
) -> BodyPair:
    """Return a coupled pair of bodies with opposite contact surfaces in the plane z = 0.

    Parameters
    ----------
    slave, master : CondensedBody
        Bodies of hexahedra with straight-sided contact faces, z pointing into the respective body;
        equal fractions of a symmetric whole. The finer or softer body should be the slave.
    coupling : {"mortar", "node_to_surface"}
        "node_to_surface" keeps the nodes of the slave above the faces of the master.
    multipliers : {"dual", "standard"}
        Pressure functions of the mortar: biorthogonal to the displacements of the slave, so that
        every slave node has its own pressure (Wohlmuth 2000, *SIAM J. Numer. Anal.* 38, 989), or
        equal to them.

    Examples
    --------
    >>> from reference.fem import Material, TensorMesh, half_space_body
    >>> lines = np.linspace(-1, 1, 9), np.linspace(-1, 1, 6)
    >>> bodies = (half_space_body(TensorMesh(x, x), Material(1.0, 0.3)) for x in lines)
    >>> pair = couple(*bodies)
    >>> (step,) = pair.press(lambda x, y: x**2 + y**2, LoadPath("penetration", 0.1))
    >>> on_slave, on_master = pair.forces(step)
    >>> bool(np.isclose(on_slave.sum(), on_master.sum(), rtol=1e-12))
    True
    """
    faults = choice_faults("coupling", coupling, COUPLINGS)
    faults += choice_faults("multipliers", multipliers, MULTIPLIERS)
    if slave.symmetry != master.symmetry:
        faults.append(
            f"both bodies must be the same share of a symmetric whole, got one of "
            f"{slave.symmetry} and one of {master.symmetry}"
        )
    if slave.iterative is not None or master.iterative is not None:
        faults.append("both bodies must be condensed, not solved by conjugate gradients")
    refuse(faults)
    # One unit of length for the whole geometry, so that scenes in nm and m have the same digits.
    ours, theirs = (ContactFaces(body, slave.length) for body in (slave, master))
    shape = len(slave.nodes), len(master.nodes)
    if coupling == "mortar":
        terms = _mortar(ours, theirs, shape, dual=multipliers == "dual")
    else:
        terms = _node_to_surface(theirs, slave, shape)
    weights, onto_slave, onto_master, points, sampling = terms
    # without slave nodes outside the master's faces; integrals over areas are means
    covered = np.flatnonzero(weights > 1e-9 * weights.max())
    divide = csr_matrix(
        (1.0 / weights[covered], (np.arange(len(covered)), covered)), (len(covered), len(weights))
    )
    onto_slave, onto_master, sampling = divide @ onto_slave, divide @ onto_master, divide @ sampling
    softer = slave.youngs_modulus * slave.length / (master.youngs_modulus * master.length)
    compliance = onto_slave @ (onto_slave @ slave.scaled_compliance).T
    compliance += softer * (onto_master @ (onto_master @ master.scaled_compliance).T)
    combined = replace(
        slave,
        scaled_points=slave.scaled_points[covered],
        scaled_weights=weights[covered],
        nodes=slave.nodes[covered],
        flexibility=DenseFlexibility(0.5 * (compliance + compliance.T), slave.system),
        ring=None,
        unknowns=slave.unknowns + master.unknowns,
    )
    return BodyPair(
        slave, master, onto_slave, onto_master, combined, points * slave.length, sampling
    )


# Areas of the pressure unknowns, and the matrices and points of `BodyPair` times these areas.
Terms = tuple[Array, csr_matrix, csr_matrix, Array, csr_matrix]


def _mortar(slave: ContactFaces, master: ContactFaces, shape: tuple[int, int], dual: bool) -> Terms:
    """Return integrals of pressure functions times both displacements over all overlaps."""
    triangles, owners = overlap_triangles(slave.corners, master.corners)
    if not len(owners):
        raise ValueError(NO_OVERLAP)
    plane, weights = get_quadrature_tri(DEGREE)
    edges = triangles[:, 1:] - triangles[:, :1]
    points = triangles[:, :1] + np.einsum("dq,tdi->tqi", plane, edges)
    areas = np.abs(np.linalg.det(edges))[:, None] * weights
    face, opposite = owners.T
    slave_shapes = slave.shapes(slave.local(face, points))
    master_shapes = master.shapes(master.local(opposite, points))
    functions = slave_shapes
    if dual:
        # biorthogonal functions A N with A = diag(int N_j) (int N_i N_j)^-1 on the covered part of
        # every face
        count, size = slave.nodes.shape
        mass, diagonal = np.zeros((count, size, size)), np.zeros((count, size))
        products = np.einsum("tqi,tqj,tq->tij", slave_shapes, slave_shapes, areas, optimize=True)
        np.add.at(mass, face, products)
        np.add.at(diagonal, face, np.einsum("tqi,tq->ti", slave_shapes, areas))
        touched = np.unique(face)
        matrices = np.zeros_like(mass)
        matrices[touched] = np.swapaxes(
            np.linalg.solve(mass[touched], diagonal[touched, :, None] * np.eye(size)), 1, 2
        )
        functions = np.einsum("tij,tqj->tqi", matrices[face], slave_shapes)
    rows, columns = slave.nodes[face], master.nodes[opposite]
    with_slave, with_master = (
        np.einsum("tqi,tqj,tq->tij", functions, shapes, areas, optimize=True)
        for shapes in (slave_shapes, master_shapes)
    )
    onto_slave = _scattered(with_slave, rows, rows, (shape[0], shape[0]))
    onto_master = _scattered(with_master, rows, columns, shape)
    values = np.einsum("tqi,tq->tiq", functions, areas)
    index = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    sampling = _scattered(values, rows, index, (shape[0], index.size))
    total = np.asarray(sampling.sum(axis=1)).ravel()
    return total, onto_slave, onto_master, points.reshape(-1, 2), sampling


def _node_to_surface(master: ContactFaces, slave: CondensedBody, shape: tuple[int, int]) -> Terms:
    """Return the coupling of slave nodes with the master faces opposite to them."""
    points = slave.scaled_points
    opposite = np.full(len(points), -1)
    low, high = master.corners.min(axis=1), master.corners.max(axis=1)
    slack = 1e-9 * (high - low)
    for face in range(len(master.corners)):
        box = (points >= (low - slack)[face]) & (points <= (high + slack)[face])
        near = np.flatnonzero(box.all(axis=1) & (opposite < 0))
        if len(near):
            local = master.local(np.full(len(near), face), points[near])
            opposite[near[(np.abs(local - 0.5) <= 0.5 + 1e-9).all(axis=1)]] = face
    inside = np.flatnonzero(opposite >= 0)
    if not len(inside):
        raise ValueError(NO_OVERLAP)
    shapes = master.shapes(master.local(opposite[inside], points[inside]))
    columns = master.nodes[opposite[inside]]
    onto_master = _scattered(shapes[:, None, :], inside[:, None], columns, shape)
    weights = np.where(opposite >= 0, slave.scaled_weights, 0.0)
    identity = csr_matrix((weights, (np.arange(shape[0]), np.arange(shape[0]))))
    return weights, identity, identity @ onto_master, points, identity


def _scattered(
    values: Array, rows: Integers, columns: Integers, shape: tuple[int, int]
) -> csr_matrix:
    """Add up blocks (t, i, j) at rows (t, i) and columns (t, j)."""
    where = np.broadcast_arrays(rows[:, :, None], columns[:, None, :])
    return csr_matrix((values.ravel(), (where[0].ravel(), where[1].ravel())), shape)


class ContactFaces:
    """Faces of a body in the plane of the contact, with candidates at all nodes.

    `nodes` (m, 4 or 9) are these candidates, `corners` (m, 4, 2) in units of `length` in cyclic
    order, as the reference square (0, 0), (1, 0), (1, 1), (0, 1). Tetrahedra and faces with curved
    sides (those of `RingMesh`) raise ValueError: overlaps have straight sides.
    """

    def __init__(self, body: CondensedBody, length: float) -> None:
        mesh = body.grid.mesh
        if isinstance(mesh, MeshTet):
            raise ValueError("two bodies need quadrilateral faces: hexahedra, not tetrahedra")
        self.element = ElementQuad1 if element_order(mesh) == 1 else ElementQuad2
        numbers = facet_quadrature(mesh, body.grid.surface, 1)[0]
        candidate = np.full(mesh.p.shape[1], -1)
        candidate[body.nodes] = np.arange(len(body.nodes))
        numbers = numbers[(candidate[numbers] >= 0).all(axis=1)]
        if not len(numbers):
            raise ValueError("no face has only candidates as nodes")
        places = (mesh.p[:2, numbers] + body.offset[:, None, None]).transpose(1, 2, 0)
        corners = places[:, :4]
        at_nodes, _ = shape_functions(ElementQuad1, self.element.doflocs.T)
        beside = np.abs(np.einsum("mcd,cn->mnd", corners, at_nodes) - places).max(axis=(1, 2))
        if (beside > STRAIGHT * np.ptp(corners, axis=1).max(axis=1)).any():
            raise ValueError("two bodies need contact faces with straight sides and even nodes")
        self.nodes: Integers = candidate[numbers]
        self.corners: Array = corners * (body.length / length)

    def shapes(self, local: Array) -> Array:
        """Shape functions (..., 4 or 9) at reference points (..., 2)."""
        values, _ = shape_functions(self.element, local.reshape(-1, 2).T)
        return values.T.reshape(*local.shape[:-1], -1)

    def local(self, face: Integers, points: Array) -> Array:
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


def overlap_triangles(first: Array, second: Array) -> tuple[Array, Integers]:
    """Return the intersections of the faces of two plane meshes (Puso & Laursen 2004).

    Faces (m, 4, 2) and (n, 4, 2) are corners of convex quadrilaterals in cyclic order of either
    sense. Disjoint triangles (t, 3, 2) cover the common area; their owners (t, 2) are the faces of
    `first` and `second` that contain them.

    >>> square = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    >>> triangles, owners = overlap_triangles(square, square + 0.5)
    >>> edges = triangles[:, 1:] - triangles[:, :1]
    >>> float(abs(np.linalg.det(edges)).sum() / 2)
    0.25
    """

    def counterclockwise(faces: Array) -> Array:
        u, v = faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1]
        turned = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] < 0.0
        return np.where(turned[:, None, None], faces[:, ::-1], faces)

    first, second = counterclockwise(first), counterclockwise(second)
    low = np.maximum(first.min(axis=1)[:, None], second.min(axis=1))
    high = np.minimum(first.max(axis=1)[:, None], second.max(axis=1))
    overlapping_boxes = np.argwhere((high > low).all(axis=-1))
    return _clip(first, second, np.ascontiguousarray(overlapping_boxes))


# Coordinates one by one: a row assigned as a whole takes a second to compile.
@numba.njit(cache=True)
def _clip(first, second, pairs):
    """Cut faces of the first mesh by the sides of the second's (Sutherland & Hodgman 1974)."""
    triangles = np.empty((len(pairs) * MOST_CORNERS, 3, 2))
    owners = np.empty((len(pairs) * MOST_CORNERS, 2), dtype=np.int64)
    count = 0
    polygon, spare = np.empty((2 * MOST_CORNERS, 2)), np.empty((2 * MOST_CORNERS, 2))
    for first_cell, second_cell in pairs:
        face, corners = first[first_cell], 4
        for k in range(4):
            polygon[k, 0], polygon[k, 1] = face[k, 0], face[k, 1]
        for side in range(4):  # keep what is to the left of the line from a to b
            a, b = second[second_cell, side], second[second_cell, (side + 1) % 4]
            kept = 0
            for k in range(corners):
                p, q = polygon[k], polygon[(k + 1) % corners]
                here = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
                there = (b[0] - a[0]) * (q[1] - a[1]) - (b[1] - a[1]) * (q[0] - a[0])
                if here >= 0.0:
                    spare[kept, 0], spare[kept, 1] = p[0], p[1]
                    kept += 1
                if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
                    share = here / (here - there)
                    spare[kept, 0] = p[0] + share * (q[0] - p[0])
                    spare[kept, 1] = p[1] + share * (q[1] - p[1])
                    kept += 1
            corners = kept
            polygon, spare = spare, polygon
        if corners < 3 or _double_area(polygon, corners) < SLIVER * _double_area(face, 4):
            continue
        for k in range(1, corners - 1):
            for axis in range(2):
                triangles[count, 0, axis] = polygon[0, axis]
                triangles[count, 1, axis] = polygon[k, axis]
                triangles[count, 2, axis] = polygon[k + 1, axis]
            owners[count, 0], owners[count, 1] = first_cell, second_cell
            count += 1
    return triangles[:count], owners[:count]


@numba.njit(cache=True)
def _double_area(polygon, corners):
    total = 0.0
    for k in range(corners):
        p, q = polygon[k], polygon[(k + 1) % corners]
        total += p[0] * q[1] - p[1] * q[0]
    return total
