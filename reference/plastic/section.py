"""Quadratic elements on the half-section of an axisymmetric half-space: nine-node rectangles."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

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

# Lines of the mesh go out to this many times the largest contact radius, growing by this factor.
_OUTER = 15.0
_GROWTH = 1.4
_NODES = 9
# Elements along the surface that lie over one in the depth. The pressure of a contact that yields
# ends in a jump, which one element does not have: the force swings while the edge passes through
# it. That falls with the length of elements along the surface alone (docs/plasticity.md).
_ALONG = 2
# More points of contact on an element than it has shapes make the edge stick and jump.
_SURFACE_GAUSS = 3


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


class Section(Elements):
    """The half-section; stresses are (rr, zz, tt, rz).

    Parameters
    ----------
    smallest, largest : float
        Contact radii that the mesh shall resolve.
    per_radius : int
        Elements per radius into the body; along the surface twice as many.
    poisson_ratio : float
    """

    def __init__(
        self, smallest: float, largest: float, per_radius: int, poisson_ratio: float
    ) -> None:
        along = graded(smallest, largest, _ALONG * per_radius, FINE[0])
        deep = graded(smallest, largest, per_radius, FINE[1])
        self.mesh = skfem.MeshQuad.init_tensor(along, deep)
        self.touchable = FINE[0] * largest
        nodes, weights = gauss(GAUSS)
        points = np.stack(np.meshgrid(nodes, nodes, indexing="ij")).reshape(2, -1)
        rule = points, np.outer(weights, weights).ravel()
        self._basis = skfem.Basis(self.mesh, skfem.ElementQuad2(), quadrature=rule)
        self.place = np.asarray(self._basis.global_coordinates())
        self.weight = 2 * np.pi * self.place[0] * self._basis.dx
        places = np.asarray(self._basis.doflocs)
        corner = np.array([[along[-1]], [deep[-1]]])
        outer = np.asarray((places > 0.999999999 * corner).any(axis=0))
        axis = places[0] < 1e-12 * along[-1]
        held = np.stack([axis, np.zeros_like(axis)])
        numbers = numbered(outer, held).ravel()
        share = np.where(held, 0.0, followers(places, outer, poisson_ratio)).ravel()
        self.size = int(numbers.max()) + 1
        nodes_of = np.asarray(self._basis.element_dofs.T)
        both = np.hstack([nodes_of, nodes_of + self._basis.N])
        self.unknowns = numbers[both]
        self.strains = self._strain_matrices(points) * share[both][:, None, None, :]
        self.exterior = exterior_stiffness(cylinder(along[-1], deep[-1]), poisson_ratio)

    def _strain_matrices(self, points: Array) -> Array:
        """Return B-bar, (elements, points, 4, 18), radial displacements first."""
        radius = self.place[0]
        fields = [self._basis.basis[i][0] for i in range(_NODES)]
        shape = np.stack([np.broadcast_to(np.asarray(f), radius.shape) for f in fields], axis=-1)
        gradient = np.stack([np.asarray(f.grad) for f in fields], axis=-1)
        matrix = np.zeros((*radius.shape, 4, 2 * _NODES))
        matrix[..., 0, :_NODES] = gradient[0]
        matrix[..., 1, _NODES:] = gradient[1]
        matrix[..., 2, :_NODES] = shape / radius[..., None]
        matrix[..., 3, :_NODES] = gradient[1]
        matrix[..., 3, _NODES:] = gradient[0]
        project_dilatation(matrix, self.weight, points)
        return matrix

    def surface(self) -> Surface:
        """Return the quadrature points of the surface that may be touched."""
        on_top = self.mesh.facets_satisfying(
            lambda x: (np.abs(x[1]) < 1e-12 * self.touchable) & (x[0] < self.touchable)
        )
        nodes, weights = gauss(_SURFACE_GAUSS)
        facet = skfem.FacetBasis(
            self.mesh, skfem.ElementQuad2(), facets=on_top, quadrature=(nodes[None], weights)
        )
        radii = np.asarray(facet.global_coordinates())[0]
        fields = [
            np.broadcast_to(np.asarray(facet.basis[i][0]), radii.shape) for i in range(_NODES)
        ]
        order = np.argsort(radii[:, 0])
        element = np.asarray(self.mesh.f2t[0, on_top])[order]
        return Surface(
            radii[None, order],
            (2 * np.pi * radii * facet.dx)[order],
            np.stack(fields, axis=-1)[order],
            element,
            self.unknowns[element, _NODES:],
            np.ptp(radii, axis=1)[order],
        )

    def contact_area(self, gap: Callable[..., Array], depth: float, unknowns: Array) -> float:
        """Return the area of the circle at which the surface parts from the indenter."""
        surface = self._surface
        sunk = (surface.shape @ unknowns[surface.unknowns][..., None])[..., 0]
        radius, over = surface.place[0].ravel(), (depth - gap(*surface.place) - sunk).ravel()
        touching = np.flatnonzero(over > 0)
        if touching.size == 0:
            return 0.0
        last = int(touching[-1])
        if last + 1 == radius.size:
            return np.inf
        share = over[last] / (over[last] - over[last + 1])
        return float(np.pi * (radius[last] + share * (radius[last + 1] - radius[last])) ** 2)

    @cached_property
    def _surface(self) -> Surface:
        return self.surface()

    def solver(self, local: Array) -> Callable[[Array], Array]:
        """Return what solves the system of element matrices and of the exterior."""
        rank, place, rows, starts = self._pattern
        data = np.asarray(np.bincount(place, local.ravel(), rows.size), dtype=np.float64)
        last = slice(starts[rank[-1]], starts[rank[-1] + 1])
        data[last] += self.exterior * (rows[last] == rank[-1])
        factor = _factors(data, rows, starts, "NATURAL")

        def solve(right: Array) -> Array:
            ranked = np.empty_like(right)
            ranked[rank] = right
            return np.asarray(factor.solve(ranked)[rank])

        return solve

    @cached_property
    def _pattern(self) -> tuple[NDArray[np.int64], ...]:
        """Where entries of element matrices go, by what is eliminated when.

        The ranks of the unknowns, which are found once for all matrices of the mesh; places of the
        entries, rows of those, and starts of columns.
        """
        _, rows, starts = self._places(self.unknowns)
        columns = np.repeat(np.arange(self.size), np.diff(starts))
        # of any matrix with these places: one that needs no pivots
        factor = _factors(1.0 + (rows == columns) * rows.size, rows, starts, "MMD_AT_PLUS_A")
        rank = np.asarray(factor.perm_c, dtype=np.int64)
        return rank, *self._places(rank[self.unknowns])

    def _places(self, unknowns: NDArray[np.int64]) -> tuple[NDArray[np.int64], ...]:
        count = unknowns.shape[1]
        rows = np.repeat(unknowns, count, axis=1).ravel()
        columns = np.tile(unknowns, (1, count)).ravel()
        keys, place = np.unique(columns * self.size + rows, return_inverse=True)
        starts = np.searchsorted(keys, np.arange(self.size + 1) * self.size)
        return place, keys % self.size, starts


def _factors(
    data: Array, rows: NDArray[np.int64], starts: NDArray[np.int64], order: str
) -> SuperLU:
    matrix = sparse.csc_matrix((data, rows, starts), shape=(starts.size - 1,) * 2)
    return splu(
        matrix, permc_spec=order, relax=1, diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )


def cylinder(far_r: float, far_z: float) -> list[tuple[Array, Array, int]]:
    """Return the faces of a cylinder below the surface, as `exterior_stiffness` wants them."""
    nodes, weights = gauss(64)
    zero, unit = np.zeros(64), np.ones(64)
    side = np.stack([far_r * unit, zero, far_z * nodes], -1)
    base = np.stack([far_r * nodes, zero, far_z * unit], -1)
    around = 2 * np.pi * weights
    return [(side, around * far_r * far_z, 0), (base, around * far_r**2 * nodes, 2)]
