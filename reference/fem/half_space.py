"""Half-spaces of finite elements, condensed onto their candidate contact points."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.arguments import choice_faults, count_faults, positive_faults, refuse
from reference.elasticity import LARGEST_POISSON_RATIO, Material
from reference.fem import pardiso
from reference.fem.condensed_body import CondensedBody
from reference.fem.element_stiffness import (
    facet_nodes,
    facet_quadrature,
    mixed_matrices,
    stiffness_matrices,
)
from reference.fem.far_field import (
    boussinesq,
    cerruti,
    exterior_stiffness,
    group_field,
    source_groups,
)
from reference.fem.half_space_mesh import GradedMesh, RingMesh, TensorMesh, ring_mesh
from reference.fem.linear_system import linear_system, stiffness_matrix
from reference.fem.matrix_free import IterativeFlexibility
from reference.fem.mesh_lines import growing_lines
from reference.fem.nested_dissection import condense

Array = NDArray[np.float64]
SOLVERS = ("nested_dissection", "pardiso", "conjugate_gradients")
# Extent of contact candidates with friction and their fine rings, in contact radii.
_FRICTION_REACH = 1.25


def half_space_body(
    mesh: RingMesh | TensorMesh,
    material: Material,
    *,
    far_field: str = "boussinesq",
    reduced_integration: bool = True,
    solver: str = SOLVERS[0],
) -> CondensedBody:
    """Return a half-space condensed onto the normal displacements of its candidate surface nodes.

    The exterior consists of Boussinesq fields (see `far_field`). Above nu = 0.4999 a mixed form is
    used (`element_stiffness.mixed_matrices`).

    Parameters
    ----------
    far_field : {"boussinesq", "fixed"}
        "fixed" clamps the outer boundary; for comparisons with published models only.
    reduced_integration : bool
        False shows locking.
    solver : {"nested_dissection", "pardiso", "conjugate_gradients"}
        "pardiso" needs the optional package pypardiso and is no faster; "conjugate_gradients"
        condenses and assembles nothing (see `matrix_free`).
    """
    faults = choice_faults("far_field", far_field, ("boussinesq", "fixed"))
    refuse(faults + _solver_faults(solver, mesh, material))
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
    # what is held, and what follows point forces on the surface
    held, outer = _held(grid), facet_nodes(grid.mesh, grid.outer)
    groups = [] if far_field == "fixed" else source_groups(*meshed.sources, grid.planes)
    if not groups:
        held[outer] = True
    unassembled = solver == "conjugate_gradients"
    if unassembled:
        size = 3 * len(grid.mesh.dofs.element_dofs)
        matrices = np.zeros((0, size, size))
    elif material.incompressible:
        matrices = mixed_matrices(grid.mesh, nu)
    else:
        matrices = stiffness_matrices(grid.mesh, nu, reduced_integration=reduced_integration)
    system = linear_system(
        grid.mesh,
        matrices,
        held,
        3 * nodes + 2,
        outer=outer,
        fields=[group_field(points.T[outer], group, nu)[0] for group in groups],
        stretch=meshed.stretch,
    )
    exterior = exterior_stiffness(grid.mesh, grid.outer, groups, nu) if groups else np.zeros((0, 0))
    seconds["assembly"], mark = time.perf_counter() - mark, time.perf_counter()
    compliance, iterative = np.zeros((0, 0)), None
    if unassembled:
        iterative = IterativeFlexibility(
            system, exterior, grid, nu, reduced_integration=reduced_integration
        )
    else:
        if solver == "pardiso":
            stiffness = pardiso.condense(stiffness_matrix(system, exterior), system.retained)
        else:
            stiffness = condense(system, exterior)
        compliance = cho_solve(cho_factor(stiffness), np.eye(len(stiffness)))
        compliance = 0.5 * (compliance + compliance.T)
    seconds["condensation"] = time.perf_counter() - mark
    return CondensedBody(
        length=meshed.length,
        youngs_modulus=material.youngs_modulus,
        poisson_ratio=nu,
        scaled_points=points[:2, nodes].T + meshed.offset,
        scaled_weights=weights[nodes],
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


def _held(grid: GradedMesh) -> NDArray[np.bool_]:
    """Return the displacements (nodes, 3) that symmetry holds."""
    held = np.zeros((grid.mesh.p.shape[1], 3), dtype=bool)
    for axis, plane in enumerate(grid.planes):
        held[:, axis] = plane & (grid.mesh.p[axis] == 0.0)
    return held


@dataclass(frozen=True, eq=False)
class FrictionalBody:
    """Half of a half-space, y >= 0, under loads symmetric about y = 0.

    Attributes
    ----------
    points : (n, 2)
        Candidate contact points.
    compliance : (n, 3, n, 3)
        Displacement (x, y, z into the body) at the first point for a unit force at the second,
        including its far field; the mirrored half is loaded equally.
    fixed : (n,) bool
        Points on the plane of symmetry, which do not move normal to it.
    """

    points: Array
    compliance: Array
    fixed: NDArray[np.bool_]
    unknowns: int


def frictional_body(
    contact_radius: float, material: Material, *, elements: int = 4, extent: float = 5.0
) -> FrictionalBody:
    """Return a half-space condensed onto all three displacements below one round contact.

    The counterpart of `half_space_body` for contact with friction. The displacement of the total
    force, Boussinesq's for its normal and Cerruti's for its tangential part, is prescribed on the
    outer boundary; the error from higher moments decreases at least as (a/L)^2.

    Candidates extend a quarter further than the (largest) contact radius, which has so many 27-node
    elements (two node spacings), at least 2; `extent` is radius and depth of the mesh in contact
    radii, at least 2; nu <= 0.4999.
    """
    faults = positive_faults(contact_radius=contact_radius) + count_faults(2, elements=elements)
    nu = material.poisson_ratio
    if material.incompressible:
        faults.append(f"poisson_ratio must be at most {LARGEST_POISSON_RATIO}, not {nu!r}")
    if not (np.isfinite(extent) and extent >= 2.0):
        faults.append(f"extent must be at least 2 contact radii, not {extent!r}")
    refuse(faults)
    # even rings up to the candidates' extent, growing beyond and with depth
    cells = max(1, round(0.5 * elements))
    size, growth = 0.5 / cells, 1.0 + 1.2 / np.sqrt(elements)
    inside = np.linspace(0.5, 1.0, cells + 1)
    further = 1.0 + size * np.arange(1, int(np.ceil((_FRICTION_REACH - 1.0) / size)) + 1)
    beyond = growing_lines(further[-1], extent, growth * size, growth)[1:]
    rings = np.concatenate([inside, further, beyond])
    depths = growing_lines(0.0, extent, 0.8 * size, growth)
    grid = ring_mesh(rings, depths, core_cells=cells, round_from=1.0, planes=(False, True))
    points = grid.mesh.p
    nodes = facet_nodes(grid.mesh, grid.surface)
    nodes = nodes[np.hypot(*points[:2, nodes]) <= _FRICTION_REACH * (1 + 1e-9)]
    held, outer = _held(grid), facet_nodes(grid.mesh, grid.outer)
    moves = ~held[nodes].ravel()
    system = linear_system(
        grid.mesh,
        stiffness_matrices(grid.mesh, nu),
        held,
        (3 * nodes[:, None] + np.arange(3)).ravel()[moves],
        outer=outer,
        fields=[cerruti(points.T[outer], nu), boussinesq(points.T[outer], nu)[0]],
    )
    stiffness = condense(system, None)
    free = len(system.retained)
    compliance = np.zeros((moves.size, len(nodes), 3))
    # unit forces on the contact, and the far fields of a unit force along x and into the body
    response = cho_solve(
        cho_factor(stiffness[:free, :free]), np.hstack([np.eye(free), -stiffness[:free, free:]])
    )
    compliance.reshape(moves.size, -1)[np.ix_(moves, moves)] = response[:, :free]
    # a force on this half and its mirror image: twice the total
    compliance[moves, :, 0::2] += 2.0 * response[:, None, free:]
    return FrictionalBody(
        points=points[:2, nodes].T * contact_radius,
        compliance=compliance.reshape(len(nodes), 3, len(nodes), 3)
        / (material.youngs_modulus * contact_radius),
        fixed=points[1, nodes] == 0.0,
        unknowns=system.first,
    )
