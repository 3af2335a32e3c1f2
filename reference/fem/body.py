"""A linear-elastic half-space condensed once onto the points that may touch."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.fem.flexibility import DenseFlexibility, Flexibility
from reference.fem.mesh import GradedMesh
from reference.fem.multigrid import MultigridFlexibility
from reference.fem.nested_dissection import LinearSystem


@dataclass(frozen=True, eq=False)
class CondensedBody:
    """A half-space known only through the flexibility between its candidate contact points.

    The body is linear, so one condensation serves every gap and every load. Numbers are kept for a
    unit Young's modulus and lengths in units of `length`; the properties return consistent units.

    Attributes
    ----------
    length, youngs_modulus : float
        The units in which the scaled quantities are kept.
    poisson_ratio : float
    scaled_points : (n, 2)
        Candidate positions on the surface / length.
    scaled_weights : (n,)
        Area that belongs to each candidate / length^2 (of the meshed part).
    nodes : (n,)
        Mesh node of each candidate.
    scaled_compliance : (n, n)
        Normal displacement at i for a unit normal force at j (meshed part), times E length.
    symmetry : int
        Number of equal parts of which one is meshed: 4 with quarter symmetry, 2 with half.
    offset : (2,)
        What the mesh coordinates lack to `scaled_points` (the mesh is centred).
    spacing_scaled : float
        Size of the surface elements in the contact / length.
    ring : float or None
        Radius of the mesh circle / length before stretching; None for a tensor body.
    stretch : (float, float)
        Semi-axes of the mesh ellipse over the radius of the circle.
    unknowns : int
        Free displacements of the mesh and far-field unknowns.
    solver : str
        What condensed the body.
    seconds : dict
        Time spent on "mesh", "assembly", "condensation".
    grid : GradedMesh
    system : LinearSystem
        For the recovery of the interior.
    exterior : (k, k)
        Far-field stiffness.
    multigrid : MultigridFlexibility or None
        In place of a condensation; `scaled_compliance` then has shape (0, 0).
    nodal : CondensedBody or None
        The body with its nodes as candidates, where the candidates are other points.
    interpolation : (n, nodes) or None
        Shape functions of those nodes at the candidates.
    """

    length: float
    youngs_modulus: float
    poisson_ratio: float
    scaled_points: NDArray[np.float64]
    scaled_weights: NDArray[np.float64]
    nodes: NDArray[np.int64]
    scaled_compliance: NDArray[np.float64]
    symmetry: int
    offset: NDArray[np.float64]
    spacing_scaled: float
    ring: float | None
    stretch: tuple[float, float]
    unknowns: int
    solver: str
    seconds: dict[str, float]
    grid: GradedMesh
    system: LinearSystem
    exterior: NDArray[np.float64]
    multigrid: MultigridFlexibility | None = None
    nodal: CondensedBody | None = None
    interpolation: NDArray[np.float64] | None = None

    @cached_property
    def flexibility(self) -> Flexibility:
        """What the body answers to forces on its candidates, in scaled quantities."""
        if self.multigrid is not None:
            return self.multigrid
        return DenseFlexibility(self.scaled_compliance, self.system, self.exterior)

    @property
    def points(self) -> NDArray[np.float64]:
        """Candidate contact positions (n, 2)."""
        return self.scaled_points * self.length

    @property
    def weights(self) -> NDArray[np.float64]:
        """Tributary areas (n,) of the candidates, of the meshed part."""
        return self.scaled_weights * self.length * self.length

    @cached_property
    def compliance(self) -> NDArray[np.float64]:
        """Normal displacements (n, n) for unit nodal forces on the meshed part."""
        return self.scaled_compliance / (self.youngs_modulus * self.length)

    @property
    def spacing(self) -> float:
        """Size of the surface elements in the contact."""
        return self.spacing_scaled * self.length

    @cached_property
    def scaled_radii(self) -> NDArray[np.float64]:
        """Distance (n,) of the candidates from the centre / length, before stretching."""
        return np.hypot(*(self.scaled_points / np.asarray(self.stretch)).T)

    @property
    def inside_ring(self) -> NDArray[np.bool_]:
        """Which candidates (n,) lie within or on the mesh circle; none for a tensor body."""
        return self.scaled_radii <= (0.0 if self.ring is None else self.ring * (1.0 + 1e-9))

    @property
    def effective_modulus(self) -> float:
        """``E* = E/(1 - nu^2)``; the indenter is rigid."""
        return self.youngs_modulus / (1.0 - self.poisson_ratio**2)

    def scaled(self, factor: float) -> CondensedBody:
        """Return the same mesh `factor` times larger.

        A half-space has no length, so nothing has to be solved again: compliances divide by the
        factor.
        """
        if not (np.isfinite(factor) and factor > 0.0):
            raise ValueError(f"factor must be positive and finite, got {factor!r}")
        nodal = None if self.nodal is None else self.nodal.scaled(factor)
        return replace(self, length=self.length * factor, nodal=nodal)

    def at_nodes(self, reactions: ArrayLike) -> tuple[CondensedBody, NDArray[np.float64]]:
        """Return the body with its nodes as candidates, and the forces on them.

        Raises
        ------
        ValueError
            If `reactions` does not have one finite value for each candidate.
        """
        reactions = np.asarray(reactions, dtype=float)
        if reactions.shape != self.scaled_weights.shape or not np.isfinite(reactions).all():
            raise ValueError(
                f"reactions must be finite with shape {self.scaled_weights.shape}, "
                f"got shape {reactions.shape}"
            )
        if self.nodal is None or self.interpolation is None:
            return self, reactions
        return self.nodal, self.interpolation.T @ reactions
