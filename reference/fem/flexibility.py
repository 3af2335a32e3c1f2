"""Response of a body to forces on its candidate contact points."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.fem.nested_dissection import Front, LinearSystem, Shift, condense, expand


class Flexibility(Protocol):
    """Flexibility of a body for contact, scaled (unit Young's modulus, unit length)."""

    def respond(
        self, inside: NDArray[np.int64], right: NDArray[np.float64], softness: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Solve ``u_i + softness_i R_i = right_i`` on the points `inside`, R = 0 elsewhere.

        Parameters
        ----------
        inside : (k,)
            Numbers of candidates.
        right : (k, m)
            Right-hand sides of m cases.
        softness : (k,)
            Compliance of springs between the rigid shape and the body (penalty); zero for rigid
            contact.

        Returns
        -------
        forces : (k, m)
        displacement : (n, m)
            Displacements of all candidates.
        """
        ...

    def interior(self, reactions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return displacements of all unknowns of the mesh under nodal forces (n,)."""
        ...


class DenseFlexibility:
    """A condensed body: the compliance between all its candidates.

    Parameters
    ----------
    compliance : (n, n)
    system, exterior
        The condensed system, for the interior.
    """

    def __init__(
        self,
        compliance: NDArray[np.float64],
        system: LinearSystem,
        exterior: NDArray[np.float64],
    ) -> None:
        self.compliance = compliance
        self.system = system
        self.exterior = exterior

    def respond(
        self, inside: NDArray[np.int64], right: NDArray[np.float64], softness: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Solve as in `Flexibility`, by a Cholesky factorisation of part of the compliance."""
        matrix = self.compliance[np.ix_(inside, inside)]
        matrix[np.diag_indices(len(inside))] += softness
        forces = cho_solve(cho_factor(matrix, lower=True, overwrite_a=True), right)
        return forces, self.compliance[:, inside] @ forces

    def interior(self, reactions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve as in `Flexibility`, by a repeated elimination that keeps its factors."""
        fronts: list[Front | Shift] = []
        condense(self.system, self.exterior, fronts)
        return expand(self.system, fronts, self.compliance @ reactions)
