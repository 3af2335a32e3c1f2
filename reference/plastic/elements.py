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
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.fem.far_field import boussinesq
from reference.plastic.element_systems import CoredSystem, OrderedSystem

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# The fine part of a mesh, in contact radii: along the surface, and into the body.
_FINE = (1.25, 1.0)
# Lines go out to this many times the largest contact radius, growing by a factor.
_OUTER, _GROWTH = 15.0, 1.4
_BLOCK_OUTER, _BLOCK_GROWTH = 10.0, 1.6
# Elements along the surface that lie over one in the depth. The pressure of a contact that yields
# ends in a jump, which one element does not have: the force swings while the edge passes through
# it. That falls with the length of elements along the surface alone (docs/plasticity.md).
_ALONG = 2
# Points of quadrature along a side of an element, and of a facet of the surface: more points of
# contact on an axisymmetric element than it has shapes make the edge stick and jump.
_GAUSS, _SURFACE_GAUSS, _BLOCK_SURFACE_GAUSS = 3, 3, 5
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
        points, weights = _rule(_GAUSS, dimensions)
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
        self.exterior = exterior_stiffness(
            cylinder(*corner) if hoop else box(corner), poisson_ratio
        )
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
        along = graded(smallest, largest, _ALONG * per_radius, _FINE[0])
        deep = graded(smallest, largest, per_radius, _FINE[1])
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
        grid = []
        for width, half in zip(half_widths, even, strict=True):
            side = growing(width / per_radius, _FINE[0] * width, far)
            grid.append(side if half else np.concatenate([-side[:0:-1], side]))
        deep = growing(narrow / per_radius, _FINE[1] * narrow, far)
        touchable = np.array([_FINE[0] * width for width in half_widths])
        return cls([*grid, deep], touchable, poisson_ratio, hoop=False, even=even)

    @property
    def components(self) -> int:
        """Components of a stress."""
        return int(self.strains.shape[2])

    def strain(self, unknowns: Array) -> Array:
        """Return strains (elements, points, components)."""
        return (self._flat @ unknowns[self.unknowns][..., None]).reshape(self.strains.shape[:3])

    def forces(self, stress: Array) -> Array:
        """Return the forces on the unknowns of stresses (elements, points, components)."""
        weighted = (stress * self.weight[..., None]).reshape(len(self.weight), 1, -1)
        local = (weighted @ self._flat)[:, 0]
        total = np.bincount(self.unknowns.ravel(), weights=local.ravel(), minlength=self.size)
        return np.asarray(total, dtype=float)

    def factorised(self, tangent: Array, held: Array) -> Callable[[Array], Array]:
        """Return what solves the system of tangents, springs on the surface and the exterior.

        Parameters
        ----------
        tangent : (elements, points, components, components)
        held : (facets, points)
            Stiffness of the springs at the points of the surface.

        Raises
        ------
        ConvergenceError
            If the elements leave a step without stiffness.
        """
        last, matrices = self._last
        changed = np.ones(len(tangent), dtype=bool)
        if last.size:
            changed = (tangent != last).any(axis=(1, 2, 3))
        else:
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

    @property
    def _flat(self) -> Array:
        elements, points, components, count = self.strains.shape
        return self.strains.reshape(elements, points * components, count)

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
        rule = _rule(count, len(self.touchable))
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


def growing(element: float, fine: float, far: float) -> Array:
    """Return coordinates of mesh lines from 0: elements of one length up to `fine`, then growing.

    Examples
    --------
    >>> growing(0.5, 1.0, 3.0).round(2)
    array([0.  , 0.5 , 1.  , 1.8 , 3.08])
    """
    at = list(np.arange(0, int(np.ceil(fine / element - 1e-9)) + 1) * element)
    while at[-1] < far:
        at.append(at[-1] + _BLOCK_GROWTH * (at[-1] - at[-2]))
    return np.array(at)


def exterior_stiffness(faces: list[tuple[Array, Array, int]], poisson_ratio: float) -> float:
    """Return twice the energy outside a body of a unit force on a half-space of E = 1.

    `faces` below the surface are points (n, 3), areas that belong to them (negative where the
    outward normal is), and the axis of the normal. Poisson's ratio is below 1/2.
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


def cylinder(far_r: float, far_z: float) -> list[tuple[Array, Array, int]]:
    """Return the faces of a cylinder below the surface, as `exterior_stiffness` wants them."""
    (nodes,), weights = _rule(64, 1)
    zero, unit = np.zeros(64), np.ones(64)
    side = np.stack([far_r * unit, zero, far_z * nodes], -1)
    base = np.stack([far_r * nodes, zero, far_z * unit], -1)
    around = 2 * np.pi * weights
    return [(side, around * far_r * far_z, 0), (base, around * far_r**2 * nodes, 2)]


def box(corner: Array) -> list[tuple[Array, Array, int]]:
    """Return the faces of a box below the surface, as `exterior_stiffness` wants them."""
    (u, v), area = _rule(32, 2)
    faces = []
    for normal in range(3):
        i, j = (k for k in range(3) if k != normal)
        points = np.empty((u.size, 3))
        points[:, normal], points[:, i], points[:, j] = corner[normal], u * corner[i], v * corner[j]
        # the quarter x, y > 0 stands for all four, and the sides for those opposite
        faces.append((points, 4 * area * corner[i] * corner[j], normal))
    return faces


def _rule(count: int, dimensions: int) -> tuple[Array, Array]:
    """Return Gauss points (dimensions, n) and weights of the unit cube."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes, weights = 0.5 * (nodes + 1), 0.5 * weights
    grid = np.meshgrid(*[nodes] * dimensions, indexing="ij")
    product = weights
    for _ in range(dimensions - 1):
        product = np.multiply.outer(product, weights)
    return np.stack(grid).reshape(dimensions, -1), product.ravel()
