"""A linear-elastic half-space condensed onto its candidate contact points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.fem.half_space_mesh import GradedMesh
from reference.fem.linear_system import LinearSystem
from reference.fem.matrix_free import IterativeFlexibility
from reference.fem.multigrid import MultigridFlexibility
from reference.fem.nested_dissection import Front, Shift, condense, expand

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DenseFlexibility:
    """Response of a body by the compliance (n, n) between its candidates, unit modulus and length.

    `system` and `exterior` are those that were condensed, for the interior.
    """

    compliance: Array
    system: LinearSystem
    exterior: Array

    def respond(
        self, inside: NDArray[np.int64], right: Array, softness: Array
    ) -> tuple[Array, Array]:
        """Solve ``u_i + softness_i R_i = right_i`` on the points `inside` (k,), R = 0 elsewhere.

        `right` (k, m) are m cases; `softness` (k,) is the compliance of springs between the rigid
        shape and the body (penalty), zero for rigid contact. Returns forces (k, m) and the
        displacements (n, m) of all candidates.
        """
        matrix = self.compliance[np.ix_(inside, inside)]
        matrix[np.diag_indices(len(inside))] += softness
        forces = cho_solve(cho_factor(matrix, lower=True, overwrite_a=True), right)
        return forces, self.compliance[:, inside] @ forces

    def interior(self, reactions: Array) -> Array:
        """Return displacements of all unknowns of the mesh under nodal forces (n,).

        By a repeated elimination that keeps its factors.
        """
        fronts: list[Front | Shift] = []
        condense(self.system, self.exterior, fronts)
        return expand(self.system, fronts, self.compliance @ reactions)


@dataclass(frozen=True, eq=False)
class CondensedBody:
    """A half-space, reduced to the flexibility between its candidate contact points.

    The body is linear, so one condensation serves every gap and every load. Scaled quantities have
    unit Young's modulus and lengths in units of `length`; the properties return consistent units.

    Attributes
    ----------
    length, youngs_modulus : float
        The units of the scaled quantities.
    scaled_points : (n, 2)
        Candidate positions on the surface / length.
    scaled_weights : (n,)
        Tributary area of the candidates / length^2 (of the meshed part).
    nodes : (n,)
        Mesh nodes of the candidates.
    scaled_compliance : (n, n)
        Normal displacement at i for a unit normal force at j (meshed part), times E length.
    symmetry : int
        Number of equal parts, one of which is meshed: 4 for quarter symmetry, 2 for half.
    offset : (2,)
        `scaled_points` minus the mesh coordinates (the mesh is centred).
    spacing_scaled : float
        Size of the surface elements in the contact / length.
    ring : float or None
        Radius of the mesh circle / length before stretching; None for a tensor body.
    stretch : (float, float)
        Semi-axes of the mesh ellipse over the radius of the circle.
    unknowns : int
        Number of free displacements of the mesh and far-field unknowns.
    seconds : dict
        Time spent on "mesh", "assembly", "condensation".
    system, exterior
        Equations of the mesh, and far-field stiffness (k, k): for the interior.
    iterative : IterativeFlexibility or MultigridFlexibility or None
        Replaces the condensation; `scaled_compliance` then has shape (0, 0).
    nodal : CondensedBody or None
        The body with its nodes as candidates, if the candidates are other points.
    interpolation : (n, nodes) or None
        Shape functions of those nodes at the candidates.
    """

    length: float
    youngs_modulus: float
    poisson_ratio: float
    scaled_points: Array
    scaled_weights: Array
    nodes: NDArray[np.int64]
    scaled_compliance: Array
    symmetry: int
    offset: Array
    spacing_scaled: float
    ring: float | None
    stretch: tuple[float, float]
    unknowns: int
    solver: str
    seconds: dict[str, float]
    grid: GradedMesh
    system: LinearSystem
    exterior: Array
    iterative: IterativeFlexibility | MultigridFlexibility | None = None
    nodal: CondensedBody | None = None
    interpolation: Array | None = None

    @cached_property
    def flexibility(self) -> DenseFlexibility | IterativeFlexibility | MultigridFlexibility:
        """Response of the body to forces on its candidates, in scaled quantities."""
        return self.iterative or DenseFlexibility(
            self.scaled_compliance, self.system, self.exterior
        )

    @property
    def points(self) -> Array:
        """Candidate contact positions (n, 2)."""
        return self.scaled_points * self.length

    @property
    def weights(self) -> Array:
        """Tributary areas (n,) of the candidates, of the meshed part."""
        return self.scaled_weights * self.length * self.length

    @cached_property
    def compliance(self) -> Array:
        """Normal displacements (n, n) for unit nodal forces on the meshed part."""
        return self.scaled_compliance / (self.youngs_modulus * self.length)

    @property
    def spacing(self) -> float:
        """Size of the surface elements in the contact."""
        return self.spacing_scaled * self.length

    @cached_property
    def scaled_radii(self) -> Array:
        """Distance (n,) of the candidates from the centre / length, before stretching."""
        return np.hypot(*(self.scaled_points / np.asarray(self.stretch)).T)

    @property
    def inside_ring(self) -> NDArray[np.bool_]:
        """Mask (n,) of the candidates within or on the mesh circle; empty for a tensor body."""
        return self.scaled_radii <= (0.0 if self.ring is None else self.ring * (1.0 + 1e-9))

    @property
    def effective_modulus(self) -> float:
        """``E* = E/(1 - nu^2)``; the indenter is rigid."""
        return self.youngs_modulus / (1.0 - self.poisson_ratio**2)

    def scaled(self, factor: float) -> CondensedBody:
        """Return the body with its mesh scaled: a half-space has no length, compliances follow."""
        if not (np.isfinite(factor) and factor > 0.0):
            raise ValueError(f"factor must be positive and finite, got {factor!r}")
        nodal = None if self.nodal is None else self.nodal.scaled(factor)
        return replace(self, length=self.length * factor, nodal=nodal)

    def at_nodes(self, reactions: ArrayLike) -> tuple[CondensedBody, Array]:
        """Return the body with its nodes as candidates, and the forces on them."""
        reactions = np.asarray(reactions, dtype=float)
        if reactions.shape != self.scaled_weights.shape or not np.isfinite(reactions).all():
            raise ValueError(
                f"reactions must be finite with shape {self.scaled_weights.shape}, "
                f"got shape {reactions.shape}"
            )
        if self.nodal is None or self.interpolation is None:
            return self, reactions
        return self.nodal, self.interpolation.T @ reactions
