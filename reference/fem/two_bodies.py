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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from skfem.quadrature import get_quadrature_tri

from reference.arguments import choice_faults, refuse
from reference.fem.body import CondensedBody
from reference.fem.contact import Contact, press
from reference.fem.contact_faces import ContactFaces
from reference.fem.overlaps import overlap_triangles
from reference.loads import LoadPath

COUPLINGS = ("mortar", "node_to_surface")
MULTIPLIERS = ("dual", "standard")
Gap = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
NO_OVERLAP = "the contact surfaces of the two bodies do not overlap"
# Products of biquadratic functions have degree 8 on parallelograms; on other quadrilaterals they
# are rational, for which degree 12 is exact to rounding.
DEGREE = 12


@dataclass(frozen=True, eq=False)
class BodyPair:
    """Two coupled bodies.

    Attributes
    ----------
    slave, master : CondensedBody
        The bodies; contact pressures are defined on the slave.
    onto_slave, onto_master : (n, n_slave), (n, n_master) sparse
        Nodal forces on the bodies for unit forces of the pressure unknowns; the transpose gives the
        corresponding normal displacements.
    combined : CondensedBody
        Input of `press`: the sum of the flexibilities between the pressure unknowns, in the units
        of the slave.
    points : (k, 2)
        Points of the initial gap.
    sampling : (n, k) sparse
        Weighted gaps of the unknowns from the gap at `points`.
    """

    slave: CondensedBody
    master: CondensedBody
    onto_slave: csr_matrix
    onto_master: csr_matrix
    combined: CondensedBody
    points: NDArray[np.float64]
    sampling: csr_matrix

    def press(self, gap: Gap, load: LoadPath) -> Iterator[Contact]:
        """Solve the contact of the bodies, load by load.

        Parameters
        ----------
        gap : callable
            Initial gap ``g(x, y)`` of the two surfaces, finite everywhere.
        load : LoadPath
            As in `reference.fem.press`; penetration is the approach of points far from the contact
            (of the supports of finite bodies).

        Raises
        ------
        ValueError, ConvergenceError
            As in `reference.fem.press`.
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

    def forces(self, contact: Contact) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
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

    Raises
    ------
    ValueError
        For arguments out of range, curved faces, and surfaces that do not overlap.

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
    refuse(faults)
    # One unit of length for the whole geometry, so that scenes in nm and m have the same digits.
    ours, theirs = (ContactFaces.of(body, slave.length) for body in (slave, master))
    if coupling == "mortar":
        terms = _mortar(ours, theirs, len(slave.nodes), len(master.nodes), multipliers)
    else:
        terms = _node_to_surface(ours, theirs, slave, len(master.nodes))
    return _pair(slave, master, terms)


class _Terms(NamedTuple):
    """Areas of the pressure unknowns and the matrices of `BodyPair`, before the division."""

    weights: NDArray[np.float64]
    onto_slave: csr_matrix
    onto_master: csr_matrix
    points: NDArray[np.float64]
    sampling: csr_matrix


def _pair(slave: CondensedBody, master: CondensedBody, terms: _Terms) -> BodyPair:
    """Return the pair without slave nodes outside the master's faces, with summed compliances."""
    weights, onto_slave, onto_master, points, sampling = terms
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
        scaled_compliance=0.5 * (compliance + compliance.T),
        ring=None,
        unknowns=slave.unknowns + master.unknowns,
    )
    return BodyPair(
        slave, master, onto_slave, onto_master, combined, points * slave.length, sampling
    )


def _mortar(
    slave: ContactFaces, master: ContactFaces, slave_count: int, master_count: int, multipliers: str
) -> _Terms:
    """Return integrals of pressure functions times both displacements over all overlaps."""
    triangles, owners = overlap_triangles(slave.corners, master.corners)
    if not len(owners):
        raise ValueError(NO_OVERLAP)
    plane, weights = get_quadrature_tri(DEGREE)
    edges = triangles[:, 1:] - triangles[:, :1]
    points = triangles[:, :1] + np.einsum("dq,tdi->tqi", plane, edges)
    areas = np.abs(np.linalg.det(edges))[:, None] * weights
    slave_shapes = slave.shapes(slave.local(owners[:, 0], points))
    master_shapes = master.shapes(master.local(owners[:, 1], points))
    functions = slave_shapes
    if multipliers == "dual":
        functions = np.einsum(
            "tij,tqj->tqi", _dual(slave, owners[:, 0], slave_shapes, areas), slave_shapes
        )
    rows = slave.nodes[owners[:, 0]]
    columns = master.nodes[owners[:, 1]]
    onto_slave = _summed(
        "tqi,tqj,tq->tij", (functions, slave_shapes, areas), rows, rows, (slave_count, slave_count)
    )
    onto_master = _summed(
        "tqi,tqj,tq->tij",
        (functions, master_shapes, areas),
        rows,
        columns,
        (slave_count, master_count),
    )
    values = np.einsum("tqi,tq->tiq", functions, areas)
    index = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    sampling = _scattered(values, rows, index, (slave_count, index.size))
    total = np.asarray(sampling.sum(axis=1)).ravel()
    return _Terms(total, onto_slave, onto_master, points.reshape(-1, 2), sampling)


def _dual(
    faces: ContactFaces,
    owners: NDArray[np.int64],
    shapes: NDArray[np.float64],
    areas: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return matrices per triangle from the shape functions of its face to biorthogonal ones.

    ``A = diag(int N_j) (int N_i N_j)^-1`` over the covered part of the face.
    """
    count, size = faces.nodes.shape
    mass, diagonal = np.zeros((count, size, size)), np.zeros((count, size))
    np.add.at(mass, owners, np.einsum("tqi,tqj,tq->tij", shapes, shapes, areas, optimize=True))
    np.add.at(diagonal, owners, np.einsum("tqi,tq->ti", shapes, areas))
    touched = np.unique(owners)
    result = np.zeros_like(mass)
    result[touched] = np.swapaxes(
        np.linalg.solve(mass[touched], diagonal[touched, :, None] * np.eye(size)), 1, 2
    )
    return result[owners]


def _summed(
    rule: str,
    factors: tuple[NDArray[np.float64], ...],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    shape: tuple[int, int],
) -> csr_matrix:
    return _scattered(np.einsum(rule, *factors, optimize=True), rows, columns, shape)


def _scattered(
    values: NDArray[np.float64],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    shape: tuple[int, int],
) -> csr_matrix:
    """Add up blocks (t, i, j) at rows (t, i) and columns (t, j)."""
    where = np.broadcast_arrays(rows[:, :, None], columns[:, None, :])
    return csr_matrix((values.ravel(), (where[0].ravel(), where[1].ravel())), shape)


def _node_to_surface(
    slave: ContactFaces, master: ContactFaces, body: CondensedBody, master_count: int
) -> _Terms:
    """Return the coupling of slave nodes with the master faces opposite to them."""
    slave_count = len(body.nodes)
    points = body.scaled_points
    face = _faces_at(master, points)
    inside = np.flatnonzero(face >= 0)
    if not len(inside):
        raise ValueError(NO_OVERLAP)
    shapes = master.shapes(master.local(face[inside], points[inside]))
    rows = inside[:, None]
    onto_master = _scattered(
        shapes[:, None, :], rows, master.nodes[face[inside]], (slave_count, master_count)
    )
    weights = np.where(face >= 0, body.scaled_weights, 0.0)
    identity = csr_matrix((weights, (np.arange(slave_count), np.arange(slave_count))))
    return _Terms(weights, identity, identity @ onto_master, points, identity)


def _faces_at(faces: ContactFaces, points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the numbers of the faces at points (k,), -1 if there is none."""
    owners = np.full(len(points), -1)
    low, high = faces.corners.min(axis=1), faces.corners.max(axis=1)
    slack = 1e-9 * (high - low)
    for face in range(len(faces.corners)):
        box = (points >= (low - slack)[face]) & (points <= (high + slack)[face])
        near = np.flatnonzero(box.all(axis=1) & (owners < 0))
        if len(near):
            local = faces.local(np.full(len(near), face), points[near])
            owners[near[(np.abs(local - 0.5) <= 0.5 + 1e-9).all(axis=1)]] = face
    return owners
