"""Contact with Coulomb friction, node by node (Jourdan, Alart & Jean 1998).

With f the force of the rigid shape on a node and u its displacement, Signorini's and Coulomb's
conditions in a step are the fixed points of

    f_z <- max(0, f_z + (d - g - u_z)/C_zz),
    f_t <- the nearest within |f_t| <= mu f_z to f_t + (U - s_before - u_t)/C_tt,

which a Gauss-Seidel sweep applies node by node, with the latest forces of all others. It shares no
code with the half-space solvers and is an independent check of them; it is also faster on so few
nodes than `contact.slide` between two pivots, and holds for strong friction, with which normal and
tangential problem in turn do not converge.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from scipy.linalg import cho_factor, cho_solve

from reference.arrays import Array, Mask
from reference.elasticity import LARGEST_POISSON_RATIO, Material
from reference.errors import (
    ConvergenceError,
    NoEquilibriumError,
    count_faults,
    positive_faults,
    refuse,
)
from reference.fem.condensation import condense, linear_system
from reference.fem.element_stiffness import facet_nodes, stiffness_matrices
from reference.fem.far_field import boussinesq, cerruti
from reference.fem.half_space_mesh import growing_lines, ring_mesh
from reference.loads import LoadPath, slides

# Newton steps towards prescribed forces, their relative error, and the finite-difference step as a
# fraction of the penetration.
_NEWTON, _FORCE_ERROR, _SLOPE_STEP = 60, 1e-6, 1e-3
_ERROR = 1e-7  # largest `NodalStep.error`
# Largest factor of the penetration in a Newton step.
_LARGEST_FACTOR = 2.0
# Extents of candidates with friction and their fine rings, and of the mesh, in contact radii.
_FRICTION_REACH, _EXTENT = 1.25, 5.0


@dataclass(frozen=True, eq=False)
class FrictionalBody:
    """Half of a half-space, y >= 0, under loads symmetric about y = 0.

    The compliance is the displacement (x, y, z into the body) at the first point for a unit force
    at the second, including its far field; the mirrored half is loaded equally.
    """

    points: Array  # (n, 2), candidate contact points
    compliance: Array  # (n, 3, n, 3)
    fixed: Mask  # (n,), on the plane of symmetry, which do not move normal to it
    unknowns: int


def frictional_body(
    contact_radius: float, material: Material, *, elements: int = 4
) -> FrictionalBody:
    """Return a half-space condensed onto all three displacements below one round contact.

    The counterpart of `half_space_body` for contact with friction. The displacement of the total
    force, Boussinesq's for its normal and Cerruti's for its tangential part, is prescribed on the
    outer boundary; the error from higher moments decreases at least as (a/L)^2.

    Candidates extend a quarter further than the (largest) contact radius, the mesh to five of them;
    one of them has so many 27-node elements (two node spacings), at least 2. nu <= 0.4999.
    """
    faults = positive_faults(contact_radius=contact_radius) + count_faults(2, elements=elements)
    nu = material.poisson_ratio
    if material.incompressible:
        faults.append(f"poisson_ratio must be at most {LARGEST_POISSON_RATIO}, not {nu!r}")
    refuse(faults)
    # even rings up to the candidates' extent, growing beyond and with depth
    cells = max(1, round(0.5 * elements))
    size, growth = 0.5 / cells, 1.0 + 1.2 / np.sqrt(elements)
    inside = np.linspace(0.5, 1.0, cells + 1)
    further = 1.0 + size * np.arange(1, int(np.ceil((_FRICTION_REACH - 1.0) / size)) + 1)
    beyond = growing_lines(further[-1], _EXTENT, growth * size, growth)[1:]
    rings = np.concatenate([inside, further, beyond])
    depths = growing_lines(0.0, _EXTENT, 0.8 * size, growth)
    grid = ring_mesh(rings, depths, core_cells=cells, round_from=1.0, planes=(False, True))
    points = grid.mesh.p
    nodes = facet_nodes(grid.mesh, grid.surface)
    nodes = nodes[np.hypot(*points[:2, nodes]) <= _FRICTION_REACH * (1 + 1e-9)]
    held, outer = grid.held, facet_nodes(grid.mesh, grid.outer)
    moves = ~held[nodes].ravel()
    system = linear_system(
        grid.mesh,
        stiffness_matrices(grid.mesh, nu),
        held,
        (3 * nodes[:, None] + np.arange(3)).ravel()[moves],
        outer=outer,
        fields=[cerruti(points.T[outer], nu), boussinesq(points.T[outer], nu)[0]],
    )
    stiffness = condense(system)
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


@dataclass(frozen=True, eq=False)
class NodalStep:
    """One converged step, with forces of both halves."""

    penetration: float
    tangential_displacement: float
    force: float
    tangential_force: float
    reactions: Array  # (n, 3), nodal forces on the meshed half
    sticking: Mask  # (n,), nodes in contact below their bound
    error: float  # largest one of a displacement in the contact conditions, over the penetration
    sweeps: int


def follow(
    body: FrictionalBody,
    gap: ArrayLike,
    friction: float,
    normal: LoadPath,
    tangential: LoadPath,
    *,
    max_sweeps: int = 20_000,
) -> Iterator[NodalStep]:
    """Solve a path of normal and tangential loads of a rigid shape.

    Parameters
    ----------
    body : FrictionalBody
    gap : array_like, shape (n,)
        Initial gap over `body.points`, symmetric about y = 0.
    friction : float
        mu, positive and finite.
    normal : LoadPath
        ``"penetration"`` or positive ``"force"``.
    tangential : LoadPath
        ``"tangential_displacement"`` or ``"tangential_force"``, of equal length; a force below mu
        F. Slip is measured over whole steps (implicit Euler).

    Raises ConvergenceError on iteration, if the sweeps of a step do not converge or its forces are
    impossible.
    """
    gap = np.asarray(gap, dtype=float)
    faults = positive_faults(friction=friction)
    if gap.shape != body.fixed.shape or not np.isfinite(gap).all():
        faults.append(f"gap must be finite, of shape {body.fixed.shape}, not {gap.shape}")
    refuse(faults)
    # whether penetration and displacement are unknown (prescribed forces)
    unknown = [normal.one_of("penetration", "force") == "force"]
    unknown.append(
        tangential.one_of("tangential_displacement", "tangential_force") == "tangential_force"
    )
    if unknown[0]:
        normal.positive()
    steps = np.column_stack([normal.values, tangential.values])
    count, sought = gap.size, np.flatnonzero(unknown)
    table = np.ascontiguousarray(body.compliance.reshape(3 * count, 3 * count))

    def solved(place: Array, position: Array, start: Array) -> tuple[Array, Array]:
        """Return nodal forces at a depth and shift of the shape, and the errors of the sweeps."""
        depth, shift = place
        aim = np.column_stack([shift - position[:, 0], -position[:, 1], depth - gap])
        forces, errors, bound = start.copy(), np.zeros(max_sweeps), _ERROR * abs(depth)
        errors = errors[: _sweeps(table, aim, body.fixed, friction, forces, errors, bound)]
        if not errors[-1] <= bound:
            raise ConvergenceError(
                f"node by node, friction stopped at an error of {errors[-1] / abs(depth):.1e} of "
                "the penetration",
                errors / abs(depth),
            )
        return forces, errors

    def totals(forces: Array) -> Array:
        """Return the normal and tangential force of both halves."""
        return 2.0 * np.array([forces[:, 2].sum(), forces[:, 0].sum()])

    def walk() -> Iterator[NodalStep]:
        forces, position, place = np.zeros((count, 3)), np.zeros((count, 2)), np.zeros(2)
        for loads in steps:
            place = np.where(unknown, place, loads)
            if unknown[0] and place[0] <= 0:
                # the depth of a punch as wide as the candidates
                even = np.zeros((count, 3))
                even[:, 2] = 1 / count
                place[0] = loads[0] / 2 * (table @ even.ravel()).reshape(-1, 3)[:, 2].mean()
            # Newton's method for the place that carries the loads
            start, history = forces, list[float]()
            for _ in range(_NEWTON):
                forces, errors = solved(place, position, start)
                if not sought.size:
                    break
                now = totals(forces)
                missing = (loads - now)[sought]
                pushed = loads[0] if unknown[0] else now[0]
                if unknown[1] and slides(loads[1], friction * pushed):
                    raise NoEquilibriumError(
                        f"the tangential force {loads[1]!r} is not below friction times the normal "
                        "force: full sliding"
                    )
                # relative to the normal force, as a tangential one may be zero
                unit = np.array([1.0, friction])[sought] * pushed
                history.append(float(np.abs(missing / unit).max()))
                if history[-1] <= _FORCE_ERROR:
                    break
                slopes = np.empty((sought.size, sought.size))
                beside = _SLOPE_STEP * np.array([1.0, friction]) * abs(place[0])
                for column, axis in enumerate(sought):
                    tried = place + beside * (np.arange(2) == axis)
                    change = totals(solved(tried, position, start)[0]) - now
                    slopes[:, column] = change[sought] / beside[axis]
                new = place.copy()
                new[sought] += np.linalg.lstsq(slopes, missing)[0]
                if unknown[0]:
                    new[0] = np.clip(new[0], place[0] / _LARGEST_FACTOR, place[0] * _LARGEST_FACTOR)
                place = new
            else:
                raise ConvergenceError(
                    "no displacement carries the forces of a frictional step", history
                )
            moved = (table @ forces.ravel()).reshape(-1, 3)
            position = np.column_stack([place[1] - moved[:, 0], -moved[:, 1]])
            pushed, along = totals(forces)
            size = np.hypot(forces[:, 0], forces[:, 1])
            yield NodalStep(
                penetration=float(place[0]),
                tangential_displacement=float(place[1]),
                force=float(pushed),
                tangential_force=float(along),
                reactions=forces.copy(),
                sticking=(forces[:, 2] > 0) & (size < (1 - 1e-9) * friction * forces[:, 2]),
                error=float(errors[-1] / abs(place[0])),
                sweeps=len(errors),
            )

    return walk()


@njit(cache=True)
def _sweeps(table, aim, fixed, friction, forces, errors, tolerance):
    """Sweep until all changes are below the tolerance; return the number of sweeps."""
    count = len(forces)
    flat = forces.reshape(-1)
    for sweep in range(errors.size):
        worst = 0.0
        for i in range(count):
            rows = table[3 * i : 3 * i + 3]
            x, y, z = forces[i]
            stiff = rows[2, 3 * i + 2]
            normal = max(0.0, z + (aim[i, 2] - np.dot(rows[2], flat)) / stiff)
            worst = max(worst, abs(normal - z) * stiff)
            flat[3 * i + 2] = normal
            soft = max(rows[0, 3 * i], rows[1, 3 * i + 1])
            new_x = x + (aim[i, 0] - np.dot(rows[0], flat)) / soft
            new_y = 0.0 if fixed[i] else y + (aim[i, 1] - np.dot(rows[1], flat)) / soft
            size, bound = np.hypot(new_x, new_y), friction * normal
            if size > bound:
                new_x, new_y = new_x * bound / size, new_y * bound / size
            worst = max(worst, np.hypot(new_x - x, new_y - y) * soft)
            flat[3 * i], flat[3 * i + 1] = new_x, new_y
        errors[sweep] = worst
        if worst <= tolerance:
            return sweep + 1
    return errors.size
