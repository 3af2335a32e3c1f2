"""Quadratic elements of a half-space that yields, around an axis or in three dimensions.

Nine-node rectangles on the half-section of an axisymmetric body, or 27-node hexahedra of which
planes of symmetry leave a half or a quarter. The dilatation of an element is projected onto linear
functions (B-bar; Hughes 1980), so that isochoric plastic flow does not lock. Beyond the mesh the
displacement is that of a point force, with the energy of the whole exterior
(`reference.fem.far_field`): mesh and exterior are one approximation of the infinite half-space.
Lengths are those of the mesh, z points into the body, moduli are relative to E.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
import skfem
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse.linalg import SuperLU, splu

from reference.arrays import Array, Integers, Mask
from reference.errors import ConvergenceError
from reference.fem.condensation import Front, LinearSystem, Shift, backward, condense, forward
from reference.fem.element_stiffness import gauss_rule
from reference.fem.far_field import boussinesq, exterior_stiffness

# The fine part of a mesh, in contact radii: along the surface, and into the body.
_FINE = (1.25, 1.0)
# Lines go out to this many times the largest contact radius, growing by a factor.
_OUTER, _GROWTH = 15.0, 1.4
_BLOCK_OUTER, _BLOCK_GROWTH = 10.0, 1.6
# Elements along the surface that lie over one in the depth. The pressure of a contact that yields
# ends in a jump, which one element does not have: the force swings while the edge passes through
# it. That falls with the length of elements along the surface alone, with an order of 1.2 to 1.9.
_ALONG = 2
# Points of quadrature along a side of an element, and of a facet of the surface: more points of
# contact on an axisymmetric element than it has shapes make the edge stick and jump.
_GAUSS, _SURFACE_GAUSS, _BLOCK_SURFACE_GAUSS = 3, 3, 5
# When elements beyond the core change, it grows to this multiple of their distance.
_BEYOND = 1.25
# Samples a side of a facet that locate the edge of a contact that is not round.
_SAMPLES = 12


class TouchableSurface(NamedTuple):
    """Quadrature points of the surface that may be touched, facet by facet.

    Facets have `place` (1 or 2, facets, points), radii (from the axis outwards) or x and y; the
    areas `weight` of their points; shape functions (facets, points, functions) of the element
    below, its number, and its displacements `unknowns` (facets, functions) into the body; and the
    `length` of their shorter side.
    """

    place: Array
    weight: Array
    shape: Array
    element: Integers
    unknowns: Integers
    length: Array

    def sunk(self, unknowns: Array) -> Array:
        """Return how far the points have gone into the body."""
        return np.asarray((self.shape @ unknowns[self.unknowns][..., None])[..., 0])


class Elements:
    """Elements on a tensor grid of lines, across and (the last) into the body.

    Unknowns are the displacements of the nodes inside the mesh, without those that symmetry holds,
    and last the amplitude of the exterior: the force (E = 1) whose displacements the nodes at the
    outer boundary follow. Stresses are (rr, zz, tt, rz), with hoop strain, or (xx, yy, zz, yz, xz,
    xy); shear strains are twice the tensor's. The last part of an element's displacements goes into
    the body. Contacts lie within `touchable`, half-widths; the displacement across a plane of
    symmetry, `even`, is zero there.

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

    def __init__(
        self,
        lines: list[Array],
        touchable: Array,
        poisson_ratio: float,
        *,
        hoop: bool,
        even: tuple[bool, ...],
    ) -> None:
        self.hoop, self.even, self.touchable = hoop, even, touchable
        self.copies = 1 if hoop else 2 ** sum(even)
        dimensions = len(lines)
        mesh, element = (
            (skfem.MeshQuad, skfem.ElementQuad2()) if hoop else (skfem.MeshHex, skfem.ElementHex2())
        )
        self.mesh = mesh.init_tensor(*lines)
        points, weights = gauss_rule(_GAUSS, dimensions)
        basis = skfem.Basis(self.mesh, element, quadrature=(points, weights))
        self.place = np.asarray(basis.global_coordinates())
        self.weight = self._around(self.place) * np.asarray(basis.dx)
        # numbers of the unknowns: nodes at the outer boundary follow the exterior, the last one
        places = np.asarray(basis.doflocs)
        corner = np.array([line[-1] for line in lines])
        outer = np.asarray((np.abs(places) > 0.999999999 * corner[:, None]).any(axis=0))
        held = np.zeros(places.shape, dtype=bool)
        for axis in np.flatnonzero(even):
            held[axis] = np.abs(places[axis]) < 1e-12 * corner[axis]
        free = ~outer & ~held
        numbers = np.full(held.shape, np.count_nonzero(free))
        numbers[free] = np.arange(np.count_nonzero(free))
        self.size = int(numbers.max()) + 1
        share = np.where(held, 0.0, 1.0)
        across = [places[0], 0 * places[0]] if hoop else list(places[:2])
        field, _ = boussinesq(np.stack([*across, places[-1]], axis=-1)[outer], poisson_ratio)
        share[:, outer] *= field.T[[0, 2]] if hoop else field.T
        of_element = np.asarray(basis.element_dofs.T)
        displacements = np.hstack([of_element + i * basis.N for i in range(dimensions)])
        self.unknowns = numbers.ravel()[displacements]
        self.strains = self._strain_matrices(basis, points)
        self.strains *= share.ravel()[displacements][:, None, None, :]
        self.components = int(self.strains.shape[2])
        self._flat = self.strains.reshape(len(self.strains), -1, self.strains.shape[-1])
        faces = cylinder(*corner) if hoop else box(corner)
        self.exterior = float(exterior_stiffness(*faces, [np.zeros((1, 2))], poisson_ratio)[0, 0])
        self.surface = self._touchable_surface(element)
        self._down = places, numbers[-1]
        self._system = (
            OrderedSystem(self.unknowns)
            if hoop
            else CoredSystem(
                self.unknowns, self.place.mean(axis=2).T, 2 * float(self.touchable.max())
            )
        )
        self._last = np.zeros(0), np.zeros(0)

    @classmethod
    def section(
        cls, smallest: float, largest: float, per_radius: int, poisson_ratio: float
    ) -> Elements:
        """Return the half-section below round contacts whose radii lie between these.

        Elements per contact radius are `per_radius` into the body, twice as many along the surface.
        """

        def lines(elements: int, fine: float) -> Array:
            # of the smallest contact up to its radius, then of their own distance, then growing
            at = [0.0]
            while at[-1] < _OUTER * largest:
                step = max(smallest, at[-1]) / elements
                if len(at) > 1 and at[-1] >= fine * largest * (1 - 1e-9):
                    step = (at[-1] - at[-2]) * _GROWTH
                at.append(at[-1] + step)
            return np.array(at)

        along, deep = lines(_ALONG * per_radius, _FINE[0]), lines(per_radius, _FINE[1])
        touchable = np.array([_FINE[0] * largest])
        return cls([along, deep], touchable, poisson_ratio, hoop=True, even=(True,))

    @classmethod
    def block(
        cls,
        half_widths: tuple[float, float],
        per_radius: int,
        poisson_ratio: float,
        even: tuple[bool, bool] = (True, True),
    ) -> Elements:
        """Return the block below contacts of up to these half-widths in x and y.

        Elements per half-width are `per_radius`; `even` says whether x = 0, and y = 0, is a plane
        of symmetry.
        """
        narrow, far = min(half_widths), _BLOCK_OUTER * max(half_widths)

        def lines(width: float, fine: float) -> Array:
            element = width / per_radius
            at = list(np.arange(0, int(np.ceil(fine * width / element - 1e-9)) + 1) * element)
            while at[-1] < far:
                at.append(at[-1] + _BLOCK_GROWTH * (at[-1] - at[-2]))
            return np.array(at)

        grid = []
        for width, half in zip(half_widths, even, strict=True):
            side = lines(width, _FINE[0])
            grid.append(side if half else np.concatenate([-side[:0:-1], side]))
        deep = lines(narrow, _FINE[1])
        touchable = np.array([_FINE[0] * width for width in half_widths])
        return cls([*grid, deep], touchable, poisson_ratio, hoop=False, even=even)

    def strain(self, unknowns: Array) -> Array:
        """Return strains (elements, points, components)."""
        return (self._flat @ unknowns[self.unknowns][..., None]).reshape(self.strains.shape[:3])

    def forces(self, stress: Array) -> Array:
        """Return the forces on the unknowns of stresses (elements, points, components)."""
        weighted = (stress * self.weight[..., None]).reshape(len(self.weight), 1, -1)
        local = (weighted @ self._flat)[:, 0]
        total = np.bincount(self.unknowns.ravel(), weights=local.ravel(), minlength=self.size)
        return np.asarray(total, dtype=float)

    def factorised(
        self,
        tangent: Array,  # (elements, points, components, components)
        held: Array,  # (facets, points), stiffness of the springs at the points of the surface
    ) -> Callable[[Array], Array]:
        """Return what solves the system of tangents, springs on the surface and the exterior.

        Raises ConvergenceError if the elements leave a step without stiffness.
        """
        last, matrices = self._last
        if last.size:
            changed = (tangent != last).any(axis=(1, 2, 3))
        else:
            changed = np.ones(len(tangent), dtype=bool)
            matrices = np.empty((len(tangent), *2 * self.strains.shape[-1:]))
        flat = self._flat[changed]
        weighted = tangent[changed] * self.weight[changed][..., None, None]
        product = weighted @ self.strains[changed]
        matrices[changed] = flat.swapaxes(1, 2) @ product.reshape(flat.shape)
        self._last = tangent, matrices
        local, surface = matrices.copy(), self.surface
        count = surface.shape.shape[-1]
        local[surface.element, -count:, -count:] += np.einsum(
            "fpi,fp,fpj->fij", surface.shape, held, surface.shape
        )
        try:
            return self._system.factorised(local, self.exterior)
        except np.linalg.LinAlgError:
            raise ConvergenceError("plastic elements leave a load step without stiffness") from None

    def contact_area(self, gap: Callable[..., Array], depth: float, unknowns: Array) -> float:
        """Return the area within the last points that touch a shape of that gap at a depth.

        Of round contacts the circle at which the surface parts from the indenter; of others what
        lies between the first and the last samples that touch along each line. Infinite where the
        contact reaches the end of what may be touched.
        """
        if self.hoop:
            surface = self.surface
            radius = surface.place[0].ravel()
            over = (depth - gap(*surface.place) - surface.sunk(unknowns)).ravel()
            touching = np.flatnonzero(over > 0)
            if touching.size == 0:
                return 0.0
            last = int(touching[-1])
            if last + 1 == radius.size:
                return np.inf
            share = over[last] / (over[last] - over[last + 1])
            return float(np.pi * (radius[last] + share * (radius[last + 1] - radius[last])) ** 2)
        nodes, ((x, dx, from_x), (y, dy, from_y)) = self._net
        sunk = from_x @ unknowns[nodes] @ from_y.T
        touches = depth - gap(*np.meshgrid(x, y, indexing="ij")) - sunk > 0
        if not touches.any():
            return 0.0
        # lines of symmetry are no edge
        edges = (touches, self.even[0]), (touches.T, self.even[1])
        if any(side[-1].any() or (side[0].any() and not half) for side, half in edges):
            return np.inf
        filled = np.logical_or.accumulate(touches[::-1])[::-1]
        if not self.even[0]:
            filled = filled & np.logical_or.accumulate(touches)
        return self.copies * float(dx @ filled @ dy)

    def _around(self, place: Array) -> Array | float:
        """Return by which factor what is modelled stands for the whole body."""
        return 2 * np.pi * place[0] if self.hoop else float(self.copies)

    def _strain_matrices(self, basis: skfem.Basis, points: Array) -> Array:
        """Return B-bar at points of the reference element, displacements along the axes in turn."""
        fields = [field[0] for field in basis.basis]
        slope = np.stack([np.asarray(field.grad) for field in fields], axis=-1)
        count, dimensions = len(fields), len(self.place)
        part = [slice(i * count, (i + 1) * count) for i in range(dimensions)]
        components = 4 if self.hoop else 6
        matrix = np.zeros((*self.weight.shape, components, dimensions * count))
        for i in range(dimensions):
            matrix[..., i, part[i]] = slope[i]
        if self.hoop:
            shape = [np.broadcast_to(np.asarray(field), self.weight.shape) for field in fields]
            matrix[..., 2, part[0]] = np.stack(shape, axis=-1) / self.place[0][..., None]
        for row, j, k in ((3, 0, 1),) if self.hoop else ((3, 1, 2), (4, 2, 0), (5, 0, 1)):
            matrix[..., row, part[j]] = slope[k]
            matrix[..., row, part[k]] = slope[j]
        # the projection of the dilatation onto linear functions of each element
        dilatation = matrix[..., :3, :].sum(axis=-2)
        linear = np.stack([np.ones(points.shape[1]), *(points - 0.5)], axis=-1)
        mass = np.einsum("ep,pi,pj->eij", self.weight, linear, linear)
        moments = np.einsum("ep,pi,epk->eik", self.weight, linear, dilatation)
        projected = linear @ np.linalg.solve(mass, moments)
        matrix[..., :3, :] += ((projected - dilatation) / 3)[..., None, :]
        return matrix

    def _touchable_surface(self, element: skfem.Element) -> TouchableSurface:
        on_top = self.mesh.facets_satisfying(
            lambda x: (
                (np.abs(x[-1]) < 1e-12 * self.touchable.max())
                & (np.abs(x[:-1]) < self.touchable[:, None]).all(axis=0)
            )
        )
        count = _SURFACE_GAUSS if self.hoop else _BLOCK_SURFACE_GAUSS
        rule = gauss_rule(count, len(self.touchable))
        facet = skfem.FacetBasis(self.mesh, element, facets=on_top, quadrature=rule)
        place = np.asarray(facet.global_coordinates())[:-1]
        shape = [np.broadcast_to(np.asarray(field[0]), place[0].shape) for field in facet.basis]
        order = np.argsort(place[0, :, 0]) if self.hoop else np.arange(on_top.size)
        below = np.asarray(self.mesh.f2t[0, on_top])[order]
        return TouchableSurface(
            place[:, order],
            (self._around(place) * np.asarray(facet.dx))[order],
            np.stack(shape, axis=-1)[order],
            below,
            self.unknowns[below, -len(shape) :],
            np.ptp(place, axis=2).min(axis=0)[order],
        )

    @cached_property
    def _net(self) -> tuple[Integers, list[tuple[Array, Array, Array]]]:
        """The surface between the nodes of a block, which locates the edge of a contact.

        Unknowns of the nodes that may be touched, and one line of elements beyond; along x and y
        places of samples, the lengths that belong to them, and what interpolates there.
        """
        places, into_body = self._down
        top = np.flatnonzero(np.abs(places[2]) < 1e-12 * self.touchable.max())
        tolerance = 1e-9 * self.touchable.max()
        axes = []
        for axis in range(2):
            at = np.unique((places[axis, top] / tolerance).round()) * tolerance
            reach = np.abs(at[::2])  # corners of elements
            keep = reach <= reach[reach > self.touchable[axis] - tolerance].min() + tolerance
            first, last = np.flatnonzero(keep)[[0, -1]]
            axes.append(at[2 * first : 2 * last + 1])
        x, y = axes
        near = top[
            (np.abs(places[0, top]) <= x[-1] + tolerance)
            & (np.abs(places[1, top]) <= y[-1] + tolerance)
        ]
        order = np.lexsort((places[1, near], (places[0, near] / tolerance).round()))
        s = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
        functions = np.stack([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)], axis=1)
        samples = []
        for nodes in axes:
            corners, widths = nodes[:-1:2], np.diff(nodes[::2])
            matrix = np.zeros((widths.size * _SAMPLES, nodes.size))
            for i in range(widths.size):
                matrix[i * _SAMPLES : (i + 1) * _SAMPLES, 2 * i : 2 * i + 3] = functions
            at = (corners[:, None] + widths[:, None] * s).ravel()
            samples.append((at, np.repeat(widths / _SAMPLES, _SAMPLES), matrix))
        return into_body[near[order]].reshape(x.size, y.size), samples


def cylinder(far_r: float, far_z: float) -> tuple[Array, Array]:
    """Return points and area vectors (2, n, 3) of the faces of a cylinder below the surface."""
    (nodes,), weights = gauss_rule(64, 1)
    points, areas = np.zeros((2, 64, 3)), np.zeros((2, 64, 3))
    points[0, :, 0], points[0, :, 2] = far_r, far_z * nodes
    points[1, :, 0], points[1, :, 2] = far_r * nodes, far_z
    areas[0, :, 0] = 2 * np.pi * weights * far_r * far_z
    areas[1, :, 2] = 2 * np.pi * weights * far_r**2 * nodes
    return points, areas


def box(corner: Array) -> tuple[Array, Array]:
    """Return points and area vectors (3, n, 3) of the faces of a box below the surface."""
    (u, v), weights = gauss_rule(32, 2)
    points, areas = np.empty((3, u.size, 3)), np.zeros((3, u.size, 3))
    for normal in range(3):
        i, j = (k for k in range(3) if k != normal)
        points[normal, :, normal] = corner[normal]
        points[normal, :, i], points[normal, :, j] = u * corner[i], v * corner[j]
        # the quarter x, y > 0 stands for all four, and the sides for those opposite
        areas[normal, :, normal] = 4 * weights * corner[i] * corner[j]
    return points, areas


class OrderedSystem:
    """A system whose pattern and order of elimination are found once for all matrices.

    `unknowns` (elements, n) are those of each element.
    """

    def __init__(self, unknowns: Integers) -> None:
        self.size = int(unknowns.max()) + 1
        _, rows, starts = self._places(unknowns)
        columns = np.repeat(np.arange(self.size), np.diff(starts))
        # of any matrix with these places: one that needs no pivots
        factor = self._factors(
            1.0 + (rows == columns) * rows.size, rows, starts, order="MMD_AT_PLUS_A"
        )
        self._rank = np.asarray(factor.perm_c, dtype=np.int64)
        self._pattern = self._places(self._rank[unknowns])

    def factorised(self, matrices: Array, spring: float) -> Callable[[Array], Array]:
        """Return what solves element matrices (elements, n, n), the last unknown on a spring."""
        rank, (place, rows, starts) = self._rank, self._pattern
        data = np.asarray(np.bincount(place, matrices.ravel(), rows.size), dtype=np.float64)
        last = slice(starts[rank[-1]], starts[rank[-1] + 1])
        data[last] += spring * (rows[last] == rank[-1])
        factor = self._factors(data, rows, starts, order="NATURAL")

        def solve(right: Array) -> Array:
            ranked = np.empty_like(right)
            ranked[rank] = right
            return np.asarray(factor.solve(ranked)[rank])

        return solve

    def _places(self, unknowns: Integers) -> tuple[Integers, Integers, Integers]:
        """Return where entries of element matrices go, rows of those places, starts of columns."""
        count = unknowns.shape[1]
        rows = np.repeat(unknowns, count, axis=1).ravel()
        columns = np.tile(unknowns, (1, count)).ravel()
        keys, place = np.unique(columns * self.size + rows, return_inverse=True)
        starts = np.searchsorted(keys, np.arange(self.size + 1) * self.size)
        return place, keys % self.size, starts

    def _factors(self, data: Array, rows: Integers, starts: Integers, *, order: str) -> SuperLU:
        return splu(
            sparse.csc_matrix((data, rows, starts), shape=(self.size, self.size)),
            permc_spec=order,
            relax=1,
            panel_size=1,
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )


class CoredSystem:
    """A positive definite system of which only a core around the origin changes.

    The rest is condensed once, by nested dissection. `unknowns` (elements, n) are those of each
    element, `centres` (elements, 3) its place. Elements within `radius` are expected to change; it
    grows when others do.
    """

    def __init__(self, unknowns: Integers, centres: Array, radius: float) -> None:
        self.unknowns, self.centres = unknowns, centres
        self.size = int(unknowns.max()) + 1
        self._distance = np.linalg.norm(centres, axis=1)
        self._radius = radius
        self._outside = np.zeros(0)  # matrices beyond the core
        self._rest: tuple[Array, list[Front | Shift]] | None = None

    def factorised(self, matrices: Array, spring: float) -> Callable[[Array], Array]:
        """Return what solves element matrices (elements, n, n), the last unknown on a spring.

        The spring is added to them.

        Raises LinAlgError if it is not positive definite.
        """
        element, slot = np.argwhere(self.unknowns == self.size - 1)[0]
        matrices[element, slot, slot] += spring
        beyond = self._distance > self._radius
        changed = np.ones(np.count_nonzero(beyond), dtype=bool)
        if self._rest is not None:
            changed = (matrices[beyond] != self._outside).any(axis=(1, 2))
            if changed.any():
                furthest = float(self._distance[beyond][changed].max())
                self._radius = min(_BEYOND * furthest, 0.9 * float(self._distance.max()))
                beyond = self._distance > self._radius
        if self._rest is None or changed.any():
            self._rim = np.intersect1d(self.unknowns[~beyond], self.unknowns[beyond])
            self._outside = matrices[beyond]
            self._rest = self._condensed(matrices, beyond)
        core, fronts = self._condensed(matrices, ~beyond)
        outside, outer_fronts = self._rest
        top = cho_factor(core + outside, check_finite=False)
        rim = self._rim

        def solve(loads: Array) -> Array:
            values = np.array(loads)
            forward(fronts, values)
            forward(outer_fronts, values)
            values[rim] = cho_solve(top, values[rim], check_finite=False)
            backward(fronts, values)
            backward(outer_fronts, values)
            return values

        return solve

    def _condensed(self, matrices: Array, part: Mask) -> tuple[Array, list[Front | Shift]]:
        """Return the stiffness of some elements on the rim, and their eliminations."""
        fronts = list[Front | Shift]()
        system = LinearSystem(
            matrices=matrices[part],
            unknowns=self.unknowns[part],
            first=self.size,
            retained=self._rim,
            centres=self.centres[part],
        )
        return condense(system, fronts), fronts
