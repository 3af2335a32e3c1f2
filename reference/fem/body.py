"""A linear-elastic half-space condensed once onto the points that may touch."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.fem import pardiso
from reference.fem.elasticity import LARGEST_POISSON_RATIO, stiffness_matrices
from reference.fem.far_field import exterior_stiffness, group_field, source_groups
from reference.fem.flexibility import DenseFlexibility, Flexibility
from reference.fem.mesh import GradedMesh, facet_nodes, facet_quadrature
from reference.fem.mixed import STRESSES, mixed_matrices
from reference.fem.multigrid import MultigridFlexibility
from reference.fem.nested_dissection import LinearSystem, condense
from reference.fem.sparse import stiffness_matrix

Region = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]]


@dataclass(frozen=True, eq=False)
class CondensedBody:
    """A half-space known only through the flexibility between its candidate contact points.

    The body is linear, so one condensation serves every gap and every load. Numbers are kept for a
    unit Young's modulus and lengths in units of `length`; the properties return consistent units.

    Attributes
    ----------
    length, youngs_modulus : float
        The units in which the scaled quantities are kept.
    poisson_ratio : float
    scaled_points : (n, 2)
        Candidate positions on the surface / length.
    scaled_weights : (n,)
        Area that belongs to each candidate / length^2 (of the meshed part).
    nodes : (n,)
        Mesh node of each candidate.
    scaled_compliance : (n, n)
        Normal displacement at i for a unit normal force at j (meshed part), times E length.
    symmetry : int
        Number of equal parts of which one is meshed: 4 with quarter symmetry, 2 with half.
    offset : (2,)
        What the mesh coordinates lack to `scaled_points` (the mesh is centred).
    spacing_scaled : float
        Size of the surface elements in the contact / length.
    ring : float or None
        Radius of the mesh circle / length before stretching; None for a tensor body.
    stretch : (float, float)
        Semi-axes of the mesh ellipse over the radius of the circle.
    unknowns : int
        Free displacements of the mesh and far-field unknowns.
    solver : str
        What condensed the body.
    seconds : dict
        Time spent on "mesh", "assembly", "condensation".
    grid : GradedMesh
    system : LinearSystem
        For the recovery of the interior.
    exterior : (k, k)
        Far-field stiffness.
    multigrid : MultigridFlexibility or None
        In place of a condensation; `scaled_compliance` then has shape (0, 0).
    nodal : CondensedBody or None
        The body with its nodes as candidates, where the candidates are other points.
    interpolation : (n, nodes) or None
        Shape functions of those nodes at the candidates.
    """

    length: float
    youngs_modulus: float
    poisson_ratio: float
    scaled_points: NDArray[np.float64]
    scaled_weights: NDArray[np.float64]
    nodes: NDArray[np.int64]
    scaled_compliance: NDArray[np.float64]
    symmetry: int
    offset: NDArray[np.float64]
    spacing_scaled: float
    ring: float | None
    stretch: tuple[float, float]
    unknowns: int
    solver: str
    seconds: dict[str, float]
    grid: GradedMesh
    system: LinearSystem
    exterior: NDArray[np.float64]
    multigrid: MultigridFlexibility | None = None
    nodal: CondensedBody | None = None
    interpolation: NDArray[np.float64] | None = None

    @cached_property
    def flexibility(self) -> Flexibility:
        """What the body answers to forces on its candidates, in scaled quantities."""
        if self.multigrid is not None:
            return self.multigrid
        return DenseFlexibility(self.scaled_compliance, self.system, self.exterior)

    @property
    def points(self) -> NDArray[np.float64]:
        """Candidate contact positions (n, 2)."""
        return self.scaled_points * self.length

    @property
    def weights(self) -> NDArray[np.float64]:
        """Tributary areas (n,) of the candidates, of the meshed part."""
        return self.scaled_weights * self.length * self.length

    @cached_property
    def compliance(self) -> NDArray[np.float64]:
        """Normal displacements (n, n) for unit nodal forces on the meshed part."""
        return self.scaled_compliance / (self.youngs_modulus * self.length)

    @property
    def spacing(self) -> float:
        """Size of the surface elements in the contact."""
        return self.spacing_scaled * self.length

    @cached_property
    def scaled_radii(self) -> NDArray[np.float64]:
        """Distance (n,) of the candidates from the centre / length, before stretching."""
        return np.hypot(*(self.scaled_points / np.asarray(self.stretch)).T)

    @property
    def inside_ring(self) -> NDArray[np.bool_]:
        """Which candidates (n,) lie within or on the mesh circle; none for a tensor body."""
        return self.scaled_radii <= (0.0 if self.ring is None else self.ring * (1.0 + 1e-9))

    @property
    def effective_modulus(self) -> float:
        """``E* = E/(1 - nu^2)``; the indenter is rigid."""
        return self.youngs_modulus / (1.0 - self.poisson_ratio**2)

    def scaled(self, factor: float) -> CondensedBody:
        """Return the same mesh `factor` times larger.

        A half-space has no length, so nothing has to be solved again: compliances divide by the
        factor.
        """
        if not (np.isfinite(factor) and factor > 0.0):
            raise ValueError(f"factor must be positive and finite, got {factor!r}")
        nodal = None if self.nodal is None else self.nodal.scaled(factor)
        return replace(self, length=self.length * factor, nodal=nodal)

    def at_nodes(self, reactions: ArrayLike) -> tuple[CondensedBody, NDArray[np.float64]]:
        """Return the body with its nodes as candidates, and the forces on them.

        Raises
        ------
        ValueError
            If `reactions` does not have one finite value for each candidate.
        """
        reactions = np.asarray(reactions, dtype=float)
        if reactions.shape != self.scaled_weights.shape or not np.isfinite(reactions).all():
            raise ValueError(
                f"reactions must be finite with shape {self.scaled_weights.shape}, "
                f"got shape {reactions.shape}"
            )
        if self.nodal is None or self.interpolation is None:
            return self, reactions
        return self.nodal, self.interpolation.T @ reactions


def condensed_body(
    grid: GradedMesh,
    candidate: Region,
    sources: tuple[float, float],
    *,
    ring: float | None,
    stretch: tuple[float, float],
    length: float,
    modulus: float,
    poisson_ratio: float,
    spacing: float,
    fixed: bool,
    reduced_integration: bool,
    solver: str,
    started: float,
) -> CondensedBody:
    """Assemble a mesh (lengths in units of `length`) and condense it onto surface nodes.

    Parameters
    ----------
    grid : GradedMesh
    candidate : callable
        Which surface nodes (x, y) may touch.
    sources : (float, float)
        Distances in x and y of the outer point forces of the far field from the centre.
    ring, stretch, length, modulus, poisson_ratio, spacing
        Recorded in the body.
    fixed : bool
        Clamp the outer boundary in place of the Boussinesq far field.
    reduced_integration : bool
    solver : {"nested_dissection", "pardiso", "multigrid"}
        The last condenses nothing.
    started : float
        `time.perf_counter()` before the mesh was made.
    """
    seconds = {"mesh": time.perf_counter() - started}
    mark = time.perf_counter()
    nodes, weights = _candidates(grid, candidate)
    groups = [] if fixed else source_groups(*sources, grid.planes)
    matrices = _matrices(grid, poisson_ratio, reduced_integration)
    system = _linear_system(grid, matrices, nodes, groups, poisson_ratio)
    exterior = np.zeros((0, 0))
    if groups:
        exterior = exterior_stiffness(grid.mesh, grid.outer, groups, poisson_ratio)
    seconds["assembly"] = time.perf_counter() - mark
    mark = time.perf_counter()
    compliance, multigrid = np.zeros((0, 0)), None
    if solver == "multigrid":
        multigrid = MultigridFlexibility(system, exterior, *_places(grid, system))
    else:
        compliance = _compliance(system, exterior, solver)
    seconds["condensation"] = time.perf_counter() - mark
    return CondensedBody(
        length=length,
        youngs_modulus=modulus,
        poisson_ratio=poisson_ratio,
        scaled_points=grid.mesh.p[:2, nodes].T.copy(),
        scaled_weights=weights,
        nodes=nodes,
        scaled_compliance=compliance,
        symmetry=2 ** sum(grid.planes),
        offset=np.zeros(2),
        ring=ring,
        stretch=stretch,
        spacing_scaled=spacing,
        unknowns=system.first + len(groups),
        solver=solver,
        seconds=seconds,
        grid=grid,
        system=system,
        exterior=exterior,
        multigrid=multigrid,
    )


def _matrices(
    grid: GradedMesh, poisson_ratio: float, reduced_integration: bool
) -> NDArray[np.float64]:
    if poisson_ratio > LARGEST_POISSON_RATIO:
        return mixed_matrices(grid.mesh, poisson_ratio)
    return stiffness_matrices(grid.mesh, poisson_ratio, reduced_integration=reduced_integration)


def _compliance(
    system: LinearSystem, exterior: NDArray[np.float64], solver: str
) -> NDArray[np.float64]:
    """Displacements of the retained unknowns for unit forces on them."""
    if solver == "pardiso":
        stiffness = pardiso.condense(stiffness_matrix(system, exterior), system.retained)
    else:
        stiffness = condense(system, exterior)
    compliance = cho_solve(cho_factor(stiffness), np.eye(len(stiffness)))
    return 0.5 * (compliance + compliance.T)


def _places(
    grid: GradedMesh, system: LinearSystem
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Position and direction of each free unknown."""
    positions = np.zeros((system.first, 3))
    components = np.zeros(system.first, dtype=np.int64)
    elements = grid.mesh.dofs.element_dofs.T
    numbers = system.unknowns.reshape(*elements.shape, 3)
    free = (numbers >= 0) & (numbers < system.first)
    node, direction = np.broadcast_arrays(elements[..., None], np.arange(3))
    positions[numbers[free]] = grid.mesh.p.T[node[free]]
    components[numbers[free]] = direction[free]
    return positions, components


def _candidates(
    grid: GradedMesh, candidate: Region
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Surface nodes that may touch, ordered by x then y, and their tributary areas."""
    mesh = grid.mesh
    numbers, shapes, _, areas = facet_quadrature(mesh, grid.surface, 3)
    shares = np.abs(areas[..., 2]) @ shapes.T
    weights = np.bincount(numbers.ravel(), shares.ravel(), minlength=mesh.p.shape[1]).astype(float)
    nodes = facet_nodes(mesh, grid.surface)
    nodes = nodes[candidate(mesh.p[0, nodes], mesh.p[1, nodes])]
    place = np.round(mesh.p[:2, nodes], 9)
    nodes = nodes[np.lexsort((place[1], place[0]))]
    return nodes, weights[nodes]


def _linear_system(
    grid: GradedMesh,
    matrices: NDArray[np.float64],
    candidates: NDArray[np.int64],
    groups: list[NDArray[np.float64]],
    poisson_ratio: float,
) -> LinearSystem:
    """Give numbers to the free displacements, then to those that follow the far field."""
    mesh = grid.mesh
    total = mesh.p.shape[1]
    fixed = np.zeros((total, 3), dtype=bool)
    for axis, plane in enumerate(grid.planes):
        fixed[:, axis] = plane & (mesh.p[axis] == 0.0)
    outer = facet_nodes(mesh, grid.outer)
    number = np.zeros((total, 3), dtype=np.int64)
    number[outer] = 1
    number[fixed] = -1
    if not groups:
        number[outer] = -1
    free, following = number == 0, number == 1
    elements = mesh.dofs.element_dofs.T
    displacements = int(free.sum())
    # in a mixed form the element matrices have rows for the mean stress, too
    stresses = matrices.shape[1] > 3 * elements.shape[1]
    extra = np.arange(len(elements) * STRESSES * stresses).reshape(-1, STRESSES) + displacements
    first = displacements + extra.size
    number[free] = np.arange(displacements)
    number[following] = first + np.arange(following.sum())
    fields = [group_field(mesh.p.T[outer], group, poisson_ratio)[0] for group in groups]
    boundary = np.zeros((int(following.sum()), len(groups)))
    for column, field in enumerate(fields):
        everywhere = np.zeros((total, 3))
        everywhere[outer] = field
        boundary[:, column] = everywhere[following]
    unknowns = number[elements].reshape(len(elements), -1)
    return LinearSystem(
        matrices=matrices,
        unknowns=np.hstack([unknowns, extra]) if stresses else unknowns,
        boundary=boundary,
        first=first,
        retained=number[candidates, 2],
        centres=mesh.p[:, mesh.t].mean(axis=1).T,
        mean_stresses=extra,
    )
