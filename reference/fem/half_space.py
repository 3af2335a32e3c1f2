"""Half-spaces of finite elements, condensed onto their candidate contact points."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.arguments import choice_faults, refuse
from reference.elasticity import LARGEST_POISSON_RATIO, Material
from reference.fem import pardiso
from reference.fem.body import CondensedBody
from reference.fem.conjugate_gradients import IterativeFlexibility
from reference.fem.element_stiffness import stiffness_matrices
from reference.fem.extruded import ExtrudedStiffness, Lattice
from reference.fem.far_field import exterior_stiffness, group_field, source_groups
from reference.fem.half_space_mesh import Region, RingMesh, TensorMesh
from reference.fem.mesh import GradedMesh, facet_nodes, facet_quadrature
from reference.fem.mixed import STRESSES, mixed_matrices
from reference.fem.nested_dissection import LinearSystem, condense
from reference.fem.sparse import stiffness_matrix

SOLVERS = ("nested_dissection", "pardiso", "conjugate_gradients")


def half_space_body(
    mesh: RingMesh | TensorMesh,
    material: Material,
    *,
    far_field: str = "boussinesq",
    reduced_integration: bool = True,
    solver: str = SOLVERS[0],
) -> CondensedBody:
    """Return a half-space condensed onto its candidate surface nodes.

    The exterior consists of Boussinesq fields (see `reference.fem.far_field`).

    Parameters
    ----------
    mesh : RingMesh or TensorMesh
    material : Material
        Above nu = 0.4999 the mixed form of `reference.fem.mixed` is used.
    far_field : {"boussinesq", "fixed"}
        "fixed" clamps the outer boundary; for comparisons with published models only.
    reduced_integration : bool
        False shows locking.
    solver : {"nested_dissection", "pardiso", "conjugate_gradients"}
        "pardiso" needs the optional package pypardiso and is no faster; "conjugate_gradients"
        condenses and assembles nothing (see `reference.fem.conjugate_gradients`).
    """
    faults = choice_faults("far_field", far_field, ("boussinesq", "fixed"))
    refuse(faults + _solver_faults(solver, mesh, material))
    mark, seconds = time.perf_counter(), {}
    meshed = mesh.meshed()
    seconds["mesh"], mark = time.perf_counter() - mark, time.perf_counter()
    grid, nu = meshed.grid, material.poisson_ratio
    nodes, weights = _candidates(grid, meshed.candidate)
    groups = [] if far_field == "fixed" else source_groups(*meshed.sources, grid.planes)
    size = 3 * len(grid.mesh.dofs.element_dofs)
    unassembled = solver == "conjugate_gradients"
    matrices = (
        np.zeros((0, size, size)) if unassembled else _matrices(grid, nu, reduced_integration)
    )
    system = _linear_system(grid, matrices, nodes, groups, nu, meshed.stretch)
    exterior = exterior_stiffness(grid.mesh, grid.outer, groups, nu) if groups else np.zeros((0, 0))
    seconds["assembly"], mark = time.perf_counter() - mark, time.perf_counter()
    compliance, iterative = np.zeros((0, 0)), None
    if unassembled:
        lattice = Lattice.of(grid)
        stiffness = ExtrudedStiffness(lattice, nu, reduced_integration=reduced_integration)
        iterative = IterativeFlexibility(system, exterior, grid, stiffness, lattice)
    else:
        compliance = _compliance(system, exterior, solver)
    seconds["condensation"] = time.perf_counter() - mark
    return CondensedBody(
        length=meshed.length,
        youngs_modulus=material.youngs_modulus,
        poisson_ratio=nu,
        scaled_points=grid.mesh.p[:2, nodes].T + meshed.offset,
        scaled_weights=weights,
        nodes=nodes,
        scaled_compliance=compliance,
        symmetry=2 ** sum(grid.planes),
        offset=meshed.offset,
        ring=meshed.ring,
        stretch=meshed.stretch,
        spacing_scaled=meshed.spacing,
        unknowns=system.first + len(groups),
        solver=solver,
        seconds=seconds,
        grid=grid,
        system=system,
        exterior=exterior,
        iterative=iterative,
    )


def _solver_faults(solver: str, mesh: RingMesh | TensorMesh, material: Material) -> list[str]:
    """Return messages for a missing solver, and for mesh and material that do not fit."""
    faults = choice_faults("solver", solver, SOLVERS)
    if solver == "pardiso" and not pardiso.available():
        faults.append(
            "solver = 'pardiso' needs the package pypardiso (pip install roughline[fast])"
        )
    if material.incompressible and solver != SOLVERS[0]:
        faults.append(
            f"poisson_ratio above {LARGEST_POISSON_RATIO} takes a mixed form, which is indefinite: "
            f"solver must be {SOLVERS[0]!r}, not {solver!r}"
        )
    if material.incompressible and mesh.order == 1:
        faults.append(
            f"poisson_ratio {material.poisson_ratio!r} is incompressible: 8-node elements cannot "
            "carry its mean stress without checkerboards; take order = 2"
        )
    return faults


def _matrices(
    grid: GradedMesh, poisson_ratio: float, reduced_integration: bool
) -> NDArray[np.float64]:
    if poisson_ratio > LARGEST_POISSON_RATIO:
        return mixed_matrices(grid.mesh, poisson_ratio)
    return stiffness_matrices(grid.mesh, poisson_ratio, reduced_integration=reduced_integration)


def _compliance(
    system: LinearSystem, exterior: NDArray[np.float64], solver: str
) -> NDArray[np.float64]:
    """Return the displacements of the retained unknowns for unit forces on them."""
    if solver == "pardiso":
        stiffness = pardiso.condense(stiffness_matrix(system, exterior), system.retained)
    else:
        stiffness = condense(system, exterior)
    compliance = cho_solve(cho_factor(stiffness), np.eye(len(stiffness)))
    return 0.5 * (compliance + compliance.T)


def _candidates(
    grid: GradedMesh, candidate: Region
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the candidate surface nodes, ordered by x then y, and their tributary areas."""
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
    stretch: tuple[float, float] = (1.0, 1.0),
) -> LinearSystem:
    """Return the system, with boundary unknowns numbered after the free ones.

    Centres are those of the mesh before it is stretched: bisected along its ellipses, an elongated
    one takes a quarter less time and memory.
    """
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
    # in a mixed form the element matrices also have rows for the mean stress
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
        centres=mesh.p[:, mesh.t].mean(axis=1).T / np.append(stretch, 1.0),
        mean_stresses=extra,
    )
