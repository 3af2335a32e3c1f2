"""Tamaas and ContactMechanics in their own processes: all surfaces and loads, with times of solves.

The problem is dimensionless: E* = 1, lengths in units of the domain, heights in units of a typical
penetration (`comparisons.peers.client`), which avoids trouble with units.
"""

from __future__ import annotations

import resource
import statistics
import time
from typing import Any, NamedTuple

import numpy as np
import psutil

Problem = dict[str, Any]


class PeerAnswer(NamedTuple):
    """A pressure with the peer's number of iterations (0: unknown), or a reason for failure."""

    pressure: np.ndarray | None
    iterations: int = 0
    reason: str = ""


def solve(problem: Problem, peer: str) -> dict[str, Any]:
    """Solve a problem of `comparisons.peers.client` by a peer, set up anew for every repeat.

    The problem: gaps and starts (m, nx, ny), spacing, periodic, control, loads (k,), tolerance and
    depth (m, k), repeats (at most), repeat_seconds (none starts later). The answer: pressure (m, k,
    nx, ny), iterations (m, k), reasons [[row, step, text], ...], seconds and processor_seconds by
    repeat, setup_seconds, compile_seconds (imports, plans of the first solve), memory (rise of the
    peak).
    """
    begin = time.perf_counter()
    solver = PEERS[peer](problem)  # imports
    before = psutil.Process().memory_info().rss
    gaps, loads = problem["gaps"], problem["loads"]
    solver.surface(gaps[0])
    # The first solve plans its transforms; a loose tolerance suffices.
    solver.step(loads[0], 1e-2, problem["depth"][0, 0], problem["starts"][0])
    compile_seconds = time.perf_counter() - begin
    seconds: list[float] = []
    processor: list[float] = []
    setups: list[float] = []
    while len(seconds) < problem["repeats"]:
        if seconds and sum(seconds) > problem["repeat_seconds"]:
            break
        start, before_work = time.perf_counter(), time.process_time()
        solver = PEERS[peer](problem)
        setups.append(time.perf_counter() - start)
        pressure = np.zeros((len(gaps), len(loads), *gaps.shape[1:]))
        iterations = np.zeros(pressure.shape[:2], dtype=int)
        reasons = []
        for row, gap in enumerate(gaps):
            solver.surface(gap)
            guess = problem["starts"][row]
            for step, load in enumerate(loads):
                tolerance, depth = problem["tolerance"][row, step], problem["depth"][row, step]
                answer = solver.step(float(load), float(tolerance), float(depth), guess)
                if answer.pressure is None:
                    reasons.append([row, step, answer.reason])
                    continue
                pressure[row, step] = answer.pressure
                iterations[row, step] = answer.iterations
                guess = pressure[row, step]  # warm start of the next load
        seconds.append(time.perf_counter() - start)
        processor.append(time.process_time() - before_work)
    return {
        "pressure": pressure,
        "iterations": iterations,
        "reasons": reasons,
        "seconds": seconds,
        "processor_seconds": processor,
        "setup_seconds": statistics.median(setups),
        "compile_seconds": compile_seconds,
        "memory": float(1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before),
    }


# Largest number of steps in the search for a penetration; four or five are typical.
MOST_STEPS = 20
_FREE = "dcfft"  # Tamaas' name of the discrete convolution with Love's kernel


class Tamaas:
    """A 2-D surface model of Tamaas, periodic or free (Rey, Anciaux & Molinari 2017).

    Tamaas (https://gitlab.com/tamaas/tamaas) is AGPL: it is installed by the user, imported in this
    process only, and called through its public interface; none of its code is copied.

    It controls the mean pressure, or the mean gap on the periodic half-space; a penetration of the
    free half-space is reached by a secant search in the force, with warm starts.
    """

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
        """Set a new surface by its gap; where contact is impossible (+inf), it is very large."""
        finite = np.isfinite(gap)
        self.gap = np.where(finite, gap, 10 * gap[finite].max() + 10)

    def step(self, load: float, tolerance: float, depth: float, start: np.ndarray) -> PeerAnswer:
        """Solve one load from an initial pressure; `depth` is a rough guess of the penetration."""
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


MOST_ITERATIONS = 10_000


class ContactMechanics:
    """A substrate of ContactMechanics, periodic or free (Polonsky & Keer 1999).

    ContactMechanics (https://github.com/ContactEngineering/ContactMechanics, MIT) takes a force or
    an offset. On the periodic half-space the stiffness of the mode q = 0 is set to zero, so that
    the mean displacement is zero as in our convention, and offset = penetration.

    It starts from the given pressure. From its default start it accepted a surface without contact
    as converged (force, periodic), or cycled endlessly with every cell loaded (penetration, free).
    """

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


PEERS: dict[str, type[Tamaas] | type[ContactMechanics]] = {
    "tamaas": Tamaas,
    "contactmechanics": ContactMechanics,
}
