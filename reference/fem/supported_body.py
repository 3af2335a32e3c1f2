"""A finite body with supports, as the response of the nodes of its contact surface."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.arguments import choice_faults, refuse
from reference.elasticity import Material
from reference.fem.condensed_body import CondensedBody
from reference.fem.element_stiffness import stiffness_matrices
from reference.fem.half_space_mesh import GradedMesh
from reference.fem.linear_system import linear_system
from reference.fem.multigrid import MultigridFlexibility
from reference.fem.nested_dissection import condense
from reference.fem.solid_mesh import SolidMesh

SOLVERS = ("nested_dissection", "conjugate_gradients")
# Linear tetrahedra have one lambda per cell in any rule, and lock.
LARGEST_POISSON_LINEAR_TETRAHEDRA = 0.45
# Under uniform pressure the corners of a ten-node tetrahedron carry no force.
NO_WEIGHT = 1e-6
RIGID_MOTIONS = (
    *("translation along x", "translation along y", "translation along z"),
    *("rotation about x", "rotation about y", "rotation about z"),
)


@dataclass(frozen=True, eq=False)
class SupportedMesh:
    """The mesh of a supported body.

    Parameters
    ----------
    solid : SolidMesh
        z points into the body, away from the indenter.
    surface : (k, 2)
        Candidate contact faces.
    fixed : (n, 3) bool
        Zero displacement components of the nodes: they must leave no rigid motion free, nor hold
        the contact surface along z.
    """

    solid: SolidMesh
    surface: NDArray[np.int64]
    fixed: NDArray[np.bool_]

    def __post_init__(self) -> None:
        points, fixed = self.solid.points, self.fixed
        if fixed.shape != points.shape:
            raise ValueError(f"fixed must have shape {points.shape}, not {fixed.shape}")
        faults, free = [], free_motions(points, fixed)
        if free:
            faults.append(f"the supports leave the body free: {', '.join(free)}")
        if fixed[self.solid.nodes_of(self.surface), 2].any():
            faults.append("nodes of the contact surface must not be held along z")
        refuse(faults)


def supported_body(
    supported: SupportedMesh,
    material: Material,
    *,
    symmetry: int = 1,
    nodes: NDArray[np.int64] | None = None,
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
    refuse(choice_faults("solver", solver, SOLVERS))
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
    weights = _weights(mesh, surface) / length**2
    nodes = contact_nodes(mesh, surface) if nodes is None else nodes
    seconds = {"mesh": time.perf_counter() - started}

    started = time.perf_counter()
    held = np.empty_like(fixed)
    held[numbers] = fixed
    system = linear_system(grid, stiffness_matrices(grid, nu), held, 3 * numbers[nodes] + 2)
    seconds["assembly"] = time.perf_counter() - started

    started = time.perf_counter()
    exterior, compliance, iterative = np.zeros((0, 0)), np.zeros((0, 0)), None
    if solver == "conjugate_gradients":
        iterative = MultigridFlexibility(
            system.matrices, grid.dofs.element_dofs.T, grid.doflocs.T, ~held, numbers[nodes]
        )
        system = replace(system, matrices=system.matrices[:0])
    else:
        stiffness = condense(system, exterior)
        compliance = cho_solve(cho_factor(stiffness), np.eye(len(stiffness)))
        compliance = 0.5 * (compliance + compliance.T)
    seconds["condensation"] = time.perf_counter() - started
    facets = grid.t2f[surface[:, 1], surface[:, 0]]
    return CondensedBody(
        length=float(length),
        youngs_modulus=material.youngs_modulus,
        poisson_ratio=nu,
        scaled_points=mesh.points[nodes, :2] / length,
        scaled_weights=weights[nodes],
        nodes=numbers[nodes],
        scaled_compliance=compliance,
        symmetry=symmetry,
        offset=np.zeros(2),
        ring=None,
        stretch=(1.0, 1.0),
        spacing_scaled=float(np.sqrt(np.median(weights[nodes]))),
        unknowns=system.first,
        solver=solver.replace("_", " "),
        seconds=seconds,
        grid=GradedMesh(grid, np.asarray(facets), np.zeros(0, dtype=np.int64)),
        system=system,
        exterior=exterior,
        iterative=iterative,
    )


def contact_nodes(mesh: SolidMesh, surface: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the surface nodes that can carry contact forces, ordered by x, then y.

    These have a tributary area: all nodes of hexahedra and linear tetrahedra, the mid-edge nodes of
    ten-node tetrahedra, whose corners carry no force under uniform pressure.
    """
    weights = _weights(mesh, surface)
    nodes = np.flatnonzero(weights > NO_WEIGHT * weights.max())
    return nodes[np.lexsort(mesh.points[nodes, 1::-1].T)]


def free_motions(points: NDArray[np.float64], fixed: NDArray[np.bool_]) -> list[str]:
    """Return the names of unsupported rigid motions, empty if the body is held.

    Examples
    --------
    A body held along z at the bottom can still slide and rotate:

    >>> corners = np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]])
    >>> free_motions(corners, np.tile([False, False, True], (3, 1)))
    ['translation along x', 'translation along y', 'rotation about z']
    """
    centred = points - points.mean(axis=0)
    centred = centred / np.abs(centred).max()
    turns = np.cross(np.eye(3)[:, None], centred)
    shifts = np.broadcast_to(np.eye(3)[:, None], turns.shape)
    modes = np.concatenate([shifts, turns])[:, fixed].T
    if not len(modes):
        return list(RIGID_MOTIONS)
    _, values, directions = np.linalg.svd(modes, full_matrices=True)
    values = np.concatenate([values, np.zeros(6 - len(values))])
    null = directions[values <= 1e-9 * np.sqrt(len(points))]
    if not len(null):
        return []
    share = np.linalg.norm(null, axis=0)
    return [name for name, size in zip(RIGID_MOTIONS, share, strict=True) if size > 0.1]


def _weights(mesh: SolidMesh, surface: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the consistent tributary areas (n,) of the nodes, projected along z."""
    weights = np.zeros(len(mesh.points))
    for nodes, shapes, areas in mesh.face_integrals(surface):
        np.add.at(weights, nodes, np.abs(areas[..., 2]) @ shapes.T)
    return weights
