"""ContactMechanics in a separate process: conjugate gradients of Polonsky & Keer (1999).

ContactMechanics (https://github.com/ContactEngineering/ContactMechanics, MIT) takes a force or an
offset, periodic or free. On the periodic half-space the stiffness of the mode q = 0 is set to zero,
so that the mean displacement is zero as in our convention, and offset = penetration.

It starts from the given pressure. From its default start it accepted a surface without contact as
converged (force, periodic), or cycled endlessly with every cell loaded (penetration, free).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from comparisons.peers.driver import PeerAnswer, Problem, drive

MOST_ITERATIONS = 10_000


def solve(problem: Problem) -> dict[str, Any]:
    """Solve a problem of `comparisons.peers.client`."""
    return drive(problem, ContactMechanicsPeer)


class ContactMechanicsPeer:
    """A substrate, periodic or free."""

    def __init__(self, problem: Problem) -> None:
        import ContactMechanics
        from SurfaceTopography import Topography

        self.minimise = ContactMechanics.Optimization.constrained_conjugate_gradients
        self.Topography = Topography
        self.control, self.periodic = problem["control"], problem["periodic"]
        self.shape = problem["gaps"].shape[1:]
        self.size = tuple(n * d for n, d in zip(self.shape, problem["spacing"], strict=True))
        self.cell = float(np.prod(problem["spacing"]))
        if self.periodic:
            kind, options = ContactMechanics.PeriodicFFTElasticHalfSpace, {"stiffness_q0": 0.0}
        else:
            kind, options = ContactMechanics.FreeFFTElasticHalfSpace, {}
        self.substrate = kind(self.shape, 1.0, self.size, **options)

    def surface(self, gap: np.ndarray) -> None:
        """Set a new surface; cells where contact is impossible are masked."""
        heights = -gap
        if not np.isfinite(gap).all():
            heights = np.ma.masked_array(np.where(np.isfinite(gap), heights, 0), np.isinf(gap))
        self.mean_gap = float(gap.mean())
        self.topography = self.Topography(heights, self.size, periodic=self.periodic)

    def step(self, load: float, tolerance: float, depth: float, start: np.ndarray) -> PeerAnswer:
        """Solve one load; the tolerances are absolute, for lengths and for forces on a cell."""
        force = float(start.sum()) * self.cell
        control = {"offset": self.mean_gap - load if self.control == "mean_gap" else load}
        if self.control == "force":
            control, force, start = {"external_force": load}, load, start * (load / force)
        forces = np.zeros(self.substrate.nb_subdomain_grid_pts)
        forces[: self.shape[0], : self.shape[1]] = -start * self.cell
        contact_cells = np.count_nonzero(start)
        result = self.minimise(
            self.substrate,
            self.topography,
            initial_forces=forces,
            pentol=tolerance * depth,
            forcetol=tolerance * force / contact_cells,
            thermotol=tolerance,
            maxiter=MOST_ITERATIONS,
            **control,
        )
        if not result.success:
            return PeerAnswer(None, reason=f"ContactMechanics: {result.message}")
        pressure = np.ma.filled(result.jac, 0.0)[: self.shape[0], : self.shape[1]] / self.cell
        return PeerAnswer(np.asarray(pressure), int(result.nit))
