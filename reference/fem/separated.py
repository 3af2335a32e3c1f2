r"""An approximate inverse of the stiffness of an extruded mesh, by modes of the depth.

Each component of the displacement alone has a stiffness A (x) m + B (x) k (see `extruded`). With
the modes of the depth, k f = kappa m f, it falls into plane problems A + kappa B, whose Cholesky
factors are narrow bands: for all modes together less than 1 kB for each unknown in single
precision, whatever the grading of the mesh (fast diagonalisation: Lynch, Rice & Thomas 1964,
*Numer. Math.* 6, 185). Left out is how the components drive each other, which costs some twenty
steps of conjugate gradients at nu = 0.3, and more towards 1/2.

Contact prescribes the normal displacement of a part of the surface, which no product form has. The
normal component is therefore eliminated down to the surface, where nothing but the compliance of
the free part is approximated, by that of the whole surface: the steps no longer grow with contact
radius over size of the elements, but with its logarithm.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import eigh, lapack

from reference.fem.extruded import ExtrudedStiffness

Array = NDArray[np.float64]


class _Planes:
    """Inverses of A + kappa B for all modes of the depth, on some of the plane nodes."""

    def __init__(
        self,
        matrices: tuple[sparse.csr_array, sparse.csr_array],
        kappas: Array,
        nodes: NDArray[np.int64],
    ) -> None:
        self.nodes = nodes
        first, second = (sparse.coo_array(matrix[nodes][:, nodes]) for matrix in matrices)
        width = int(max(np.max(m.row - m.col, initial=0) for m in (first, second)))
        low, high = _band(first, width), _band(second, width)
        # factorised in double precision, which graded meshes need, and kept in single
        self.factors = np.empty((len(kappas), len(nodes), width + 1), dtype=np.float32)
        for factor, kappa in zip(self.factors, kappas, strict=True):
            band, fault = lapack.dpbtrf((low + kappa * high).T, lower=1, overwrite_ab=1)
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


def _band(matrix: sparse.coo_array, width: int) -> Array:
    """Return the lower band of a symmetric matrix, (n, width + 1): a column in each row."""
    lower = matrix.row >= matrix.col
    row, column = matrix.row[lower], matrix.col[lower]
    band = np.zeros((matrix.shape[0], width + 1))
    band[column, row - column] = matrix.data[lower]
    return band


class SeparatedInverse:
    """Preconditioner of the stiffness, symmetric and positive definite.

    Parameters
    ----------
    stiffness : ExtrudedStiffness
    free : (3, n, levels) bool
        Free displacements; none at the lowest level, and elsewhere equal at all levels.
    """

    def __init__(self, stiffness: ExtrudedStiffness, free: NDArray[np.bool_]) -> None:
        self.depth, self.levels = stiffness.depth, free.shape[2]
        nodes = [np.flatnonzero(component[:, 0]) for component in free]
        kappas, self.modes = self._modes(slice(0, -1))
        held, self.inner = self._modes(slice(1, -1))
        parts = [stiffness.alone(axis) for axis in range(3)]
        self.planes = [_Planes(parts[axis], kappas, nodes[axis]) for axis in range(3)]
        self.below = _Planes(parts[2], held, nodes[2])
        self.normal = parts[2]

    def _modes(self, levels: slice) -> tuple[Array, Array]:
        kappas, modes = eigh(self.depth.slopes[levels, levels], self.depth.mass[levels, levels])
        return kappas, modes

    def __call__(self, load: Array, touching: NDArray[np.bool_]) -> Array:
        """Return displacements under loads (3, n, levels), normal ones zero where it touches.

        Parameters
        ----------
        load : (3, n, levels)
        touching : (n,) bool
            Plane nodes at the surface with prescribed normal displacement.
        """
        result = np.zeros_like(load)
        for axis in (0, 1):
            result[axis, :, :-1] = self._along(load[axis, :, :-1], axis)
        inside = self._below(load[2])
        surface = load[2, :, 0] - self._coupled(inside)
        surface[touching] = 0.0
        top = self.modes[0]
        moved = self.planes[2](np.multiply.outer(surface, top)) @ top
        moved[touching] = 0.0
        follow = np.zeros_like(load[2])
        depth = self.depth
        follow[:, 1:-1] = np.multiply.outer(self.normal[0] @ moved, depth.mass[0, 1:-1])
        follow[:, 1:-1] += np.multiply.outer(self.normal[1] @ moved, depth.slopes[0, 1:-1])
        result[2] = inside - self._below(follow)
        result[2, :, 0] = moved
        return result

    def _along(self, load: Array, axis: int) -> Array:
        """Solve for one component with a free surface."""
        return self.planes[axis](load @ self.modes) @ self.modes.T

    def _below(self, load: Array) -> Array:
        """Solve for the normal component below a surface that is held."""
        result = np.zeros_like(load)
        result[:, 1:-1] = self.below(load[:, 1:-1] @ self.inner) @ self.inner.T
        return result

    def _coupled(self, inside: Array) -> Array:
        """Return the forces on a held surface by normal displacements below it."""
        low, high = inside @ self.depth.mass[:, 0], inside @ self.depth.slopes[:, 0]
        forces: Array = self.normal[0] @ low + self.normal[1] @ high
        return forces
