r"""Contact without a factorisation: conjugate gradients on the whole body, nothing condensed.

The meshes of half-spaces repeat one plane mesh at all levels of the depth. A node is then a plane
node a at a level i, its shape function a product N_a(x, y) L_i(z), and every integral a product

    int d_alpha N_A d_beta N_B dV = P_alpha,beta (x) m,    int d_alpha N_A d_z N_B = Q_alpha (x) d,
    int d_z N_A d_z N_B = M (x) k,

so that the matrix of three dimensions, 2 kB for each unknown, is never assembled
(`ExtrudedStiffness`). The same products precondition it (`SeparatedInverse`), and the
preconditioner knows the contact (`IterativeFlexibility`): two million unknowns take 2 GB.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy import sparse
from scipy.linalg import eigh, lapack
from scipy.sparse.csgraph import reverse_cuthill_mckee
from skfem.element import ElementLineP1, ElementLineP2, ElementQuad1, ElementQuad2

from reference.arrays import Array, Integers, Mask
from reference.elasticity import lame_parameters
from reference.errors import ConvergenceError
from reference.fem.condensation import LinearSystem
from reference.fem.element_stiffness import (
    element_order,
    facet_quadrature,
    gauss_rule,
    gauss_square,
    shape_functions,
)
from reference.fem.half_space_mesh import GradedMesh

MOST_STEPS = 1000  # of conjugate gradients
# Relative residual in the norm of the preconditioner. The force is stationary: its error is of the
# order of the square of that of the fields.
TOLERANCE = 1e-7
IN_SPAN = 1e-7  # a right-hand side this close to a combination of solved ones is not solved again


def conjugate_gradients(
    act: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    loads: Array,
    tolerance: float,
) -> tuple[Array, int]:
    """Return the solution of a positive definite system for loads (n,) or (n, k), and the steps.

    The tolerance is that of the residual in the norm of the preconditioner, over the load's. Raises
    ConvergenceError after a thousand steps, or if the preconditioner is not definite; the history
    has the largest relative residual by step.

    >>> matrix = np.array([[2.0, 1.0], [1.0, 2.0]])
    >>> conjugate_gradients(matrix.__matmul__, np.copy, np.array([4.0, 5.0]), 1e-12)
    (array([1., 2.]), 2)
    """
    # Saad 2003, alg. 9.1, for every column alone. Units of powers of two change no digit, and
    # preconditioners in single precision have no numbers below 1e-45.
    units = power_of_two(loads)
    residual = loads / units
    values = np.zeros_like(residual)
    dot = np.dot if loads.ndim == 1 else partial(np.einsum, "ik,ik->k")
    direction = precondition(residual)
    size = start = dot(residual, direction)
    history = [1.0]
    while residual.any() and not history[-1] <= tolerance:
        if not np.max(size) > 0.0 <= np.min(size):  # NaN, or a preconditioner not definite
            raise ConvergenceError("conjugate gradients broke down", history)
        if len(history) > MOST_STEPS:
            raise ConvergenceError("conjugate gradients did not converge", history)
        image = act(direction)
        work = dot(direction, image)
        step = np.divide(size, work, out=np.zeros_like(size), where=size > 0.0)
        values += step * direction
        residual -= step * image
        upward = precondition(residual)
        last, size = size, dot(residual, upward)
        turn = np.divide(size, last, out=np.zeros_like(size), where=last > 0.0)
        direction = upward + turn * direction
        largest = np.max(np.divide(size, start, out=np.zeros_like(size), where=start > 0.0))
        history.append(float(np.sqrt(largest)) if np.min(size) >= 0.0 else np.nan)
    return values * units, len(history) - 1


def power_of_two(values: Array) -> Array:
    """Return a power of two of the size of the largest value of each column, 1 of none."""
    largest = np.abs(values).max(axis=0, initial=0.0)
    good = (largest > 0.0) & (largest < np.inf)
    return np.asarray(np.ldexp(1.0, np.frexp(np.where(good, largest, 1.0))[1] - 1))


class Lattice:
    """The nodes of an extruded mesh by plane node and level.

    Numbers of the nodes (n, levels) from the surface down, plane nodes in an order that keeps
    neighbours close; plane nodes (cells, 4 or 9) of the faces at the surface; places (n, 2) and
    depths (levels,); order of the elements.
    """

    def __init__(self, grid: GradedMesh) -> None:
        mesh = grid.mesh
        surface = facet_quadrature(mesh, grid.surface, 1)[0]
        # positions agree to rounding, and differ by far more than 1e-9 of the contact
        x, y, z = np.round(mesh.p, 9)
        count, size = len(np.unique(surface)), surface.shape[1]
        nodes = np.lexsort((z, y, x)).reshape(count, -1)
        place = np.empty(mesh.p.shape[1], dtype=np.int64)
        place[nodes[:, 0]] = np.arange(count)
        cells = place[surface]
        # the order of plane nodes with the narrowest band: by rings, by lines, or found
        x, y = mesh.p[:2, nodes[:, 0]]
        pairs = np.repeat(cells, size, axis=1).ravel(), np.tile(cells, (1, size)).ravel()
        graph = sparse.csr_matrix((np.ones(len(pairs[0])), pairs), shape=(count, count))
        orders = [np.argsort(np.hypot(x, y)), np.lexsort((y, x)), np.lexsort((x, y))]
        orders.append(reverse_cuthill_mckee(graph, symmetric_mode=True).astype(np.int64))
        order = min(orders, key=lambda order: int(np.ptp(np.argsort(order)[cells], axis=1).max()))
        place[order] = np.arange(count)
        self.nodes: Integers = nodes[order]
        self.cells: Integers = place[cells]
        self.plane: Array = mesh.p[:2, self.nodes[:, 0]].T
        self.depths: Array = mesh.p[2, self.nodes[0]]
        self.order = element_order(mesh)


class Products:
    """Integrals by so many Gauss points in each direction of an element.

    Matrices (n, n) over the plane, (levels, levels) of the depth.

    Of two derivatives (P, k), of one (Q, of the row; d, of the column), and of none (M, m).
    """

    def __init__(self, lattice: Lattice, points: int) -> None:
        order, cells, depths = lattice.order, lattice.cells, lattice.depths
        # over the plane: gradients[i, e, q, n] of the shape functions
        local, weights = gauss_square(points)
        values, slopes = shape_functions(ElementQuad1 if order == 1 else ElementQuad2, local)
        jacobian = np.einsum("eni,ndq->eqid", lattice.plane[cells], slopes)
        gradients = np.einsum("ndq,eqdi->ieqn", slopes, np.linalg.inv(jacobian))
        areas = np.abs(np.linalg.det(jacobian)) * weights
        steady = np.broadcast_to(values.T, gradients.shape[1:])
        size, count = cells.shape[1], len(lattice.plane)
        pairs = np.repeat(cells, size, axis=1).ravel(), np.tile(cells, (1, size)).ravel()

        def summed(first: Array, second: Array) -> sparse.csr_array:
            blocks = np.matmul(np.swapaxes(first * areas[..., None], 1, 2), second)
            return sparse.csr_array((blocks.ravel(), pairs), shape=(count, count))

        # along the depth; of three functions the one in the middle is scikit-fem's last
        line, places = (ElementLineP1, [0, 1]) if order == 1 else (ElementLineP2, [0, 2, 1])
        at, weights = gauss_rule(points, 1)
        value, steep = shape_functions(line, at)
        value, steep = value[places], steep[places, 0]
        shape = 3, len(depths), len(depths)
        self.depth_mass, self.depth_slopes, self.depth_slope = np.zeros(shape)
        for start in range(0, len(depths) - 1, order):
            part = slice(start, start + order + 1)
            height = depths[start + order] - depths[start]
            self.depth_mass[part, part] += height * (value * weights) @ value.T
            self.depth_slopes[part, part] += (steep * weights) @ steep.T / height
            self.depth_slope[part, part] += (value * weights) @ steep.T
        self.plane = [[summed(row, column) for column in gradients] for row in gradients]
        self.slope = [summed(row, steady) for row in gradients]
        self.mass = summed(steady, steady)


class ExtrudedStiffness:
    """The stiffness of an extruded mesh of unit Young's modulus, applied without assembling it.

    Integrated selectively (as `stiffness_matrices`, but 8-node elements must be bricks), both
    factors of the lambda term have a Gauss point less.
    """

    def __init__(self, lattice: Lattice, poisson_ratio: float) -> None:
        lame, shear = lame_parameters(poisson_ratio)
        full = lattice.order + 1
        rule = full - 1 if lame > 0.0 else full
        ours = self.products = Products(lattice, full)
        volume = self.volume = Products(lattice, rule)
        (pxx, pxy), (pyx, pyy) = ours.plane
        both, block = pxx + pyy, sparse.block_array
        flat = block([[both + pxx, pyx], [pxy, both + pyy]], format="csr")
        self._flat = shear * flat, lame * block(volume.plane, format="csr")
        self._upright = shear * both
        self._mass = shear * ours.mass, lame * volume.mass
        self._tilted = (
            lame * block([[slope] for slope in volume.slope], format="csr"),
            shear * block([[slope.T] for slope in ours.slope], format="csr"),
        )
        self._across = [sparse.csr_array(matrix.T) for matrix in self._tilted]
        # A and B of each component alone, whose stiffness is nearly A (x) m + B (x) k: nearly, as
        # the depth of the lambda term is integrated like that of the other
        self.alone = [
            (shear * both + (shear * ours.plane[i][i] + lame * volume.plane[i][i]), self._mass[0])
            for i in (0, 1)
        ]
        self.alone.append((shear * both, 2.0 * self._mass[0] + self._mass[1]))

    def __matmul__(self, field: Array) -> Array:
        """Return the nodal forces (3, n, levels) of displacements (3, n, levels)."""
        _, count, levels = field.shape
        sides, down = field[:2].reshape(2 * count, levels), field[2]
        depth, volume = self.products, self.volume
        forces = np.empty_like(field)
        result = forces[:2].reshape(2 * count, levels)
        result[:] = self._flat[0] @ (sides @ depth.depth_mass)
        result += self._flat[1] @ (sides @ volume.depth_mass)
        steep = field[:2] @ depth.depth_slopes
        for axis in (0, 1):
            forces[axis] += self._mass[0] @ steep[axis]
        result += self._tilted[0] @ (down @ volume.depth_slope.T)
        result += self._tilted[1] @ (down @ depth.depth_slope)
        forces[2] = self._upright @ (down @ depth.depth_mass)
        forces[2] += self._mass[0] @ (down @ (2.0 * depth.depth_slopes))
        forces[2] += self._mass[1] @ (down @ volume.depth_slopes)
        forces[2] += self._across[0] @ (sides @ volume.depth_slope)
        forces[2] += self._across[1] @ (sides @ depth.depth_slope.T)
        return forces


class _PlaneInverses:
    """Inverses of A + kappa B for all modes of the depth, on some of the plane nodes."""

    def __init__(
        self, matrices: tuple[sparse.csr_array, sparse.csr_array], kappas: Array, nodes: Integers
    ) -> None:
        self.nodes = nodes
        parts = [sparse.coo_array(matrix[nodes][:, nodes]) for matrix in matrices]
        width = int(max(np.max(part.row - part.col, initial=0) for part in parts))
        # lower bands, a column in each row
        bands = np.zeros((2, len(nodes), width + 1))
        for band, part in zip(bands, parts, strict=True):
            lower = part.row >= part.col
            row, column = part.row[lower], part.col[lower]
            band[column, row - column] = part.data[lower]
        # factorised in double precision, which graded meshes need, and kept in single
        self.factors = np.empty((len(kappas), len(nodes), width + 1), dtype=np.float32)
        for factor, kappa in zip(self.factors, kappas, strict=True):
            band, fault = lapack.dpbtrf((bands[0] + kappa * bands[1]).T, lower=1, overwrite_ab=1)
            if fault:
                raise np.linalg.LinAlgError("a plane problem is not definite")
            factor[:] = band.T

    def __call__(self, modes: Array) -> Array:
        """Solve for right-hand sides (n, modes), zero on the other plane nodes."""
        loads = np.ascontiguousarray(modes[self.nodes].T, dtype=np.float32)
        for factor, load in zip(self.factors, loads, strict=True):
            lapack.spbtrs(factor.T, load, lower=1, overwrite_b=1)
        result = np.zeros_like(modes)
        result[self.nodes] = loads.T
        return result


class SeparatedInverse:
    """Approximate inverse of the stiffness by modes of the depth, symmetric and positive definite.

    With the modes of the depth, k f = kappa m f, the stiffness A (x) m + B (x) k of a component of
    the displacement falls into plane problems A + kappa B, whose Cholesky factors are narrow bands:
    for all modes together less than 1 kB for each unknown in single precision, whatever the grading
    of the mesh (fast diagonalisation: Lynch, Rice & Thomas 1964, *Numer. Math.* 6, 185). Left out
    is how the components drive each other, which costs some twenty steps of conjugate gradients at
    nu = 0.3, and more towards 1/2.

    Contact prescribes the normal displacement of a part of the surface, which no product form has.
    The normal component is therefore eliminated down to the surface, where nothing but the
    compliance of the free part is approximated, by that of the whole surface: the steps grow with
    the logarithm of contact radius over size of the elements only.

    Displacements (3, n, levels) are free at no node of the lowest level, and elsewhere alike at all
    levels.
    """

    def __init__(self, stiffness: ExtrudedStiffness, free: Mask) -> None:
        self.mass, self.slopes = stiffness.products.depth_mass, stiffness.products.depth_slopes
        nodes = [np.flatnonzero(component[:, 0]) for component in free]
        # modes of all levels but the lowest, and of those below a held surface
        kappas, self.modes = eigh(self.slopes[:-1, :-1], self.mass[:-1, :-1])
        held, self.inner = eigh(self.slopes[1:-1, 1:-1], self.mass[1:-1, 1:-1])
        alone = stiffness.alone
        self.planes = [_PlaneInverses(alone[axis], kappas, nodes[axis]) for axis in range(3)]
        self.below = _PlaneInverses(alone[2], held, nodes[2])
        self.normal = alone[2]

    def __call__(self, load: Array, touching: Mask) -> Array:
        """Return displacements under loads (3, n, levels), normal ones zero where it touches.

        `touching` (n,) are the plane nodes at the surface with prescribed normal displacement.
        """
        result, (across, along) = np.zeros_like(load), self.normal
        for axis in (0, 1):
            result[axis, :, :-1] = self.planes[axis](load[axis, :, :-1] @ self.modes) @ self.modes.T
        # the normal component: below a held surface, at the surface, and what follows it below
        inside = self._below(load[2])
        surface = load[2, :, 0] - (
            across @ (inside @ self.mass[:, 0]) + along @ (inside @ self.slopes[:, 0])
        )
        surface[touching] = 0.0
        moved = self.planes[2](np.multiply.outer(surface, self.modes[0])) @ self.modes[0]
        moved[touching] = 0.0
        follow = np.zeros_like(load[2])
        follow[:, 1:-1] = np.multiply.outer(across @ moved, self.mass[0, 1:-1])
        follow[:, 1:-1] += np.multiply.outer(along @ moved, self.slopes[0, 1:-1])
        result[2] = inside - self._below(follow)
        result[2, :, 0] = moved
        return result

    def _below(self, load: Array) -> Array:
        """Solve for the normal component below a surface that is held."""
        result = np.zeros_like(load)
        result[:, 1:-1] = self.below(load[:, 1:-1] @ self.inner) @ self.inner.T
        return result


class IterativeFlexibility:
    """Response of a half-space by preconditioned conjugate gradients, as `DenseFlexibility`'s.

    A contact set is a set of prescribed displacements, and the few necessary fields are solved one
    by one; loads in the span of previous right-hand sides need no solve. On a mesh fitted to the
    contact edge the set never changes, and all depths of a paraboloid take two solves (1 and r^2).

    Vectors are the displacements of all nodes (3, n, levels), flat and zero where nothing is free,
    followed by the far-field unknowns, whose block is inverted exactly. `iterations` are the steps
    of every solve.
    """

    def __init__(self, system: LinearSystem, grid: GradedMesh, poisson_ratio: float) -> None:
        lattice = Lattice(grid)
        exterior = np.zeros((0, 0)) if system.exterior is None else system.exterior
        self.system, self.exterior = system, exterior
        self.stiffness = ExtrudedStiffness(lattice, poisson_ratio)
        elements = grid.mesh.dofs.element_dofs.T
        numbers = np.empty((grid.mesh.p.shape[1], 3), dtype=np.int64)
        numbers[elements] = system.unknowns.reshape(*elements.shape, 3)
        self.numbers = np.moveaxis(numbers[lattice.nodes], 2, 0)
        unknowns = self.numbers.ravel()
        free = (unknowns >= 0) & (unknowns < system.first)
        self.free = np.append(free, np.ones(len(exterior), dtype=bool))
        self.following = np.flatnonzero(unknowns >= system.first)
        self.boundary = system.boundary[unknowns[self.following] - system.first]
        place = np.empty(system.first, dtype=np.int64)
        place[unknowns[free]] = np.flatnonzero(free)
        self.candidates = place[system.retained]
        self.inverse = SeparatedInverse(self.stiffness, free.reshape(self.numbers.shape))
        modes = np.eye(len(self.free), len(exterior), k=-len(free))
        self.far = np.zeros_like(exterior)
        if len(exterior):
            self.far[:] = np.linalg.inv([self._image(mode)[len(free) :] for mode in modes.T])
        self.iterations: list[int] = []
        # of the last contact set, which rarely recurs: prescribed displacements (k, m), and their
        # fields and forces (size, m)
        self.solved: dict[bytes, tuple[Array, Array, Array]] = {}

    def respond(
        self, inside: Integers, right: Array, softness: Array | None = None
    ) -> tuple[Array, Array]:
        """Solve as `DenseFlexibility.respond`, for rigid contact only.

        Raises ConvergenceError if conjugate gradients break down, or need more than a thousand
        steps.
        """
        if softness is not None and softness.any():
            raise ValueError("conjugate gradients solve contact = 'active_set' only")
        nothing = np.zeros((len(self.free), 0))
        span = np.zeros((len(inside), 0)), nothing, nothing
        basis, fields, images = self.solved.get(inside.tobytes(), span)
        place = self.candidates[inside]
        free = self.free.copy()
        free[place] = False
        for column in right.T:
            # what is a combination of known displacements needs no solve
            column = column / power_of_two(column)
            remainder = column - basis @ np.linalg.lstsq(basis, column, rcond=None)[0]
            size = np.linalg.norm(remainder)
            if size <= IN_SPAN * np.linalg.norm(column):
                continue
            remainder /= size
            field = np.zeros(len(self.free))
            field[place] = remainder
            field += self._solve(-self._image(field), free)
            basis = np.column_stack((basis, remainder))
            fields = np.column_stack((fields, field))
            images = np.column_stack((images, self._image(field)))
        self.solved = {inside.tobytes(): (basis, fields, images)}
        weights = np.linalg.lstsq(basis, right, rcond=None)[0]
        forces = images[place]
        # with the work of the residual on the fields, the components of the forces in the basis,
        # including the total, have only the square of the error of the fields
        forces = forces + basis @ (fields.T @ images - basis.T @ forces)
        return forces @ weights, fields[self.candidates] @ weights

    def interior(self, reactions: Array) -> Array:
        """Return displacements of all unknowns of the mesh under nodal forces: one more solve."""
        load = np.zeros(len(self.free))
        load[self.candidates] = reactions
        whole = self._whole(self._solve(load, self.free)).ravel()
        numbers = self.numbers.ravel()
        values = np.empty(self.system.first + len(self.boundary))
        values[numbers[numbers >= 0]] = whole[numbers >= 0]
        return values

    def _solve(self, load: Array, free: Mask) -> Array:
        """Solve for the free unknowns, others zero."""
        size, shape = self.numbers.size, self.numbers.shape
        touching = (self.free & ~free)[:size].reshape(shape)[2, :, 0]

        def precondition(residual: Array) -> Array:
            moved = self.inverse(residual[:size].reshape(shape), touching).ravel()
            return np.concatenate([moved, self.far @ residual[size:]])

        values, steps = conjugate_gradients(
            lambda direction: np.where(free, self._image(direction), 0.0),
            precondition,
            np.where(free, load, 0.0),
            TOLERANCE,
        )
        self.iterations.append(steps)
        return values

    def _image(self, values: Array) -> Array:
        """Return the stiffness times displacements."""
        forces = (self.stiffness @ self._whole(values)).ravel()
        far = values[len(forces) :]
        followed = self.boundary.T @ forces[self.following] + self.exterior @ far
        return np.where(self.free, np.concatenate([forces, followed]), 0.0)

    def _whole(self, values: Array) -> Array:
        """Return the displacements (3, n, levels) of all nodes, those at the boundary included."""
        size = self.numbers.size
        field = values[:size].copy()
        field[self.following] = self.boundary @ values[size:]
        return field.reshape(self.numbers.shape)
