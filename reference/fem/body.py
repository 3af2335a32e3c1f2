"""A linear-elastic half-space condensed onto its candidate contact points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.fem.conjugate_gradients import IterativeFlexibility
from reference.fem.flexibility import DenseFlexibility, Flexibility
from reference.fem.mesh import GradedMesh
from reference.fem.nested_dissection import LinearSystem


@dataclass(frozen=True, eq=False)
class CondensedBody:
    """A half-space, reduced to the flexibility between its candidate contact points.

    The body is linear, so one condensation serves every gap and every load. Scaled quantities have
    unit Young's modulus and lengths in units of `length`; the properties return consistent units.

    Attributes
    ----------
    length, youngs_modulus : float
        The units of the scaled quantities.
    poisson_ratio : float
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
    solver : str
        The solver of the condensation.
    seconds : dict
        Time spent on "mesh", "assembly", "condensation".
    grid : GradedMesh
    system : LinearSystem
        For the recovery of the interior.
    exterior : (k, k)
        Far-field stiffness.
    iterative : IterativeFlexibility or None
        Replaces the condensation; `scaled_compliance` then has shape (0, 0).
    nodal : CondensedBody or None
        The body with its nodes as candidates, if the candidates are other points.
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
    iterative: IterativeFlexibility | None = None
    nodal: CondensedBody | None = None
    interpolation: NDArray[np.float64] | None = None

    @cached_property
    def flexibility(self) -> Flexibility:
        """Response of the body to forces on its candidates, in scaled quantities."""
        if self.iterative is not None:
            return self.iterative
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
        """Mask (n,) of the candidates within or on the mesh circle; empty for a tensor body."""
        return self.scaled_radii <= (0.0 if self.ring is None else self.ring * (1.0 + 1e-9))

    @property
    def effective_modulus(self) -> float:
        """``E* = E/(1 - nu^2)``; the indenter is rigid."""
        return self.youngs_modulus / (1.0 - self.poisson_ratio**2)

    def scaled(self, factor: float) -> CondensedBody:
        """Return the body with its mesh scaled by `factor`.

        A half-space has no length scale, so no new solution is needed: compliances are divided by
        the factor.
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
            If `reactions` does not have one finite value per candidate.
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
