r"""Stiffness of extruded meshes, as products of matrices over the plane and along the depth.

The meshes of half-spaces repeat one plane mesh at all levels of the depth. A node is then a plane
node a at a level i, its shape function a product N_a(x, y) L_i(z), and every integral a product

    int d_alpha N_A d_beta N_B dV = P_alpha,beta (x) m,    int d_alpha N_A d_z N_B = Q_alpha (x) d,
    int d_z N_A d_z N_B = M (x) k,

so that the matrix of three dimensions, 2 kB for each unknown, is never assembled. Integrated
selectively (see `element_stiffness`), both factors of the lambda term have a Gauss point less.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from skfem.element import ElementLineP1, ElementLineP2, ElementQuad1, ElementQuad2

from reference.elasticity import lame_parameters
from reference.fem.element_stiffness import element_order
from reference.fem.mesh import GradedMesh, facet_quadrature

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Lattice:
    """The nodes of an extruded mesh by plane node and level.

    Attributes
    ----------
    nodes : (n, levels)
        Numbers of the nodes of the mesh, from the surface down; plane nodes in an order that keeps
        neighbours close.
    cells : (cells, 4 or 9)
        Plane nodes of the faces at the surface.
    plane : (n, 2)
    depths : (levels,)
    order : {1, 2}
        Of the elements.
    """

    nodes: NDArray[np.int64]
    cells: NDArray[np.int64]
    plane: Array
    depths: Array
    order: int

    @classmethod
    def of(cls, grid: GradedMesh) -> Lattice:
        """Return the lattice of a mesh of a half-space."""
        mesh = grid.mesh
        surface = facet_quadrature(mesh, grid.surface, 1)[0]
        # positions agree to rounding, and differ by far more than 1e-9 of the contact
        x, y, z = np.round(mesh.p, 9)
        count = len(np.unique(surface))
        nodes = np.lexsort((z, y, x)).reshape(count, -1)
        place = np.empty(mesh.p.shape[1], dtype=np.int64)
        place[nodes[:, 0]] = np.arange(count)
        cells = place[surface]
        order = _narrowest(mesh.p[:2, nodes[:, 0]], cells)
        place[order] = np.arange(count)
        nodes = nodes[order]
        top = mesh.p[:2, nodes[:, 0]].T
        return cls(nodes, place[cells], top, mesh.p[2, nodes[0]], element_order(mesh))


def _narrowest(plane: Array, cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the order of plane nodes with the narrowest band: by rings, by lines, or found."""
    count, size = plane.shape[1], cells.shape[1]
    pairs = np.repeat(cells, size, axis=1).ravel(), np.tile(cells, (1, size)).ravel()
    graph = sparse.csr_matrix((np.ones(len(pairs[0])), pairs), shape=(count, count))
    x, y = plane
    orders = [np.argsort(np.hypot(x, y)), np.lexsort((y, x)), np.lexsort((x, y))]
    orders.append(reverse_cuthill_mckee(graph, symmetric_mode=True).astype(np.int64))
    return min(orders, key=lambda order: int(np.ptp(np.argsort(order)[cells], axis=1).max()))


@dataclass(frozen=True, eq=False)
class Plane:
    """Matrices (n, n) over the plane: of two derivatives, of one (of the row), and of none."""

    slopes: list[list[sparse.csr_array]]
    slope: list[sparse.csr_array]
    mass: sparse.csr_array


@dataclass(frozen=True, eq=False)
class Depth:
    """Matrices (levels, levels): of no derivative, of two, and of one (of the column)."""

    mass: Array
    slopes: Array
    slope: Array


def _line_rule(points: int) -> tuple[Array, Array]:
    """Return Gauss points and weights on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    return 0.5 * (nodes + 1.0), 0.5 * weights


def plane_matrices(lattice: Lattice, points: int) -> Plane:
    """Return the integrals over the plane by so many Gauss points in each direction."""
    element = ElementQuad1() if lattice.order == 1 else ElementQuad2()
    cells, line = lattice.cells, _line_rule(points)
    local = np.stack(np.meshgrid(line[0], line[0])).reshape(2, -1)
    basis = [element.lbasis(local, i) for i in range(cells.shape[1])]
    values = np.array([value for value, _ in basis])
    slopes = np.array([slope for _, slope in basis])
    jacobian = np.einsum("eni,ndq->eqid", lattice.plane[cells], slopes)
    gradients = np.einsum("ndq,eqdi->ieqn", slopes, np.linalg.inv(jacobian))
    areas = np.abs(np.linalg.det(jacobian)) * np.outer(line[1], line[1]).ravel()
    steady = np.broadcast_to(values.T, gradients.shape[1:])

    def summed(first: Array, second: Array) -> sparse.csr_array:
        size, count = cells.shape[1], len(lattice.plane)
        blocks = np.matmul(np.swapaxes(first * areas[..., None], 1, 2), second)
        pairs = np.repeat(cells, size, axis=1).ravel(), np.tile(cells, (1, size)).ravel()
        return sparse.csr_array((blocks.ravel(), pairs), shape=(count, count))

    return Plane(
        slopes=[[summed(row, column) for column in gradients] for row in gradients],
        slope=[summed(row, steady) for row in gradients],
        mass=summed(steady, steady),
    )


def depth_matrices(lattice: Lattice, points: int) -> Depth:
    """Return the integrals along the depth by so many Gauss points in an element."""
    order, depths = lattice.order, lattice.depths
    # of the three functions the one in the middle is scikit-fem's last
    element, places = (ElementLineP1(), (0, 1)) if order == 1 else (ElementLineP2(), (0, 2, 1))
    at, weights = _line_rule(points)
    basis = [element.lbasis(at[None], i) for i in places]
    values = np.array([value for value, _ in basis])
    slopes = np.array([slope[0] for _, slope in basis])
    result = Depth(*np.zeros((3, len(depths), len(depths))))
    for start in range(0, len(depths) - 1, order):
        part = slice(start, start + order + 1)
        height = depths[start + order] - depths[start]
        result.mass[part, part] += height * (values * weights) @ values.T
        result.slopes[part, part] += (slopes * weights) @ slopes.T / height
        result.slope[part, part] += (values * weights) @ slopes.T
    return result


class ExtrudedStiffness:
    """The stiffness of an extruded mesh of unit Young's modulus, applied without assembling it.

    Parameters
    ----------
    lattice : Lattice
    poisson_ratio : float
    reduced_integration : bool
        As of `stiffness_matrices`; 8-node elements must be bricks.
    """

    def __init__(
        self, lattice: Lattice, poisson_ratio: float, *, reduced_integration: bool = True
    ) -> None:
        lame, shear = lame_parameters(poisson_ratio)
        full = lattice.order + 1
        rule = full - 1 if reduced_integration and lame > 0.0 else full
        self.lame, self.shear = lame, shear
        self.plane, self.depth = plane_matrices(lattice, full), depth_matrices(lattice, full)
        volume, along = plane_matrices(lattice, rule), depth_matrices(lattice, rule)
        self.volume, self.volume_depth = volume, along
        (pxx, pxy), (pyx, pyy) = self.plane.slopes
        both, block = pxx + pyy, sparse.block_array
        flat = block([[both + pxx, pyx], [pxy, both + pyy]], format="csr")
        self._flat = shear * flat, lame * block(volume.slopes, format="csr")
        self._upright = shear * both
        self._mass = shear * self.plane.mass, lame * volume.mass
        self._tilted = (
            lame * block([[slope] for slope in volume.slope], format="csr"),
            shear * block([[slope.T] for slope in self.plane.slope], format="csr"),
        )
        self._across = [sparse.csr_array(matrix.T) for matrix in self._tilted]

    def __matmul__(self, field: Array) -> Array:
        """Return the nodal forces (3, n, levels) of displacements (3, n, levels)."""
        _, count, levels = field.shape
        sides, down = field[:2].reshape(2 * count, levels), field[2]
        depth, volume = self.depth, self.volume_depth
        forces = np.empty_like(field)
        result = forces[:2].reshape(2 * count, levels)
        result[:] = self._flat[0] @ (sides @ depth.mass)
        result += self._flat[1] @ (sides @ volume.mass)
        steep = field[:2] @ depth.slopes
        for axis in (0, 1):
            forces[axis] += self._mass[0] @ steep[axis]
        result += self._tilted[0] @ (down @ volume.slope.T)
        result += self._tilted[1] @ (down @ depth.slope)
        forces[2] = self._upright @ (down @ depth.mass)
        forces[2] += self._mass[0] @ (down @ (2.0 * depth.slopes))
        forces[2] += self._mass[1] @ (down @ volume.slopes)
        forces[2] += self._across[0] @ (sides @ volume.slope)
        forces[2] += self._across[1] @ (sides @ depth.slope.T)
        return forces

    def alone(self, axis: int) -> tuple[sparse.csr_array, sparse.csr_array]:
        """Return A and B of one component: its stiffness is nearly A (x) m + B (x) k.

        Nearly, as the depth of the lambda term is integrated like that of the other.
        """
        both = self.plane.slopes[0][0] + self.plane.slopes[1][1]
        if axis == 2:
            return self.shear * both, 2.0 * self._mass[0] + self._mass[1]
        stretch = self.shear * self.plane.slopes[axis][axis]
        stretch = stretch + self.lame * self.volume.slopes[axis][axis]
        return self.shear * both + stretch, self._mass[0]
