"""Quadratic elements on the half-section of an axisymmetric half-space.

Nine-node rectangles whose dilatation is projected onto linear functions in each element (B-bar;
Hughes 1980), so that isochoric plastic flow does not lock. Beyond the mesh the displacement is
that of a point force, with the energy of the whole exterior (`reference.fem.far_field`): mesh and
exterior are one approximation of the infinite half-space. Lengths are those of the mesh, z points
into the body, moduli are relative to E.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy import sparse

from reference.fem.far_field import boussinesq

Array = NDArray[np.float64]

# Lines of the mesh go out to this many times the largest contact radius, growing by this factor.
_OUTER = 15.0
_GROWTH = 1.4
# The fine part, in radii of the largest contact: along the surface, and into the body.
_FINE = (1.25, 1.0)
_GAUSS = 3
_SURFACE_GAUSS = 5


def graded(smallest: float, largest: float, per_radius: int, fine: float) -> Array:
    """Return coordinates of mesh lines from 0 to far away.

    Elements have 1/per_radius of the smallest contact radius up to that, then of their own distance
    up to `fine` times the largest contact radius, and grow by a factor from there.

    Examples
    --------
    >>> graded(1.0, 1.0, 2, 1.0)[:4].round(2)
    array([0. , 0.5, 1. , 1.7])
    """
    lines = [0.0]
    while lines[-1] < _OUTER * largest:
        step = max(smallest, lines[-1]) / per_radius
        if len(lines) > 1 and lines[-1] >= fine * largest * (1 - 1e-9):
            step = (lines[-1] - lines[-2]) * _GROWTH
        lines.append(lines[-1] + step)
    return np.array(lines)


def _gauss(count: int) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (nodes + 1), 0.5 * weights


@dataclass(frozen=True)
class Surface:
    """Quadrature points of the surface, facet by facet from the axis outwards.

    Attributes
    ----------
    radius, weight : ndarray, shape (facets, points)
        Radii, and the areas that belong to the points.
    shape : ndarray, shape (facets, points, 9)
        Shape functions of the element below.
    element : ndarray, shape (facets,)
        Its number.
    unknowns : ndarray, shape (facets, 9)
        Its displacements into the body.
    """

    radius: Array
    weight: Array
    shape: Array
    element: NDArray[np.int64]
    unknowns: NDArray[np.int64]


class Section:
    """The mesh, and what turns unknowns into strains and stresses into forces.

    Unknowns are the displacements of the nodes inside the mesh, without the radial ones on the
    axis, and last the amplitude of the exterior: the force (E = 1) whose displacements the nodes at
    the outer boundary follow.

    Parameters
    ----------
    smallest, largest : float
        Contact radii that the mesh shall resolve.
    per_radius : int
        Elements per radius.
    poisson_ratio : float
    """

    def __init__(
        self, smallest: float, largest: float, per_radius: int, poisson_ratio: float
    ) -> None:
        along, deep = (graded(smallest, largest, per_radius, fine) for fine in _FINE)
        self.mesh = skfem.MeshQuad.init_tensor(along, deep)
        self.extent = float(along[-1]), float(deep[-1])
        nodes, weights = _gauss(_GAUSS)
        points = np.stack(np.meshgrid(nodes, nodes, indexing="ij")).reshape(2, -1)
        rule = points, np.outer(weights, weights).ravel()
        self._basis = skfem.Basis(self.mesh, skfem.ElementQuad2(), quadrature=rule)
        self.place = np.asarray(self._basis.global_coordinates())
        self.weight: Array = 2 * np.pi * self.place[0] * self._basis.dx
        numbers, share = self._numbered(poisson_ratio)
        self.size = int(numbers.max()) + 1
        self._nodes = np.asarray(self._basis.element_dofs.T)
        both = np.hstack([self._nodes, self._nodes + self._basis.N])
        self.unknowns: NDArray[np.int64] = numbers[both]
        self.strains = self._strain_matrices(points) * share[both][:, None, None, :]
        self.exterior = exterior_stiffness(*self.extent, poisson_ratio)

    def _numbered(self, poisson_ratio: float) -> tuple[NDArray[np.int64], Array]:
        """Return the unknown that each displacement follows, and by which factor."""
        r, z = np.asarray(self._basis.doflocs)
        outer = (r > self.extent[0] * (1 - 1e-9)) | (z > self.extent[1] * (1 - 1e-9))
        axis = r < 1e-12 * self.extent[0]
        free = np.concatenate([~outer & ~axis, ~outer])
        field, _ = boussinesq(
            np.stack([r[outer], np.zeros(outer.sum()), z[outer]], axis=-1), poisson_ratio
        )
        share = free.astype(float)
        share[: r.size][outer] = np.where(axis[outer], 0.0, field[:, 0])
        share[r.size :][outer] = field[:, 2]
        numbers = np.full(free.size, np.count_nonzero(free))
        numbers[free] = np.arange(np.count_nonzero(free))
        return numbers, share

    def _strain_matrices(self, points: Array) -> Array:
        """Return B-bar, (elements, points, 4, 18), radial displacements first."""
        radius = self.place[0]
        fields = [self._basis.basis[i][0] for i in range(9)]
        shape = np.stack([np.broadcast_to(np.asarray(f), radius.shape) for f in fields], axis=-1)
        gradient = np.stack([np.asarray(f.grad) for f in fields], axis=-1)
        matrix = np.zeros((*radius.shape, 4, 18))
        matrix[..., 0, :9] = gradient[0]
        matrix[..., 1, 9:] = gradient[1]
        matrix[..., 2, :9] = shape / radius[..., None]
        matrix[..., 3, :9] = gradient[1]
        matrix[..., 3, 9:] = gradient[0]
        dilatation = matrix[..., :3, :].sum(axis=-2)
        linear = np.stack([np.ones(points.shape[1]), *(points - 0.5)], axis=-1)
        mass = np.einsum("ep,pi,pj->eij", self.weight, linear, linear)
        moments = np.einsum("ep,pi,epk->eik", self.weight, linear, dilatation)
        projected = linear @ np.linalg.solve(mass, moments)
        matrix[..., :3, :] += ((projected - dilatation) / 3)[..., None, :]
        return matrix

    def surface(self, radius: float) -> Surface:
        """Return quadrature points on the surface up to a radius."""
        on_top = self.mesh.facets_satisfying(
            lambda x: (np.abs(x[1]) < 1e-12 * self.extent[1]) & (x[0] < radius)
        )
        nodes, weights = _gauss(_SURFACE_GAUSS)
        facet = skfem.FacetBasis(
            self.mesh, skfem.ElementQuad2(), facets=on_top, quadrature=(nodes[None], weights)
        )
        radii = np.asarray(facet.global_coordinates())[0]
        fields = [np.broadcast_to(np.asarray(facet.basis[i][0]), radii.shape) for i in range(9)]
        order = np.argsort(radii[:, 0])
        element = np.asarray(self.mesh.f2t[0, on_top])[order]
        return Surface(
            radii[order],
            (2 * np.pi * radii * facet.dx)[order],
            np.stack(fields, axis=-1)[order],
            element,
            self.unknowns[element, 9:],
        )

    def strain(self, unknowns: Array) -> Array:
        """Return strains (elements, points, 4)."""
        elements, points = self.weight.shape
        flat = self.strains.reshape(elements, points * 4, 18)
        return (flat @ unknowns[self.unknowns][..., None]).reshape(elements, points, 4)

    def forces(self, stress: Array) -> Array:
        """Return the forces on the unknowns of stresses (elements, points, 4)."""
        elements, points = self.weight.shape
        flat = self.strains.reshape(elements, points * 4, 18)
        weighted = (stress * self.weight[..., None]).reshape(elements, 1, points * 4)
        local = (weighted @ flat)[:, 0]
        total = np.bincount(self.unknowns.ravel(), weights=local.ravel(), minlength=self.size)
        return np.asarray(total, dtype=float)

    def stiffness(self, tangent: Array) -> Array:
        """Return element matrices (elements, 18, 18) of tangents (elements, points, 4, 4)."""
        elements, points = self.weight.shape
        product = (tangent * self.weight[..., None, None]) @ self.strains
        flat = self.strains.reshape(elements, points * 4, 18)
        return flat.swapaxes(1, 2) @ product.reshape(elements, points * 4, 18)

    @cached_property
    def _pattern(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Where entries of element matrices go: their place, rows, and starts of columns."""
        rows = np.repeat(self.unknowns, 18, axis=1).ravel()
        columns = np.tile(self.unknowns, (1, 18)).ravel()
        keys, place = np.unique(columns * self.size + rows, return_inverse=True)
        starts = np.searchsorted(keys, np.arange(self.size + 1) * self.size)
        return place, keys % self.size, starts

    def matrix(self, local: Array) -> sparse.csc_matrix:
        """Return the sparse matrix of element matrices, with the exterior."""
        place, rows, starts = self._pattern
        data = np.bincount(place, weights=local.ravel(), minlength=rows.size)
        data[-1] += self.exterior
        return sparse.csc_matrix((data, rows, starts), shape=(self.size, self.size))


def exterior_stiffness(far_r: float, far_z: float, poisson_ratio: float) -> float:
    """Return twice the energy outside a cylinder of a unit force on a half-space of E = 1.

    Parameters
    ----------
    far_r, far_z : float
        Radius and depth of the cylinder.
    poisson_ratio : float
        Below 1/2.
    """
    nodes, weights = _gauss(64)
    zero, unit = np.zeros(64), np.ones(64)
    faces = [
        (np.stack([far_r * unit, zero, far_z * nodes], -1), 0, far_r * far_z * unit),
        (np.stack([far_r * nodes, zero, far_z * unit], -1), 2, far_r**2 * nodes),
    ]
    shear = 0.5 / (1 + poisson_ratio)
    lame = 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio)
    total = 0.0
    for points, normal, area in faces:
        field, gradient = boussinesq(points, poisson_ratio)
        stress = shear * (gradient + gradient.swapaxes(-1, -2))
        trace = np.trace(gradient, axis1=-2, axis2=-1)
        stress = stress + lame * trace[:, None, None] * np.eye(3)
        work = (stress[:, :, normal] * field).sum(-1)
        total -= float((2 * np.pi * area * weights * work).sum())
    return total
