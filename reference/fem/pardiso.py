"""MKL Pardiso, if the optional package pypardiso is installed (the extra `fast`)."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

POSITIVE_DEFINITE = 2  # Pardiso's number for real symmetric positive definite matrices


def available() -> bool:
    """Return whether pypardiso can be imported (wheels for 64-bit Intel and AMD only)."""
    return find_spec("pypardiso") is not None


def factorise(matrix: sparse.csr_array) -> None:
    """Order and factorise a symmetric positive definite matrix, and drop the factor.

    The yardstick of the benchmarks: the minimum cost of a sparse direct solution.
    """
    solver, upper = _prepared(matrix)
    solver.factorize(upper)
    solver.free_memory(everything=True)


def condense(matrix: sparse.csr_array, retained: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the Schur complement on the retained unknowns, in order, from one factorisation."""
    solver, upper = _prepared(matrix)
    size = len(retained)
    solver.perm = np.zeros(matrix.shape[0], dtype=np.int32)
    solver.perm[retained] = 1
    # MKL reads its other settings only with the first one set; zeros elsewhere are its defaults,
    # except for METIS ordering and no pivoting, which positive definite matrices do not need
    for place, value in ((1, 1), (2, 2), (10, 8), (36, 1)):
        solver.set_iparm(place, value)
    solver._check_A(upper)
    solver.set_phase(12)
    # for a Schur complement, the factorisation returns it instead of a solution
    complement = solver._call_pardiso(upper, np.zeros((size, size), order="F"))
    solver.free_memory(everything=True)
    order = np.argsort(np.argsort(retained))
    complement = 0.5 * (complement + complement.T)
    return complement[np.ix_(order, order)]


def _prepared(matrix: sparse.csr_array):
    from pypardiso import PyPardisoSolver

    upper = sparse.csr_matrix(sparse.triu(matrix, format="csr"))
    upper.sort_indices()
    return PyPardisoSolver(mtype=POSITIVE_DEFINITE), upper
