"""Tamaas in a separate process: projected conjugate gradients (Rey, Anciaux & Molinari 2017).

Tamaas (https://gitlab.com/tamaas/tamaas) is AGPL: it is installed by the user, imported in this
process only, and called through its public interface; none of its code is copied.

It controls the mean pressure, or the mean gap on the periodic half-space; a penetration of the free
half-space is reached by a secant search in the force, with warm starts.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from comparisons.peers.driver import PeerAnswer, Problem, drive

MOST_ITERATIONS = 10_000
# Largest number of steps in the search for a penetration; four or five are typical.
MOST_STEPS = 20
_FREE = "dcfft"  # Tamaas' name of the discrete convolution with Love's kernel


def solve(problem: Problem) -> dict[str, Any]:
    """Solve a problem of `comparisons.peers.client`."""
    return drive(problem, TamaasPeer)


class TamaasPeer:
    """A 2-D surface model, periodic or free."""

    def __init__(self, problem: Problem) -> None:
        import tamaas

        tamaas.set_log_level(tamaas.LogLevel.error)
        self.tamaas, self.control, self.free = tamaas, problem["control"], not problem["periodic"]
        self.shape = problem["gaps"].shape[1:]
        self.size = [n * d for n, d in zip(self.shape, problem["spacing"], strict=True)]
        kind = tamaas.model_type.basic_2d
        self.model = tamaas.ModelFactory.createModel(kind, self.size, list(self.shape))
        self.model.E, self.model.nu = 1.0, 0.0
        if self.free:
            tamaas.ModelFactory.registerNonPeriodic(self.model, _FREE)

    def surface(self, gap: np.ndarray) -> None:
        """Set a new surface; where contact is impossible, the gap is very large."""
        finite = np.isfinite(gap)
        self.gap = np.where(finite, gap, 10 * gap[finite].max() + 10)

    def step(self, load: float, tolerance: float, depth: float, start: np.ndarray) -> PeerAnswer:
        """Solve one load."""
        if self.control == "force":
            return self._at_force(load, tolerance, start)
        if not self.free:
            mean = load if self.control == "mean_gap" else float(self.gap.mean()) - load
            kind = self.tamaas.PolonskyKeerRey.gap
            self.model.traction[:] = 0.0
            solver = self.tamaas.PolonskyKeerRey(self.model, -self.gap, tolerance, kind, kind)
            answer = self._finish(solver, mean, tolerance)
            if answer.pressure is not None:
                # The gap is the unknown; where it is open, the remaining pressure is the residual.
                answer.pressure[np.array(self.model["gap"]).reshape(self.shape) > 0] = 0.0
            return answer
        return self._at_penetration(load, tolerance, start)

    def _at_force(self, force: float, tolerance: float, start: np.ndarray) -> PeerAnswer:
        self.model.traction[:] = start  # rescaled to the prescribed mean
        solver = self.tamaas.PolonskyKeerRey(self.model, -self.gap, tolerance)
        if self.free:
            solver.setIntegralOperator(_FREE)
        return self._finish(solver, force / (self.size[0] * self.size[1]), tolerance)

    def _finish(self, solver: Any, target: float, tolerance: float) -> PeerAnswer:
        solver.max_iter = MOST_ITERATIONS
        error = solver.solve(target)
        if not error <= tolerance:
            return PeerAnswer(None, reason=f"Tamaas stopped at an error of {error:.1e}")
        return PeerAnswer(np.array(self.model.traction))

    def _at_penetration(self, depth: float, tolerance: float, start: np.ndarray) -> PeerAnswer:
        """Search for the force in logarithms, in which F(d) is nearly straight."""
        cell = self.size[0] * self.size[1] / start.size
        force, slope = start.sum() * cell, 1.5
        last: tuple[float, float] | None = None
        for _ in range(MOST_STEPS):
            answer = self._at_force(force, tolerance, start)
            if answer.pressure is None:
                return answer
            start = answer.pressure
            # Tamaas' displacements are relative to the body, u - d
            displacement = np.zeros(self.shape)
            self.model.operators[_FREE](self.model.traction, displacement)
            penetration = float((displacement - self.model.displacement).mean())
            if abs(penetration / depth - 1) <= tolerance:
                return answer
            if last is not None and penetration != last[1]:
                slope = np.log(force / last[0]) / np.log(penetration / last[1])
            last = (force, penetration)
            force *= (depth / penetration) ** np.clip(slope, 0.5, 4.0)
        return PeerAnswer(None, reason=f"the penetration was not reached in {MOST_STEPS} solves")
