"""Quadratic elements in three dimensions below a shape that is not round: 27-node hexahedra.

The mesh is a tensor grid, graded away from the contact; planes of symmetry of the shape halve it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import skfem
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.plastic.cored import Cored
from reference.plastic.elements import (
    FINE,
    GAUSS,
    Elements,
    Surface,
    exterior_stiffness,
    followers,
    gauss,
    numbered,
    project_dilatation,
)

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# The mesh reaches this multiple of the longer half-width; elements grow by this factor.
_OUTER = 10.0
_GROWTH = 1.6
_NODES = 27
_SURFACE_GAUSS = 5
# Samples a side of a facet that locate the edge of the contact.
_SAMPLES = 12


def lines(element: float, fine: float, far: float) -> Array:
    """Return coordinates of mesh lines from 0: elements of one length up to `fine`, then growing.

    Examples
    --------
    >>> lines(0.5, 1.0, 3.0).round(2)
    array([0.  , 0.5 , 1.  , 1.8 , 3.08])
    """
    at = list(np.arange(0, int(np.ceil(fine / element - 1e-9)) + 1) * element)
    while at[-1] < far:
        at.append(at[-1] + _GROWTH * (at[-1] - at[-2]))
    return np.array(at)


class Block(Elements):
    """The block; stresses are (xx, yy, zz, yz, xz, xy).

    Parameters
    ----------
    half_widths : tuple of float
        Of the largest contact, in x and y.
    per_radius : int
        Elements per half-width.
    poisson_ratio : float
    even : tuple of bool
        Whether x = 0, and y = 0, is a plane of symmetry.
    """

    def __init__(
        self,
        half_widths: tuple[float, float],
        per_radius: int,
        poisson_ratio: float,
        even: tuple[bool, bool] = (True, True),
    ) -> None:
        narrow, far = min(half_widths), _OUTER * max(half_widths)
        sides = [lines(w / per_radius, FINE[0] * w, far) for w in half_widths]
        grid = [
            side if half else np.concatenate([-side[:0:-1], side])
            for side, half in zip(sides, even, strict=True)
        ]
        deep = lines(narrow / per_radius, FINE[1] * narrow, far)
        self.mesh = skfem.MeshHex.init_tensor(*grid, deep)
        self.touchable = np.array([FINE[0] * w for w in half_widths])
        self.copies = 2 ** sum(even)
        nodes, weights = gauss(GAUSS)
        points = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij")).reshape(3, -1)
        rule = points, np.einsum("i,j,k->ijk", weights, weights, weights).ravel()
        self._basis = skfem.Basis(self.mesh, skfem.ElementHex2(), quadrature=rule)
        self.place = np.asarray(self._basis.global_coordinates())
        self.weight = self.copies * np.asarray(self._basis.dx)
        places = np.asarray(self._basis.doflocs)
        corner = np.array([sides[0][-1], sides[1][-1], deep[-1]])
        outer = np.asarray((np.abs(places) > 0.999999999 * corner[:, None]).any(axis=0))
        held = np.zeros(places.shape, dtype=bool)
        for axis in np.flatnonzero(even):
            held[axis] = np.abs(places[axis]) < 1e-12 * corner[axis]
        numbers = numbered(outer, held).ravel()
        share = np.where(held, 0.0, followers(places, outer, poisson_ratio)).ravel()
        self.size = int(numbers.max()) + 1
        nodes_of = np.asarray(self._basis.element_dofs.T)
        all_three = np.hstack([nodes_of + i * self._basis.N for i in range(3)])
        self.unknowns = numbers[all_three]
        self.strains = self._strain_matrices(points) * share[all_three][:, None, None, :]
        self.exterior = exterior_stiffness(box(corner), poisson_ratio)
        self._cored = Cored(
            self.unknowns, self.place.mean(axis=2).T, 2 * float(self.touchable.max())
        )
        self._net = _Net.of(places, numbers[2 * self._basis.N :], self.touchable, even)

    def _strain_matrices(self, points: Array) -> Array:
        """Return B-bar, (elements, points, 6, 81), displacements along x first."""
        fields = [self._basis.basis[i][0] for i in range(_NODES)]
        slope = np.stack([np.asarray(f.grad) for f in fields], axis=-1)
        matrix = np.zeros((*self.weight.shape, 6, 3 * _NODES))
        part = [slice(i * _NODES, (i + 1) * _NODES) for i in range(3)]
        for i in range(3):
            matrix[..., i, part[i]] = slope[i]
            j, k = (i + 1) % 3, (i + 2) % 3  # shears yz, xz, xy
            matrix[..., 3 + i, part[j]] = slope[k]
            matrix[..., 3 + i, part[k]] = slope[j]
        project_dilatation(matrix, self.weight, points)
        return matrix

    def surface(self) -> Surface:
        """Return the quadrature points of the surface that may be touched."""
        on_top = self.mesh.facets_satisfying(
            lambda x: (
                (np.abs(x[2]) < 1e-12 * self.touchable.max())
                & (np.abs(x[:2]) < self.touchable[:, None]).all(axis=0)
            )
        )
        nodes, weights = gauss(_SURFACE_GAUSS)
        points = np.stack(np.meshgrid(nodes, nodes, indexing="ij")).reshape(2, -1)
        rule = points, np.outer(weights, weights).ravel()
        facet = skfem.FacetBasis(self.mesh, skfem.ElementHex2(), facets=on_top, quadrature=rule)
        place = np.asarray(facet.global_coordinates())[:2]
        fields = [
            np.broadcast_to(np.asarray(facet.basis[i][0]), place[0].shape) for i in range(_NODES)
        ]
        element = np.asarray(self.mesh.f2t[0, on_top])
        return Surface(
            place,
            self.copies * np.asarray(facet.dx),
            np.stack(fields, axis=-1),
            element,
            self.unknowns[element, 2 * _NODES :],
            np.ptp(place, axis=2).min(axis=0),
        )

    def contact_area(self, gap: Callable[..., Array], depth: float, unknowns: Array) -> float:
        """Return the area between the first and the last samples that touch along each line."""
        return self.copies * self._net.area(gap, depth, unknowns)

    def solver(self, local: Array) -> Callable[[Array], Array]:
        """Return what solves the system of element matrices and of the exterior."""
        element, slot = np.argwhere(self.unknowns == self.size - 1)[0]
        local[element, slot, slot] += self.exterior
        try:
            return self._cored.factorised(local)
        except np.linalg.LinAlgError:
            raise ConvergenceError("plastic elements leave a load step without stiffness") from None


@dataclass(frozen=True)
class _Net:
    """The surface between the nodes: what locates the edge of a contact.

    Attributes
    ----------
    nodes : ndarray, shape (2m + 1, 2n + 1)
        Unknowns of the nodes into the body.
    samples : tuple
        In x and y: coordinates, the lengths that belong to them, and what interpolates there.
    even : tuple of bool
    """

    nodes: Integers
    samples: tuple[tuple[Array, Array, Array], ...]
    even: tuple[bool, bool]

    @classmethod
    def of(
        cls, places: Array, unknowns: Integers, touchable: Array, even: tuple[bool, bool]
    ) -> _Net:
        """Find the nodes of the surface that may be touched, and one line beyond."""
        top = np.flatnonzero(np.abs(places[2]) < 1e-12 * touchable.max())
        tolerance = 1e-9 * touchable.max()
        axes = []
        for axis in range(2):
            at = np.unique((places[axis, top] / tolerance).round()) * tolerance
            reach = np.abs(at[::2])  # corners of elements
            keep = reach <= reach[reach > touchable[axis] - tolerance].min() + tolerance
            first, last = np.flatnonzero(keep)[[0, -1]]
            axes.append(at[2 * first : 2 * last + 1])
        x, y = axes
        near = top[
            (np.abs(places[0, top]) <= x[-1] + tolerance)
            & (np.abs(places[1, top]) <= y[-1] + tolerance)
        ]
        order = np.lexsort((places[1, near], (places[0, near] / tolerance).round()))
        nodes = unknowns[near[order]].reshape(x.size, y.size)
        return cls(nodes, (_interpolation(x), _interpolation(y)), even)

    def area(self, gap: Callable[..., Array], depth: float, unknowns: Array) -> float:
        """Return the area in contact; infinite where it reaches the edge of the net."""
        (x, dx, from_x), (y, dy, from_y) = self.samples
        sunk = from_x @ unknowns[self.nodes] @ from_y.T
        touching = depth - gap(*np.meshgrid(x, y, indexing="ij")) - sunk > 0
        if not touching.any():
            return 0.0
        # lines of symmetry are no edge
        edges = (touching, self.even[0]), (touching.T, self.even[1])
        if any(side[-1].any() or (side[0].any() and not half) for side, half in edges):
            return np.inf
        return float(dx @ _filled(touching, self.even[0]) @ dy)


def _filled(touching: NDArray[np.bool_], half: bool) -> NDArray[np.bool_]:
    """Return what lies between the first and the last along x; from x = 0 on where that is half."""
    after = np.logical_or.accumulate(touching[::-1])[::-1]
    return np.asarray(after if half else after & np.logical_or.accumulate(touching))


def _interpolation(nodes: Array) -> tuple[Array, Array, Array]:
    """Return samples between nodes of quadratic elements, their lengths, and the interpolation."""
    corners = nodes[::2]
    s = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    functions = np.stack([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)], axis=1)
    widths = np.diff(corners)
    matrix = np.zeros((widths.size * _SAMPLES, nodes.size))
    for i in range(widths.size):
        matrix[i * _SAMPLES : (i + 1) * _SAMPLES, 2 * i : 2 * i + 3] = functions
    places = (corners[:-1, None] + widths[:, None] * s).ravel()
    return places, np.repeat(widths / _SAMPLES, _SAMPLES), matrix


def box(corner: Array) -> list[tuple[Array, Array, int]]:
    """Return the faces of a box below the surface, as `exterior_stiffness` wants them."""
    nodes, weights = gauss(32)
    u, v = (a.ravel() for a in np.meshgrid(nodes, nodes, indexing="ij"))
    area = np.outer(weights, weights).ravel()
    faces = []
    for normal in range(3):
        i, j = (k for k in range(3) if k != normal)
        points = np.empty((u.size, 3))
        points[:, normal], points[:, i], points[:, j] = corner[normal], u * corner[i], v * corner[j]
        # the quarter x, y > 0 stands for all four, and the sides for those opposite
        faces.append((points, 4 * area * corner[i] * corner[j], normal))
    return faces
