"""Elastic bodies of finite elements, condensed onto their candidate contact points.

A body is linear, so that one condensation serves every gap and every load: the mesh
(`half_space_mesh`, `solid_mesh`), its element matrices (`element_stiffness`), their unknowns and
the elimination of all but the normal displacements of the candidates (`condensation`), and the
inverse of what is left, the compliance. Large bodies are not condensed: conjugate gradients find
what a contact asks for (`matrix_free`, `multigrid`).
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_factor, cho_solve
from skfem import MeshTet
from skfem.element import ElementHex1, ElementHex2

from reference.arrays import Array, Integers, Mask
from reference.elasticity import LARGEST_POISSON_RATIO, Material, lame_parameters, von_mises
from reference.errors import choice_faults, refuse
from reference.fem.condensation import Front, LinearSystem, Shift, condense, expand, linear_system
from reference.fem.element_stiffness import (
    element_order,
    facet_nodes,
    facet_quadrature,
    gauss_rule,
    mean_stress_modes,
    mixed_matrices,
    shape_gradients,
    simplex_points,
    stiffness_matrices,
)
from reference.fem.far_field import exterior_stiffness, group_field, source_groups
from reference.fem.half_space_mesh import GradedMesh, RingMesh, TensorMesh
from reference.fem.matrix_free import IterativeFlexibility
from reference.fem.multigrid import MultigridFlexibility
from reference.fem.solid_mesh import CUBE, SupportedMesh, contact_nodes, tributary_areas

HALF_SPACE_SOLVERS = ("nested_dissection", "conjugate_gradients")
SUPPORTED_SOLVERS = ("nested_dissection", "conjugate_gradients")
# Linear tetrahedra have one lambda per cell in any rule, and lock.
LARGEST_POISSON_LINEAR_TETRAHEDRA = 0.45


@dataclass(frozen=True, eq=False)
class DenseFlexibility:
    """Response of a body by the compliance (n, n) between its candidates, unit modulus and length.

    `system` is what was condensed, for the interior.
    """

    compliance: Array
    system: LinearSystem

    @classmethod
    def of(cls, system: LinearSystem, stiffness: Array) -> DenseFlexibility:
        """Return the response of a system whose condensed stiffness is given."""
        compliance = cho_solve(cho_factor(stiffness), np.eye(len(stiffness)))
        return cls(0.5 * (compliance + compliance.T), system)

    def respond(
        self, inside: Integers, right: Array, softness: Array | None = None
    ) -> tuple[Array, Array]:
        """Solve ``u_i + softness_i R_i = right_i`` on the points `inside` (k,), R = 0 elsewhere.

        `right` (k, m) are m cases; `softness` (n,) is the compliance of springs between the rigid
        shape and the body (penalty), none for rigid contact. Returns forces (k, m) and the
        displacements (n, m) of all candidates.
        """
        matrix = self.compliance[np.ix_(inside, inside)]
        if softness is not None:
            matrix[np.diag_indices(len(inside))] += softness[inside]
        forces = cho_solve(cho_factor(matrix, lower=True, overwrite_a=True), right)
        return forces, self.compliance[:, inside] @ forces

    def interior(self, reactions: Array) -> Array:
        """Return displacements of all unknowns of the mesh under nodal forces (n,).

        By a repeated elimination that keeps its factors.
        """
        fronts: list[Front | Shift] = []
        condense(self.system, fronts)
        return expand(self.system, fronts, self.compliance @ reactions)


@dataclass(frozen=True, eq=False)
class CondensedBody:
    """A body, reduced to the flexibility between its candidate contact points.

    Scaled quantities have unit Young's modulus and lengths in units of `length`; the properties
    return consistent units.
    """

    # the units of the scaled quantities
    length: float
    youngs_modulus: float
    poisson_ratio: float
    scaled_points: Array  # (n, 2), candidate positions on the surface / length
    scaled_weights: Array  # (n,), tributary area of the candidates / length^2 (of the meshed part)
    nodes: Integers  # (n,), mesh nodes of the candidates
    # normal displacements for normal forces on the candidates, of the meshed part, scaled
    flexibility: DenseFlexibility | IterativeFlexibility | MultigridFlexibility
    spacing_scaled: float  # size of the surface elements in the contact / length
    unknowns: int  # number of free displacements of the mesh and far-field unknowns
    # number of equal parts, one of which is meshed: 4 for quarter symmetry, 2 for half
    symmetry: int
    seconds: dict[str, float]  # time spent on "mesh", "assembly", "condensation"
    grid: GradedMesh
    system: LinearSystem  # equations of the mesh
    # (2,), `scaled_points` minus the mesh coordinates (the mesh is centred)
    offset: Array = field(default_factory=lambda: np.zeros(2))
    ring: float | None = None  # radius of the mesh circle / length before stretching, if any
    stretch: tuple[float, float] = (1.0, 1.0)  # semi-axes of the mesh ellipse over that radius
    # the body with its nodes as candidates, if the candidates are other points
    nodal: CondensedBody | None = None
    # (n, nodes), shape functions of those nodes at the candidates
    interpolation: Array | None = None

    @property
    def iterative(self) -> IterativeFlexibility | MultigridFlexibility | None:
        """The flexibility if conjugate gradients find it, None if the body is condensed."""
        return None if isinstance(self.flexibility, DenseFlexibility) else self.flexibility

    @property
    def scaled_compliance(self) -> Array:
        """Displacements (n, n) of a condensed body at i for unit forces at j, times E length."""
        if not isinstance(self.flexibility, DenseFlexibility):
            raise ValueError("a body of conjugate gradients is not condensed")
        return self.flexibility.compliance

    @property
    def points(self) -> Array:
        """Candidate contact positions (n, 2)."""
        return self.scaled_points * self.length

    @property
    def weights(self) -> Array:
        """Tributary areas (n,) of the candidates, of the meshed part."""
        return self.scaled_weights * self.length * self.length

    @cached_property
    def scaled_radii(self) -> Array:
        """Distance (n,) of the candidates from the centre / length, before stretching."""
        return np.hypot(*(self.scaled_points / np.asarray(self.stretch)).T)

    @property
    def inside_ring(self) -> Mask:
        """Mask (n,) of the candidates within or on the mesh circle; empty for a tensor body."""
        return self.scaled_radii <= (0.0 if self.ring is None else self.ring * (1.0 + 1e-9))

    @property
    def effective_modulus(self) -> float:
        """``E* = E/(1 - nu^2)``; the indenter is rigid."""
        return self.youngs_modulus / (1.0 - self.poisson_ratio**2)

    def scaled(self, factor: float) -> CondensedBody:
        """Return the body with its mesh scaled: a half-space has no length, compliances follow."""
        if not (np.isfinite(factor) and factor > 0.0):
            raise ValueError(f"factor must be positive and finite, got {factor!r}")
        nodal = None if self.nodal is None else self.nodal.scaled(factor)
        return replace(self, length=self.length * factor, nodal=nodal)

    def at_nodes(self, reactions: ArrayLike) -> tuple[CondensedBody, Array]:
        """Return the body with its nodes as candidates, and the forces on them."""
        reactions = np.asarray(reactions, dtype=float)
        if reactions.shape != self.scaled_weights.shape or not np.isfinite(reactions).all():
            raise ValueError(
                f"reactions must be finite with shape {self.scaled_weights.shape}, "
                f"got shape {reactions.shape}"
            )
        if self.nodal is None or self.interpolation is None:
            return self, reactions
        return self.nodal, self.interpolation.T @ reactions


def half_space_body(
    mesh: RingMesh | TensorMesh, material: Material, *, solver: str = HALF_SPACE_SOLVERS[0]
) -> CondensedBody:
    """Return a half-space condensed onto the normal displacements of its candidate surface nodes.

    The exterior consists of Boussinesq fields (see `far_field`). Above nu = 0.4999 a mixed form is
    used (`element_stiffness.mixed_matrices`).

    Parameters
    ----------
    solver : {"nested_dissection", "conjugate_gradients"}
        The latter condenses and assembles nothing (see `matrix_free`).
    """
    faults = choice_faults("solver", solver, HALF_SPACE_SOLVERS)
    if material.incompressible and solver != "nested_dissection":
        faults.append(
            f"poisson_ratio above {LARGEST_POISSON_RATIO} takes a mixed form, which is indefinite: "
            f"solver must be 'nested_dissection', not {solver!r}"
        )
    if material.incompressible and mesh.order == 1:
        faults.append(
            f"poisson_ratio {material.poisson_ratio!r} is incompressible: 8-node elements cannot "
            "carry its mean stress without checkerboards; take order = 2"
        )
    refuse(faults)
    mark, seconds = time.perf_counter(), {}
    meshed = mesh.meshed()
    grid, nu = meshed.grid, material.poisson_ratio
    points = grid.mesh.p
    seconds["mesh"], mark = time.perf_counter() - mark, time.perf_counter()
    # candidates, by x then y, and tributary areas of all surface nodes
    numbers, shapes, _, areas = facet_quadrature(grid.mesh, grid.surface, 3)
    shares = np.abs(areas[..., 2]) @ shapes.T
    weights = np.bincount(numbers.ravel(), shares.ravel(), minlength=points.shape[1]).astype(float)
    nodes = facet_nodes(grid.mesh, grid.surface)
    nodes = nodes[meshed.candidate(*points[:2, nodes])]
    nodes = nodes[np.lexsort(np.round(points[1::-1, nodes], 9))]
    # what follows point forces on the surface
    outer = facet_nodes(grid.mesh, grid.outer)
    beyond = facet_quadrature(grid.mesh, grid.outer, 5)[2:]
    groups = source_groups(*meshed.sources, grid.planes)
    # the elements, and the numbers of their unknowns
    if solver == "conjugate_gradients":
        size = 3 * len(grid.mesh.dofs.element_dofs)
        matrices = np.zeros((0, size, size))
    elif material.incompressible:
        matrices = mixed_matrices(grid.mesh, nu)
    else:
        matrices = stiffness_matrices(grid.mesh, nu)
    system = linear_system(
        grid.mesh,
        matrices,
        grid.held,
        3 * nodes + 2,
        outer=outer,
        fields=[group_field(points.T[outer], group, nu)[0] for group in groups],
        exterior=exterior_stiffness(*beyond, groups, nu),
        stretch=meshed.stretch,
    )
    seconds["assembly"], mark = time.perf_counter() - mark, time.perf_counter()
    # all but the candidates are eliminated; the inverse of their stiffness is the compliance
    flexibility: DenseFlexibility | IterativeFlexibility
    if solver == "conjugate_gradients":
        flexibility = IterativeFlexibility(system, grid, nu)
    else:
        flexibility = DenseFlexibility.of(system, condense(system))
    seconds["condensation"] = time.perf_counter() - mark
    return CondensedBody(
        length=meshed.length,
        youngs_modulus=material.youngs_modulus,
        poisson_ratio=nu,
        scaled_points=points[:2, nodes].T + meshed.offset,
        scaled_weights=weights[nodes],
        nodes=nodes,
        flexibility=flexibility,
        symmetry=2 ** sum(grid.planes),
        offset=meshed.offset,
        ring=meshed.ring,
        stretch=meshed.stretch,
        spacing_scaled=meshed.spacing,
        unknowns=system.first + len(groups),
        seconds=seconds,
        grid=grid,
        system=system,
    )


def supported_body(
    supported: SupportedMesh,
    material: Material,
    *,
    symmetry: int = 1,
    nodes: Integers | None = None,
    solver: str = "nested_dissection",
) -> CondensedBody:
    """Return a supported body for contact on normal displacements of its surface.

    There is no far field: the body ends with its mesh and is held by its supports only.

    Parameters
    ----------
    material : Material
        nu <= 0.4999; at most 0.45 for linear tetrahedra, which lock.
    symmetry : int
        Number of equal parts, one of which is meshed; it enters forces and areas.
    nodes : (c,), optional
        Candidate nodes, some or (by default) all of `contact_nodes`; the candidates of the body
        have their order.
    solver : {"nested_dissection", "conjugate_gradients"}
        A factorisation condenses the body at once; conjugate gradients with algebraic multigrid
        find the compliance of the points that come into contact (`MultigridFlexibility`).
    """
    refuse(choice_faults("solver", solver, SUPPORTED_SOLVERS))
    mesh, surface, fixed = supported.solid, supported.surface, supported.fixed
    nu = material.poisson_ratio
    linear_tetrahedra = mesh.kind.simplex and mesh.kind.order == 1
    if linear_tetrahedra and nu > LARGEST_POISSON_LINEAR_TETRAHEDRA:
        raise ValueError(
            f"poisson_ratio must be at most {LARGEST_POISSON_LINEAR_TETRAHEDRA} with linear "
            f"tetrahedra, which lock, not {nu!r}: take ten-node tetrahedra"
        )
    started = time.perf_counter()
    length = 2.0 ** np.round(np.log2(np.ptp(mesh.points[mesh.nodes_of(surface), :2])))
    grid, numbers = mesh.to_scikit()
    grid = type(grid)(grid.doflocs / length, grid.t)
    weights = tributary_areas(mesh, surface) / length**2
    nodes = contact_nodes(mesh, surface) if nodes is None else nodes
    seconds = {"mesh": time.perf_counter() - started}

    started = time.perf_counter()
    held = np.empty_like(fixed)
    held[numbers] = fixed
    system = linear_system(grid, stiffness_matrices(grid, nu), held, 3 * numbers[nodes] + 2)
    seconds["assembly"] = time.perf_counter() - started

    started = time.perf_counter()
    flexibility: DenseFlexibility | MultigridFlexibility
    if solver == "conjugate_gradients":
        flexibility = MultigridFlexibility(
            system.matrices, grid.dofs.element_dofs.T, grid.doflocs.T, ~held, numbers[nodes]
        )
        system = replace(system, matrices=system.matrices[:0])
    else:
        flexibility = DenseFlexibility.of(system, condense(system))
    seconds["condensation"] = time.perf_counter() - started
    facets = grid.t2f[surface[:, 1], surface[:, 0]]
    return CondensedBody(
        length=float(length),
        youngs_modulus=material.youngs_modulus,
        poisson_ratio=nu,
        scaled_points=mesh.points[nodes, :2] / length,
        scaled_weights=weights[nodes],
        nodes=numbers[nodes],
        flexibility=flexibility,
        symmetry=symmetry,
        spacing_scaled=float(np.sqrt(np.median(weights[nodes]))),
        unknowns=system.first,
        seconds=seconds,
        grid=GradedMesh(grid, np.asarray(facets), np.zeros(0, dtype=np.int64)),
        system=system,
    )


@dataclass(frozen=True, eq=False)
class Fields:
    """Nodal fields of the meshed part, in consistent units."""

    points: Array  # (m, 3), z points into the half-space
    # (k, 8) or (k, 4), corners in VTK order of hexahedra (eight of a 27-node one) or tetrahedra
    cells: Integers
    displacement: Array  # (m, 3)
    stress: Array  # (m, 6), xx, yy, zz, yz, xz, xy; tension positive
    von_mises: Array  # (m,)


def recover(body: CondensedBody, reactions: ArrayLike) -> Fields:
    """Return displacement and stress at all mesh nodes for given nodal contact forces (n,).

    The elimination is repeated, keeping its factors (at the cost of the first condensation, and the
    memory of the factors). Stresses are evaluated at the reduced Gauss points, where they are most
    accurate (Barlow 1976), extrapolated to the nodes and averaged by volume.
    """
    body, reactions = body.at_nodes(reactions)
    mesh, elements = body.grid.mesh, body.grid.mesh.dofs.element_dofs.T
    values = body.flexibility.interior(
        reactions / (body.youngs_modulus * body.length * body.length)
    )
    numbers = np.full((mesh.p.shape[1], 3), -1, dtype=np.int64)
    unknowns = body.system.unknowns[:, : 3 * elements.shape[1]]
    numbers[elements] = unknowns.reshape(*elements.shape, 3)
    displacement = np.where(numbers >= 0, values[numbers], 0.0)

    # stress at the Gauss points, over Young's modulus
    per_direction = element_order(mesh) + isinstance(mesh, MeshTet)
    gradients, volumes = shape_gradients(mesh, per_direction)
    gradient = np.einsum("eqaj,eai->eqij", gradients, displacement[elements], optimize=True)
    strain = 0.5 * (gradient + np.swapaxes(gradient, -1, -2))
    if len(body.system.mean_stresses):
        shear = 0.5 / (1.0 + body.poisson_ratio)
        modes = mean_stress_modes(mesh, per_direction)
        mean = np.einsum("eqj,ej->eq", modes, values[body.system.mean_stresses])
    else:
        lame, shear = lame_parameters(body.poisson_ratio)
        mean = lame * np.trace(strain, axis1=-2, axis2=-1)
    tensor = 2.0 * shear * strain + mean[..., None, None] * np.eye(3)
    at_points = tensor[..., [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]

    # its mean, linear or tensor Lagrange interpolation at the nodes of the elements
    locations = mesh.elem.doflocs
    if element_order(mesh) == 1:
        extrapolation = np.ones((len(locations), 1))
    elif isinstance(mesh, MeshTet):
        at_gauss, at_all = (
            np.column_stack([1.0 - points.sum(axis=1), points])
            for points in (simplex_points(2)[0].T, locations)
        )
        extrapolation = np.linalg.solve(at_gauss.T, at_all.T).T
    else:
        line = gauss_rule(2, 1)[0][0]
        toward = (locations - line[0]) / (line[1] - line[0])
        x, y, z = np.stack([1.0 - toward, toward], axis=1).transpose(2, 0, 1)
        extrapolation = np.einsum("ni,nj,nk->nijk", x, y, z).reshape(len(locations), -1)
    at_nodes = np.einsum("nq,eqs->ens", extrapolation, at_points)
    weights = np.broadcast_to(volumes.sum(axis=1)[:, None], elements.shape).ravel()
    total = np.bincount(elements.ravel(), weights)
    columns = [
        np.bincount(elements.ravel(), weights * at_nodes[..., s].ravel()) / total for s in range(6)
    ]
    stress = np.stack(columns, axis=1) * body.youngs_modulus

    # elements, or the eight sub-cells of 27-node ones, as VTK cells of positive volume
    if isinstance(mesh, MeshTet):
        cells, spanning, mirror = elements[:, :4].copy(), [1, 2, 3], [0, 2, 1, 3]
    else:
        order = element_order(mesh)
        lattice = np.empty((len(elements),) + (order + 1,) * 3, dtype=np.int64)
        i, j, k = np.round(order * (ElementHex1, ElementHex2)[order - 1].doflocs.T).astype(int)
        lattice[:, i, j, k] = elements
        blocks = []
        for start in np.ndindex(order, order, order):
            i, j, k = (np.array(start) + CUBE).T
            blocks.append(lattice[:, i, j, k])
        cells, spanning, mirror = np.concatenate(blocks), [1, 3, 4], [4, 5, 6, 7, 0, 1, 2, 3]
    corners = mesh.p.T[cells]
    inverted = np.linalg.det(corners[:, spanning] - corners[:, [0]]) < 0.0
    cells[inverted] = cells[inverted][:, mirror]

    points = mesh.p.T.copy()
    points[:, :2] += body.offset
    return Fields(
        points=points * body.length,
        cells=cells,
        displacement=displacement * body.length,
        stress=stress,
        von_mises=von_mises(stress),
    )
