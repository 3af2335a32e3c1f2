"""What meshes of quadratic elements share: strains from unknowns, forces from stresses.

The dilatation of an element is projected onto linear functions (B-bar; Hughes 1980), so that
isochoric plastic flow does not lock. Beyond the mesh the displacement is that of a point force,
with the energy of the whole exterior (`reference.fem.far_field`): mesh and exterior are one
approximation of the infinite half-space. Lengths are those of the mesh, z points into the body,
moduli are relative to E.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.fem.far_field import boussinesq

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# The fine part of a mesh, in contact radii: along the surface, and into the body.
FINE = (1.25, 1.0)
GAUSS = 3


def gauss(count: int) -> tuple[Array, Array]:
    """Return nodes and weights on [0, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (nodes + 1), 0.5 * weights


@dataclass(frozen=True)
class Surface:
    """Quadrature points of the surface that may be touched, facet by facet.

    Attributes
    ----------
    place : ndarray, shape (1 or 2, facets, points)
        Radii (from the axis outwards), or x and y.
    weight : ndarray, shape (facets, points)
        The areas that belong to the points.
    shape : ndarray, shape (facets, points, functions)
        Shape functions of the element below.
    element : ndarray, shape (facets,)
        Its number.
    unknowns : ndarray, shape (facets, functions)
        Its displacements into the body.
    length : ndarray, shape (facets,)
        Sides of the facets.
    """

    place: Array
    weight: Array
    shape: Array
    element: Integers
    unknowns: Integers
    length: Array


class Elements:
    """Elements with what turns unknowns into strains and stresses into forces.

    Unknowns are the displacements of the nodes inside the mesh, without those that symmetry holds,
    and last the amplitude of the exterior: the force (E = 1) whose displacements the nodes at the
    outer boundary follow. Stresses are (direct, direct, direct, shears), shear strains twice the
    tensor's. The last third (half) of an element's displacements goes into the body.

    Attributes
    ----------
    place : ndarray, shape (2 or 3, elements, points)
        Quadrature points.
    weight : ndarray, shape (elements, points)
        Volumes of the whole body that belong to them.
    unknowns : ndarray, shape (elements, displacements)
    strains : ndarray, shape (elements, points, components, displacements)
        B-bar.
    exterior : float
        Stiffness of the amplitude.
    """

    place: Array
    weight: Array
    unknowns: Integers
    strains: Array
    exterior: float
    size: int
    _last: tuple[Array, Array] = np.zeros(0), np.zeros(0)

    def surface(self) -> Surface:
        """Return the quadrature points of the surface that may be touched."""
        raise NotImplementedError

    def contact_area(self, gap: Callable[..., Array], depth: float, unknowns: Array) -> float:
        """Return the area within the last points that touch a shape of that gap at a depth.

        Infinite where the contact reaches the end of what may be touched.
        """
        raise NotImplementedError

    def solver(self, local: Array) -> Callable[[Array], Array]:
        """Return what solves the system of element matrices and of the exterior."""
        raise NotImplementedError

    @property
    def components(self) -> int:
        """Components of a stress."""
        return int(self.strains.shape[2])

    @property
    def into_body(self) -> slice:
        """Which of an element's displacements go into the body."""
        count = self.unknowns.shape[1]
        return slice(count - count // len(self.place), count)

    def strain(self, unknowns: Array) -> Array:
        """Return strains (elements, points, components)."""
        return (self._flat @ unknowns[self.unknowns][..., None]).reshape(self.strains.shape[:3])

    def forces(self, stress: Array) -> Array:
        """Return the forces on the unknowns of stresses (elements, points, components)."""
        weighted = (stress * self.weight[..., None]).reshape(len(self.weight), 1, -1)
        local = (weighted @ self._flat)[:, 0]
        total = np.bincount(self.unknowns.ravel(), weights=local.ravel(), minlength=self.size)
        return np.asarray(total, dtype=float)

    def stiffness(self, tangent: Array) -> Array:
        """Return element matrices of tangents (elements, points, components, components).

        Those of elements whose tangent is that of the last time are kept.
        """
        last, matrices = self._last
        changed = (
            (tangent != last).any(axis=(1, 2, 3)) if last.size else np.ones(len(tangent), bool)
        )
        if not last.size:
            matrices = np.empty((len(tangent), *2 * self.strains.shape[-1:]))
        flat = self._flat[changed]
        weighted = tangent[changed] * self.weight[changed][..., None, None]
        product = weighted @ self.strains[changed]
        matrices[changed] = flat.swapaxes(1, 2) @ product.reshape(flat.shape)
        self._last = tangent, matrices
        return matrices.copy()

    @property
    def _flat(self) -> Array:
        elements, points, components, count = self.strains.shape
        return self.strains.reshape(elements, points * components, count)


def followers(places: Array, outer: NDArray[np.bool_], poisson_ratio: float) -> Array:
    """Return by which factor each displacement (components, nodes) follows its unknown.

    One inside; at the outer nodes the displacement of a unit force. Of two components the first is
    radial.
    """
    share = np.ones(places.shape)
    across = [places[0], 0 * places[0]] if len(places) == 2 else list(places[:2])
    points = np.stack([*across, places[-1]], axis=-1)[outer]
    field, _ = boussinesq(points, poisson_ratio)
    share[:, outer] = field.T[[0, 2]] if len(places) == 2 else field.T
    return share


def numbered(outer: NDArray[np.bool_], held: NDArray[np.bool_]) -> Integers:
    """Return the unknown of each displacement (components, nodes); the exterior's is the last."""
    free = ~outer & ~held
    numbers = np.full(held.shape, np.count_nonzero(free))
    numbers[free] = np.arange(np.count_nonzero(free))
    return numbers


def project_dilatation(strains: Array, weight: Array, points: Array) -> None:
    """Replace the dilatation in B by its projection onto linear functions of each element.

    Parameters
    ----------
    strains : (elements, points, components, displacements)
        Changed in place.
    weight : (elements, points)
    points : (dimensions, points)
        In the reference element.
    """
    dilatation = strains[..., :3, :].sum(axis=-2)
    linear = np.stack([np.ones(points.shape[1]), *(points - 0.5)], axis=-1)
    mass = np.einsum("ep,pi,pj->eij", weight, linear, linear)
    moments = np.einsum("ep,pi,epk->eik", weight, linear, dilatation)
    projected = linear @ np.linalg.solve(mass, moments)
    strains[..., :3, :] += ((projected - dilatation) / 3)[..., None, :]


def exterior_stiffness(faces: list[tuple[Array, Array, int]], poisson_ratio: float) -> float:
    """Return twice the energy outside a body of a unit force on a half-space of E = 1.

    Parameters
    ----------
    faces : list
        Points (n, 3) of the faces below the surface, areas that belong to them (negative where the
        outward normal is), and the axis of the normal.
    poisson_ratio : float
        Below 1/2.
    """
    shear = 0.5 / (1 + poisson_ratio)
    lame = 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio)
    total = 0.0
    for points, area, normal in faces:
        field, gradient = boussinesq(points, poisson_ratio)
        stress = shear * (gradient + gradient.swapaxes(-1, -2))
        trace = np.trace(gradient, axis1=-2, axis2=-1)
        stress = stress + lame * trace[:, None, None] * np.eye(3)
        total -= float((area * (stress[:, :, normal] * field).sum(-1)).sum())
    return total
