"""What a body answers when some of its candidate contact points are pushed."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.fem.nested_dissection import Front, LinearSystem, Shift, condense, expand


class Flexibility(Protocol):
    """All that contact needs to know of a body; scaled (unit Young's modulus, unit length)."""

    def respond(
        self, inside: NDArray[np.int64], right: NDArray[np.float64], softness: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Solve ``u_i + softness_i R_i = right_i`` on the points `inside`, R = 0 elsewhere.

        Parameters
        ----------
        inside : (k,)
            Numbers of candidates.
        right : (k, m)
            Several cases at once.
        softness : (k,)
            Of springs between the rigid shape and the body (penalty); zero for rigid contact.

        Returns
        -------
        forces : (k, m)
        displacement : (n, m)
            Of all candidates.
        """
        ...

    def interior(self, reactions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Displacements of all unknowns of the mesh under nodal forces (n,)."""
        ...


class DenseFlexibility:
    """A condensed body: the compliance between all its candidates.

    Parameters
    ----------
    compliance : (n, n)
    system, exterior
        What was condensed, for the interior.
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
        """See `Flexibility`: one Cholesky factorisation of the part of the compliance."""
        matrix = self.compliance[np.ix_(inside, inside)]
        matrix[np.diag_indices(len(inside))] += softness
        forces = cho_solve(cho_factor(matrix, lower=True, overwrite_a=True), right)
        return forces, self.compliance[:, inside] @ forces

    def interior(self, reactions: NDArray[np.float64]) -> NDArray[np.float64]:
        """See `Flexibility`: the elimination is repeated with its factors kept."""
        fronts: list[Front | Shift] = []
        condense(self.system, self.exterior, fronts)
        return expand(self.system, fronts, self.compliance @ reactions)
